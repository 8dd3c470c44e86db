"""A link of off-axis plies in three dimensions, between rigid end faces that turn about pins.

Plies off the axis twist a link as it bends, and contract it across. What a beam makes of that is
right for a long link in its first mode (:mod:`flexmech.sections.free_edges`). End faces that joints
keep plane do more: they restrain warping and the curvature across as well, over about a width from
each end, and a mode is no half sine. So the beam is compared with the link itself, in elements with
27 nodes, for its own length and width.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from flexmech.arrays import FloatArray
from flexmech.beams.elements import BEAM_SHAPES
from flexmech.beams.link_matrices import build_chain
from flexmech.linkages import LinkMass
from flexmech.sections import BeamSection, LaminateSection
from flexmech.sections.free_edges import FIRST_MODE, is_off_axis, layer_runs
from flexmech.sections.solid_section import (
    VALUES,
    Parabolas,
    graded,
    rows_of_runs,
    section_energy,
)

MODES = 2
"""Bending modes that are compared."""
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


@lru_cache(maxsize=64)
def beam_error(section: LaminateSection, length: float) -> FloatArray | None:
    """Relative errors of a beam's bending frequencies between pins, of off-axis plies.

    Of links longer than :data:`SHORT` widths against a beam whose ends restrain the twist, as what
    end faces restrain besides does not matter; of shorter ones against three dimensions.

    Parameters
    ----------
    section : LaminateSection
        With its twist as it is in the linkage.
    length : float
        In m.

    Returns
    -------
    ndarray, shape (2,), optional
        Of the first two modes, positive where the beam is too high. None where the plies are along
        or across, where no restraint by joints can matter, and for short links of more than
        :data:`MOST_RUNS` runs of equal plies.
    """
    if not twists_matter(section):
        return None
    free = replace(section, reduction="narrow", twist="free")
    if length > SHORT * section.width:
        exact = _by_beams(free, length, twisted_back(free))
    elif len(layer_runs(section.laminate)[0]) <= MOST_RUNS + 1:
        exact = bending_between_pins(section, length)
    else:
        return None
    return np.asarray(_by_beams(section, length) / exact - 1)


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


def _by_beams(section: LaminateSection, length: float, torsion: float = 0.0) -> FloatArray:
    """Frequencies in Hz between pins, with the energy by the ends' rotations."""
    beam = BeamSection.of_laminate(section)
    mass = LinkMass(length, beam.mass_per_length)
    model = build_chain("link", beam, mass, 2 * ALONG, BEAM_SHAPES["timoshenko"]).model
    turned = np.zeros(model.size)
    turned[model.start_rotation[0]], turned[model.end_rotation[0]] = -1.0, 1.0
    stiffness = model.stiffness + torsion / length * np.outer(turned, turned)
    kept = np.setdiff1d(np.arange(model.size), [*model.start, model.end[1]])
    grid = np.ix_(kept, kept)
    squares = scipy.linalg.eigh(stiffness[grid], model.mass[grid], eigvals_only=True)
    return np.asarray(np.sqrt(squares[:MODES]) / (2 * np.pi))


def bending_between_pins(section: LaminateSection, length: float) -> FloatArray:
    """Bending frequencies of a link in three dimensions whose rigid end faces turn about pins.

    Sine waves are one step of inverse iteration away from the modes: torsion, which follows
    statically, does not stand among them.

    Parameters
    ----------
    section : LaminateSection
    length : float
        In m.

    Returns
    -------
    ndarray, shape (2,)
        In Hz.
    """
    solid = SolidLink.of(section, length)
    shapes = solid.solve(solid.mass @ solid.sine_waves(MODES))
    k, m = (shapes.T @ (matrix @ shapes) for matrix in (solid.stiffness, solid.mass))
    return np.asarray(np.sqrt(scipy.linalg.eigh(k, m, eigvals_only=True)) / (2 * np.pi))


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

    def sine_waves(self, count: int) -> FloatArray:
        """Bending by one to ``count`` half sines, (n, count)."""
        x, y, z = self.along, self.through, self.across
        shapes = []
        for number in range(1, count + 1):
            k = number * np.pi / self.length
            along = -k * np.cos(k * x.places)[:, None, None] * y.places[:, None]
            up = np.sin(k * x.places)[:, None, None] * np.ones((y.size, 1))
            parts = [
                np.broadcast_to(part, (x.size, y.size, z.size)) for part in (along, up, 0 * up)
            ]
            inside = np.stack(parts)[:, 1:-1].ravel()
            slopes = [k, k * np.cos(k * self.length), 0.0]
            shapes.append(np.concatenate([inside, slopes]))
        return np.stack(shapes, axis=1)


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
