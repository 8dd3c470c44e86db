"""Tolerances of assembled linkages: each test fails if its constant is another one."""

from __future__ import annotations

import inspect
from types import SimpleNamespace

import numpy as np
import pytest

from flexmech import (
    ReferenceEngine,
    ReportRequest,
    moving_frequencies,
    natural_frequencies,
    stability,
)
from flexmech.analyses import StabilityRequest
from flexmech.analyses.default_engines import chosen_engines
from flexmech.choices import MODES
from flexmech.cli import campaigns, maps
from flexmech.errors import ComputationError, InputError
from flexmech.linear_system import inertia_loads
from flexmech.linear_system.assembly import balanced_loads as balance
from flexmech.linear_system.assembly import free_shaft
from flexmech.linear_system.assembly.batches import checked_elements
from flexmech.linear_system.assembly.constant_turn import all_constant
from flexmech.linear_system.assembly.element_kinds import TheoryComparison
from flexmech.linkages import FourBar
from flexmech.multibody.static_model import StaticSettings
from flexmech.reference import equilibrium

# --- loads that depend on the displacement ------------------------------------------------------


def passes_of(changes, monkeypatch):
    """Passes of Newton's method in which a force of one changes by these amounts."""
    left, taken = iter(changes), []

    class Acting:
        force = 1.0

        def __init__(self, *of, **connects):
            pass

        def forces(self, displacement):
            if displacement is not None:
                taken.append(next(left))
                self.force += taken[-1]
            return [np.full((1, 1), self.force)]

        def excess(self, counted, displacement):
            return [np.zeros((1, 1))]

        def stiffness(self, frames, stiffness, displacement):
            return np.ones((1, 1, 1))

    monkeypatch.setattr(balance, "_DisplacementForces", Acting)
    frames = SimpleNamespace(
        links=[SimpleNamespace(stiffness=None)],
        gather=lambda motion, loads: loads[0],
        link_coordinates=lambda motion, step: [step],
    )
    zero = [np.zeros((1, 1))]
    motion = SimpleNamespace(crank_angle=np.zeros(1), crank_speed=np.zeros(1))
    connectors = SimpleNamespace(depend_on_displacement=True)
    balance.balanced_loads(
        connectors, frames, motion, zero, lambda loads: zero, lambda displacement: None
    )
    return len(taken)


def test_forces_of_springs_are_balanced_to_ten_digits(monkeypatch):
    assert passes_of([1e-3, 1e-9, 3e-11], monkeypatch) == 3
    # A first pass finds what it was to find, the second one confirms it.
    assert passes_of([1e-12, 1e-12], monkeypatch) == 2


def test_forces_that_no_longer_settle_are_balanced_to_eight_digits(monkeypatch):
    """The round-off of a solver; larger changes that stay are an oscillation."""
    assert passes_of([1e-3, 5e-8, 5e-8, 3e-9, 2e-9], monkeypatch) == 5
    # Half of the last change may be the last one but for round-off; a tenth still falls.
    assert passes_of([1e-3, 9e-9, 8e-10, 7e-11], monkeypatch) == 4


def test_forces_that_oscillate_are_refused_after_ten_times_the_usual_passes(monkeypatch):
    with pytest.raises(ComputationError, match=r"still change by 0\.\d+ of .* after 60 passes"):
        passes_of([0.5, -0.5] * 100, monkeypatch)


def test_equilibria_are_exact_where_the_last_step_is_small(aluminium, monkeypatch):
    """The error that is left is the square of that step times some thousands."""
    engine = ReferenceEngine(aluminium, 4)
    motion = aluminium.linkage.motion(np.radians(np.arange(0.0, 360.0, 15.0)), 5.0)

    def displacement():
        found = engine.stressed_links(motion, "equilibrium").displacement
        return np.concatenate([q.ravel() for q in found])

    usual = displacement()
    monkeypatch.setattr(equilibrium, "LAST_STEP", 1e-12)
    exact = displacement()
    assert np.abs(usual - exact).max() < 2e-11 * np.abs(exact).max()


def test_forces_are_in_balance_to_ten_digits_of_the_loads_where_no_step_is_small():
    """Or to the round-off of the model, where that is greater."""

    def allowed(loaded, round_off):
        by_steps, by_forces = StaticSettings(round_off).under(loaded)
        assert by_steps.staticSolver.newton.residualMode == 1
        assert by_forces.staticSolver.newton.residualMode == 0
        return by_forces.staticSolver.newton.absoluteTolerance

    assert 1e-11 < allowed(1.0, 1e-13) < 1e-9
    assert allowed(1.0, 1e-7) == 1e-7


# --- what is constant, negligible or the same ---------------------------------------------------


def test_loads_are_constant_over_a_turn_but_for_round_off(unit_arm):
    arm = unit_arm(100.0, 0.3)
    motion = arm.linkage.motion(np.linspace(0.0, 2 * np.pi, 25), 7.0)
    [load] = inertia_loads(ReferenceEngine(arm, 100).links, motion, (0.0, 0.0))
    wave = np.abs(load).max() * np.sin(motion.crank_angle)[:, None] / 2
    assert all_constant([load])
    assert all_constant([load + 5e-14 * wave])
    assert not all_constant([load + 1e-12 * wave])


def test_a_theory_that_changes_frequencies_by_less_than_moduli_are_known_to_is_not_taken():
    def suitable(shear):
        frequency = {"euler": 1 + shear, "timoshenko": 1.0, "zigzag": 1.0}
        return TheoryComparison(lambda name: np.full((3, 4), frequency[name]), False).suitable

    assert suitable(0.005) == "euler"
    assert suitable(0.02) == "timoshenko"


def test_a_link_turns_with_the_shaft_within_what_kinematics_leave(monkeypatch):
    topology = FourBar(0.25, 0.1, 0.28, 0.27).topology
    monkeypatch.setattr(free_shaft, "picture_crank_angle", lambda linkage: 0.0)

    def shaft(off):
        turning = SimpleNamespace(angular_velocity=np.array([1 + off, 0.3, 0.5]))
        linkage = SimpleNamespace(topology=topology, motion=lambda angle, speed: turning)
        return free_shaft.FreeShaft.of(SimpleNamespace(linkage=linkage, shaft_inertia=1e-3))

    assert shaft(2e-10).inertia == 1e-3
    with pytest.raises(InputError, match="needs a link that turns with the shaft"):
        shaft(5e-9)


# --- what is taken where nothing is asked for, and the most that can be asked for ---------------

ANGLES = np.radians([0.0, 90.0, 200.0])


def off_by(frequency, engine):
    """Greatest relative error of four frequencies at rest."""
    fine = type(engine)(engine.mechanism, 40, engine.element)
    exact = natural_frequencies(fine, ANGLES, modes=MODES, prestress="none")
    return np.abs(frequency / exact - 1).max()


def test_the_usual_elements_give_four_frequencies_to_a_thousandth(aluminium):
    """Their error, here 2.6e-4, goes with the fourth power of an element's length."""
    [engine] = chosen_engines(aluminium, "reference", "euler")
    found = natural_frequencies(engine, ANGLES, modes=MODES, prestress="none")
    assert 5e-5 < off_by(found, engine) < 1e-3


def test_maps_are_refined_to_a_tenth_of_what_moduli_are_known_to(aluminium):
    """Without a tolerance of the user's the mesh is off by less than a thousandth, not by a
    hundredth; an error of less than 1e-5 would ask for three times as many elements."""
    commands = maps.frequencies, maps.campbell, campaigns.report
    usual = {inspect.signature(each).parameters["tolerance"].default for each in commands}
    usual |= {ReportRequest([0.0]).tolerance}
    assert len(usual) == 1
    engine = ReferenceEngine(aluminium, 1, "euler")
    found = moving_frequencies(engine, ANGLES, [0.0], prestress="none", tolerance=usual.pop())
    assert 3e-5 < off_by(found.dataset["frequency"].values[0, 0], engine) < 1e-3


def test_stability_maps_keep_twice_the_modes_of_other_maps():
    functions = maps.stability, stability
    usual = {inspect.signature(each).parameters["modes"].default for each in functions}
    assert usual == {StabilityRequest(np.array([1.0])).modes} == {2 * MODES}


def test_the_finest_meshes_are_those_whose_matrices_take_a_gigabyte(unit_arm):
    """Of three links at sixteen positions, with three coordinates a node."""
    fine = ReferenceEngine(unit_arm(100.0), checked_elements(500), "euler")
    [link] = fine.links
    assert 0.5e9 < 3 * 16 * 8 * link.size**2 < 1.5e9
    for elements in (600, 1500):
        with pytest.raises(InputError, match="do not fit into memory"):
            checked_elements(elements)
    # All of their coordinates may be asked for as modes, and no more.
    assert ReportRequest([0.0], modes=3 * (link.size - 3)).modes == 4500
    with pytest.raises(InputError, match="modes"):
        ReportRequest([0.0], modes=3 * link.size + 1)
