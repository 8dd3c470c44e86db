"""Polynomials between instants at which values and some derivatives are known (Hermite)."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linkages.drives.pieces import MotionPiece, PiecewiseMotion


def hermite_coefficients(time: FloatArray, derivatives: Sequence[FloatArray]) -> FloatArray:
    """Coefficients of the powers of ``tau = (t - start) / span`` between instants.

    Parameters
    ----------
    time : ndarray, shape (m,)
        Increasing, in s.
    derivatives : sequence of n ndarray, shape (..., m)
        The values, their first time derivative, and so on.

    Returns
    -------
    ndarray, shape (2 n, ..., m - 1)
        That of the zeroth power first.
    """
    count, span = len(derivatives), np.diff(time)
    scales = [span**order / math.factorial(order) for order in range(count)]
    starts = [own[..., :-1] * by for own, by in zip(derivatives, scales, strict=True)]
    ends = [own[..., 1:] * by for own, by in zip(derivatives, scales, strict=True)]
    # What the powers of the start leave at the end is made by as many higher ones.
    left = [
        end - sum(math.comb(power, order) * own for power, own in enumerate(starts))
        for order, end in enumerate(ends)
    ]
    matrix = [[math.comb(count + j, order) for j in range(count)] for order in range(count)]
    higher = np.tensordot(np.linalg.inv(np.array(matrix, dtype=float)), np.stack(left), 1)
    return np.concatenate([np.stack(starts), higher])


def hermite_motion(
    time: FloatArray, derivatives: Sequence[FloatArray], end_speed: float | None = None
) -> PiecewiseMotion:
    """Motion through angles with their speeds, accelerations and so on.

    Parameters
    ----------
    time : ndarray, shape (m,)
        Increasing, in s.
    derivatives : sequence of ndarray, shape (m,)
        Angle in rad and its time derivatives.
    end_speed : float, optional
        From the last time on, in rad/s; the last one if left out.

    Returns
    -------
    PiecewiseMotion
    """
    rows = hermite_coefficients(time, derivatives).T.tolist()
    spans = np.diff(time).tolist()
    pieces = [
        MotionPiece(begin, length, tuple(row))
        for begin, length, row in zip(time[:-1].tolist(), spans, rows, strict=True)
    ]
    last = float(derivatives[1][-1]) if end_speed is None else end_speed
    return PiecewiseMotion(tuple(pieces), float(time[-1]), float(derivatives[0][-1]), last)
