"""A link of off-axis plies in three dimensions, between rigid end faces that turn about pins.

Plies off the axis twist a link as it bends, and contract it across. What a beam makes of that is
right for a long link in its first mode (:mod:`flexmech.sections.free_edges`). End faces that joints
keep plane do more: they restrain warping and the curvature across as well, over about a width from
each end, and a mode is no half sine. So the link itself is solved, in elements with 27 nodes, for
its own length and width.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from flexmech.arrays import FloatArray
from flexmech.sections import LaminateSection
from flexmech.sections.free_edges import FIRST_MODE, is_off_axis, layer_runs
from flexmech.sections.solid_section import (
    VALUES,
    Parabolas,
    graded,
    rows_of_runs,
    section_energy,
)

# Runs of equal plies that are computed in three dimensions: each takes a row of elements, and the
# solution's time goes with its square.
MOST_RUNS = 8
# Elements along the link (at least, and in each width of it), across its width and through it,
# shorter towards ends and edges: within 0.3 % of a finer mesh.
ALONG, A_WIDTH, ACROSS, ROWS = 14, 1.2, 4, 4
GRADED = 0.6
# Displacements or their rates along the link, of rows and columns.
_RATES = ((False, False), (False, True), (True, False), (True, True))
# Length over width up to which links are computed in three dimensions. What end faces restrain
# besides the twist changes the first mode of longer ones by 1.7 % at most ([15], wide; [30] by
# 0.9 %).
SHORT = 40
# Of the frequency between all strains across free and none: one percent is what is told of beams.
LEAST = 0.01


def twists_matter(section: LaminateSection) -> bool:
    """Whether restraint by joints across a link can change its bending noticeably.

    Parameters
    ----------
    section : LaminateSection

    Returns
    -------
    bool
        False where its plies are along or across.
    """
    if not is_off_axis(section.laminate):
        return False
    free = replace(section, reduction="narrow", twist="free")
    wide = replace(section, reduction="wide", twist=None)
    return wide.bending_stiffness > (1 + LEAST) ** 2 * free.bending_stiffness


def twisted_back(free: LaminateSection) -> float:
    """Twist by a unit of curvature, squared, times the torsional stiffness.

    Parameters
    ----------
    free : LaminateSection
        Whose twist is free.

    Returns
    -------
    float
        In N m^2.
    """
    untwisted = replace(free, twist="held")
    return (untwisted.bending_stiffness - free.bending_stiffness) / FIRST_MODE


@dataclass(frozen=True, eq=False)
class SolidLink:
    """Matrices of a link in three dimensions whose rigid end faces turn about pins.

    The n unknowns are the displacements along, through and across of all nodes between the faces,
    the rotations of the first and the last face, and how far the last one slides.

    Parameters
    ----------
    length : float
        In m.
    along, through, across : Parabolas
    expansion : sparse matrix, shape (N, n)
        All displacements by the unknowns.
    stiffness, mass : sparse matrix, shape (n, n)
    """

    length: float
    along: Parabolas
    through: Parabolas
    across: Parabolas
    expansion: Any
    stiffness: Any
    mass: Any

    @classmethod
    def of(cls, section: LaminateSection, length: float) -> SolidLink:
        """Link of brick elements with 27 nodes.

        Parameters
        ----------
        section : LaminateSection
        length : float
            In m.
        """
        faces, stiffness = layer_runs(section.laminate)
        x = Parabolas(length * graded(max(ALONG, round(A_WIDTH * length / section.width)), GRADED))
        z = Parabolas(section.width / 2 * np.sin(np.pi / 2 * np.linspace(-1, 1, ACROSS + 1)))
        ends, rows = rows_of_runs(faces, ROWS)
        y = Parabolas(ends)
        elastic = np.repeat(stiffness, rows, axis=0)
        density = section.mass_per_length / (section.width * (faces[-1] - faces[0]))
        weight = np.full(len(elastic), density)
        stiff: Any = 0.0
        for rates in _RATES:
            energy = section_energy(y, z, elastic, rates)
            along, count = x.integral(rates), y.size * z.size
            parts = [slice(count * part, count * (part + 1)) for part in range(3)]
            blocks = [[sp.kron(along, energy[i, j]) for j in parts] for i in parts]
            stiff = stiff + sp.bmat(blocks, format="csc")
        one = sp.kron(x.integral(VALUES), sp.kron(y.integral(VALUES, weight), z.integral(VALUES)))
        expansion = _between_pins(x, y, z)
        k = (expansion.T @ stiff @ expansion).tocsc()
        m = (expansion.T @ sp.block_diag([one] * 3, format="csc") @ expansion).tocsc()
        return cls(length, x, y, z, expansion, k, m)

    def solve(self, forces: FloatArray) -> FloatArray:
        """Displacements (n, k) under forces."""
        factors = spla.splu(
            self.stiffness,
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        return np.asarray(factors.solve(forces))

    def couples(self) -> FloatArray:
        """Unit couples at both faces, opposite ones that bend by a unit moment, and like ones."""
        forces = np.zeros((self.stiffness.shape[0], 2))
        forces[-3], forces[-2] = (-1.0, 1.0), (1.0, 1.0)
        return forces

    def waves(self, count: int) -> FloatArray:
        """Forces across in one to ``count`` half sines of a unit for each metre, (n, count)."""
        total = np.zeros((self.expansion.shape[0], count))
        half = len(total) // 3
        even = self.through.integral(VALUES).sum(axis=1) / np.ptp(self.through.places)
        wide = self.across.integral(VALUES).sum(axis=1) / np.ptp(self.across.places)
        section = np.kron(np.asarray(even).ravel(), np.asarray(wide).ravel())
        for number in range(count):
            wave = np.sin((number + 1) * np.pi * self.along.places / self.length)
            total[half : 2 * half, number] = np.kron(self.along.integral(VALUES) @ wave, section)
        return np.asarray(self.expansion.T @ total)


def _between_pins(x: Parabolas, y: Parabolas, z: Parabolas) -> Any:
    """From free displacements, rotations of both faces and the slide of one to all, sparse."""
    shape = (x.size, y.size, z.size)
    number = np.arange(3 * np.prod(shape)).reshape(3, *shape)
    free = number[:, 1:-1].ravel()
    rows, columns, values = [free], [np.arange(len(free))], [np.ones(len(free))]
    turned = -np.repeat(y.places, z.size)
    for column, (face, value) in enumerate(((0, turned), (-1, turned), (-1, np.ones(len(turned))))):
        rows.append(number[0, face].ravel())
        columns.append(np.full(len(value), len(free) + column))
        values.append(value)
    places = (np.concatenate(rows), np.concatenate(columns))
    return sp.csc_matrix((np.concatenate(values), places), shape=(number.size, len(free) + 3))
