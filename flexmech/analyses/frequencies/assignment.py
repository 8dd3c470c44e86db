"""Likeness of the modes of two positions, and which is which by it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from flexmech.types import FloatArray, IntArray


def cross_amplitude(first: NDArray[Any], second: NDArray[Any]) -> FloatArray:
    """``|x_i^H M x_j|`` between the modes of paired positions.

    Parameters
    ----------
    first, second : ndarray, shape (B, n, m)
        Mode shapes of unit mass, in coordinates of unit mass
        (:meth:`flexmech.linear_system.LinearSystem.inertial_shapes`).

    Returns
    -------
    ndarray, shape (B, m, m)
        Square root of the modal assurance criterion.
    """
    amplitude: FloatArray = np.abs(np.swapaxes(first.conj(), 1, 2) @ second)
    return amplitude


def assign(amplitude: FloatArray) -> IntArray:
    """One-to-one assignment of the greatest total MAC.

    Parameters
    ----------
    amplitude : ndarray, shape (B, m, m)

    Returns
    -------
    ndarray of int, shape (B, m)
        For each mode (column) of the second position its mode of the first.
    """
    best: IntArray = amplitude.argmax(axis=1)
    unclear = np.flatnonzero(np.any(np.sort(best, axis=1) != np.arange(best.shape[1]), axis=1))
    for number in unclear:
        rows, columns = linear_sum_assignment(amplitude[number] ** 2, maximize=True)
        best[number, columns] = rows
    return best


def same_shapes(known: NDArray[Any], shapes: NDArray[Any], numbering: IntArray | None) -> IntArray:
    """Branch numbers of modes by their likeness to modes with known numbers.

    For modes of different crank speeds, whose coordinates may differ: compared as
    displacements along the links.

    Parameters
    ----------
    known, shapes : ndarray, shape (m, n_links, n_stations, 2)
    numbering : ndarray of int, shape (m,), or None
        Branch of each known mode; in order by default.

    Returns
    -------
    ndarray of int, shape (m,)
    """
    a, b = (np.reshape(s, (len(s), -1)) for s in (known, shapes))
    a, b = (s / _lengths(s) for s in (a, b))
    source: IntArray = assign(np.abs(a.conj() @ b.T)[None])[0]
    return source if numbering is None else numbering[source]


def _lengths(shapes: NDArray[Any]) -> FloatArray:
    """Norm of each shape (m, 1); one where nothing moves but sections turn, at stations of none."""
    length = np.linalg.norm(shapes, axis=1, keepdims=True)
    return np.where(length > 0, length, 1.0)
