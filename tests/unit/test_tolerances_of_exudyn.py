"""Tolerances of Exudyn's solvers: each test fails if its constant is another one."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech import BeamSection, ExudynEngine, InputError, Mechanism, RotatingArm
from flexmech.linear_system import DeadMoments, inertia_loads
from flexmech.linkages import ConstantSpeed
from flexmech.multibody import items, static_model
from flexmech.multibody.linearize import static_equilibrium
from flexmech.time_domain import LinkState, UnbalancedStepError

# --- steps of a run -----------------------------------------------------------------------------


def run(mechanism, speed, step, steps):
    engine = ExudynEngine(mechanism, 2)
    time = step * np.linspace(0.0, steps, 11)
    return engine.simulate(ConstantSpeed(speed), LinkState.rigid(engine.links), time, step)


def test_steps_are_in_balance_to_the_sixth_digit_of_joint_forces(aluminium, monkeypatch):
    usual = run(aluminium, 20.0, 5e-4, 100).joint_force
    monkeypatch.setattr(items, "STEP_RESIDUAL", 1e-12)
    tight = run(aluminium, 20.0, 5e-4, 100).joint_force
    assert np.abs(usual - tight).max() < 1e-6 * np.abs(tight).max()


def test_steps_near_standstill_end_at_the_round_off_of_forces(aluminium, monkeypatch):
    """Those begin so close to balance that no part of it is left to be gained."""
    assert run(aluminium, 1.0, 1e-3, 20).energy_error < 2e-6
    monkeypatch.setattr(items, "ROUND_OFF", 0.0)
    with pytest.raises(UnbalancedStepError, match="does not converge"):
        run(aluminium, 1.0, 1e-3, 20)


def test_generalized_alpha_damps_what_rings_along_a_link_but_no_bending():
    """Ten and half a radian a step."""
    section = BeamSection(4e3, 2.0, 1e3, 1.0, 1e-6, in_plane_thickness=0.01)
    engine = ExudynEngine(Mechanism(RotatingArm(1.0, 0.2), {"arm": section}), 4, "ancf")
    link, start = engine.links[0], LinkState.rigid(engine.links)
    x, own = link.readings.nodes, start.displacement[0]
    own[0::4], own[2::4] = 1e-6 * x, 1e-6
    own[1::4], own[3::4] = 1e-6 * (3 - x) * x**2 / 2, 1e-6 * (2 - x) * x * 3 / 2
    time = 0.1 * np.arange(121)
    found = engine.simulate(ConstantSpeed(1e-9), start, time, 0.1, integrator="generalized-alpha")
    along, across = np.abs(found.displacement[0][100:, link.end]).max(axis=0)
    assert 0.05e-6 < along < 0.4e-6
    assert across > 0.95e-6


def test_starts_may_tear_joints_apart_by_a_millionth_of_the_links(aluminium):
    length = sum(link.length for link in aluminium.linkage.topology.links)
    for gap, refused in ((0.5e-6, False), (2e-6, True)):
        engine = ExudynEngine(aluminium, 2)
        start = LinkState.rigid(engine.links)
        start.displacement[1][1] += gap * length
        arguments = ConstantSpeed(1.0), start, np.array([0.0, 1e-4]), 1e-4
        if refused:
            with pytest.raises(InputError, match="displaces link ends"):
                engine.simulate(*arguments)
        else:
            engine.simulate(*arguments)


# --- static equilibrium -------------------------------------------------------------------------


def equilibrium(engine, degrees=200.0, speed=20.0):
    motion = engine.mechanism.linkage.motion(np.array([np.radians(degrees)]), speed)
    loads = inertia_loads(engine.links, motion, engine.mechanism.gravity)
    dead = DeadMoments.of(engine.links, motion, engine.mechanism.gravity, loads)
    found = static_equilibrium(engine.model, motion, loads, dead).displacement
    return np.concatenate([part[0] for part in found])


def test_static_equilibrium_is_exact_where_the_last_step_is_small(aluminium, monkeypatch):
    """With a step a thousand times as long it is off by a thousandth."""
    engine = ExudynEngine(aluminium, 4)
    usual = equilibrium(engine)
    monkeypatch.setattr(static_model, "LAST_STEP", 1e-11)
    tight = equilibrium(engine)
    assert np.abs(usual - tight).max() < 1e-10 * np.abs(tight).max()
