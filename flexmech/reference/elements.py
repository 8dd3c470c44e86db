"""The two-node plane beam of Euler and Bernoulli: linear along, Hermite across.

Coordinates of an element: (u1, v1, phi1, u2, v2, phi2), displacement along and across the
element and rotation at its two nodes. All functions take element lengths of shape (e,)
and return matrices of shape (e, 6, 6).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "geometric_stiffness",
    "gyroscopic_matrix",
    "mass_matrix",
    "shape_functions",
    "stiffness_matrix",
]

FloatArray = NDArray[np.float64]

AXIAL = (0, 3)
BENDING = (1, 2, 4, 5)


def _from_blocks(axial: FloatArray, bending: FloatArray) -> FloatArray:
    matrix = np.zeros((len(bending), 6, 6))
    matrix[:, np.array(AXIAL)[:, None], AXIAL] = axial
    matrix[:, np.array(BENDING)[:, None], BENDING] = bending
    return matrix


def _scaled(rows: list[list[int]], length: FloatArray, power: float) -> FloatArray:
    """Hermite matrix: rotations carry one more power of the length each."""
    scale = np.stack([np.ones_like(length), length, np.ones_like(length), length], axis=-1)
    return np.array(rows) * scale[:, :, None] * scale[:, None, :] * length[:, None, None] ** power


def stiffness_matrix(
    length: FloatArray, axial_stiffness: float, bending_stiffness: float
) -> FloatArray:
    """Elastic stiffness; Kumar & Chandrakar, eq. 1.53, corrected (k36 = k63 = +2EI/L).

    Parameters
    ----------
    length : ndarray, shape (e,)
        In m.
    axial_stiffness, bending_stiffness : float
        EA in N and EI in N m^2.

    Returns
    -------
    ndarray, shape (e, 6, 6)
    """
    rows = [[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]]
    axial = np.array([[1.0, -1], [-1, 1]]) * (axial_stiffness / length)[:, None, None]
    return _from_blocks(axial, bending_stiffness * _scaled(rows, length, -3))


def mass_matrix(length: FloatArray, mass_per_length: float) -> FloatArray:
    """Consistent mass; Kumar & Chandrakar, eq. 1.52, corrected (m22 = 13/35)."""
    rows = [[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]
    axial = np.array([[2.0, 1], [1, 2]]) * (mass_per_length * length / 6)[:, None, None]
    return _from_blocks(axial, mass_per_length / 420 * _scaled(rows, length, 1))


def gyroscopic_matrix(length: FloatArray, mass_per_length: float) -> FloatArray:
    """``S``, the integral of ``rho A N^T J N``; K, eq. 1.54 with ``m_vel = omega S``."""
    product = np.array([[21.0, 3, 9, -2], [9, 2, 21, -3]]) / 60
    scale = np.stack([np.ones_like(length), length, np.ones_like(length), length], axis=-1)
    coupling = mass_per_length * product * scale[:, None, :] * length[:, None, None]
    matrix = np.zeros((len(length), 6, 6))
    matrix[:, np.array(AXIAL)[:, None], BENDING] = -coupling
    matrix[:, np.array(BENDING)[:, None], AXIAL] = np.swapaxes(coupling, 1, 2)
    return matrix


def geometric_stiffness(length: FloatArray, tension: FloatArray) -> FloatArray:
    """Geometric stiffness of elements whose tension varies along them.

    With a constant tension this is Kumar & Chandrakar, eq. 1.58. Inertia forces make the
    tension quadratic in place; its mean alone would cost two orders of convergence.

    Parameters
    ----------
    length : ndarray, shape (e,)
    tension : ndarray, shape (..., e, 3)
        Legendre coefficients in N: mean, linear and quadratic part.

    Returns
    -------
    ndarray, shape (..., e, 6, 6)
    """
    scale = np.stack([np.ones_like(length), length, np.ones_like(length), length], axis=-1)
    unit = _UNIT_GEOMETRIC * (scale[:, None, :, None] * scale[:, None, None, :])
    unit = unit / length[:, None, None, None]
    matrix = np.zeros((*tension.shape[:-1], 6, 6))
    matrix[..., np.array(BENDING)[:, None], BENDING] = np.einsum(
        "...ek,ekij->...eij", tension, unit
    )
    return matrix


def _unit_geometric() -> FloatArray:
    """Integrals of P_k H'^T H' over a unit element for the Legendre polynomials k = 0, 1, 2."""
    points, weights = np.polynomial.legendre.leggauss(4)  # exact to degree 7; degree 6 is met
    s = (points + 1) / 2
    slopes = np.stack([6 * s**2 - 6 * s, 1 - 4 * s + 3 * s**2, 6 * s - 6 * s**2, 3 * s**2 - 2 * s])
    polynomials = np.stack([np.ones_like(s), points, (3 * points**2 - 1) / 2])
    integrals: FloatArray = np.einsum("kg,ig,jg,g->kij", polynomials, slopes, slopes, weights / 2)
    return integrals


_UNIT_GEOMETRIC = _unit_geometric()


def shape_functions(fraction: FloatArray, length: FloatArray) -> FloatArray:
    """Displacement inside elements.

    Parameters
    ----------
    fraction, length : ndarray, shape (s,)
        Place in the element from 0 to 1, and the element's length.

    Returns
    -------
    ndarray, shape (s, 2, 6)
    """
    s = fraction
    values = np.zeros((len(s), 2, 6))
    values[:, 0, 0], values[:, 0, 3] = 1 - s, s
    values[:, 1, 1] = 1 - 3 * s**2 + 2 * s**3
    values[:, 1, 2] = length * (s - 2 * s**2 + s**3)
    values[:, 1, 4] = 3 * s**2 - 2 * s**3
    values[:, 1, 5] = length * (s**3 - s**2)
    return values
