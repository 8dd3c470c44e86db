"""Tolerances of periodic systems and motions: each test fails if its constant is another one."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from flexmech import load_mechanism
from flexmech.analyses.damping_ratios import with_damping_ratio
from flexmech.analyses.speed_sweep import compute as sweep
from flexmech.dynamical_systems import periodic_schur
from flexmech.dynamical_systems.periodic_schur import block_eigenvalues, periodic_schur_form
from flexmech.errors import ComputationError
from flexmech.reference import ReferenceEngine
from flexmech.time_domain import SampledTurn, forced_modes
from flexmech.time_domain.periodic_motion import orbit_newton
from flexmech.time_domain.periodic_motion.orbit_equations import OrbitEquations

# --- multipliers of a periodic system -----------------------------------------------------------


def product_of(logs, count=4):
    """So many equal matrices whose product has multipliers with these logarithms."""
    size = len(logs)
    basis = np.linalg.qr(np.random.default_rng(3).normal(size=(size, size)))[0]
    step = basis @ np.diag(np.exp(np.asarray(logs) / count)) @ basis.T
    return np.stack([step] * count)


def test_groups_of_multipliers_are_parted_to_a_hundred_billionth():
    """Each turn parts them by exp(-r); none is spent on what is below round-off of long turns."""
    left = []
    for r in np.linspace(4.5, 7.0, 21):
        form = periodic_schur_form(product_of([0.0, -0.5, -0.5 - r, -1.0 - r]))
        left += [np.abs(form.seam[group.start :, : group.start]).max() for group in form.groups[1:]]
    assert len(left) > 10
    assert 1e-12 < max(left) <= 1.01e-11


def test_groups_that_are_hardly_apart_are_waited_for():
    """Of modes evenly apart, together too wide for one group, halves part in 27 and 37 turns."""
    for size, apart in ((18, 0.9), (24, 0.7)):
        logs = -apart * np.arange(size)
        form = periodic_schur_form(product_of(logs))
        assert len(form.groups) == 2
        found = block_eigenvalues(form)[0]
        assert np.sort(found.real)[::-1] == pytest.approx(logs, abs=1e-9)


def turns_until_groups_show(monkeypatch, first):
    """Turns and groups of three modes, the weakest one ahead until the given turn."""
    turns = []

    def iterated(matrices, start):
        turns.append(1)
        logs = [-20.0, 0.0, -13.0] if len(turns) < first else [0.0, -13.0, -26.0]
        return np.stack([np.eye(3)] * 2), np.diag(np.exp(logs))[None]

    monkeypatch.setattr(periodic_schur, "_iterated", iterated)
    try:
        form = periodic_schur_form(np.eye(3)[None])
    except ComputationError:
        return len(turns), 0
    return len(turns), len(form.groups)


def test_groups_have_twenty_turns_to_show(monkeypatch):
    """Averages over half of the turns tell which modes are the stronger ones."""
    turns, groups = turns_until_groups_show(monkeypatch, 9)
    assert groups == 2
    assert 9 <= turns < 20
    # Where they do not show there is no distance by which to wait, and the search ends.
    turns, groups = turns_until_groups_show(monkeypatch, 1000)
    assert groups == 0
    assert 10 < turns < 40


def test_groups_that_do_not_part_end_the_search(monkeypatch):
    """After a few times the turns in which modes so far apart would have parted."""
    turns = []

    def iterated(matrices, start):
        turns.append(1)
        mixed = np.array([[1.0, 0.0], [1e-3, 1.0]])
        return np.stack([np.eye(2), mixed]), np.diag(np.exp([0.0, -5.0]))[None]

    monkeypatch.setattr(periodic_schur, "_iterated", iterated)
    with pytest.raises(ComputationError, match="do not part into groups"):
        periodic_schur_form(np.eye(2)[None])
    assert len(turns) < 20 + 10 * 25 / 5


# --- crank speeds -------------------------------------------------------------------------------


def test_steady_motion_needs_component_modes_of_twice_the_frequency(aluminium, monkeypatch):
    """Peaks are those of the unreduced links, by less than a third of their coordinates."""
    monkeypatch.setattr(sweep, "LEAST_STEPS", 240)

    def peaks(component_modes):
        engine = ReferenceEngine(aluminium, 6, component_modes=component_modes)
        linkage = sweep.vibrating_linkage(engine, 37.0, 3, "axial")
        return linkage.size, sweep.periodic_peaks(linkage, 0.0)

    few, found = peaks(True)
    many, exact = peaks(False)
    assert few < many / 3
    assert found == pytest.approx(exact, rel=1e-4)


# --- moving modes -------------------------------------------------------------------------------


def frozen_frequencies(mechanism, component_modes):
    """Natural frequencies at a dozen crank angles in rad/s, where four of them are asked for."""
    engine = ReferenceEngine(mechanism, 8, component_modes=component_modes)
    angle = 2 * np.pi / 12 * np.arange(12)
    motion = engine.mechanism.linkage.motion(angle, 20.0)
    stressed = engine.stressed_links(motion, "axial")
    turn = SampledTurn.of(engine, motion, stressed, "axial", 4)
    return np.sqrt(turn.frozen_squares)


def test_component_modes_have_a_few_natural_modes_more_than_are_asked_for(aluminium):
    """Three more, by less than a third of the coordinates."""
    found, exact = (frozen_frequencies(aluminium, reduced) for reduced in (True, False))
    assert found.shape[1] < exact.shape[1] / 3
    assert found[:, :7] == pytest.approx(exact[:, :7], rel=1e-4)


def test_positions_of_a_turn_show_all_harmonics_of_its_loads(aluminium):
    """The last ones are far below what the higher modes leave, and not yet round-off."""
    engine = with_damping_ratio(ReferenceEngine(aluminium, 2), 0.01)
    found = forced_modes(engine, 30.0, [[None, engine.links[1].curvature, None]], "axial")
    size = np.abs(found.force.coefficients).max(axis=1)
    assert 1e-13 < size[-5:].max() / size.max() < 1e-7


def test_an_arm_has_moving_modes_beyond_those_asked_for(models):
    """They reach twice as far, and not so far that a turn takes many more steps."""
    mechanism = load_mechanism(models / "rotating_arm.toml")
    arm = with_damping_ratio(ReferenceEngine(mechanism, 4), 0.01)
    found = forced_modes(arm, 10.0, [[arm.links[0].shape[-1, 1]]], "axial", modes=4)
    highest = found.frequency_ranges()[3, 1]
    assert 2 < found.fastest / (2 * np.pi) / highest < 5


# --- orbits -------------------------------------------------------------------------------------


def test_few_modes_move_and_the_others_take_few_products(aluminium):
    """Of eighteen modes all but a few follow what is fast enough; GMRES needs a few products."""
    equations = OrbitEquations(ReferenceEngine(aluminium, 2), 20.0, 48)
    state = equations.state(np.zeros((48, equations.frames.size)))
    matrices = equations.linearized(state.stressed, 0.0)
    modal = orbit_newton._ModalPreconditioner(equations, state.stressed, matrices)
    _, products = modal.solve(matrices, -state.residual)
    assert modal.moving <= 6
    assert products <= 8


def test_the_matrix_of_the_moving_modes_has_a_hundred_megabytes_at_most(monkeypatch):
    monkeypatch.setattr(
        orbit_newton._ModalPreconditioner, "_moving_block", lambda self, matrices: np.eye(1)
    )
    # All modes are slow enough to move.
    mass = np.tile(np.eye(40), (256, 1, 1))
    equations = SimpleNamespace(samples=256, crank_speed=1.0, elastic=lambda stressed: mass)
    modal = orbit_newton._ModalPreconditioner(equations, None, SimpleNamespace(mass=mass))
    assert 5e7 < 8 * (256 * modal.moving) ** 2 < 1.1e8
