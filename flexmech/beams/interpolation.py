"""Interpolation between the nodes of beam elements, and where a node's coordinates stand."""

from __future__ import annotations

import numpy as np

from flexmech.types import FloatArray


def hermite(s: FloatArray, length: FloatArray, derivatives: int = 3) -> tuple[FloatArray, ...]:
    """Cubic with end values and slopes, and its first derivatives.

    Parameters
    ----------
    s, length : ndarray, shape (m,)
        Places from 0 to 1, and lengths of the elements in m.
    derivatives : int
        How many of them.

    Returns
    -------
    tuple of ndarray, shape (m, 4)
    """
    powers = np.stack([np.ones_like(s), s, s**2, s**3], axis=-1)
    scale = np.ones((len(s), 4))
    scale[:, 1] = scale[:, 3] = length
    shapes = []
    for order in range(derivatives + 1):
        shapes.append(powers @ _HERMITE[order] * scale)
        scale = scale / length[:, None]
    return tuple(shapes)


# Coefficients of 1, s, s^2 and s^3 (rows) of the four cubics (columns), and of their
# derivatives.
_CUBICS = np.array([[1.0, 0, 0, 0], [0, 1, 0, 0], [-3, -2, 3, -1], [2, 1, -2, 1]])
_DERIVATIVE = np.array([[0.0, 1, 0, 0], [0, 0, 2, 0], [0, 0, 0, 3], [0, 0, 0, 0]])
_HERMITE = [np.linalg.matrix_power(_DERIVATIVE, order) @ _CUBICS for order in range(4)]


def hermite_integral(s: FloatArray, length: FloatArray) -> FloatArray:
    """Integral of the cubic from the element's start; (s, 4)."""
    rows = [
        s - s**3 + s**4 / 2,
        s**2 / 2 - 2 * s**3 / 3 + s**4 / 4,
        s**3 - s**4 / 2,
        s**4 / 4 - s**3 / 3,
    ]
    one = np.ones_like(s)
    scale = np.stack([one, length, one, length], axis=-1)
    return np.stack(rows, axis=-1) * scale * length[:, None]


def placed(rows: FloatArray, columns: tuple[int, ...], size: int) -> FloatArray:
    """Rows at some of an element's coordinates, zero at the others.

    Parameters
    ----------
    rows : ndarray, shape (m, k)
    columns : tuple of int
        Where they belong, k of them.
    size : int
        Number of coordinates.

    Returns
    -------
    ndarray, shape (m, size)
    """
    full = np.zeros((len(rows), size))
    full[:, columns] = rows
    return full


def linear(fraction: FloatArray, length: FloatArray, size: int) -> tuple[FloatArray, FloatArray]:
    """Linear interpolation of the axial displacement, and its derivative.

    Parameters
    ----------
    fraction, length : ndarray, shape (m,)
        Places from 0 to 1, and lengths of the elements in m.
    size : int
        Number of an element's coordinates.

    Returns
    -------
    tuple of ndarray, shape (m, size)
    """
    value, slope = np.zeros((2, len(fraction), size))
    first, second = 0, size // 2
    value[:, first], value[:, second] = 1 - fraction, fraction
    slope[:, second] = 1 / length
    slope[:, first] = -slope[:, second]
    return value, slope
