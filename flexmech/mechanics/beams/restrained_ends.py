"""Restrained twist and warping at the ends of links of off-axis plies, in three dimensions.

Plies off the link's axis twist it as it bends. End faces that joints keep plane restrain twist and
warping of the ends, so that the bending moment at a place depends on the curvature everywhere: it
is nonlocal. A beam with free twist is right in the middle of a long link. The difference is
computed by elasticity in three dimensions, for five distributions of the bending moment: those of
couples at both ends and of loads in one to three half sines. In the span of these the beam then has
the link's own compliance, and the kinetic energy of the twist that follows; beyond it, its own.

With orthonormal shapes ``psi`` in this span and ``m`` the integrals of ``psi`` times the curvature
the energies are ``m' S m / 2`` and, of the rates, ``m' J m / 2``, with
``S = (1 / EI + D)^-1 - EI`` and D the difference of the compliances.

A beam whose plies twist and contract it freely is right for a long link in its first mode
(:mod:`flexmech.sections.free_edges`). End faces that joints keep plane restrain warping and the
curvature across as well, over about a width from each end, and a mode is no half sine. So the link
is solved in three dimensions, in elements with 27 nodes, for its length and width.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from flexmech.arrays import FloatArray
from flexmech.linkages import LinkEnd, LinkMass
from flexmech.mechanics.beams.elements import (
    BEAM_SHAPES,
    BeamElements,
    Chain,
    Coupling,
    build_chain,
    sum_of_elements,
)
from flexmech.mechanism import Mechanism
from flexmech.sections import BeamSection, LaminateSection
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
# Least change of the frequency between all strains across free and none: one percent is named of
# beams.
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
            parts = [slice(count * axis, count * (axis + 1)) for axis in range(3)]
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


WAVES = 3
"""Loads in half sines whose bending moments are among the distributions."""
# Part of the bending stiffness that end faces may seem to take away. They add to it; what takes
# is a difference in shear.
SOFTEST = 0.2
# Elements of the beam with which the link is compared: twice those along the link in three
# dimensions, so that its own error does not count.
ELEMENTS = 28
# These integrate products of half sines over the whole link to all digits.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(24)


@dataclass(frozen=True, eq=False)
class RestrainedEnds:
    """Energies by distributions of the curvature along a link.

    Parameters
    ----------
    length : float
        Length of the link in m.
    shapes : ndarray, shape (k, 5)
        Orthonormal shapes psi, in 1/sqrt(m), of the bending moments of couples that are equal
        and opposite, of equal ones, and of loads in one to three half sines.
    stiffness : ndarray, shape (k, k)
        S, in N m^2.
    mass : ndarray, shape (k, k)
        J, in kg m^2.
    mass_per_length : float
        At which the mass is such, in kg/m.
    """

    length: float
    shapes: FloatArray
    stiffness: FloatArray
    mass: FloatArray
    mass_per_length: float

    @property
    def solid(self) -> bool:
        """Whether the link was computed in three dimensions; else its twist is restrained alone."""
        return len(self.shapes) > 1

    @property
    def of_half_sine(self) -> float:
        """Added bending stiffness against a half sine, in N m^2."""
        values = np.einsum("ki,ig->kg", self.shapes, _moments((_POINTS + 1) / 2))
        wave = np.sqrt(2 / self.length) * np.sin(np.pi * (_POINTS + 1) / 2)
        amount = values @ (wave * _WEIGHTS * self.length / 2)
        return float(amount @ self.stiffness @ amount)

    @property
    def constant(self) -> FloatArray:
        """Integrals m of a unit of curvature everywhere, (k,), in m^(1/2)."""
        moments = _moments((_POINTS + 1) / 2)
        return np.asarray(self.shapes @ (moments @ _WEIGHTS) * self.length / 2)

    def rows(self, nodes: FloatArray, elements: BeamElements) -> FloatArray:
        """Integrals m by the coordinates of a chain of elements.

        Parameters
        ----------
        nodes : ndarray, shape (e + 1,)
            Their places in m.
        elements : BeamElements

        Returns
        -------
        ndarray, shape (k, n)
        """
        places, weights, curvature = elements.curvatures
        x = (nodes[:-1, None] + places * elements.length[:, None]) / self.length
        values = np.einsum("ki,ieg->keg", self.shapes, _moments(x))
        return sum_of_elements(np.einsum("keg,eg,egp->kep", values, weights, curvature))

    def restrain(self, chain: Chain, mass_per_length: float) -> Chain:
        """A chain of elements with the energies of restrained twist in its matrices.

        Parameters
        ----------
        chain : Chain
        mass_per_length : float
            Mass per length of the link in kg/m; none where its mass stands in points.

        Returns
        -------
        Chain
        """
        model, elements = chain.model, chain.elements
        rows = self.rows(chain.nodes, elements)
        section = elements.section
        swollen = section.free_curvature * self.constant
        coupling = Coupling(rows, self.stiffness, section.damping.bending, swollen)
        inertia = mass_per_length / self.mass_per_length * rows.T @ self.mass @ rows
        restrained = replace(
            model,
            mass=model.mass + inertia,
            # What twists moves in the linkage's plane too, on both sides of the axis.
            centrifugal_mass=model.centrifugal_mass + inertia,
            gyroscopic=model.gyroscopic,
            stiffness=model.stiffness + coupling.stiffness,
            damping=model.damping + coupling.damping_time * coupling.stiffness,
        )
        return replace(chain, model=restrained, coupling=coupling)


def restrained_beam(mechanism: Mechanism, link: str) -> tuple[BeamSection, RestrainedEnds | None]:
    """Beam section of a flexible link, and the restraint of its ends by joints.

    Parameters
    ----------
    mechanism : Mechanism
    link : str
        Its name.

    Returns
    -------
    section : BeamSection
        With its twist free where the joints' part is added.
    added : RestrainedEnds, optional
        None of links that are not between two joints, whose plies are along or across, whose
        stiffness is stated, or whose twist is stated to be free.
    """
    section, layers = mechanism.sections[link], mechanism.sections[link].layers
    if not isinstance(layers, LaminateSection) or layers.twist == "free":
        return section, None
    # Before stiffnesses, which take time.
    if not twists_matter(layers):
        return section, None
    ends = {LinkEnd(link, "start"), LinkEnd(link, "end")}
    between_joints = ends <= mechanism.linkage.topology.joined_ends
    if not between_joints or section.bending_stiffness != layers.bending_stiffness:
        return section, None
    added = restrained_ends(layers, mechanism.link_mass(link).length)
    free = BeamSection.of_laminate(replace(layers, twist="free"))
    kept: Mapping[str, object] = {
        name: getattr(section, name)
        for name in (
            "damping",
            "specific_damping",
            "damping_frequency",
            "free_strain",
            "free_curvature",
            "mass_per_length",
            "rotary_inertia",
        )
    }
    return replace(free, **kept), added  # type: ignore[arg-type]


@lru_cache(maxsize=64)
def restrained_ends(section: LaminateSection, length: float) -> RestrainedEnds:
    """Restraint by joints at both ends of a beam with free twist.

    Parameters
    ----------
    section : LaminateSection
        Section of plies whose twist matters.
    length : float
        In m.

    Returns
    -------
    RestrainedEnds
        For links longer than :data:`SHORT` widths, of more than :data:`MOST_RUNS` runs of equal
        plies, and so short that shear hides their bending, the constant torque of
        :mod:`flexmech.sections.free_edges` alone.
    """
    free = replace(section, reduction="narrow", twist="free")
    if length > SHORT * section.width or len(layer_runs(section.laminate)[0]) > MOST_RUNS + 1:
        return _twist_alone(free, length)
    return _from_solid(free, length) or _twist_alone(free, length)


def _twist_alone(free: LaminateSection, length: float) -> RestrainedEnds:
    """Restraint by a constant torque along the link that cancels the mean twist."""
    shapes = np.zeros((1, 2 + WAVES))
    shapes[0, 0] = 1 / np.sqrt(length)
    stiffness = np.array([[twisted_back(free)]])
    return RestrainedEnds(length, shapes, stiffness, np.zeros((1, 1)), free.mass_per_length)


def _from_solid(free: LaminateSection, length: float) -> RestrainedEnds | None:
    """Restraint from three-dimensional elasticity; None of links too short for it."""
    solid = SolidLink.of(free, length)
    loads = np.concatenate([solid.couples(), solid.waves(WAVES)], axis=1)
    answers = solid.solve(loads)
    beam = BeamSection.of_laminate(free)
    mass = LinkMass(length, beam.mass_per_length)
    chain = build_chain("link", beam, mass, ELEMENTS, BEAM_SHAPES["timoshenko"])
    inner = np.setdiff1d(np.arange(chain.model.size), [*chain.model.start, chain.model.end[1]])
    beam_loads = _loads_of(chain, length)[inner]
    grid = np.ix_(inner, inner)
    stiffness = chain.model.stiffness[grid]
    points = (_POINTS + 1) / 2
    moments = _load_moments(length) @ _moments(points)
    gram = (moments * _WEIGHTS * length / 2) @ moments.T
    inverse = np.linalg.inv(np.linalg.cholesky(gram))
    apart = loads.T @ answers - beam_loads.T @ np.linalg.solve(stiffness, beam_loads)
    bending = free.bending_stiffness
    compliance = np.eye(len(gram)) / bending + inverse @ apart @ inverse.T
    added = np.linalg.inv(compliance) - bending * np.eye(len(gram))
    if np.linalg.eigvalsh(added)[0] < -SOFTEST * bending:
        return None
    shapes = inverse @ _load_moments(length)
    ends = RestrainedEnds(length, shapes, (added + added.T) / 2, 0 * added, free.mass_per_length)
    rows = ends.rows(chain.nodes, chain.elements)[:, inner]
    moved = np.linalg.solve(stiffness + rows.T @ ends.stiffness @ rows, beam_loads)
    lacking = answers.T @ (solid.mass @ answers) - moved.T @ chain.model.mass[grid] @ moved
    by_shapes = np.linalg.inv(rows @ moved)
    inertia = by_shapes.T @ lacking @ by_shapes
    return replace(ends, mass=_without_negative((inertia + inertia.T) / 2))


def _without_negative(matrix: FloatArray) -> FloatArray:
    """A kinetic energy without its negative parts, which are of shear and not of twist."""
    values, vectors = np.linalg.eigh(matrix)
    return np.asarray((vectors * np.maximum(values, 0.0)) @ vectors.T)


def _moments(x: FloatArray) -> FloatArray:
    """Distributions over places x (...) from 0 to 1: constant, linear, half sines; (5, ...)."""
    waves = [np.sin(count * np.pi * x) for count in range(1, WAVES + 1)]
    return np.stack([np.ones_like(x), 2 * x - 1, *waves])


def _load_moments(length: float) -> FloatArray:
    """Bending moments of the unit loads by the distributions, diagonal (5, 5)."""
    waves = [-((length / (count * np.pi)) ** 2) for count in range(1, WAVES + 1)]
    return np.diag([1.0, 1.0, *waves])


def _loads_of(chain: Chain, length: float) -> FloatArray:
    """The unit loads on a chain, (n, 5)."""
    model, elements = chain.model, chain.elements
    loads = np.zeros((model.size, 2 + WAVES))
    turned = [model.start_rotation[0], model.end_rotation[0]]
    loads[turned, 0], loads[turned, 1] = (-1.0, 1.0), (1.0, 1.0)
    places, weights, deflection = elements.deflections
    x = (chain.nodes[:-1, None] + places * elements.length[:, None]) / length
    shares = np.einsum("weg,eg,egp->wep", _moments(x)[2:], weights, deflection)
    loads[:, 2:] = sum_of_elements(shares).T
    return loads
