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

from flexmech.errors import ComputationError
from flexmech.time_domain.linkage_stretch import LinkageStretch, PinTurns, StretchForces
from flexmech.time_domain.state import VibrationState
from flexmech.time_domain.trapezoidal import PREDICT, StepOperators, scaling
from flexmech.types import FloatArray

__all__ = ["StretchOperators", "march_stretching"]

logger = logging.getLogger(__name__)


# Passes of the modified Newton's method in every step of a block; more where the last of them
# changes the accelerations by more than this part of their size. Where five do not do, the
# passes gain so little that a small last change does not mean a small error.
PASSES = (2, 3, 5)
LAST_CHANGE = 2e-2
# Newton's method with the tangent of the bowed links.
NEWTON_PASSES = 12
NEWTON_CHANGE = 1e-9


@dataclass(frozen=True)
class StretchOperators:
    """What a step makes of forces on spread coordinates.

    Parameters
    ----------
    answer : ndarray, shape (m, n, p)
        Acceleration at the step's end times ``step**2 / 4``, by unit forces.
    turns : PinTurns
        At the ends of the m steps.
    """

    answer: FloatArray
    turns: PinTurns


def march_stretching(
    linear: StepOperators,
    operators: StretchOperators,
    stretch: LinkageStretch,
    state: VibrationState,
    passes: int = 0,
) -> tuple[VibrationState, int]:
    """Take all steps from a state.

    Parameters
    ----------
    linear : StepOperators
        Of m steps.
    operators : StretchOperators
    stretch : LinkageStretch
    state : VibrationState
        Arrays of shape (n,).
    passes : int
        Of the modified Newton's method to begin with, where more than the least are needed.

    Returns
    -------
    VibrationState
        Arrays of shape (m + 1, n), the given state first.
    int
        The passes that it took.

    Raises
    ------
    ComputationError
        If Newton's method does not converge in a step.
    """
    scale = scaling(linear.step)
    history = np.empty((len(linear.response) + 1, 3, len(state.position)))
    history[0] = np.stack([state.position, state.velocity, state.acceleration]) * scale[:, None]
    for count in PASSES:
        if count < passes:
            continue
        passes = count
        change = _fixed_passes(linear, operators, stretch, history, passes)
        if _is_small(change, history[1:, 2]):
            break
        logger.info("modified Newton's method: %d passes do not do", passes)
    else:
        _newton(linear, operators, stretch, history)
    history /= scale[:, None]
    return VibrationState(history[:, 0], history[:, 1], history[:, 2]), passes


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
    history: FloatArray,
    passes: int,
) -> FloatArray:
    """Fill in a history (m + 1, 3, n) of z, h z' and h^2 z'' / 4; return the last changes."""
    steps, size = len(history) - 1, history.shape[2]
    forces = StretchForces(stretch, size, linear.step)
    turns, rates = operators.turns.turn, linear.step * operators.turns.rate
    forces.position[:], forces.rate[:] = history[0, :2]
    start = operators.answer[0] @ forces.evaluate(turns[0], rates[0])
    # What the stretch takes off the accelerations; two steps back to begin with.
    taken, before = np.empty((steps + 2, size)), np.empty((steps, size))
    taken[:2] = start
    position, rate, linear_part = forces.position, forces.rate, np.empty(size)
    is_damped, twice = stretch.is_damped, np.empty(size)
    rows = zip(
        history,
        history[1:],
        history[1:, :2].reshape(steps, -1),
        linear.response,
        linear.forced,
        operators.answer,
        turns,
        rates,
        taken,
        taken[1:],
        taken[2:],
        before,
        strict=False,
    )
    for now, after, z_and_v, response, forced, answer, turn, turning, old, last, new, prior in rows:
        np.dot(PREDICT, now, out=after)
        np.dot(response, z_and_v, out=linear_part)
        np.subtract(forced, linear_part, out=linear_part)
        np.subtract(last, old, out=new)
        np.add(new, last, out=new)
        z, v, a = after
        for left in range(passes, 0, -1):
            np.subtract(linear_part, new, out=a)
            np.add(z, a, out=position)
            if is_damped:
                np.add(a, a, out=twice)
                np.add(v, twice, out=rate)
            if left == 1:
                prior[:] = new
            np.dot(answer, forces.evaluate(turn, turning), out=new)
        np.subtract(linear_part, new, out=a)
        np.add(z, a, out=z)
        np.add(a, a, out=twice)
        np.add(v, twice, out=v)
    return taken[2:] - before


def _newton(
    linear: StepOperators,
    operators: StretchOperators,
    stretch: LinkageStretch,
    history: FloatArray,
) -> None:
    """Fill in a history by Newton's method in every step."""
    size = history.shape[2]
    forces = StretchForces(stretch, size, linear.step)
    turns, rates = operators.turns.turn, linear.step * operators.turns.rate
    ends, unit = stretch.end_count, np.eye(size)
    a = np.array(history[0, 2])
    for number, answer in enumerate(operators.answer):
        z, v, _ = PREDICT @ history[number]
        linear_part = linear.forced[number] - linear.response[number] @ np.concatenate([z, v])
        spreading = np.zeros((stretch.size, size))
        spreading[:size], spreading[size:, :ends] = unit, turns[number]
        for _ in range(NEWTON_PASSES):
            forces.position[:], forces.rate[:] = z + a, v + 2 * a
            gap = a - linear_part + answer @ forces.evaluate(turns[number], rates[number])
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
        history[number + 1] = z + a, v + 2 * a, a
