"""Constraints of moving bodies: rates, Jacobian and its derivative against differences."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmech.linkages.body_motion import BodyMotion, BodyPoint
from flexmech.linkages.constraints import Coincidence, Constraints, EqualAngle, PointOnLine

STEP = 1e-3
TIME = STEP * np.array([-1.0, 0.0, 1.0])
SMALL = 1e-6
FORCE = np.array([3.0, -2.0])
PIN = BodyPoint(0, -0.1 + 0.2j), BodyPoint(1, 0.3 + 0.1j)


def moving() -> BodyMotion:
    """Two bodies and the ground, with constant accelerations, at three instants."""
    drawn = np.array([0.2 - 0.1j, 0.05 + 0.3j, 0.0])
    place, velocity, acceleration = np.array(
        [[0.4 + 0.2j, -0.3 + 0.6j, 0.0], [1.1 - 0.4j, 0.3 + 0.8j, 0.0], [2.0 + 1.0j, -3.0j, 0.0]]
    )
    angle, spin, change = np.array([[0.3, -0.8, 0.0], [1.7, -2.3, 0.0], [4.0, 5.0, 0.0]])
    t = TIME[:, None]
    return BodyMotion(
        drawn,
        place + velocity * t + acceleration * t**2 / 2,
        np.exp(1j * (angle + spin * t + change * t**2 / 2)),
        velocity + acceleration * t,
        acceleration + 0 * t,
        spin + change * t,
        change + 0 * t,
    )


def constraints(bodies: BodyMotion) -> Constraints:
    """A pin, an equal angle, and a point of the first body on a line of the second one."""
    along = np.exp(0.6j)
    at = BodyPoint(0, 0.15 + 0.25j)
    in_guide = bodies.drawn[1] + np.conj(bodies.turn[1, 1]) * (
        bodies.of(0).point(at.place)[1] - bodies.place[1, 1]
    )
    line = PointOnLine(at, BodyPoint(1, in_guide - 0.4 * along), along)
    return Constraints([Coincidence(*PIN), EqualAngle(0, 1), line], (0, 1))


def displaced(bodies: BodyMotion, coordinate: int, by: float) -> BodyMotion:
    """The bodies with one of their coordinates changed."""
    body, which = divmod(coordinate, 3)
    place, turn = bodies.place.copy(), bodies.turn.copy()
    if which == 2:
        turn[:, body] *= np.exp(1j * by)
    else:
        place[:, body] += by * (1.0, 1j)[which]
    return replace(bodies, place=place, turn=turn)


def test_rates_of_gaps_are_their_derivatives() -> None:
    """Where the point is, a line's own turning and the point's sliding count."""
    bodies = moving()
    joints = constraints(bodies)
    gap = joints.gap(bodies)
    assert abs(gap[1, 3]) < 1e-12
    first, second = (rates[1] for rates in joints.gap_rates(bodies))
    np.testing.assert_allclose(first, (gap[2] - gap[0]) / (2 * STEP), rtol=0, atol=1e-4)
    np.testing.assert_allclose(second, (gap[2] - 2 * gap[1] + gap[0]) / STEP**2, atol=1e-4)


def test_the_jacobian_is_the_derivative_of_the_gaps() -> None:
    """A guide that turns takes the place of the point along."""
    bodies = moving()
    joints = constraints(bodies)
    matrix = joints.jacobian(bodies)[1]
    points = [0, 1, 3]
    for coordinate in range(6):
        ahead, back = (displaced(bodies, coordinate, sign * SMALL) for sign in (1, -1))
        slope = (joints.gap(ahead)[1] - joints.gap(back)[1]) / (2 * SMALL)
        np.testing.assert_allclose(matrix[points, coordinate], slope[points], rtol=0, atol=1e-8)
        assert matrix[2, coordinate] == (0, 0, 1, 0, 0, -1)[coordinate]


def test_the_stiffness_of_a_pin_is_the_derivative_of_its_moments() -> None:
    """Its force keeps its direction on both bodies while their arms turn."""
    bodies = moving()
    pin = Constraints([Coincidence(*PIN)], (0, 1))
    slid = np.zeros((3, 0), dtype=complex)
    stiffness = pin.geometric_stiffness(bodies, slid, np.tile(FORCE, (3, 1)))[0][1]
    for body, turn in ((0, 2), (1, 5)):
        ahead, back = (
            pin.jacobian(displaced(bodies, turn, sign * SMALL))[1].T @ FORCE for sign in (1, -1)
        )
        change = (ahead - back)[turn] / (2 * SMALL)
        np.testing.assert_allclose(-stiffness[body], change, rtol=1e-8)


def test_rates_of_a_jacobian_are_its_derivatives() -> None:
    """By coordinates in the turning axes of the bodies; a point that slides changes its arm."""
    bodies, along = moving(), np.exp(0.6j)
    joints = Constraints([Coincidence(*PIN)], (0, 1), slides=1)
    points = joints.points([BodyPoint(0, slide=0, along=along), BodyPoint(1, 0.2 + 0.1j)])
    place = 0.15 + 0.9 * TIME - 1.4 * TIME**2 / 2
    slid = along * np.stack([place, 0.9 - 1.4 * TIME, np.full(3, -1.4)])[..., None]
    found = points.jacobian_with_rates(bodies, slid)
    rate = (found.value[2] - found.value[0]) / (2 * STEP)
    second = (found.value[2] - 2 * found.value[1] + found.value[0]) / STEP**2
    np.testing.assert_allclose(found.rate[1], rate, rtol=0, atol=1e-4)
    np.testing.assert_allclose(found.twice[1], second, rtol=0, atol=1e-4)
