"""From a laminate to a beam: what is free across the link, and the stiffness along it.

``narrow``: the stress resultants across the link and in shear of its plies vanish (plane
stress); ``wide``: their strains do (plane strain, cylindrical bending). For Reddy's theory
the higher-order resultants and strains are treated alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from flexmech.materials import Laminate
from flexmech.types import FloatArray

__all__ = [
    "REDUCTIONS",
    "Reduction",
    "Strained",
    "WarpingParts",
    "laminate_strains",
    "reduced_stiffness",
    "shear_across",
    "stiffness_by_powers",
    "warping_parts",
]

Reduction = Literal["narrow", "wide"]
REDUCTIONS: tuple[Reduction, ...] = ("narrow", "wide")


def reduced_stiffness(
    laminate: Laminate, reduction: Reduction, powers: Sequence[int], restraint: float = 0.0
) -> FloatArray:
    """Stiffness along the link by the strains k_p of ``sum(k_p y**p)``, over the width.

    Powers 0 and 1 are the classical theory (matrices A, B, D), powers 0, 1 and 3 Reddy's
    (A, B, D, E, F, H; Reddy, *Mechanics of Laminated Composite Plates and Shells*,
    sec. 11.2). What the narrow link lets go is condensed from all of them at once.

    Parameters
    ----------
    laminate : Laminate
    reduction : {"narrow", "wide"}
    powers : sequence of int
        Of y in the strain, P of them.
    restraint : float
        Of the twist; see :func:`laminate_strains`.

    Returns
    -------
    ndarray, shape (P, P)
        In N/m times m to the two powers.
    """
    matrix = stiffness_by_powers(laminate, powers)
    along = np.arange(0, len(matrix), 3)
    every = laminate_strains(laminate, reduction, np.eye(len(along)), powers, restraint)
    reduced = matrix[along] @ every.reshape(len(along), -1).T
    return np.asarray((reduced + reduced.T) / 2)


def laminate_strains(
    laminate: Laminate,
    reduction: Reduction,
    strains: FloatArray,
    powers: Sequence[int] = (0, 1),
    restraint: float = 0.0,
) -> FloatArray:
    """In-plane strains of the laminate that go with strains along the link.

    Parameters
    ----------
    laminate : Laminate
    reduction : {"narrow", "wide"}
    strains : ndarray, shape (..., P)
        Along the link, by powers of y.
    powers : sequence of int
        Of y in the strain, P of them.
    restraint : float
        Of a narrow link's twist, the gradient in y of the shear strain: 0 leaves it free, 1
        holds it.

    Returns
    -------
    ndarray, shape (..., P, 3)
        Strains x, z and xz by powers of y.
    """
    size = 3 * len(powers)
    along = np.arange(0, size, 3)
    every = np.zeros((*strains.shape[:-1], size))
    every[..., along] = strains
    if reduction == "narrow":
        matrix = stiffness_by_powers(laminate, powers)
        others = np.setdiff1d(np.arange(size), along)
        for held, share in (([], 1 - restraint), ([3 * list(powers).index(1) + 2], restraint)):
            if share:
                free = np.setdiff1d(others, held)
                moved = np.linalg.solve(matrix[np.ix_(free, free)], matrix[np.ix_(free, along)])
                every[..., free] -= share * strains @ moved.T
    return every.reshape(*strains.shape, 3)


@dataclass(frozen=True)
class Strained:
    """In-plane strains of a laminate at points in its layers.

    Parameters
    ----------
    place, weight : ndarray, shape (N, m)
        In m: where, and what each point counts in an integral through the thickness.
    strain : ndarray, shape (N, m, 3)
        Strains x, z and xz; those that a narrow link lets go are not among them.
    """

    place: FloatArray
    weight: FloatArray
    strain: FloatArray


@dataclass(frozen=True)
class WarpingParts:
    """Strains of warping cross-sections, against those of stretching and bending.

    Parameters
    ----------
    classical : ndarray, shape (2, 2)
        Stiffness along the link by mid-plane strain and its gradient, in N, N m and N m^2 for
        each metre of width.
    coupling : ndarray, shape (2,)
        Of these with the warping.
    residual : ndarray, shape (N, m, 3)
        What is left of the warping's strains without the stretching and bending that it holds.
    stiffness : float
        Integral of the residual's stress times strain.
    """

    classical: FloatArray
    coupling: FloatArray
    residual: FloatArray
    stiffness: float

    @property
    def matrix(self) -> FloatArray:
        """Stiffness by mid-plane strain, its gradient and the warping, (3, 3)."""
        held = np.linalg.solve(self.classical, self.coupling)
        column = self.coupling[:, None]
        return np.block(
            [[self.classical, column], [column.T, self.coupling @ held + self.stiffness]]
        )


def warping_parts(
    laminate: Laminate, reduction: Reduction, warped: Strained, restraint: float = 0.0
) -> WarpingParts:
    """Split the strains of warping cross-sections from stretching and bending.

    Stretching and bending are those of classical theory. If a free edge let go strains of higher
    order with them, they would be too soft however slender the link; so what warping lets go of
    its own belongs to the warping alone.

    Parameters
    ----------
    laminate : Laminate
    reduction : {"narrow", "wide"}
    warped : Strained
        Strains of a unit change of the warping along the link.
    restraint : float
        Of the twist; see :func:`laminate_strains`.

    Returns
    -------
    WarpingParts
    """
    y, stiffness = warped.place, laminate.transformed_stiffness
    bent = laminate_strains(laminate, reduction, np.eye(2), restraint=restraint)
    mean, gradient = np.moveaxis(bent, 1, 0)
    classical = mean[:, None, None] + gradient[:, None, None] * y[..., None]

    def products(left: FloatArray, right: FloatArray) -> FloatArray:
        """Integrals of fields (a, N, m, 3) with the stress of fields (b, N, m, 3)."""
        stress = np.einsum("nij,bnmj->bnmi", stiffness, right)
        return np.asarray(np.einsum("nm,anmi,bnmi->ab", warped.weight, left, stress))

    own = reduced_stiffness(laminate, reduction, (0, 1), restraint)
    coupling = products(classical, warped.strain[None])[:, 0]
    residual = warped.strain - np.tensordot(np.linalg.solve(own, coupling), classical, axes=1)
    if reduction == "narrow":
        # Of like size, whatever the units of the warping.
        shapes = np.stack([np.ones_like(y), y, residual[..., 0]])
        shapes /= np.abs(shapes).max(axis=(1, 2))[:, None, None]
        free = np.zeros((2, *shapes.shape, 3))
        free[0, ..., 1] = free[1, ..., 2] = shapes
        free = free.reshape(6, *residual.shape)
        amount = np.linalg.solve(products(free, free), products(free, residual[None]))[:, 0]
        residual = residual - np.tensordot(amount, free, axes=1)
    return WarpingParts(
        own, coupling, residual, float(products(residual[None], residual[None])[0, 0])
    )


def shear_across(stiffness: FloatArray, reduction: Reduction) -> float:
    """Shear strain across the link over that along it, from a (2, 2) stiffness (zy, xy).

    In a narrow link no shear force acts across; in a wide one nothing shears across.
    """
    if reduction == "wide":
        return 0.0
    return float(-stiffness[0, 1] / stiffness[0, 0])


def stiffness_by_powers(laminate: Laminate, powers: Sequence[int]) -> FloatArray:
    """Stiffness by the strains x, z and xz, each times powers of y.

    Parameters
    ----------
    laminate : Laminate
    powers : sequence of int
        P of them.

    Returns
    -------
    ndarray, shape (3 P, 3 P)
        Of 3x3 blocks, in N/m times m to the two powers.
    """
    return np.block([[laminate.stiffness_moment(p + q) for q in powers] for p in powers])
