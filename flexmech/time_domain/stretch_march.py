"""The trapezoidal rule for links that stretch by the square of their slopes.

The linear part of a step is solved as in :mod:`flexmech.time_domain.trapezoidal`. The forces
that are left act through what the same step makes of a force: a modified Newton's method
whose tangent is that of the straight links. Slopes are small, so that it gains one to two
digits a pass; where it does not, Newton's method takes the tangent of the bowed links.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from flexmech.errors import ComputationError
from flexmech.time_domain.linkage_stretch import LinkageStretch, PinTurns, StretchForces
from flexmech.time_domain.state import VibrationState
from flexmech.time_domain.trapezoidal import StepOperators, predicted, settled
from flexmech.types import FloatArray

__all__ = ["Course", "StretchOperators", "march_stretching"]

logger = logging.getLogger(__name__)


# Passes of the modified Newton's method in every step of a block; more where the last of them
# changes the accelerations by more than this part of their size. Where five do not do, the
# passes gain so little that a small last change does not mean a small error.
PASSES = (2, 3, 5)
LAST_CHANGE = 2e-2
# A pass gains one to two digits: after a change that is smaller by this, the next block begins
# with the fewest passes again.
AMPLE = 30
# Newton's method with the tangent of the bowed links.
NEWTON_PASSES = 12
NEWTON_CHANGE = 1e-9
# What the stretch takes off the positions, by a parabola through the last three steps.
EXTRAPOLATE = np.array([1.0, -3.0, 3.0])


@dataclass(frozen=True)
class StretchOperators:
    """What a step makes of forces on spread coordinates.

    Parameters
    ----------
    answer : ndarray, shape (m, n, p)
        Position at the step's end by unit forces: acceleration times ``step**2 / 4``.
    turns : PinTurns
        At the ends of the m steps.
    """

    answer: FloatArray
    turns: PinTurns


@dataclass(frozen=True)
class Course:
    """How the passes went, for the steps that come next.

    Parameters
    ----------
    passes : int
        Of the modified Newton's method to begin with, where more than the fewest are needed.
    taken : ndarray, shape (3, n), optional
        What the stretch took off the positions in the last three steps.
    """

    passes: int = 0
    taken: FloatArray | None = None


def march_stretching(
    linear: StepOperators,
    operators: StretchOperators,
    stretch: LinkageStretch,
    state: VibrationState,
    course: Course,
) -> tuple[VibrationState, Course]:
    """Take all steps from a state.

    Parameters
    ----------
    linear : StepOperators
        Of m steps.
    operators : StretchOperators
    stretch : LinkageStretch
    state : VibrationState
        Arrays of shape (n,).
    course : Course
        Of the steps before.

    Returns
    -------
    VibrationState
        Arrays of shape (m + 1, n), the given state first.
    Course

    Raises
    ------
    ComputationError
        If Newton's method does not converge in a step.
    """
    steps, size = linear.forced.shape
    prediction, acceleration = np.empty((steps + 1, 2 * size)), np.empty((steps, size))
    prediction[0] = predicted(state, linear.step).ravel()
    passes = course.passes
    for count in PASSES:
        if count < passes:
            continue
        passes = count
        change, taken = _fixed_passes(
            linear, operators, stretch, state, prediction, acceleration, passes, course.taken
        )
        if _is_small(4 * change, acceleration):
            passes = 0 if _is_small(4 * AMPLE * change, acceleration) else passes
            break
        logger.info("modified Newton's method: %d passes do not do", passes)
    else:
        taken = None
        _newton(linear, operators, stretch, state, prediction, acceleration)
    parts = prediction[:-1].reshape(steps, 2, size)
    return settled(state, parts, acceleration, linear.step), Course(passes, taken)


def _is_small(change: FloatArray, acceleration: FloatArray) -> bool:
    """Whether the last change is small against accelerations; both of shape (m, n)."""
    with np.errstate(over="ignore", invalid="ignore"):
        size, whole = (np.einsum("mn,mn->m", a, a).max() for a in (change, acceleration))
    # Passes that diverge overflow in both.
    return bool(np.isfinite(whole) and size <= LAST_CHANGE**2 * whole)


def _fixed_passes(
    linear: StepOperators,
    operators: StretchOperators,
    stretch: LinkageStretch,
    state: VibrationState,
    prediction: FloatArray,
    acceleration: FloatArray,
    passes: int,
    last_taken: FloatArray | None,
) -> tuple[FloatArray, FloatArray]:
    """Fill in predictions (m + 1, 2 n) and accelerations (m, n).

    Returns
    -------
    ndarray, shape (m, n)
        By how much the last pass changed the positions.
    ndarray, shape (3, n)
        What the stretch took off them in the last steps.
    """
    steps, size = acceleration.shape
    forces = StretchForces(stretch, size, linear.step)
    turns, rates = operators.turns.turn, linear.step * operators.turns.rate
    forces.position[:], forces.rate[:] = state.position, linear.step * state.velocity
    # What the stretch takes off the positions; three steps back to begin with.
    taken, before = np.empty((steps + 3, size)), np.empty((steps, size))
    if last_taken is None:
        taken[:3] = operators.answer[0] @ forces.evaluate(turns[0], rates[0])
    else:
        taken[:3] = last_taken
    position, rate = forces.position, forces.rate
    linear_part, z_linear, v_linear, part = np.empty((4, size))
    is_damped = stretch.is_damped
    z, v = prediction[:, :size], prediction[:, size:]
    rows = zip(
        prediction,
        linear.response,
        linear.forced,
        operators.answer,
        turns,
        rates,
        sliding_window_view(taken, 3, axis=0),
        taken[3:],
        before,
        acceleration,
        z,
        v,
        z[1:],
        v[1:],
        strict=False,
    )
    for (
        z_and_v,
        response,
        forced,
        answer,
        turn,
        turning,
        last,
        new,
        prior,
        a,
        z_now,
        v_now,
        z_next,
        v_next,
    ) in rows:
        np.dot(response, z_and_v, out=linear_part)
        np.subtract(forced, linear_part, out=linear_part)
        np.multiply(linear_part, 0.25, out=z_linear)
        np.add(z_now, z_linear, out=z_linear)
        if is_damped:
            np.multiply(linear_part, 0.5, out=v_linear)
            np.add(v_now, v_linear, out=v_linear)
        np.dot(last, EXTRAPOLATE, out=new)
        for left in range(passes, 0, -1):
            np.subtract(z_linear, new, out=position)
            if is_damped:
                np.add(new, new, out=part)
                np.subtract(v_linear, part, out=rate)
            if left == 1:
                prior[:] = new
            np.dot(answer, forces.evaluate(turn, turning), out=new)
        np.multiply(new, 4.0, out=part)
        np.subtract(linear_part, part, out=a)
        np.add(v_now, a, out=v_next)
        np.add(z_now, v_next, out=z_next)
    return taken[3:] - before, taken[-3:]


def _newton(
    linear: StepOperators,
    operators: StretchOperators,
    stretch: LinkageStretch,
    state: VibrationState,
    prediction: FloatArray,
    acceleration: FloatArray,
) -> None:
    """Fill in predictions and accelerations by Newton's method in every step."""
    size = acceleration.shape[1]
    forces = StretchForces(stretch, size, linear.step)
    turns, rates = operators.turns.turn, linear.step * operators.turns.rate
    ends, unit = stretch.end_count, np.eye(size)
    a = linear.step**2 * state.acceleration
    for number, answer in enumerate(operators.answer):
        z, v = prediction[number].reshape(2, size)
        linear_part = linear.forced[number] - linear.response[number] @ prediction[number]
        spreading = np.zeros((stretch.size, size))
        spreading[:size], spreading[size:, :ends] = unit, turns[number]
        for _ in range(NEWTON_PASSES):
            forces.position[:], forces.rate[:] = z + a / 4, v + a / 2
            gap = a - linear_part + 4 * answer @ forces.evaluate(turns[number], rates[number])
            tangent = unit + answer @ forces.tangent(2.0) @ spreading
            change = np.linalg.solve(tangent, gap)
            a = a - change
            if np.abs(change).max() <= NEWTON_CHANGE * np.abs(a).max():
                break
        else:
            raise ComputationError(
                f"links that bow deeply have no balance in a time step of {linear.step:.4g} s; "
                "choose a smaller --step"
            )
        acceleration[number] = a
        prediction[number + 1] = np.concatenate([z + v + a, v + a])
