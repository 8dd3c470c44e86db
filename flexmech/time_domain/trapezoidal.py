"""The trapezoidal rule for a linear time-varying system.

Newmark's average-acceleration method (Newmark 1959, beta = 1/4, gamma = 1/2): second order,
unconditionally stable, no numerical damping. The equations of motion hold at every step::

    (M + h/2 C + h^2/4 K) a1 = f - C (v + h/2 a) - K (z + h v + h^2/4 a)

All matrices of a block of steps are solved at once; what is left to do one after another is
a matrix-vector product a step.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.time_domain.equations import Equations
from flexmech.time_domain.state import VibrationState
from flexmech.types import FloatArray

__all__ = ["PREDICT", "StepOperators", "initial_state", "march", "scaling", "step_operators"]


PREDICT = np.array([[1.0, 1.0, 1.0], [0.0, 1.0, 2.0], [0.0, 0.0, 0.0]])
"""In (z, h v, h^2 a / 4) a step is this prediction and one new acceleration."""
CORRECT = np.array([1.0, 2.0, 1.0])


@dataclass(frozen=True)
class StepOperators:
    """What leads to the acceleration at each of m steps: ``forced - response @ [z; h v]``.

    All accelerations are times ``h**2 / 4``.

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
        Acceleration by unit forces, times ``h**2 / 4``.
    """
    _, h, scale = scaling(step)
    mass, damping, stiffness = equations.mass, equations.damping, equations.stiffness
    effective = mass + step / 2 * damping + step**2 / 4 * stiffness
    size = mass.shape[-1]
    unit = np.broadcast_to(np.eye(size), mass.shape)[..., : size if forces else 0]
    right = [stiffness, damping / h, equations.force[..., None], unit]
    solved = np.linalg.solve(effective, scale * np.concatenate(right, axis=-1))
    response = np.ascontiguousarray(solved[..., : 2 * size])
    return StepOperators(step, response, solved[..., 2 * size]), solved[..., 2 * size + 1 :]


def scaling(step: float) -> FloatArray:
    """What turns (z, v, a) into (z, h v, h^2 a / 4), shape (3,)."""
    return np.array([1.0, step, step**2 / 4])


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
    scale = scaling(operators.step)
    correct = CORRECT[:, None]
    steps, tail_size = len(operators.response), int(np.prod(tail, dtype=int))
    forced = np.broadcast_to(operators.forced[..., None], (steps, size, tail_size))
    history = np.empty((steps + 1, 3, size * tail_size))
    history[0] = np.stack([state.position, state.velocity, state.acceleration]).reshape(3, -1)
    history[0] *= scale[:, None]
    predicted = history[1:, :2].reshape(steps, 2 * size, tail_size)
    change, corrected = np.empty((size, tail_size)), np.empty_like(history[0])
    # Everything that a step needs is laid out before: what is left are five small products.
    for now, after, z_and_v, answer, force in zip(
        history, history[1:], predicted, operators.response, forced, strict=False
    ):
        np.dot(PREDICT, now, out=after)
        np.dot(answer, z_and_v, out=change)
        np.subtract(force, change, out=change)
        np.multiply(correct, change.reshape(1, -1), out=corrected)
        np.add(after, corrected, out=after)
    history /= scale[:, None]
    parts = history.reshape(steps + 1, 3, size, *tail)
    return VibrationState(parts[:, 0], parts[:, 1], parts[:, 2])
