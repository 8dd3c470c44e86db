"""From a laminate to a beam: what is free across the link, and the stiffness along it.

``narrow``: the stress resultants across the link and in shear of its plies vanish (plane
stress); ``wide``: their strains do (plane strain, cylindrical bending). For Reddy's theory
the higher-order resultants and strains are treated alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np

from flexmech.materials import Laminate
from flexmech.types import FloatArray

__all__ = ["REDUCTIONS", "Reduction", "laminate_strains", "reduced_stiffness", "shear_across"]

Reduction = Literal["narrow", "wide"]
REDUCTIONS: tuple[Reduction, ...] = ("narrow", "wide")


def reduced_stiffness(
    laminate: Laminate, reduction: Reduction, powers: Sequence[int]
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

    Returns
    -------
    ndarray, shape (P, P)
        In N/m times m to the two powers.
    """
    matrix = _stiffness(laminate, powers)
    along = np.arange(0, len(matrix), 3)
    every = laminate_strains(laminate, reduction, np.eye(len(along)), powers)
    reduced = matrix[along] @ every.reshape(len(along), -1).T
    return np.asarray((reduced + reduced.T) / 2)


def laminate_strains(
    laminate: Laminate,
    reduction: Reduction,
    strains: FloatArray,
    powers: Sequence[int] = (0, 1),
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
        matrix = _stiffness(laminate, powers)
        others = np.setdiff1d(np.arange(size), along)
        free = -np.linalg.solve(matrix[np.ix_(others, others)], matrix[np.ix_(others, along)])
        every[..., others] = strains @ free.T
    return every.reshape(*strains.shape, 3)


def shear_across(stiffness: FloatArray, reduction: Reduction) -> float:
    """Shear strain across the link over that along it, from a (2, 2) stiffness (zy, xy).

    In a narrow link no shear force acts across; in a wide one nothing shears across.
    """
    if reduction == "wide":
        return 0.0
    return float(-stiffness[0, 1] / stiffness[0, 0])


def _stiffness(laminate: Laminate, powers: Sequence[int]) -> FloatArray:
    """Matrix of 3x3 blocks by powers of y, (3 P, 3 P)."""
    return np.block([[laminate.stiffness_moment(p + q) for q in powers] for p in powers])
