"""Mode tracking: crossings, veering, breaks and the way home."""

from __future__ import annotations

from dataclasses import replace
from itertools import permutations
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray

from flexmech.analyses import moving_frequencies, natural_frequencies
from flexmech.analyses.frequencies.formulation import Systems
from flexmech.analyses.frequencies.reduction import converged_modes
from flexmech.analyses.frequencies.refinement import (
    Between,
    Positions,
    assign,
    cross_amplitude,
    same_shapes,
)
from flexmech.analyses.frequencies.tracking import Branches, Tracker
from flexmech.errors import ComputationError
from flexmech.linear_system import Engine
from flexmech.multibody import ExudynEngine
from flexmech.reference import ReferenceEngine
from tests.support.random_mechanisms import random_case
from tests.support.strategies import fourbar

FloatArray = NDArray[np.float64]
PLACE = np.linspace(-1.0, 1.0, 81)


def coupled(coupling: float) -> tuple[FloatArray, FloatArray]:
    """Two oscillators of unit mass whose stiffnesses cross in the middle: frequency, modes."""
    rise = 0.2 * PLACE
    stiffness = np.empty((len(PLACE), 2, 2))
    stiffness[:, 0, 0], stiffness[:, 1, 1] = 1 + rise, 1 - rise
    stiffness[:, 0, 1] = stiffness[:, 1, 0] = coupling
    values, vectors = np.linalg.eigh(stiffness)
    signs = np.random.default_rng(0).choice([-1.0, 1.0], size=(len(PLACE), 1, 2))
    return np.sqrt(values), vectors * signs


def track(
    frequency: FloatArray,
    vectors: FloatArray,
    *,
    batch: int = 1000,
    full_turn: bool = False,
    numbering: NDArray[np.intp] | None = None,
) -> Branches:
    tracker = Tracker(numbering)
    for start in range(0, len(vectors), batch):
        tracker.add(vectors[start : start + batch])
    step = 2 * np.pi / len(vectors) if full_turn else np.radians(1.0)
    return tracker.finish(frequency, step * np.arange(len(vectors)), full_turn=full_turn)


def test_uncoupled_branches_cross_without_veering() -> None:
    found = track(*coupled(0.0))
    assert found.branch[0].tolist() == [0, 1]
    assert found.branch[-1].tolist() == [1, 0]
    assert not found.veering.any()
    assert found.mac.min() > 0.999
    assert found.whole.all()


@pytest.mark.parametrize("coupling", [0.02, 0.04])
def test_coupled_branches_veer_and_keep_their_order(coupling: float) -> None:
    found = track(*coupled(coupling))
    assert (found.branch == [0, 1]).all()
    flagged = np.flatnonzero(found.veering.all(axis=1))
    assert 40 in flagged
    assert not found.veering[[0, -1]].any()
    # The gap is 1.25 times its least where 0.2 |x| = 0.75 times the coupling.
    assert np.abs(PLACE[flagged]).max() == pytest.approx(3.75 * coupling, abs=0.03)
    assert found.whole.all()


# Of these the steps of five degrees alone have another answer than those of one degree.
SEEDS = (0, 6)
CENTRE = np.radians(47.3)


def between(width: float, centre: float = CENTRE) -> Between:
    """Two modes that exchange over a width of the crank angle (both in rad)."""

    def solve(crank_angles: FloatArray) -> Positions:
        apart = 0.2 * np.sin(crank_angles - centre)
        stiffness = np.empty((len(crank_angles), 2, 2))
        stiffness[:, 0, 0], stiffness[:, 1, 1] = 1 + apart, 1 - apart
        stiffness[:, 0, 1] = stiffness[:, 1, 0] = 0.2 * width
        values, vectors = np.linalg.eigh(stiffness)
        return Positions(crank_angles, np.sqrt(values), vectors)

    return solve


def followed(solve: Between, degrees: NDArray[Any], *, full_turn: bool = False) -> Branches:
    """Branches over crank angles in degrees, with more solved for between them."""
    asked = solve(np.radians(degrees))
    tracker = Tracker()
    tracker.add(asked.shapes)
    return tracker.finish(asked.frequency, asked.crank_angle, full_turn=full_turn, between=solve)


@pytest.mark.parametrize("step", [1, 5, 10, 15, 30])
@pytest.mark.parametrize(
    ("width", "crosses"), [(0.0, True), (0.02, True), (0.15, True), (0.4, False), (3.0, False)]
)
def test_what_happens_between_coarse_angles_is_seen(step: int, width: float, crosses: bool) -> None:
    """Crossing and veering by the width of the exchange, whatever the step."""
    found = followed(between(np.radians(width)), np.arange(0, 91, step))
    assert found.branch[-1].tolist() == ([1, 0] if crosses else [0, 1])
    assert found.veering.any() == (not crosses)
    assert not found.unclear.any()
    assert found.whole.all()
    assert found.mac.min() >= 0.8
    flagged = np.arange(0, 91, step)[found.veering.all(axis=1)]
    assert crosses or np.abs(flagged - 47.3).min() <= step / 2


@pytest.mark.parametrize("step", [1, 5, 10])
@pytest.mark.parametrize("off", [0.0, 0.01, 0.04])
def test_an_angle_in_the_middle_of_a_crossing_is_passed_over(step: int, off: float) -> None:
    """Whether an angle asked for happens to lie in a narrow exchange decides nothing."""
    found = followed(between(np.radians(0.05), np.radians(40.0 + off)), np.arange(0, 91, step))
    assert found.branch[-1].tolist() == [1, 0]
    assert found.whole.all()


def test_steps_are_divided_at_whole_degrees_and_only_where_it_is_not_clear() -> None:
    solved: list[float] = []
    solve = between(np.radians(0.2))

    def noted(crank_angles: FloatArray) -> Positions:
        solved.extend(np.degrees(crank_angles).round(9))
        return solve(crank_angles)

    asked = np.arange(0, 91, 15)
    found = followed(noted, asked)
    between_them = solved[len(asked) :]
    assert found.branch[-1].tolist() == [1, 0]
    assert 0 < len(between_them) <= 5
    assert all(45 < angle < 60 and angle == round(angle) for angle in between_them)


def test_what_cannot_be_told_is_flagged() -> None:
    """The step from 190 to 210 degrees cannot be divided; over 20 degrees shapes exchange."""
    exchange = between(np.radians(8.0), np.radians(200.0))

    def not_everywhere(crank_angles: FloatArray) -> Positions:
        if np.any(np.abs(crank_angles - np.radians(200.0)) < 1e-9):
            raise ComputationError("no equilibrium there")
        return exchange(crank_angles)

    found = followed(not_everywhere, np.arange(150, 251, 20))
    assert np.flatnonzero(found.unclear.any(axis=1)).tolist() == [3]
    assert not found.whole.any()
    # What the map delivers is a flag, and no error of an angle that nobody asked for.
    assert np.isfinite(found.mac).all()


@pytest.mark.parametrize("degrees", [np.arange(0, 360, 40), np.arange(0, 361, 40)])
def test_the_step_home_is_divided_too(degrees: NDArray[Any]) -> None:
    """The two modes meet at 5 and at 185 degrees and cross twice."""
    found = followed(between(0.0, np.radians(340.0)), degrees, full_turn=True)
    assert found.whole.all()
    assert found.branch[0].tolist() == [0, 1]


def test_parallel_branches_do_not_veer() -> None:
    _, vectors = coupled(0.0)
    frequency = np.stack([1 + 0.1 * PLACE**2, 1.1 + 0.2 * PLACE**2], axis=1)
    steady = np.broadcast_to(np.eye(2), vectors.shape)
    assert not track(frequency, steady).veering.any()


def test_assignment_is_one_to_one_where_both_modes_like_the_same() -> None:
    amplitude = np.array([[[0.8, 0.75], [0.6, 0.3]], [[0.9, 0.1], [0.2, 0.9]]])
    assert assign(amplitude).tolist() == [[1, 0], [0, 1]]


def test_assignment_takes_the_greatest_total_of_squares() -> None:
    amplitude = np.random.default_rng(5).uniform(size=(50, 4, 4))
    for table, chosen in zip(amplitude, assign(amplitude), strict=True):
        assert sorted(chosen) == [0, 1, 2, 3]
        best = np.sum(table[chosen, range(4)] ** 2)
        if not np.array_equal(np.sort(table.argmax(axis=0)), np.arange(4)):
            others = (np.sum(table[p, range(4)] ** 2) for p in permutations(range(4)))
            assert best == pytest.approx(max(others))


def test_shapes_are_compared_by_the_mass_of_the_links() -> None:
    """One position: the products are those of the mass matrix; also with links off their pins."""
    mechanism = fourbar()
    sections = {
        name: replace(section, neutral_axis=2e-4, mass_axis=-1e-4)
        for name, section in mechanism.sections.items()
    }
    for each in (mechanism, replace(mechanism, sections=sections)):
        system = ReferenceEngine(each, 4).linear_system([0.4, 1.3], 0.0)
        vectors = np.random.default_rng(2).normal(size=(2, system.size, 3))
        shapes = system.inertial_shapes(vectors)
        found = cross_amplitude(shapes, shapes)
        expected = np.abs(np.swapaxes(vectors, 1, 2) @ system.mass @ vectors)
        assert found == pytest.approx(expected, rel=1e-9)


def test_branches_of_unsymmetric_links_do_not_swap() -> None:
    mechanism = fourbar()
    sections = {
        name: replace(section, neutral_axis=0.2 * section.in_plane_thickness)
        for name, section in mechanism.sections.items()
    }
    engine = ReferenceEngine(replace(mechanism, sections=sections), 6)
    found = moving_frequencies(engine, np.radians(np.arange(0, 361, 10)), [0.0], modes=2)
    assert found.dataset["mac"].max() < 1 + 1e-9
    assert (found.dataset["branch_of_mode"][0, 0, :, 0] == 1).all()


def numbers_by_step(engine: Engine, speed: float, steps: list[int]) -> dict[int, xr.DataArray]:
    """Branch of each mode over the crank angle in degrees, from maps of several steps."""
    found = {}
    for step in steps:
        degrees = np.arange(0, 361, step)
        data = moving_frequencies(engine, np.radians(degrees), [speed]).dataset
        found[step] = data["branch_of_mode"][0, 0].assign_coords(crank_angle=degrees)
        assert not data["branch_unclear"].any()
    return found


def check_steps(engine: Engine, speed: float, steps: list[int]) -> None:
    fine, *coarse = numbers_by_step(engine, speed, [1, *steps]).values()
    for branch in coarse:
        assert branch.equals(fine.sel(crank_angle=branch["crank_angle"]))


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("runs", [pytest.param(False, marks=pytest.mark.thorough), True])
def test_coarse_maps_number_their_branches_as_the_map_of_one_degree(seed: int, runs: bool) -> None:
    case = random_case(seed)
    check_steps(ReferenceEngine(case.mechanism, 4), runs * case.crank_speed, [5, 15, 30])


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(100, 120))
@pytest.mark.parametrize("kind", [ReferenceEngine, ExudynEngine])
@pytest.mark.parametrize("runs", [False, True])
def test_coarse_maps_of_many_mechanisms(seed: int, kind: type[Engine], runs: bool) -> None:
    case = random_case(seed)
    engine = kind(case.mechanism, 4)
    check_steps(engine, runs * case.crank_speed, [5, 10, 15, 30])


def broken() -> tuple[FloatArray, FloatArray]:
    """Three modes of five coordinates; the middle one jumps to another shape."""
    vectors = np.tile(np.eye(5)[:, :3], (30, 1, 1))
    vectors[15:, :, 1] = np.eye(5)[:, 4]
    return np.tile([1.0, 2.0, 3.0], (30, 1)), vectors


def test_a_branch_that_jumps_is_not_whole() -> None:
    found = track(*broken())
    assert found.whole.tolist() == [True, False, True]
    assert found.mac[15].tolist() == [1.0, 0.0, 1.0]
    assert np.delete(found.mac, 15, axis=0).min() == 1.0


def test_a_jump_is_charged_to_the_branch_wherever_it_is_in_order() -> None:
    found = track(*broken(), numbering=np.array([2, 0, 1]))
    assert found.branch[-1].tolist() == [2, 0, 1]
    assert found.whole.tolist() == [False, True, True]


def test_branches_that_do_not_come_home_are_not_whole() -> None:
    """Shapes that turn by a quarter over the full turn: each branch ends as the other."""
    angle = np.linspace(0, np.pi / 2, 40)
    turn = np.stack([np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)], axis=1)
    vectors = turn.reshape(-1, 2, 2)
    frequency = np.tile([1.0, 5.0], (40, 1))
    assert track(frequency, vectors, full_turn=False).whole.all()
    assert not track(frequency, vectors, full_turn=True).whole.any()
    back_and_forth = np.concatenate([vectors, vectors[::-1]])
    twice = np.concatenate([frequency, frequency]), back_and_forth
    assert track(*twice, full_turn=True).whole.all()


@pytest.mark.parametrize("batch", [1, 7, 40])
def test_batches_do_not_change_the_branches(batch: int) -> None:
    for data in (coupled(0.0), coupled(0.03), broken()):
        whole, parts = track(*data), track(*data, batch=batch)
        for name in ("branch", "mac", "veering", "whole"):
            assert np.array_equal(getattr(whole, name), getattr(parts, name))


def test_a_single_position_is_a_whole_branch() -> None:
    frequency, vectors = (part[:1] for part in broken())
    found = track(frequency, vectors)
    assert found.branch.tolist() == [[0, 1, 2]]
    assert found.mac.tolist() == [[1.0, 1.0, 1.0]]
    assert found.whole.all()


def test_same_shapes_are_found_whatever_their_order_sign_and_scale() -> None:
    known = np.random.default_rng(4).normal(size=(3, 2, 5, 2))
    shapes = known[[2, 0, 1]] * np.array([-3.0, 1j, 0.1]).reshape(3, 1, 1, 1)
    assert same_shapes(known, shapes, None).tolist() == [2, 0, 1]
    assert same_shapes(known, shapes, np.array([5, 6, 7])).tolist() == [7, 5, 6]


class SmallBatches(ReferenceEngine):
    @property
    def batch_size(self) -> int:
        return 10


def test_a_map_does_not_depend_on_its_batches() -> None:
    angles = np.radians(np.arange(0.0, 361.0, 7.5))
    large, small = (
        moving_frequencies(kind(fourbar(), 4), angles, [0.0, 20.0], modes=3).dataset
        for kind in (ReferenceEngine, SmallBatches)
    )
    assert small["frequency"].values == pytest.approx(large["frequency"].values, rel=1e-9)
    assert small["mac"].values == pytest.approx(large["mac"].values, abs=1e-7)
    for name in ("branch_of_mode", "veering", "branch_whole"):
        assert np.array_equal(small[name], large[name])


def test_frequencies_at_positions_do_not_depend_on_their_batches(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The first batch takes along the positions that are checked; here in no order."""
    angles = np.random.default_rng(2).uniform(0, 2 * np.pi, 33)

    def with_its_stress(
        systems: Systems, crank_angle: FloatArray, *rest: Any, stressed: Any
    ) -> Any:
        own = systems.stressed(crank_angle, 20.0).displacement
        assert own is not None
        for found, expected in zip(stressed.displacement, own, strict=True):
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)
        return converged_modes(systems, crank_angle, *rest, stressed=stressed)

    large = natural_frequencies(ReferenceEngine(fourbar(), 4), angles, 20.0, modes=3)
    monkeypatch.setattr("flexmech.analyses.frequencies.positions.converged_modes", with_its_stress)
    small = natural_frequencies(SmallBatches(fourbar(), 4), angles, 20.0, modes=3)
    assert small == pytest.approx(large, rel=1e-9)


@pytest.mark.parametrize(
    ("count", "sizes"), [(1, [1]), (12, [12]), (13, [6, 7]), (32, [10, 11, 11])]
)
def test_batches_are_of_equal_size(count: int, sizes: list[int]) -> None:
    parts = SmallBatches(fourbar(), 4).batches(count)
    assert [len(range(count)[part]) for part in parts] == sizes
    assert [place for part in parts for place in range(count)[part]] == list(range(count))


def test_branches_of_the_aluminium_mechanism_follow_smooth_frequencies() -> None:
    angles = np.radians(np.arange(0.0, 360.5, 2.5))
    result = moving_frequencies(ReferenceEngine(fourbar(), 4), angles, [0.0, 20.0]).dataset
    assert result["branch_whole"].sel(branch=[1, 2, 3]).all()
    plain = natural_frequencies(ReferenceEngine(fourbar(), 4), angles, 20.0)
    assert result["frequency"].values[0, 1] == pytest.approx(plain, rel=1e-4)
    for speed in (0, 1):
        frequency = result["frequency"].values[0, speed]
        number = result["branch_of_mode"].values[0, speed]
        assert all(len(set(row)) == 4 for row in number.tolist())
        assert (number[0] == number[-1]).all()
        for branch in (1, 2, 3):
            along = frequency[number == branch]
            assert len(along) == len(angles)
            assert np.abs(np.diff(along, 2)).max() < 0.01 * along.mean()
