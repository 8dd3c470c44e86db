"""The trapezoidal rule for links that stretch by the square of their slopes.

The linear part of a step is solved as in :mod:`flexmech.time_domain.trapezoidal`. The forces
that are left act through what the same step makes of a force: a modified Newton's method
whose tangent is that of the straight links. Within a pass the links yield first to what their
slopes stretch them by, which is most of the answer; the tension that is left then pulls at
the slopes (block Gauss-Seidel). Slopes are small, so that a pass gains about two digits; where
it does not, Newton's method takes the tangent of the bowed links.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from flexmech.errors import ComputationError
from flexmech.time_domain.linkage_stretch import LinkageStretch, PinTurns, StretchForces
from flexmech.time_domain.state import VibrationState
from flexmech.time_domain.trapezoidal import StepOperators, consecutive, predicted, settled
from flexmech.types import FloatArray

__all__ = ["Course", "StretchOperators", "UnbalancedStepError", "march_stretching"]

logger = logging.getLogger(__name__)


# Passes of the modified Newton's method in every step of a block; more where the last of them
# changes the accelerations by more than this part of their size. Where three do not do, the
# passes gain so little that a small last change does not mean a small error. Over two turns of
# the aluminium linkage at 20 rad/s one pass leaves 1e-3 of the deflections, a hundredth of what
# the step itself does.
PASSES = (1, 2, 3)
LAST_CHANGE = 1e-1
# A pass gains about two digits: after a change that is smaller by this, the next block begins
# with the fewest passes again.
AMPLE = 30
# Newton's method with the tangent of the bowed links.
NEWTON_PASSES = 12
NEWTON_CHANGE = 1e-9
# What the stretch takes off the predictions, by a parabola through the last three steps.
EXTRAPOLATE = np.array([1.0, -3.0, 3.0])
# Four times the position is the next prediction and this of the last two.
LAST_TWO = np.array([1.0, 2.0])


class UnbalancedStepError(ComputationError):
    """No balance is found in a step of this length; there may be one in a shorter step."""


@dataclass(frozen=True)
class StretchOperators:
    """What a step makes of forces on spread coordinates.

    Parameters
    ----------
    answer : ndarray, shape (m, n, p)
        By how much unit forces at the step's end move the next prediction.
    yielding : ndarray, shape (m, s, s)
        Of :meth:`LinkageStretch.yielding`.
    turns : PinTurns
        At the ends of the m steps.
    """

    answer: FloatArray
    yielding: FloatArray
    turns: PinTurns


@dataclass(frozen=True)
class Course:
    """How the passes went, for the steps that come next.

    Parameters
    ----------
    passes : int
        Of the modified Newton's method to begin with, where more than the fewest are needed.
    taken : ndarray, shape (3, n + s), optional
        What the stretch took off the predictions in the last three steps, and the
        second-order tensions.
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
    UnbalancedStepError
        If Newton's method does not converge in a step.
    """
    steps, size = linear.forced.shape
    prediction = np.empty((steps + 2, size))
    prediction[:2] = predicted(state, linear.step)
    passes = course.passes
    for count in PASSES:
        if count < passes:
            continue
        passes = count
        change, taken = _fixed_passes(
            linear, operators, stretch, state, prediction, passes, course.taken
        )
        size_of_change, whole = _greatest(change), _greatest(np.diff(prediction, 2, axis=0))
        if size_of_change <= LAST_CHANGE * whole < np.inf:
            passes = 0 if AMPLE * size_of_change <= LAST_CHANGE * whole else passes
            break
        logger.info("modified Newton's method: %d passes do not do", passes)
    else:
        taken = None
        _newton(linear, operators, stretch, prediction)
    return settled(state, prediction, linear.step), Course(passes, taken)


def _greatest(vectors: FloatArray) -> float:
    """Greatest length of vectors of shape (m, n); not finite where passes diverge."""
    with np.errstate(over="ignore", invalid="ignore"):
        return float(np.sqrt(np.einsum("mn,mn->m", vectors, vectors).max()))


def _fixed_passes(
    linear: StepOperators,
    operators: StretchOperators,
    stretch: LinkageStretch,
    state: VibrationState,
    prediction: FloatArray,
    passes: int,
    last_taken: FloatArray | None,
) -> tuple[FloatArray, FloatArray]:
    """Fill in predictions (m + 2, n) after the first two.

    Returns
    -------
    ndarray, shape (m, n)
        By how much the last pass changed them.
    ndarray, shape (3, n + s)
        What the stretch took off the last of them, and the second-order tensions.
    """
    steps, size = linear.forced.shape
    forces = StretchForces(stretch, size, linear.step, scale=4.0)
    turns, rates = operators.turns.turn, linear.step * operators.turns.rate
    # What the stretch takes off the predictions, and the second-order tensions; three steps
    # back to begin with.
    strains = len(stretch.gradient)
    taken, before = np.empty((steps + 3, size + strains)), np.empty((steps, size))
    if last_taken is None:
        forces.position[:], forces.rate[:] = 4 * state.position, 4 * linear.step * state.velocity
        taken[:3, :size] = operators.answer[0] @ forces.evaluate(turns[0], rates[0])
        taken[:3, size:] = forces.second
    else:
        taken[:3] = last_taken
    position, rate = forces.position, forces.rate
    linear_part, z_linear, v_linear, part = np.empty((4, size))
    is_damped = stretch.is_damped
    evaluate, add, subtract = forces.evaluate, np.add, np.subtract
    for (
        two,
        stacked,
        advance,
        forced,
        answer,
        yielding,
        turn,
        turning,
        last,
        guess,
        new,
        second,
        prior,
        result,
    ) in zip(
        sliding_window_view(prediction, 2, axis=0),
        consecutive(prediction),
        linear.advance,
        linear.forced,
        operators.answer,
        operators.yielding,
        turns,
        rates,
        sliding_window_view(taken, 3, axis=0),
        taken[3:],
        taken[3:, :size],
        taken[3:, size:],
        before,
        prediction[2:],
        strict=False,
    ):
        advance.dot(stacked, linear_part)
        add(linear_part, forced, linear_part)
        two.dot(LAST_TWO, z_linear)
        add(z_linear, linear_part, z_linear)
        if is_damped:
            subtract(linear_part, stacked[:size], v_linear)
            add(v_linear, v_linear, v_linear)
        last.dot(EXTRAPOLATE, guess)
        for left in range(passes, 0, -1):
            subtract(z_linear, new, position)
            if is_damped:
                add(new, new, part)
                subtract(v_linear, part, rate)
            if left == 1:
                prior[:] = new
            answer.dot(evaluate(turn, turning, yielding, second), new)
        subtract(linear_part, new, result)
    return taken[3:, :size] - before, taken[-3:]


def _newton(
    linear: StepOperators,
    operators: StretchOperators,
    stretch: LinkageStretch,
    prediction: FloatArray,
) -> None:
    """Fill in predictions after the first two by Newton's method in every step."""
    size = prediction.shape[1]
    forces = StretchForces(stretch, size, linear.step)
    turns, rates = operators.turns.turn, linear.step * operators.turns.rate
    ends, unit = stretch.end_count, np.eye(size)
    new = 2 * prediction[1] - prediction[0]
    for number, answer in enumerate(operators.answer):
        last, now = prediction[number : number + 2]
        linear_part = linear.forced[number] + linear.advance[number] @ np.concatenate([last, now])
        spreading = np.zeros((stretch.size, size))
        spreading[:size], spreading[size:, :ends] = unit, turns[number]
        for _ in range(NEWTON_PASSES):
            forces.position[:], forces.rate[:] = (last + 2 * now + new) / 4, (new - last) / 2
            gap = new - linear_part + answer @ forces.evaluate(turns[number], rates[number])
            tangent = unit + answer @ forces.tangent(2.0) @ spreading / 4
            change = np.linalg.solve(tangent, gap)
            new = new - change
            if np.abs(change).max() <= NEWTON_CHANGE * np.abs(new - 2 * now + last).max():
                break
        else:
            raise UnbalancedStepError(
                f"links that bow deeply have no balance in a time step of {linear.step:.4g} s; "
                "choose a smaller --step (of a hammer test: a wider --bandwidth)"
            )
        prediction[number + 2] = new
        new = 2 * new - now
