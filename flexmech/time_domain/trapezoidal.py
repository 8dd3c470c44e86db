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

from flexmech.time_domain.driven_linkage import Equations
from flexmech.time_domain.state import VibrationState
from flexmech.types import FloatArray

__all__ = ["StepOperators", "initial_state", "march", "step_operators"]


@dataclass(frozen=True)
class StepOperators:
    """What leads to the acceleration at each of m steps: ``forced - response @ [z; v]``.

    Parameters
    ----------
    step : float
        Time step in s.
    response : ndarray, shape (m, n, 2 n)
        Multiplies the predicted position and velocity.
    forced : ndarray, shape (m, n)
    """

    step: float
    response: FloatArray
    forced: FloatArray


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
    """Solve the effective mass matrix of each step.

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
    size = equations.mass.shape[-1]
    effective = equations.mass + step / 2 * equations.damping + step**2 / 4 * equations.stiffness
    right = np.concatenate(
        [equations.stiffness, equations.damping, equations.force[..., None]], axis=-1
    )
    solved = np.linalg.solve(effective, right)
    return StepOperators(step, np.ascontiguousarray(solved[..., :-1]), solved[..., 2 * size])


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
    h = operators.step
    size, tail = len(state.position), state.position.shape[1:]
    # In (z, h v, h^2 a / 4) a step is a constant prediction and one new acceleration.
    scale = np.array([1.0, h, h**2 / 4])
    predict = np.array([[1.0, 1.0, 1.0], [0.0, 1.0, 2.0], [0.0, 0.0, 0.0]])
    correct = np.array([1.0, 2.0, 1.0])[:, None]
    response = operators.response.copy()
    response[..., :size] *= scale[2]
    response[..., size:] *= scale[2] / h
    steps, tail_size = len(response), int(np.prod(tail, dtype=int))
    forced = np.broadcast_to(scale[2] * operators.forced[..., None], (steps, size, tail_size))
    history = np.empty((steps + 1, 3, size * tail_size))
    history[0] = np.stack([state.position, state.velocity, state.acceleration]).reshape(3, -1)
    history[0] *= scale[:, None]
    predicted = history[1:, :2].reshape(steps, 2 * size, tail_size)
    change, corrected = np.empty((size, tail_size)), np.empty_like(history[0])
    # Everything that a step needs is laid out before: what is left are five small products.
    for now, after, z_and_v, answer, force in zip(
        history, history[1:], predicted, response, forced, strict=False
    ):
        np.dot(predict, now, out=after)
        np.dot(answer, z_and_v, out=change)
        np.subtract(force, change, out=change)
        np.multiply(correct, change.reshape(1, -1), out=corrected)
        np.add(after, corrected, out=after)
    history /= scale[:, None]
    parts = history.reshape(steps + 1, 3, size, *tail)
    return VibrationState(parts[:, 0], parts[:, 1], parts[:, 2])
