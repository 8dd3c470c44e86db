"""Lobatto's collocation methods IIIA: the trapezoidal rule, and that of three stages.

Two stages make the trapezoidal rule, Newmark's average acceleration (Newmark 1959, beta = 1/4,
gamma = 1/2): second order, unconditionally stable, no numerical damping. The equations of motion
hold at every step::

    (M + h/2 C + h^2/4 K) a1 = f - C (v + h/2 a) - K (z + h v + h^2/4 a)

All matrices of a block of steps are solved at once; what is left to do one after another is
a matrix-vector product a step. It leads from the last two predictions of the position to the
next one, of which everything else is a central difference or mean::

    z'[k] = z[k] + h v[k] + h^2/4 a[k],  h v[k] = (z'[k] - z'[k-2]) / 2,
    h^2 a[k] = z'[k] - 2 z'[k-1] + z'[k-2],  z[k] = (z'[k] + 2 z'[k-1] + z'[k-2]) / 4

With three stages the equations hold at the start, the middle and the end of a double step of length
H = 2 h; in between z' and z'' are parabolas. Fourth order, stable for any step, no numerical
damping (Ehle 1969; Hairer & Wanner, *Solving Ordinary Differential Equations II*, 1996, sec. IV.5);
for a load alone this is Simpson's rule. With the products ``H z'`` and ``H^2 z''``, the stages i =
middle, end are::

    H z'_i = H z'_0 + a_i0 H^2 z''_0 + sum_j a_ij H^2 z''_j
       z_i = z_0 + c_i H z'_0 + b_i0 H^2 z''_0 + sum_j b_ij H^2 z''_j,   b = a a
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from flexmech.arrays import FloatArray

# Coefficients a of start, middle and end.
_WHOLE = np.array([[0, 0, 0], [5 / 24, 8 / 24, -1 / 24], [4 / 24, 16 / 24, 4 / 24]])
# What is solved for in a double step: the middle and the end.
STAGES = 2
# What ends and middles count in an integral over many double steps, over h.
WEIGHTS = (2 / 3, 4 / 3)
# By how much H^2 z'' of the stages moves H z' and z there.
RATE, POSITION = _WHOLE[1:, 1:], (_WHOLE @ _WHOLE)[1:, 1:]
_ACCELERATION = np.linalg.inv(POSITION)
# By how much z of the stages moves H z' there.
RATE_BY_POSITION = RATE @ _ACCELERATION
_EARLIER_POSITION = np.column_stack([np.ones(2), _WHOLE.sum(axis=1)[1:], (_WHOLE @ _WHOLE)[1:, 0]])
_EARLIER_RATE = np.column_stack([np.zeros(2), np.ones(2), _WHOLE[1:, 0]])
# What z, H z' and H^2 z'' at the start alone make of z and H z' at the middle, then at the end.
PREDICTION = np.stack([_EARLIER_POSITION, _EARLIER_RATE], axis=1).reshape(4, 3)
# From z, H z', H^2 z'' at the start and z of both stages to z, H z', H^2 z'' at both stages.
MARCH_ON = np.stack(
    [
        np.hstack([np.zeros((2, 3)), np.eye(2)]),
        np.hstack([_EARLIER_RATE - RATE_BY_POSITION @ _EARLIER_POSITION, RATE_BY_POSITION]),
        np.hstack([-_ACCELERATION @ _EARLIER_POSITION, _ACCELERATION]),
    ],
    axis=1,
)


@dataclass(frozen=True)
class VibrationState:
    """Independent coordinates z, z', z'' of a driven linkage; see each use for the shapes."""

    position: FloatArray
    velocity: FloatArray
    acceleration: FloatArray

    def __getitem__(self, where: int | slice) -> VibrationState:
        """States at chosen instants."""
        return VibrationState(self.position[where], self.velocity[where], self.acceleration[where])


@dataclass(frozen=True)
class EquationsOfMotion:
    """Equations of motion ``M z'' + C z' + K z = f`` at m instants.

    Parameters
    ----------
    mass, damping, stiffness : ndarray, shape (m, n, n)
    force : ndarray, shape (m, n)
    """

    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    force: FloatArray

    def quasi_static(self, constrained: Sequence[int] = ()) -> FloatArray:
        """Displacement z that the loads would cause if nothing moved, (m, n).

        Parameters
        ----------
        constrained : sequence of int
            Coordinates that are zero.

        Returns
        -------
        ndarray, shape (m, n)
        """
        moved = np.setdiff1d(np.arange(self.force.shape[1]), constrained)
        position = np.zeros_like(self.force)
        stiffness = self.stiffness[:, moved[:, None], moved]
        position[:, moved] = np.linalg.solve(stiffness, self.force[:, moved, None])[..., 0]
        return position


def initial_state(
    equations: EquationsOfMotion, position: FloatArray, velocity: FloatArray
) -> VibrationState:
    """State whose acceleration satisfies the first of the equations of motion.

    Parameters
    ----------
    equations : EquationsOfMotion
    position, velocity : ndarray, shape (n,) or (n, k)

    Returns
    -------
    VibrationState
    """
    force = equations.force[0] if position.ndim == 1 else equations.force[0][:, None]
    rest = force - equations.damping[0] @ velocity - equations.stiffness[0] @ position
    return VibrationState(position, velocity, np.linalg.solve(equations.mass[0], rest))


def step_matrices(equations: EquationsOfMotion, step: float) -> tuple[FloatArray, FloatArray]:
    """Solve the effective mass matrix ``M + h/2 C + h^2/4 K`` of each step for all forces.

    Parameters
    ----------
    equations : EquationsOfMotion
        At the ends of m steps.
    step : float
        In s.

    Returns
    -------
    ndarray, shape (m, n, 2 n)
        ``advance`` of :func:`march`.
    ndarray, shape (m, n, n)
        From the force at the end of each step to ``forced``.
    """
    mass, damping, stiffness = equations.mass, equations.damping, equations.stiffness
    effective = mass + step / 2 * damping + step**2 / 4 * stiffness
    size = mass.shape[-1]
    right = [damping / step, stiffness, np.broadcast_to(np.eye(size), mass.shape)]
    solved = np.linalg.solve(effective, step**2 * np.concatenate(right, axis=-1))
    # The predicted velocity is the difference of the last two predictions.
    by_velocity, by_position = solved[..., :size], solved[..., size : 2 * size]
    advance = np.concatenate([by_velocity, -by_velocity - by_position], axis=-1)
    place = np.arange(size)
    advance[:, place, place] -= 1.0
    advance[:, place, size + place] += 2.0
    return advance, np.asarray(solved[..., 2 * size :], dtype=float)


def march(
    state: VibrationState, step: float, advance: FloatArray, forced: FloatArray
) -> VibrationState:
    """Take m steps from a state.

    Each leads to the next prediction, ``z'[k] = advance @ [z'[k-2]; z'[k-1]] + forced``.

    Parameters
    ----------
    state : VibrationState
        Arrays of shape (n,), or (n, k) for k motions at once.
    step : float
        Time step h in s.
    advance : ndarray, shape (m, n, 2 n)
    forced : ndarray, shape (m, n)

    Returns
    -------
    VibrationState
        Arrays of shape (m + 1, n) or (m + 1, n, k), the given state first.
    """
    steps, size = forced.shape
    tail = state.position.shape[1:]
    forced = forced.reshape(steps, size, *(1,) * len(tail))
    prediction = np.empty((steps + 2, size, *tail))
    # The two predictions that the state leaves.
    half = step * state.velocity + step**2 / 2 * state.acceleration
    prediction[1] = state.position + step * state.velocity + step**2 / 4 * state.acceleration
    prediction[0] = prediction[1] - half
    # Each two that follow each other, one below the other, as a view: everything that a step needs
    # is laid out before, and what is left are a product and a sum.
    view = sliding_window_view(prediction.reshape(-1, *tail), 2 * size, axis=0)[::size]
    pairs = np.moveaxis(view, -1, 1)
    for last_two, matrix, force, new in zip(pairs, advance, forced, prediction[2:], strict=False):
        matrix.dot(last_two, new)
        np.add(new, force, new)
    before, now, after = prediction[:-2], prediction[1:-1], prediction[2:]
    mean, difference = (before + after) / 2, (after - before) / 2
    states = (
        (state.position, (mean + now) / 2),
        (state.velocity, difference / step),
        (state.acceleration, (mean - now) * (2 / step**2)),
    )
    return VibrationState(*(np.concatenate([first[None], rest]) for first, rest in states))


def parabolic_work(step: float, power: FloatArray) -> FloatArray:
    """Integral of powers from the first instant on, by the parabola through each double step.

    Parameters
    ----------
    step : float
        h in s, between instants.
    power : ndarray, shape (k, 2 m + 1)

    Returns
    -------
    ndarray, shape (k, 2 m + 1)
    """
    three = np.stack([power[:, :-2:2], power[:, 1::2], power[:, 2::2]])
    middle, end = np.tensordot(2 * step * _WHOLE[1:], three, 1)
    work = np.zeros_like(power)
    np.cumsum(end, axis=1, out=work[:, 2::2])
    work[:, 1::2] = work[:, :-2:2] + middle
    return work
