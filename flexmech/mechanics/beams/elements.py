"""Matrices of two-node plane beam elements, integrated from their shape functions.

Coordinates of an element are those of its two nodes, one node after the other: displacement
of the pins' axis along and across, rotation of the section, and what else the element has
(:mod:`flexmech.mechanics.beams.theories`). Gauss points integrate every product exactly.

A straight link is assembled of such elements.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray
from flexmech.linkages import LinkMass
from flexmech.mechanics import LinkModel, LinkReadings, RigidFields, chain_matrix
from flexmech.mechanics.beams.theories import (
    BeamFields,
    BeamShapes,
    EulerBernoulli,
    Reddy,
    Timoshenko,
    ZigzagBeam,
)
from flexmech.mesh import node_positions
from flexmech.sections import BeamSection

# Which of a node's coordinates is the rotation of the section, in all theories.
ROTATION = 2


@dataclass(frozen=True)
class BeamElements:
    """Elements of one kind along a link, p coordinates a node.

    Parameters
    ----------
    shapes : BeamShapes
    section : BeamSection
    length : ndarray, shape (e,)
        In m.
    kinked : ndarray of bool, shape (e,), optional
        Elements at whose start a couple acts, so that the curvature jumps there. That of the node
        is of the element before; these begin with the one that makes their rotation quadratic.
    """

    shapes: BeamShapes
    section: BeamSection
    length: FloatArray
    kinked: NDArray[np.bool_] | None = None

    @cached_property
    def element_maps(self) -> FloatArray | None:
        """Coordinates of elements by those of their nodes, (e, 2 p, 2 p); None if the same."""
        curvature, size = self.shapes.curvature, self.shapes.per_node
        if curvature is None or self.kinked is None or not self.kinked.any():
            return None
        maps = np.tile(np.eye(2 * size), (len(self.length), 1, 1))
        h, (first, second) = self.length[self.kinked], (ROTATION, size + ROTATION)
        rows = np.zeros((len(h), 2 * size))
        rows[:, first], rows[:, second], rows[:, size + curvature] = -2 / h, 2 / h, -1.0
        maps[self.kinked, curvature, :] = rows
        return maps

    @cached_property
    def stiffness(self) -> FloatArray:
        """Elastic stiffness, (e, 2 p, 2 p).

        For Euler-Bernoulli beams: Kumar & Chandrakar, eq. 1.53, corrected (k36 = k63 = +2EI/L).
        """
        return self._at_the_pins(self.neutral_stiffness)

    @cached_property
    def damping(self) -> FloatArray:
        """Kelvin-Voigt damping, (e, 2 p, 2 p)."""
        return self._at_the_pins(self.neutral_damping)

    @cached_property
    def neutral_stiffness(self) -> FloatArray:
        """Elastic stiffness by the neutral axis's nodes, (e, 2 p, 2 p)."""
        return self._from_strains(self.shapes.strain_stiffness(self.section))

    @cached_property
    def neutral_damping(self) -> FloatArray:
        """Kelvin-Voigt damping by the neutral axis's nodes, (e, 2 p, 2 p)."""
        times = self.section.damping_times
        if not times.any():
            return np.zeros_like(self.neutral_stiffness)
        stiffness = self.shapes.strain_stiffness(self.section)
        angles = stiffness.shape[-1] // 2 - 1
        # Without a coordinate of its own, warping is a part of bending.
        warping = 2 if self.shapes.warping else 1
        of_strain = times[[0, 1, *[warping] * angles, *[3] * angles]]
        return self._from_strains(of_strain[:, None] * stiffness)

    @cached_property
    def mass(self) -> FloatArray:
        """Consistent mass, (e, 2 p, 2 p).

        For Euler-Bernoulli beams: Kumar & Chandrakar, eq. 1.52, corrected (m22 = 13/35).
        """
        return self._moved(self._inertia)

    @cached_property
    def centrifugal_mass(self) -> FloatArray:
        """Centrifugal mass ``M_t``: that of the displacements without rotary inertia.

        A section that turns about its centre keeps its centrifugal potential: rotary inertia
        is not in it, the coupling of displacement and rotation by the first moment is.
        """
        if not self._inertia[1:, 1:].any():
            return self.mass
        displaced = self._inertia.copy()
        displaced[1:, 1:] = 0.0
        return self._moved(displaced)

    @cached_property
    def gyroscopic(self) -> FloatArray:
        """``S``, the integral of ``rho A N^T J N``; K, eq. 1.54 with ``m_vel = omega S``."""
        momentum = np.einsum("a,aegi->egi", self._inertia[0], self._along)
        across = self._weights[..., None] * self._inside.deflection
        product = np.swapaxes(across, -1, -2) @ momentum
        return np.asarray(product - np.swapaxes(product, -1, -2))

    @cached_property
    def first_moment(self) -> FloatArray:
        """Integral of ``rho y N`` along and across, (2, e, 2 p)."""
        moment = self.section.first_moment_of_mass * self._weights[..., None]
        fields = np.stack([self._along[0], self._inside.deflection])
        return np.asarray((moment * fields).sum(axis=-2))

    def geometric_stiffness(self, tension: FloatArray) -> FloatArray:
        """Geometric stiffness of elements whose tension varies along them.

        With a constant tension, of Euler-Bernoulli beams, Kumar & Chandrakar, eq. 1.58.
        Inertia forces make the tension quadratic in place; its mean alone would cost two
        orders of convergence.

        Parameters
        ----------
        tension : ndarray, shape (..., e, 3)
            Legendre coefficients in N: mean, linear and quadratic part.

        Returns
        -------
        ndarray, shape (..., e, 2 p, 2 p)
        """
        unit = self._unit_geometric
        count, _, size, _ = unit.shape
        by_element = np.swapaxes(tension.reshape(-1, count, 3), 0, 1)
        matrices = np.swapaxes(by_element @ unit.reshape(count, 3, size**2), 0, 1)
        return np.asarray(matrices.reshape(*tension.shape[:-1], size, size), dtype=float)

    @cached_property
    def arch(self) -> FloatArray:
        """Mean of the squared slope over each element, (e, 2 p, 2 p): half is an axial strain."""
        return np.asarray(self._integral(self._squared_slope) / self.length[:, None, None])

    def displacement_shapes(self, fraction: FloatArray, length: FloatArray) -> FloatArray:
        """Displacement of the pins' axis inside elements by their own coordinates.

        Those are their nodes' but for :attr:`element_maps`.

        Parameters
        ----------
        fraction, length : ndarray, shape (s,)
            Place in the element from 0 to 1, and the element's length.

        Returns
        -------
        ndarray, shape (s, 2, 2 p)
        """
        fields = self.shapes.fields(fraction, length, self.section)
        return np.stack([self._at_pins_axis(fields), fields.deflection], axis=1)

    @property
    def curvatures(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Curvature inside elements: places (e, g), from 0 to 1, weights (e, g), (e, g, 2 p)."""
        return *self._quadrature, self._of_nodes(self._inside.curvature)

    @property
    def deflections(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Deflection inside elements: places (e, g), from 0 to 1, weights (e, g), (e, g, 2 p)."""
        return *self._quadrature, self._of_nodes(self._inside.deflection)

    @cached_property
    def to_neutral_axis(self) -> FloatArray:
        """Displacements of the neutral axis's nodes from those of the pins' axis, (2 p, 2 p)."""
        size = self.shapes.per_node
        turn = np.eye(2 * size)
        for angle, arm in zip(self.shapes.angles, self.shapes.arms(self.section), strict=True):
            for first in (0, size):
                turn[first, first + angle] = -arm
        return turn

    @cached_property
    def _inside(self) -> BeamFields:
        """Fields at the g points of integration, each (e, g, 2 p), by the neutral axis's nodes."""
        places = self._quadrature[0]
        lengths = np.repeat(self.length, places.shape[1])
        fields = self.shapes.fields(places.ravel(), lengths, self.section)
        shape = (*places.shape, -1)
        every = (v.reshape((*v.shape[:-2], *shape)) for v in vars(fields).values())
        maps = self.element_maps
        return BeamFields(*(every if maps is None else (values @ maps for values in every)))

    @cached_property
    def _along(self) -> FloatArray:
        """Displacement along at the pins' axis, rotation, shear angles, (2 + w, e, g, 2 p)."""
        fields = self._inside
        return np.stack([self._at_pins_axis(fields), fields.rotation, *fields.shears])

    def _of_nodes(self, fields: FloatArray) -> FloatArray:
        """Fields by the nodes of the pins' axis."""
        return fields @ self.to_neutral_axis if any(self.shapes.arms(self.section)) else fields

    def _at_pins_axis(self, fields: BeamFields) -> FloatArray:
        """Axial displacement at the pins' axis, by rigid arms from the neutral axis."""
        arms = self.shapes.arms(self.section)
        if not any(arms):
            return fields.axial
        along = fields.axial @ self.to_neutral_axis
        turning = (fields.rotation, fields.slope)
        return along + sum(
            arm * angle for arm, angle in zip(arms, turning[: len(arms)], strict=True)
        )

    @cached_property
    def _inertia(self) -> FloatArray:
        return self.shapes.inertia(self.section)

    @cached_property
    def _quadrature(self) -> tuple[FloatArray, FloatArray]:
        return self.shapes.quadrature(self.length, self.section)

    @property
    def _weights(self) -> FloatArray:
        return self._quadrature[1]

    def _moved(self, inertia: FloatArray) -> FloatArray:
        """Mass matrix of the motion along by ``inertia`` (3, 3) and of the deflection."""
        across = self._inside.deflection[None]
        return self._quadratic(self._along, inertia) + self._quadratic(across, inertia[:1, :1])

    def _quadratic(self, fields: FloatArray, weight: FloatArray) -> FloatArray:
        """Integral of ``fields^T weight fields``: (a, e, g, 2 p), (a, a)."""
        total = np.zeros((len(self.length), *2 * fields.shape[-1:]))
        for a, b in zip(*np.nonzero(weight), strict=True):
            left = (weight[a, b] * self._weights)[..., None] * fields[a]
            total += np.swapaxes(left, -1, -2) @ fields[b]
        return total

    def _integral(self, values: FloatArray) -> FloatArray:
        """Integral over each element of values (e, g, 2 p, 2 p) at its points."""
        return np.asarray(np.einsum("eg,egij->eij", self._weights, values))

    def _from_strains(self, stiffness: FloatArray) -> FloatArray:
        f = self._inside
        strains = np.stack([f.axial_strain, f.curvature, *f.shear_changes, *f.shears])
        return self._quadratic(strains, stiffness)

    def _at_the_pins(self, matrix: FloatArray) -> FloatArray:
        """A matrix by the neutral axis's nodes in coordinates of the pins' axis."""
        if not any(self.shapes.arms(self.section)):
            return matrix
        return np.asarray(self.to_neutral_axis.T @ matrix @ self.to_neutral_axis)

    @cached_property
    def _unit_geometric(self) -> FloatArray:
        """Geometric stiffness of unit tension, by Legendre polynomial, (e, 3, 2 p, 2 p)."""
        t = 2 * self._quadrature[0] - 1
        polynomials = np.stack([np.ones_like(t), t, (3 * t**2 - 1) / 2])
        square = self._squared_slope
        return np.stack([self._integral(p[..., None, None] * square) for p in polynomials], axis=1)

    @cached_property
    def _squared_slope(self) -> FloatArray:
        """Integrand of the geometric stiffness: squared slope less the part of the shear angle."""
        square = _product(self._inside.slope)
        softening = self.shapes.softening(self.section)
        return square - softening * _product(self._inside.shear) if softening else square


def _product(rows: FloatArray) -> FloatArray:
    return rows[..., :, None] * rows[..., None, :]


BEAM_SHAPES: dict[str, BeamShapes] = {
    "euler": EulerBernoulli(),
    "timoshenko": Timoshenko(),
    "reddy": Reddy(),
    "zigzag": ZigzagBeam(),
}
"""Beam theories by the names of the reference engine's elements."""


# Links whose matrices are kept. Speed alone: a comparison of theories has made an engine's links,
# and designs of a study have links in common.
KEPT_CHAINS = 8


@dataclass(frozen=True, eq=False)
class Coupling:
    """Elastic energy by distributions of the curvature over a whole link.

    Parameters
    ----------
    rows : ndarray, shape (k, n)
        Amounts of the distributions by the link's coordinates.
    elastic : ndarray, shape (k, k)
        Stiffness by these amounts.
    damping_time : float
        Damping time of Kelvin-Voigt damping in s.
    unloaded : ndarray, shape (k,)
        Amounts that need no force, of links that swelling bends.
    """

    rows: FloatArray
    elastic: FloatArray
    damping_time: float
    unloaded: FloatArray

    @property
    def stiffness(self) -> FloatArray:
        """Stiffness matrix in the link's coordinates, (n, n)."""
        return np.asarray(self.rows.T @ self.elastic @ self.rows)


@dataclass(frozen=True)
class Chain:
    """One link of beam elements.

    Parameters
    ----------
    model : LinkModel
        Coordinates (u, v, phi, ...) node by node.
    nodes : ndarray, shape (e + 1,)
        Node positions in m.
    elements : BeamElements
    line_mass : float
        Mass per length that is distributed along it, in kg/m.
    coupling : Coupling, optional
        What the link's matrices have besides those of the elements.
    """

    model: LinkModel
    nodes: FloatArray
    elements: BeamElements
    line_mass: float
    coupling: Coupling | None = None


@lru_cache(maxsize=KEPT_CHAINS)
def build_chain(
    name: str,
    section: BeamSection,
    mass: LinkMass,
    elements: int,
    shapes: BeamShapes,
    acting_at: tuple[float, ...] = (),
) -> Chain:
    """Build one link of beam elements.

    Parameters
    ----------
    name : str
    section : BeamSection
    mass : LinkMass
        Distributed and point masses of the link, and bodies fixed to it.
    elements : int
    shapes : BeamShapes
        Kind of element.
    acting_at : tuple of float
        Where loads and springs act, m from the start: a node is put there.

    Returns
    -------
    Chain
    """
    fixed = [*mass.point_positions, *(body.position for body in mass.bodies), *acting_at]
    nodes = node_positions(mass.length, elements, fixed)
    of_elements = _section_of_elements(section, mass.length, shapes)
    beams = BeamElements(
        shapes, of_elements, np.diff(nodes), _kinked(nodes, section, mass, acting_at)
    )
    model = _straight_link(name, nodes, beams, mass).carrying(mass)
    return Chain(model, nodes, beams, mass.mass_per_length)


def _section_of_elements(section: BeamSection, length: float, shapes: BeamShapes) -> BeamSection:
    """Section with a shear flexibility that elements can have, where they shear."""
    return section if shapes.stiff_in_shear else section.shearing_over(length)


def _straight_link(name: str, nodes: FloatArray, beams: BeamElements, mass: LinkMass) -> LinkModel:
    """Straight link of beam elements with nodes (e + 1,) and point masses, without bodies."""
    shapes = beams.shapes
    per_node = shapes.per_node
    size = per_node * len(nodes)
    matrices = np.stack(
        [
            beams.mass,
            beams.centrifugal_mass,
            beams.gyroscopic,
            beams.stiffness,
            beams.damping,
        ]
    )
    first_moment = sum_of_elements(beams.first_moment)
    if not mass.mass_per_length:
        # All of it is in points.
        matrices[:3], first_moment[:] = 0.0, 0.0
    for place, lump in zip(mass.point_positions, mass.point_masses, strict=True):
        _add_point_mass(matrices[:3], int(np.abs(nodes - place).argmin()), lump)
    inertia, centrifugal, gyroscopic, stiffness, damping = map(chain_matrix, matrices)
    last, clamped = size - per_node, np.array(shapes.clamped)
    warping = np.array(shapes.warping, dtype=np.intp)
    return LinkModel(
        name=name,
        mass=inertia,
        gyroscopic=gyroscopic,
        centrifugal_mass=centrifugal,
        first_moment=first_moment,
        stiffness=stiffness,
        damping=damping,
        is_axial=np.arange(size) % per_node == 0,
        start=np.array([0, 1]),
        end=np.array([last, last + 1]),
        start_rotation=clamped,
        end_rotation=last + clamped,
        readings=LinkReadings(
            nodes,
            per_node,
            beams.displacement_shapes,
            slope=ROTATION,
            deflection=1 if shapes.stiff_in_shear else None,
            element_maps=beams.element_maps,
        ),
        fields=_rigid_fields(nodes, shapes),
        start_warping=warping,
        end_warping=last + warping,
        vectors=per_node * np.arange(len(nodes)) + np.array([[0], [1]]),
        uncounted_rotary_inertia=0.0 if shapes.has_rotary_inertia else mass.rotary_inertia,
    )


def _kinked(
    nodes: FloatArray, section: BeamSection, mass: LinkMass, acting_at: Sequence[float]
) -> NDArray[np.bool_]:
    """Elements at whose start a couple may act and the curvature jump, (e,)."""
    # A force along the pins' axis turns a neutral one that is off it.
    off = section.is_eccentric
    turned = [x.position for x in mass.bodies if off or x.inertia or any(x.offset)]
    places = [*turned, *acting_at, *(mass.point_positions if off else ())]
    kinked = np.zeros(len(nodes), dtype=bool)
    kinked[[int(np.argmin(np.abs(nodes - x))) for x in places]] = True
    kinked[0] = False
    return kinked[:-1]


def _add_point_mass(matrices: FloatArray, node: int, mass: float) -> None:
    """Add a point mass to the mass, the centrifugal mass and ``S`` of elements.

    Parameters
    ----------
    matrices : ndarray, shape (3, e, 2 p, 2 p)
    node : int
    mass : float
    """
    count, per_node = matrices.shape[1], matrices.shape[-1] // 2
    element = min(node, count - 1)
    u = per_node * (node - element)
    for place in (u, u + 1):
        matrices[:2, element, place, place] += mass
    matrices[2, element, u, u + 1] -= mass
    matrices[2, element, u + 1, u] += mass


def sum_of_elements(vectors: FloatArray) -> FloatArray:
    """Sum vectors of consecutive elements of p coordinates a node.

    Parameters
    ----------
    vectors : ndarray, shape (..., e, 2 p)

    Returns
    -------
    ndarray, shape (..., p (e + 1))
    """
    *kinds, count, size = vectors.shape
    total = np.zeros((*kinds, count + 1, size // 2))
    total[..., :-1, :] += vectors[..., : size // 2]
    total[..., 1:, :] += vectors[..., size // 2 :]
    return total.reshape(*kinds, -1)


def _rigid_fields(nodes: FloatArray, shapes: BeamShapes) -> RigidFields:
    every = np.zeros((4, len(nodes), shapes.per_node))
    along, across, centripetal, tangential = every
    along[..., 0] = 1.0
    across[..., 1] = 1.0
    centripetal[..., 0] = nodes
    tangential[..., 1] = nodes
    tangential[..., shapes.angles] = 1.0
    return RigidFields(*every.reshape(4, -1))
