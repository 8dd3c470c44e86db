"""The trapezoidal rule for a linear time-varying system.

Newmark's average-acceleration method (Newmark 1959, beta = 1/4, gamma = 1/2): second order,
unconditionally stable, no numerical damping. The equations of motion hold at every step::

    (M + h/2 C + h^2/4 K) a1 = f - C (v + h/2 a) - K (z + h v + h^2/4 a)

All matrices of a block of steps are solved at once; what is left to do one after another is
a matrix-vector product a step. It leads from the last two predictions of the position to the
next one, of which everything else is a central difference or mean::

    z'[k] = z[k] + h v[k] + h^2/4 a[k],  h v[k] = (z'[k] - z'[k-2]) / 2,
    h^2 a[k] = z'[k] - 2 z'[k-1] + z'[k-2],  z[k] = (z'[k] + 2 z'[k-1] + z'[k-2]) / 4
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from flexmech.time_domain.equations import Equations
from flexmech.time_domain.state import VibrationState
from flexmech.types import FloatArray


@dataclass(frozen=True)
class StepOperators:
    """What leads to the next prediction in each of m steps.

    ``z'[k] = advance @ [z'[k-2]; z'[k-1]] + forced``.

    Parameters
    ----------
    step : float
        Time step h in s.
    advance : ndarray, shape (m, n, 2 n)
    forced : ndarray, shape (m, n)
    """

    step: float
    advance: FloatArray
    forced: FloatArray

    def __getitem__(self, where: slice) -> StepOperators:
        """Those of some of the steps."""
        return StepOperators(self.step, self.advance[where], self.forced[where])


def initial_state(
    equations: Equations, position: FloatArray, velocity: FloatArray
) -> VibrationState:
    """State whose acceleration satisfies the first of the equations of motion.

    Parameters
    ----------
    equations : Equations
    position, velocity : ndarray, shape (n,) or (n, k)

    Returns
    -------
    VibrationState
    """
    force = equations.force[0] if position.ndim == 1 else equations.force[0][:, None]
    rest = force - equations.damping[0] @ velocity - equations.stiffness[0] @ position
    return VibrationState(position, velocity, np.linalg.solve(equations.mass[0], rest))


def step_operators(equations: Equations, step: float) -> StepOperators:
    """Solve the effective mass matrix ``M + h/2 C + h^2/4 K`` of each step.

    Parameters
    ----------
    equations : Equations
        At the ends of m steps.
    step : float
        In s.

    Returns
    -------
    StepOperators
    """
    mass, damping, stiffness = equations.mass, equations.damping, equations.stiffness
    effective = mass + step / 2 * damping + step**2 / 4 * stiffness
    size = mass.shape[-1]
    right = [damping / step, stiffness, equations.force[..., None]]
    solved = np.linalg.solve(effective, step**2 * np.concatenate(right, axis=-1))
    # The predicted velocity is the difference of the last two predictions.
    by_velocity, by_position = solved[..., :size], solved[..., size : 2 * size]
    advance = np.concatenate([by_velocity, -by_velocity - by_position], axis=-1)
    place = np.arange(size)
    advance[:, place, place] -= 1.0
    advance[:, place, size + place] += 2.0
    return StepOperators(step, advance, np.asarray(solved[..., 2 * size]))


def predicted(state: VibrationState, step: float) -> FloatArray:
    """The two predictions that a state of shape (...) leaves, the last one second; (2, ...)."""
    half = step * state.velocity + step**2 / 2 * state.acceleration
    whole = state.position + step * state.velocity + step**2 / 4 * state.acceleration
    return np.stack([whole - half, whole])


def consecutive(prediction: FloatArray) -> FloatArray:
    """Each two predictions that follow each other, one below the other, as a view.

    Parameters
    ----------
    prediction : ndarray, shape (m, n) or (m, n, k)

    Returns
    -------
    ndarray, shape (m - 1, 2 n) or (m - 1, 2 n, k)
    """
    size = prediction.shape[1]
    stacked = prediction.reshape(-1, *prediction.shape[2:])
    return np.moveaxis(sliding_window_view(stacked, 2 * size, axis=0)[::size], -1, 1)


def settled(start: VibrationState, prediction: FloatArray, step: float) -> VibrationState:
    """The states of a start and of m steps.

    Parameters
    ----------
    start : VibrationState
        Arrays of shape (...).
    prediction : ndarray, shape (m + 2, ...)
        Two that the start leaves, and one of each step.
    step : float
        In s.

    Returns
    -------
    VibrationState
        Arrays of shape (m + 1, ...).
    """
    before, now, after = prediction[:-2], prediction[1:-1], prediction[2:]
    mean, difference = (before + after) / 2, (after - before) / 2
    states = (
        (start.position, (mean + now) / 2),
        (start.velocity, difference / step),
        (start.acceleration, (mean - now) * (2 / step**2)),
    )
    return VibrationState(*(np.concatenate([first[None], rest]) for first, rest in states))


def march(operators: StepOperators, state: VibrationState) -> VibrationState:
    """Take all steps from a state.

    Parameters
    ----------
    operators : StepOperators
        Of m steps.
    state : VibrationState
        Arrays of shape (n,), or (n, k) for k motions at once.

    Returns
    -------
    VibrationState
        Arrays of shape (m + 1, n) or (m + 1, n, k), the given state first.
    """
    steps, size = operators.forced.shape
    tail = state.position.shape[1:]
    forced = operators.forced.reshape(steps, size, *(1,) * len(tail))
    prediction = np.empty((steps + 2, size, *tail))
    prediction[:2] = predicted(state, operators.step)
    # Everything that a step needs is laid out before: what is left are a product and a sum.
    for last_two, advance, force, new in zip(
        consecutive(prediction), operators.advance, forced, prediction[2:], strict=False
    ):
        advance.dot(last_two, new)
        np.add(new, force, new)
    return settled(state, prediction, operators.step)
