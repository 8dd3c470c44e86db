"""Collocation at the ends and the middle of a double step: Lobatto's method IIIA of three stages.

The equations of motion hold at the middle and at the end of a double step of length H = 2 h, as
they do at its start; in between z' and z'' are parabolas. Fourth order, stable for any step, no
numerical damping (Ehle 1969; Hairer & Wanner, *Solving Ordinary Differential Equations II*, 1996,
sec. IV.5); for a load alone this is Simpson's rule. The trapezoidal rule is the same with two
stages. With the products ``H z'`` and ``H^2 z''``, the stages i = middle, end are::

    H z'_i = H z'_0 + a_i0 H^2 z''_0 + sum_j a_ij H^2 z''_j
       z_i = z_0 + c_i H z'_0 + b_i0 H^2 z''_0 + sum_j b_ij H^2 z''_j,   b = a a
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.time_domain.equations import Equations
from flexmech.time_domain.linkage_stretch import LinkageStretch, PinTurns
from flexmech.types import FloatArray

# Coefficients a of start, middle and end.
_WHOLE = np.array([[0, 0, 0], [5 / 24, 8 / 24, -1 / 24], [4 / 24, 16 / 24, 4 / 24]])
STAGES = 2
# What ends and middles count in an integral over many double steps, over h.
WEIGHTS = (2 / 3, 4 / 3)
# By how much H^2 z'' of the stages moves H z' and z there.
_RATE, _POSITION = _WHOLE[1:, 1:], (_WHOLE @ _WHOLE)[1:, 1:]
_ACCELERATION = np.linalg.inv(_POSITION)
# By how much z of the stages moves H z' there.
RATE_BY_POSITION = _RATE @ _ACCELERATION
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
class StageOperators:
    """Equations of motion at both stages of m double steps, and their solution.

    Parameters
    ----------
    resistance : ndarray, shape (m, 2, n, 2 n)
        Stiffness and, beside it, damping over H, at each stage.
    force : ndarray, shape (m, 2, n)
    answer : ndarray, shape (m, 2 p, 2 p)
        By how much unit forces on spread coordinates at the stages move these there.
    yielding : ndarray, shape (m, 2 s, 2 s)
        By how much tensions at the stages fall as links yield to them.
    turns : PinTurns
        Arrays of shape (m, 2, f, k).
    """

    resistance: FloatArray
    force: FloatArray
    answer: FloatArray
    yielding: FloatArray
    turns: PinTurns


def stage_operators(equations: Equations, stretch: LinkageStretch, step: float) -> StageOperators:
    """Solve the equations of both stages for all forces at once.

    Parameters
    ----------
    equations : Equations
        At the middle of m double steps, then at their ends, one pair after the other.
    stretch : LinkageStretch
    step : float
        H in s.

    Returns
    -------
    StageOperators
    """
    size, strains = equations.force.shape[-1], len(stretch.gradient)
    mass, damping, stiffness = (
        part.reshape(-1, STAGES, size, size)
        for part in (equations.mass, equations.damping, equations.stiffness)
    )
    count = len(mass)
    effective = _coupled(step * _RATE, damping) + _coupled(step**2 * _POSITION, stiffness)
    for stage in range(STAGES):
        effective[:, stage, :, stage] += mass[:, stage]
    flat = stretch.pin_turns(equations.motion)
    turns = PinTurns(*(t.reshape(count, STAGES, *t.shape[1:]) for t in (flat.turn, flat.rate)))
    gathered = np.zeros((count, STAGES, size, STAGES, stretch.size))
    for stage in range(STAGES):
        gathered[:, stage, :, stage] = np.swapaxes(stretch.spreading(turns.turn[:, stage]), 1, 2)
    total = STAGES * stretch.size
    solved = np.linalg.solve(
        effective.reshape(count, STAGES * size, -1), gathered.reshape(count, STAGES * size, -1)
    ).reshape(count, STAGES, -1)
    moved = (step**2 * _POSITION @ solved).reshape(count, STAGES, size, total)
    answer = stretch.spread(turns.turn, moved)
    # Strains by unit tensions, which act and are seen by the linear part of the strain.
    pulled = (stretch.gradient @ answer).reshape(count, STAGES, strains, STAGES, -1)
    strain = pulled @ stretch.gradient.T
    by_rate = np.einsum("ik,mksjt->misjt", RATE_BY_POSITION, strain)
    yielding = strain + (stretch.damping_time / step)[:, None, None] * by_rate
    return StageOperators(
        np.concatenate([stiffness, damping / step], axis=-1),
        equations.force.reshape(count, STAGES, size),
        answer.reshape(count, total, total),
        yielding.reshape(count, STAGES * strains, -1),
        turns,
    )


def _coupled(weights: FloatArray, matrices: FloatArray) -> FloatArray:
    """Blocks ``weights[i, j] * matrices[i]``, (m, 2, n, 2, n)."""
    return np.asarray(weights[:, None, :, None] * matrices[:, :, :, None, :])


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
