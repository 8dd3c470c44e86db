"""The trapezoidal rule for a linear time-varying system.

Newmark's average-acceleration method (Newmark 1959, beta = 1/4, gamma = 1/2): second order,
unconditionally stable, no numerical damping. The equations of motion hold at every step::

    (M + h/2 C + h^2/4 K) a1 = f - C (v + h/2 a) - K (z + h v + h^2/4 a)

All matrices of a block of steps are solved at once; what is left to do one after another is
a matrix-vector product a step. It multiplies the prediction from the step before, which
follows from the last prediction by two sums::

    v' = v + h/2 a,  z' = z + h v + h^2/4 a;  v'1 = v' + h a1,  z'1 = z' + h v'1
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.time_domain.equations import Equations
from flexmech.time_domain.state import VibrationState
from flexmech.types import FloatArray

__all__ = [
    "StepOperators",
    "initial_state",
    "march",
    "predicted",
    "settled",
    "step_operators",
]


@dataclass(frozen=True)
class StepOperators:
    """What leads to the acceleration at each of m steps: ``forced - response @ [z'; h v']``.

    All accelerations are times ``h**2``.

    Parameters
    ----------
    step : float
        Time step h in s.
    response : ndarray, shape (m, n, 2 n)
        Multiplies the predicted position and velocity.
    forced : ndarray, shape (m, n)
    """

    step: float
    response: FloatArray
    forced: FloatArray

    def __getitem__(self, where: slice) -> StepOperators:
        """Those of some of the steps."""
        return StepOperators(self.step, self.response[where], self.forced[where])


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


def step_operators(
    equations: Equations, step: float, *, forces: bool = False
) -> tuple[StepOperators, FloatArray]:
    """Solve the effective mass matrix ``M + h/2 C + h^2/4 K`` of each step.

    Parameters
    ----------
    equations : Equations
        At the ends of m steps.
    step : float
        In s.
    forces : bool
        Whether the answer to any force is wanted as well.

    Returns
    -------
    StepOperators
    ndarray, shape (m, n, n) or (m, n, 0)
        Position at the step's end by unit forces: acceleration times ``h**2 / 4``.
    """
    mass, damping, stiffness = equations.mass, equations.damping, equations.stiffness
    effective = mass + step / 2 * damping + step**2 / 4 * stiffness
    size = mass.shape[-1]
    unit = np.broadcast_to(np.eye(size), mass.shape)[..., : size if forces else 0]
    right = [stiffness, damping / step, equations.force[..., None], unit]
    solved = np.linalg.solve(effective, step**2 * np.concatenate(right, axis=-1))
    response = np.ascontiguousarray(solved[..., : 2 * size])
    linear = StepOperators(step, response, np.asarray(solved[..., 2 * size]))
    return linear, np.asarray(solved[..., 2 * size + 1 :] / 4)


def predicted(state: VibrationState, step: float) -> FloatArray:
    """Prediction (z', h v') of the next step's end from a state of shape (...), (2, ...)."""
    half = state.velocity + step / 2 * state.acceleration
    whole = state.position + step * state.velocity + step**2 / 4 * state.acceleration
    return np.stack([whole, step * half])


def settled(
    start: VibrationState, prediction: FloatArray, acceleration: FloatArray, step: float
) -> VibrationState:
    """The states of a start and of m steps.

    Parameters
    ----------
    start : VibrationState
        Arrays of shape (...).
    prediction : ndarray, shape (m, 2, ...)
        At the steps' ends.
    acceleration : ndarray, shape (m, ...)
        Times ``step**2``.
    step : float
        In s.

    Returns
    -------
    VibrationState
        Arrays of shape (m + 1, ...).
    """
    states = (
        (start.position, prediction[:, 0] + acceleration / 4),
        (start.velocity, (prediction[:, 1] + acceleration / 2) / step),
        (start.acceleration, acceleration / step**2),
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
    size, tail = len(state.position), state.position.shape[1:]
    steps, tail_size = len(operators.response), int(np.prod(tail, dtype=int))
    forced = np.broadcast_to(operators.forced[..., None], (steps, size, tail_size))
    prediction = np.empty((steps + 1, 2 * size, tail_size))
    prediction[0] = predicted(state, operators.step).reshape(2 * size, tail_size)
    acceleration, change = np.empty((steps, size, tail_size)), np.empty((size, tail_size))
    z, v = prediction[:, :size], prediction[:, size:]
    # Everything that a step needs is laid out before: what is left are four small products.
    for z_and_v, response, force, a, z_now, v_now, z_next, v_next in zip(
        prediction, operators.response, forced, acceleration, z, v, z[1:], v[1:], strict=False
    ):
        np.dot(response, z_and_v, out=change)
        np.subtract(force, change, out=a)
        np.add(v_now, a, out=v_next)
        np.add(z_now, v_next, out=z_next)
    return settled(
        state,
        prediction[:-1].reshape(steps, 2, size, *tail),
        acceleration.reshape(steps, size, *tail),
        operators.step,
    )
