"""By what factor the speed may rise where a part of a pin's force grows with its square.

The force at s times the speed is F0 + s^2 F1: what acts at rest, and inertia. Vectors are over what
is allowed, so that their bound is 1.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray


def speed_of_force(still: FloatArray, growing: FloatArray) -> FloatArray:
    """Speed factor at which a force reaches its bound, ``|F0 + s^2 F1| = 1``.

    Parameters
    ----------
    still, growing : ndarray, shape (..., 2)
        F0 and F1 over the allowed force.

    Returns
    -------
    ndarray, shape (...)
        Zero where the force at rest is too large already, infinite where it never is.
    """
    square, _ = _crossing(still, growing)
    return _of_square(square, np.hypot(still[..., 0], still[..., 1]))


def speed_of_pull(still: FloatArray, growing: FloatArray) -> FloatArray:
    """The same of the part of a force that tears at an eye, :func:`tearing_force`.

    Parameters
    ----------
    still, growing : ndarray, shape (..., 2)
        F0 and F1 over the allowed force: away from the link along its axis, and across.

    Returns
    -------
    ndarray, shape (...)
    """
    whole, pulls = _crossing(still, growing)
    alone, _ = _crossing(still * (0.0, 1.0), growing * (0.0, 1.0))
    # The part is convex in s^2: it leaves the bound once, while it pulls or while it pushes.
    return _of_square(np.where(pulls, whole, alone), tearing_force(still))


def tearing_force(force: FloatArray) -> FloatArray:
    """Size of a pin's force on an eye without what pushes the eye onto its link.

    Parameters
    ----------
    force : ndarray, shape (..., 2)
        Away from the link along its axis, and across.

    Returns
    -------
    ndarray, shape (...)
        The whole force where it pulls, its part across the link where it pushes: an eye that is
        rounded about the hole bears alike in all these directions.
    """
    return np.asarray(np.hypot(np.maximum(force[..., 0], 0.0), force[..., 1]))


def speed_of_wear(still: FloatArray, growing: FloatArray) -> FloatArray:
    """Speed factor at which force times sliding velocity reaches its bound.

    The velocity grows with s, so that it is at ``s |F0 + s^2 F1| = 1``: with inertia alone the cube
    root of the load factor. Squared it is a cubic equation in 1 / s^2, solved in closed form.

    Parameters
    ----------
    still, growing : ndarray, shape (..., 2)
        F0 and F1 over the force that is allowed at the speed itself.

    Returns
    -------
    ndarray, shape (...)
        Infinite where it never is.
    """
    first, both, second = _products(still, growing)
    # w^3 - |F0|^2 w^2 - 2 F0.F1 w - |F1|^2 = 0 with w = 1 / s^2, whose largest root comes first;
    # w = x + shift takes the square out of it.
    shift = first / 3
    linear = -3 * shift**2 - 2 * both
    constant = -2 * shift**3 - 2 * both * shift - second
    root = _largest_root(linear, constant) + shift
    with np.errstate(divide="ignore"):
        return np.asarray(1 / np.sqrt(np.maximum(root, 0.0)))


def _largest_root(linear: FloatArray, constant: FloatArray) -> FloatArray:
    """Largest real root of ``x^3 + linear x + constant``, by Cardano and by Viete."""
    half, third = constant / 2, linear / 3
    under = half**2 + third**3
    one = under > 0
    # One real root: the cube root without cancellation, and the other one by their product.
    large = -np.cbrt(half + np.copysign(np.sqrt(np.where(one, under, 0.0)), half))
    with np.errstate(divide="ignore", invalid="ignore"):
        small = np.where(large == 0, 0.0, -third / large)
        # Three: linear is negative, or all are zero.
        size = np.sqrt(np.maximum(-third, 0.0))
        cosine = np.where(size == 0, 0.0, -half / size**3)
    three = 2 * size * np.cos(np.arccos(np.clip(cosine, -1.0, 1.0)) / 3)
    return np.where(one, large + small, three)


def _products(still: FloatArray, growing: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Scalar products of F0 with itself, of both, and of F1 with itself."""
    first, both = np.sum(still * still, axis=-1), np.sum(still * growing, axis=-1)
    return first, both, np.sum(growing * growing, axis=-1)


def _crossing(still: FloatArray, growing: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Largest s^2 at which ``|F0 + s^2 F1| = 1``, and whether it is one at which F pulls.

    Infinite where the force does not grow; negative or not a number where there is none.
    """
    first, both, second = _products(still, growing)
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(both**2 + second * (1 - first))
        # Either form of the root of the quadratic equation, without cancellation.
        square = np.where(both > 0, (1 - first) / (both + root), (root - both) / second)
        square = np.where(second == 0, np.where(first <= 1, np.inf, np.nan), square)
        along = np.where(
            growing[..., 0] == 0, still[..., 0], still[..., 0] + square * growing[..., 0]
        )
    return square, (square >= 0) & (along >= 0)


def _of_square(square: FloatArray, at_rest: FloatArray) -> FloatArray:
    """Root of s^2; none is left where the force at rest is beyond its bound."""
    with np.errstate(invalid="ignore"):
        return np.where(at_rest > 1, 0.0, np.sqrt(square))
