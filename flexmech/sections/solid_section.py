"""A cross-section as it is in three dimensions: the stiffness of a prismatic bar.

A long bar with forces and moments at its ends alone has, away from them, strains that grow
linearly along it (Saint-Venant). Its cross-sections warp, in and out of their planes. With the
warping in finite elements over the section, the equations of the bar give the warping of each
load, and its energy the compliance by all six loads (Giavotto, Borri, Mantegazza, Ghiringhelli,
Carmaschi, Maffioli & Mussi, *Computers & Structures* 16 (1983) 403). Nothing is assumed about
the shape of the strains, so that edges of angle plies are free of stress.

Section axes: x along the link, y through the thickness, z along the width. Six strains and
their loads: stretch, shear along y and z, twist, and the curvatures of z and y, so that
``eps_x = e + z k_y - y k_z``.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from flexmech.arrays import FloatArray, IntArray
from flexmech.errors import ComputationError
from flexmech.model_text import shapes, short_repr

STRETCH, TWIST, ACROSS_PLANE, CURVATURE = 0, 3, 4, 5
"""Strains of a section by number; the last curvature is that which bends through the layers."""
LOADS = 6
# Strains x, y, z, yz, xz, xy: displacements and the direction along which they change.
STRAINS = (((0, 0),), ((1, 1),), ((2, 2),), ((1, 2), (2, 1)), ((0, 2), (2, 0)), ((0, 1), (1, 0)))
# Integrals over an element of length one of two parabolas, of two slopes, and of a parabola (row)
# and a slope (column); nodes at its start, middle and end.
_MASS = np.array([[4.0, 2.0, -1.0], [2.0, 16.0, 2.0], [-1.0, 2.0, 4.0]]) / 30
_STIFFNESS = np.array([[7.0, -8.0, 1.0], [-8.0, 16.0, -8.0], [1.0, -8.0, 7.0]]) / 3
_COUPLING = np.array([[-3.0, 4.0, -1.0], [-4.0, 0.0, 4.0], [1.0, -4.0, 3.0]]) / 6
# By what rows and columns stand for, with the power of the length with which it goes.
VALUES, SLOPES = (False, False), (True, True)
_INTEGRALS = {
    VALUES: (_MASS, 1),
    SLOPES: (_STIFFNESS, -1),
    (False, True): (_COUPLING, 0),
    (True, False): (_COUPLING.T, 0),
}


def graded(count: int, share: float) -> FloatArray:
    """Ends of elements between 0 and 1, graded towards both ends.

    Parameters
    ----------
    count : int
        Count of the elements.
    share : float
        Share of spacing by a cosine; the rest is even.

    Returns
    -------
    ndarray, shape (count + 1,)
    """
    s = np.linspace(0, 1, count + 1)
    return np.asarray(share * (1 - np.cos(np.pi * s)) / 2 + (1 - share) * s)


def rows_of_runs(faces: FloatArray, total: int) -> tuple[FloatArray, IntArray]:
    """Share rows of elements among runs of layers by their thickness, one at least to each.

    Parameters
    ----------
    faces : ndarray, shape (n + 1,)
        Faces of the runs, ascending.
    total : int
        About how many rows.

    Returns
    -------
    ends : ndarray, shape (m + 1,)
        Ends of all rows.
    count : ndarray of int, shape (n,)
        Rows of each run.
    """
    shares = total * np.diff(faces) / (faces[-1] - faces[0])
    count = np.maximum(1, np.round(shares)).astype(int)
    return lines_of_rows(faces, count), count


def lines_of_rows(faces: FloatArray, count: IntArray) -> FloatArray:
    """Faces of rows of elements, of which as many as ``count`` (n,) are of each run, evenly."""
    ends = np.concatenate([[0], np.cumsum(count)])
    return np.asarray(np.interp(np.arange(ends[-1] + 1), ends, faces))


class Parabolas:
    """Quadratic shape functions in each element, with a node in its middle.

    Parameters
    ----------
    ends : ndarray, shape (n + 1,)
        Ends of the elements, ascending.

    Attributes
    ----------
    places : ndarray, shape (2 n + 1,)
        Places of the nodes.
    size : int
        Number of nodes.
    rows, columns : ndarray of int, shape (9 n,)
        Row and column of the matrices' entries, one element after the other.
    """

    def __init__(self, ends: FloatArray) -> None:
        self._lengths = np.diff(ends)
        self.places = np.sort(np.concatenate([ends, (ends[1:] + ends[:-1]) / 2]))
        self.size = len(self.places)
        nodes = 2 * np.arange(len(self._lengths))[:, None] + np.arange(3)
        self.rows, self.columns = np.repeat(nodes, 3, axis=1).ravel(), np.tile(nodes, 3).ravel()

    def entries(self, slopes: tuple[bool, bool], weight: FloatArray | None = None) -> FloatArray:
        """Integrals of a weight times two functions or slopes in each element.

        Parameters
        ----------
        slopes : tuple of bool
            Whether rows and columns stand for slopes: :data:`VALUES`, :data:`SLOPES`, or a function
            and a slope.
        weight : ndarray, shape (n,), optional
            Weight of each element; one where it is left out.

        Returns
        -------
        ndarray, shape (9 n,)
        """
        element, power = _INTEGRALS[slopes]
        factor = self._lengths**power if weight is None else weight * self._lengths**power
        return np.outer(factor, element).ravel()

    def integral(self, slopes: tuple[bool, bool], weight: FloatArray | None = None) -> Any:
        """Sparse matrix of :meth:`entries`, (2 n + 1, 2 n + 1)."""
        places, shape = (self.rows, self.columns), (self.size, self.size)
        return sp.csr_matrix((self.entries(slopes, weight), places), shape=shape)


@dataclass(frozen=True, repr=False)
class SolidSection:
    """Compliance of a cross-section.

    Parameters
    ----------
    compliance : ndarray, shape (6, 6)
        Stretch, shear along y and z, twist, curvatures of z and y by the axial force, shear
        forces along y and z, torque, and the moments of these curvatures.
    """

    compliance: FloatArray

    def __repr__(self) -> str:
        return short_repr(self, *shapes(self))

    @cached_property
    def stiffness(self) -> FloatArray:
        """Its inverse, (6, 6)."""
        return np.asarray(np.linalg.inv(self.compliance))

    def stiffness_of(self, strains: Sequence[int]) -> FloatArray:
        """Stiffness by some strains where the loads of all others vanish.

        Parameters
        ----------
        strains : sequence of int, length n
            Their numbers.

        Returns
        -------
        ndarray, shape (n, n)
        """
        return np.asarray(np.linalg.inv(self.compliance[np.ix_(strains, strains)]))


def solid_section(faces: FloatArray, stiffness: FloatArray, sides: FloatArray) -> SolidSection:
    """Compliance of a rectangle of layers.

    Parameters
    ----------
    faces : ndarray, shape (n + 1,)
        Places y of the elements' faces in m, ascending; a row of elements has one material.
    stiffness : ndarray, shape (n, 6, 6)
        Stiffness of each row by strains x, y, z, yz, xz and xy in Pa.
    sides : ndarray, shape (m + 1,)
        Places z of the elements' sides in m, ascending.

    Returns
    -------
    SolidSection

    Raises
    ------
    ComputationError
        If the stiffnesses differ too much to solve for the warping.
    """
    # In units of the section, whatever its size.
    length, modulus = faces[-1] - faces[0], float(np.abs(stiffness).max())
    through, across = Parabolas(faces / length), Parabolas(sides / length)
    try:
        compliance = _central_solutions(through, across, stiffness / modulus)
    except RuntimeError as error:
        raise ComputationError(
            "the warping of a laminate section cannot be solved for: its plies' stiffnesses or "
            "thicknesses differ too much; check their units"
        ) from error
    unit = length ** np.array([1, 1, 1, 2, 2, 2])
    return SolidSection(compliance / (np.outer(unit, unit) * modulus))


def section_energy(
    through: Parabolas, across: Parabolas, stiffness: FloatArray, rates: tuple[bool, bool]
) -> Any:
    """Twice the strain energy of each metre by displacements of a section, or by their rates.

    Parameters
    ----------
    through, across : Parabolas
        Along y and z.
    stiffness : ndarray, shape (n, 6, 6)
        Stiffness of each row of elements by strains x, y, z, yz, xz and xy.
    rates : tuple of bool
        Whether rows and columns are the rates along x of the displacements.

    Returns
    -------
    sparse matrix, shape (3 N, 3 N)
        By the displacements x, y and z of all nodes, those of one y after the other.
    """
    count = through.size * across.size
    rows = np.add.outer(across.size * through.rows, across.rows).ravel()
    columns = np.add.outer(across.size * through.columns, across.columns).ravel()
    values, places = [], []
    for row, column in itertools.product(range(3), repeat=2):
        total = np.zeros((len(through.rows), len(across.rows)))
        for (a, p), (b, q) in itertools.product(_changes(row), _changes(column)):
            if (p == 0, q == 0) == rates and stiffness[:, a, b].any():
                along_y = through.entries((p == 1, q == 1), stiffness[:, a, b])
                total += np.outer(along_y, across.entries((p == 2, q == 2)))
        if total.any():
            values.append(total.ravel())
            places.append((count * row + rows, count * column + columns))
    both = np.concatenate(places, axis=1)
    return sp.csc_matrix((np.concatenate(values), (both[0], both[1])), shape=(3 * count,) * 2)


def _changes(displacement: int) -> list[tuple[int, int]]:
    """Strains of a displacement component, each with the direction of its derivative."""
    return [
        (strain, direction)
        for strain, parts in enumerate(STRAINS)
        for moved, direction in parts
        if moved == displacement
    ]


def _by_section(y: FloatArray, z: FloatArray) -> FloatArray:
    """Rates of the displacements (3 n, 6) at nodes (n,) by the strains of the section."""
    one, none = np.ones(len(y)), np.zeros(len(y))
    along = [one, none, none, none, z, -y]
    up = [none, one, none, -z, none, none]
    aside = [none, none, one, y, none, none]
    return np.concatenate([np.stack(rates, axis=1) for rates in (along, up, aside)])


def _central_solutions(through: Parabolas, across: Parabolas, stiffness: FloatArray) -> FloatArray:
    """Compliance (6, 6) from the warping that grows linearly along the bar."""
    stretching, coupling, of_rates = (
        section_energy(through, across, stiffness, rates)
        for rates in ((False, False), (False, True), (True, True))
    )
    line, count = across.size, through.size * across.size
    section = _by_section(np.repeat(through.places, line), np.tile(across.places, through.size))
    by_section, rate_by_section = coupling @ section, of_rates @ section
    # Six displacements are fixed that would move the section without warping it.
    supports = [0, count, 2 * count, line - 1, count + line - 1, count - line]
    free = np.setdiff1d(np.arange(3 * count), supports)
    inner = stretching[free][:, free]
    factors = spla.splu(
        inner, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )

    def warped(forces: FloatArray) -> FloatArray:
        """Warping (3 n, 6) of forces."""
        answer = factors.solve(forces[free])
        # In wide sections round-off of the stiff bending across reaches the soft one.
        answer += factors.solve(forces[free] - inner @ answer)
        every = np.zeros(forces.shape)
        every[free] = answer
        return every

    by_strains = -warped(by_section)
    resultants = section.T @ rate_by_section + by_section.T @ by_strains
    # A shear force changes the moments along the bar; nothing else changes.
    growth = np.zeros((LOADS, LOADS))
    growth[5, 1], growth[4, 2] = -1.0, 1.0
    strain_rates = np.linalg.solve(resultants, growth)
    grown = by_strains @ strain_rates
    shapes_ = warped((coupling.T - coupling) @ grown + rate_by_section @ strain_rates)
    loads = np.eye(LOADS) - rate_by_section.T @ grown - by_section.T @ shapes_
    strains = np.linalg.solve(resultants, loads)
    warping, rates = shapes_ + by_strains @ strains, grown + section @ strains
    mixed = warping.T @ (coupling @ rates)
    compliance = warping.T @ (stretching @ warping) + mixed + mixed.T + rates.T @ (of_rates @ rates)
    return np.asarray((compliance + compliance.T) / 2)
