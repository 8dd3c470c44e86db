"""Polynomials over intervals at whose ends values and some derivatives are known (Hermite)."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linkages.drives.pieces import MotionPiece, PiecewiseMotion


def hermite_coefficients(
    span: FloatArray, starts: Sequence[FloatArray], ends: Sequence[FloatArray]
) -> FloatArray:
    """Coefficients of the powers of ``tau = (t - start) / span`` over each interval.

    Parameters
    ----------
    span : ndarray, shape (m,)
        Of the intervals, in s.
    starts, ends : sequence of n ndarray, shape (..., m)
        At the start and at the end of each: values, their first time derivative, and so on.

    Returns
    -------
    ndarray, shape (2 n, ..., m)
        That of the zeroth power first.
    """
    count = len(starts)
    scales = [span**order / math.factorial(order) for order in range(count)]
    lower = [own * by for own, by in zip(starts, scales, strict=True)]
    # What the powers of the start leave at the end is made by as many higher ones.
    left = [
        end * scales[order] - sum(math.comb(power, order) * own for power, own in enumerate(lower))
        for order, end in enumerate(ends)
    ]
    matrix = [[math.comb(count + j, order) for j in range(count)] for order in range(count)]
    higher = np.tensordot(np.linalg.inv(np.array(matrix, dtype=float)), np.stack(left), 1)
    return np.concatenate([np.stack(lower), higher])


def hermite_pieces(
    time: FloatArray, starts: Sequence[FloatArray], ends: Sequence[FloatArray]
) -> list[MotionPiece]:
    """Pieces of a motion from each instant to the next.

    Parameters
    ----------
    time : ndarray, shape (m,)
        Increasing, in s.
    starts, ends : sequence of ndarray, shape (m - 1,)
        Angle in rad and its time derivatives where each piece starts and ends.

    Returns
    -------
    list of MotionPiece
    """
    span = np.diff(time)
    rows = hermite_coefficients(span, starts, ends).T.tolist()
    return [
        MotionPiece(begin, length, tuple(row))
        for begin, length, row in zip(time[:-1].tolist(), span.tolist(), rows, strict=True)
    ]


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
    pieces = hermite_pieces(
        time, [own[:-1] for own in derivatives], [own[1:] for own in derivatives]
    )
    last = float(derivatives[1][-1]) if end_speed is None else end_speed
    return PiecewiseMotion(tuple(pieces), float(time[-1]), float(derivatives[0][-1]), last)
