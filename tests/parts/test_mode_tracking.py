"""Modes followed by their shapes: crossings, veering, breaks, and the way home."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexmech import ComputationError
from flexmech.solvers.tracking import Between, Branches, Positions, Tracker, assign

FloatArray = NDArray[np.float64]
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


def followed(solve: Between, degrees: Any, *, full_turn: bool = False) -> Branches:
    """Branches over crank angles in degrees, with more solved for between them."""
    asked = solve(np.radians(degrees))
    tracker = Tracker()
    tracker.add(asked.shapes)
    return tracker.finish(asked.frequency, asked.crank_angle, full_turn=full_turn, between=solve)


def track(
    frequency: FloatArray, vectors: FloatArray, *, batch: int = 1000, full_turn: bool = False
) -> Branches:
    tracker = Tracker(None)
    for start in range(0, len(vectors), batch):
        tracker.add(vectors[start : start + batch])
    step = 2 * np.pi / len(vectors) if full_turn else np.radians(1.0)
    return tracker.finish(frequency, step * np.arange(len(vectors)), full_turn=full_turn)


@pytest.mark.parametrize("step", [1, 10, 30])
@pytest.mark.parametrize(("width", "crosses"), [(0.0, True), (0.15, True), (0.4, False)])
def test_modes_cross_or_veer_by_the_width_of_their_exchange_whatever_the_step(
    step: int, width: float, crosses: bool
) -> None:
    found = followed(between(np.radians(width)), np.arange(0, 91, step))
    assert found.branch[-1].tolist() == ([1, 0] if crosses else [0, 1])
    assert found.veering.any() == (not crosses)
    assert not found.unclear.any()
    assert found.whole.all()
    assert found.mac.min() >= 0.8
    flagged = np.arange(0, 91, step)[found.veering.all(axis=1)]
    assert crosses or np.abs(flagged - 47.3).min() <= step / 2


def test_an_angle_in_the_middle_of_a_crossing_is_passed_over() -> None:
    for off in (0.0, 0.01):
        found = followed(between(np.radians(0.05), np.radians(40.0 + off)), np.arange(0, 91, 5))
        assert found.branch[-1].tolist() == [1, 0]
        assert found.whole.all()


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
    assert np.isfinite(found.mac).all()


@pytest.mark.parametrize("degrees", [np.arange(0, 360, 40), np.arange(0, 361, 40)])
def test_two_crossings_in_a_turn_lead_home(degrees: Any) -> None:
    """At 160 and at 340 degrees."""
    found = followed(between(0.0, np.radians(340.0)), degrees, full_turn=True)
    assert found.whole.all()
    assert found.branch[0].tolist() == [0, 1]


def test_branches_that_end_as_another_or_jump_are_not_whole() -> None:
    """Shapes that turn by a quarter over the full turn; one that jumps to another shape."""
    angle = np.linspace(0, np.pi / 2, 40)
    turn = np.stack([np.cos(angle), -np.sin(angle), np.sin(angle), np.cos(angle)], axis=1)
    vectors, frequency = turn.reshape(-1, 2, 2), np.tile([1.0, 5.0], (40, 1))
    assert track(frequency, vectors).whole.all()
    assert not track(frequency, vectors, full_turn=True).whole.any()
    jumping = np.tile(np.eye(5)[:, :3], (30, 1, 1))
    jumping[15:, :, 1] = np.eye(5)[:, 4]
    for batch in (7, 1000):
        found = track(np.tile([1.0, 2.0, 3.0], (30, 1)), jumping, batch=batch)
        assert found.whole.tolist() == [True, False, True]
        assert found.mac[15].tolist() == [1.0, 0.0, 1.0]


def test_modes_are_assigned_one_to_one_by_the_greatest_total() -> None:
    amplitude = np.array([[[0.8, 0.75], [0.6, 0.3]], [[0.9, 0.1], [0.2, 0.9]]])
    assert assign(amplitude).tolist() == [[1, 0], [0, 1]]
