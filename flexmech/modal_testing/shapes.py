"""How alike two mode shapes are, and how far a shape is from a real one."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray
from flexmech.errors import InputError


def mac(first: NDArray[Any], second: NDArray[Any]) -> FloatArray:
    """Modal assurance criterion of all pairs of two sets of shapes.

    Parameters
    ----------
    first : ndarray, shape (points, k)
        Real or complex shapes as columns; one shape may be of shape (points,).
    second : ndarray, shape (points, l)

    Returns
    -------
    ndarray, shape (k, l)
        ``|a^H b|^2 / (a^H a  b^H b)``: 1 for shapes that differ by a factor alone, 0 for orthogonal
        ones. It is not a number where a shape is zero everywhere or holds no number.

    Raises
    ------
    InputError
        The shapes have different points.

    Notes
    -----
    Source: R. J. Allemang, Sound and Vibration 37 (2003), no. 8, 14-21.

    Examples
    --------
    >>> mac(np.array([1.0, 2.0]), np.array([[2.0j, 2.0], [4.0j, -1.0]])).tolist()
    [[1.0, 0.0]]
    """
    a, b = _columns(first), _columns(second)
    if a.shape[0] != b.shape[0]:
        raise InputError(
            f"shapes at {a.shape[0]} and at {b.shape[0]} points: give both at the same points"
        )
    own = np.outer(np.sum(abs(a) ** 2, axis=0), np.sum(abs(b) ** 2, axis=0))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(abs(a.conj().T @ b) ** 2 / own)


def complexity_factor(shape: NDArray[Any]) -> FloatArray:
    """Modal complexity factor of shapes.

    Parameters
    ----------
    shape : ndarray of complex, shape (points, k)
        Shapes as columns; one shape may be of shape (points,).

    Returns
    -------
    ndarray, shape (k,)
        0 where all points move in phase or against it, 1 where the phases favour no direction:
        ``1 - |sum x^2|^2 / (sum |x|^2)^2``. Not a number for a shape that is zero everywhere.

    Notes
    -----
    With the sums of squares and of products of real and imaginary parts it is
    ``1 - ((Sxx - Syy)^2 + 4 Sxy^2)/(Sxx + Syy)^2``. Source: M. Imregun and D. J. Ewins, Proceedings
    of the 13th International Modal Analysis Conference (1995), 496-506, "Complex modes: origins
    and limits".

    Examples
    --------
    >>> complexity_factor(np.array([[1.0, 1.0], [-2.0, 1.0j]])).tolist()
    [0.0, 1.0]
    """
    x = _columns(shape)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(1.0 - abs(np.sum(x**2, axis=0)) ** 2 / np.sum(abs(x) ** 2, axis=0) ** 2)


def _columns(shapes: NDArray[Any]) -> NDArray[Any]:
    shapes = np.asarray(shapes)
    return shapes[:, None] if shapes.ndim == 1 else shapes
