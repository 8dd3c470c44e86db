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

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from numpy.polynomial.legendre import leggauss

from flexmech.arrays import FloatArray, IntArray
from flexmech.errors import ComputationError
from flexmech.model_text import shapes, short_repr

STRETCH, TWIST, ACROSS_PLANE, CURVATURE = 0, 3, 4, 5
"""Strains of a section by number; the last curvature is that which bends through the layers."""
# Loads of a bar, nodes of an element of two parabolas, and its displacements.
LOADS = 6
NODES = 9
WARPING = 3 * NODES


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
        Of each row by strains x, y, z, yz, xz and xy in Pa.
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
    mesh = _Mesh(faces / length, sides / length)
    energy = _energy(mesh, stiffness / modulus)
    try:
        compliance = _central_solutions(mesh, energy)
    except RuntimeError as error:
        raise ComputationError(
            "the warping of a laminate section cannot be solved for: its plies' stiffnesses or "
            "thicknesses differ too much; check their units"
        ) from error
    unit = length ** np.array([1, 1, 1, 2, 2, 2])
    return SolidSection(compliance / (np.outer(unit, unit) * modulus))


@dataclass(frozen=True)
class _Mesh:
    """Rectangles with nine nodes, in rows: faces (n + 1,) and sides (m + 1,)."""

    faces: FloatArray
    sides: FloatArray

    @cached_property
    def rows(self) -> IntArray:
        """Row of each element."""
        return np.repeat(np.arange(len(self.faces) - 1), len(self.sides) - 1)

    @cached_property
    def columns(self) -> IntArray:
        """Column of each element."""
        return np.tile(np.arange(len(self.sides) - 1), len(self.faces) - 1)

    @property
    def size(self) -> int:
        """Number of displacements: three at each node."""
        return 3 * (2 * len(self.faces) - 1) * (2 * len(self.sides) - 1)

    @property
    def supports(self) -> IntArray:
        """Six displacements that are fixed: they would move the section without warping it."""
        line = 2 * len(self.sides) - 1
        first, second, third = 0, 3 * (line - 1), self.size - 3 * line
        return np.array([first, first + 1, first + 2, second, second + 1, third])

    @cached_property
    def displacements(self) -> IntArray:
        """Displacements of each element, (elements, 27)."""
        corner = np.arange(3)
        line = 2 * len(self.sides) - 1
        y = 2 * self.rows[:, None] + np.repeat(corner, 3)
        z = 2 * self.columns[:, None] + np.tile(corner, 3)
        return (3 * (y * line + z)[:, :, None] + corner).reshape(len(y), WARPING)


def _energy(mesh: _Mesh, stiffness: FloatArray) -> sp.csc_matrix:
    """Twice the strain energy of each metre, by the warping, its rate along x, and the strains."""
    points, weights = leggauss(3)
    value, slope = _parabolas(points)

    def product(along_y: FloatArray, along_z: FloatArray) -> FloatArray:
        """Shape functions (or slopes) at the nine points of an element, (9, 9)."""
        outer = np.einsum("gi,hj->ghij", along_y, along_z)
        return np.asarray(outer.reshape(NODES, NODES))

    half_y = np.diff(mesh.faces)[mesh.rows, None] / 2
    half_z = np.diff(mesh.sides)[mesh.columns, None] / 2
    y = mesh.faces[mesh.rows, None] + half_y * (1 + np.repeat(points, 3))
    z = mesh.sides[mesh.columns, None] + half_z * (1 + np.tile(points, 3))
    shape = product(value, value)
    by_y = product(slope, value) / half_y[..., None]
    by_z = product(value, slope) / half_z[..., None]
    count = len(mesh.rows)
    strain = np.zeros((count, NODES, 6, 2 * WARPING + LOADS))
    warping, rate = strain[..., :WARPING], strain[..., WARPING : 2 * WARPING]
    for row, direction, shapes_ in (
        (1, 1, by_y),
        (2, 2, by_z),
        (3, 1, by_z),
        (3, 2, by_y),
        (4, 0, by_z),
        (5, 0, by_y),
    ):
        warping[:, :, row, direction::3] = shapes_
    for row, direction in ((0, 0), (4, 2), (5, 1)):
        rate[:, :, row, direction::3] = shape
    strain[..., 2 * WARPING :] = _strains_of_section(y, z)
    area = np.outer(weights, weights).ravel() * half_y * half_z
    stress = (stiffness[mesh.rows, None] @ strain) * area[..., None, None]
    flat = (count, NODES * 6, -1)
    parts = np.swapaxes(strain.reshape(flat), 1, 2) @ stress.reshape(flat)
    pattern = _pattern(len(mesh.faces) - 1, len(mesh.sides) - 1)
    return pattern.filled(parts)


@dataclass(frozen=True)
class _Pattern:
    """Where the energies of the elements go in a sparse matrix.

    Parameters
    ----------
    place : ndarray of int, shape (elements * width^2,)
        Number of the matrix's entry to which each pair of an element's unknowns adds.
    indices, starts : ndarray of int
        Rows of the entries, and where each column starts among them.
    """

    place: IntArray
    indices: IntArray
    starts: IntArray

    def filled(self, parts: FloatArray) -> sp.csc_matrix:
        """Matrix of the symmetric energies of the elements, (elements, width, width)."""
        values = np.bincount(self.place, parts.ravel(), minlength=len(self.indices))
        matrix = sp.csc_matrix((values, self.indices, self.starts))
        matrix.has_canonical_format = True
        return matrix


@lru_cache(maxsize=8)
def _pattern(rows: int, columns: int) -> _Pattern:
    """Of a mesh of so many rows and columns, whatever their sizes."""
    mesh = _Mesh(np.arange(rows + 1.0), np.arange(columns + 1.0))
    size, count = mesh.size, rows * columns
    own = np.broadcast_to(2 * size + np.arange(LOADS), (count, LOADS))
    unknown = np.concatenate([mesh.displacements, size + mesh.displacements, own], axis=1)
    whole = 2 * size + LOADS
    entry, place = np.unique(unknown[:, :, None] * whole + unknown[:, None, :], return_inverse=True)
    starts = np.searchsorted(entry, whole * np.arange(whole + 1))
    return _Pattern(
        place.ravel().astype(np.int32), (entry % whole).astype(np.int32), starts.astype(np.int32)
    )


def _parabolas(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Lagrange's parabolas over -1, 0, 1 and their slopes at points, (m, 3)."""
    t = points
    value = np.stack([t * (t - 1) / 2, 1 - t**2, t * (t + 1) / 2], axis=-1)
    return value, np.stack([t - 0.5, -2 * t, t + 0.5], axis=-1)


def _strains_of_section(y: FloatArray, z: FloatArray) -> FloatArray:
    """Strains x, y, z, yz, xz, xy at places (...) by those of the section, (..., 6, 6)."""
    strain = np.zeros((*y.shape, 6, LOADS))
    strain[..., 0, 0] = strain[..., 5, 1] = strain[..., 4, 2] = 1.0
    strain[..., 5, 3], strain[..., 4, 3] = -z, y
    strain[..., 0, 4], strain[..., 0, 5] = z, -y
    return strain


def _central_solutions(mesh: _Mesh, energy: sp.csc_matrix) -> FloatArray:
    """Compliance (6, 6) from the warping that grows linearly along the bar."""
    size = mesh.size
    warping, rate, section = slice(size), slice(size, 2 * size), slice(2 * size, None)
    coupling = energy[warping, rate]
    by_section = energy[warping, section].toarray()
    rate_by_section = energy[rate, section].toarray()
    free = np.setdiff1d(np.arange(size), mesh.supports)
    own = energy[free][:, free]
    factors = spla.splu(
        own, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )

    def warped(forces: FloatArray) -> FloatArray:
        """Warping (size, 6) of forces."""
        answer = factors.solve(forces[free])
        # In wide sections round-off of the stiff bending across reaches the soft one.
        answer += factors.solve(forces[free] - own @ answer)
        every = np.zeros(forces.shape)
        every[free] = answer
        return every

    by_strains = -warped(by_section)
    resultants = energy[section, section].toarray() + by_section.T @ by_strains
    # A shear force changes the moments along the bar; nothing else changes.
    growth = np.zeros((LOADS, LOADS))
    growth[5, 1], growth[4, 2] = -1.0, 1.0
    strain_rates = np.linalg.solve(resultants, growth)
    rates = by_strains @ strain_rates
    shapes_ = warped((coupling.T - coupling) @ rates + rate_by_section @ strain_rates)
    loads = np.eye(LOADS) - rate_by_section.T @ rates - by_section.T @ shapes_
    strains = np.linalg.solve(resultants, loads)
    state = np.concatenate([shapes_ + by_strains @ strains, rates, strains])
    compliance = state.T @ (energy @ state)
    return np.asarray((compliance + compliance.T) / 2)
