"""A straight link assembled of beam elements."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, IntArray
from flexmech.beams.elements import ROTATION, BeamElements
from flexmech.beams.theories import BeamShapes
from flexmech.linear_system import LinkModel, LinkReadings, RigidFields, chain_matrix
from flexmech.linkages import LinkMass
from flexmech.mesh import node_positions
from flexmech.sections import BeamSection, SectionStack


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
        Of Kelvin-Voigt damping in s.
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
    """One link of beam elements, or that of D designs with this leading dimension.

    Parameters
    ----------
    model : LinkModel
        Coordinates (u, v, phi, ...) node by node.
    nodes : ndarray, shape (e + 1,)
        Node positions in m.
    elements : BeamElements
    line_mass : float or ndarray, shape (D,)
        Mass per length that is distributed along it, in kg/m.
    coupling : Coupling, optional
        What the link's matrices have besides those of the elements.
    """

    model: LinkModel
    nodes: FloatArray
    elements: BeamElements
    line_mass: FloatArray | float
    coupling: Coupling | None = None


def build_chain(
    name: str,
    section: BeamSection,
    mass: LinkMass,
    elements: int,
    shapes: BeamShapes,
    acting_at: Sequence[float] = (),
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
    acting_at : sequence of float
        Where loads and springs act, m from the start: a node is put there.

    Returns
    -------
    Chain
    """
    fixed = [*mass.point_positions, *(body.position for body in mass.bodies), *acting_at]
    nodes = node_positions(mass.length, elements, fixed)
    own = _section_of_elements(section, mass.length, shapes)
    beams = BeamElements(shapes, own, np.diff(nodes), _kinked(nodes, section, mass, acting_at))
    model = _straight_link(name, nodes, beams, [mass]).carrying(mass)
    return Chain(model, nodes, beams, mass.mass_per_length)


def _section_of_elements(section: BeamSection, length: float, shapes: BeamShapes) -> BeamSection:
    """Section with a shear flexibility that elements can have, where they shear."""
    return section if shapes.stiff_in_shear else section.shearing_over(length)


def stack_chains(
    name: str,
    sections: Sequence[BeamSection],
    masses: Sequence[LinkMass],
    elements: int,
    shapes: BeamShapes,
) -> Chain:
    """Build one link of D designs, as :func:`build_chain` builds that of one.

    Parameters
    ----------
    name : str
    sections : sequence of BeamSection
        Whose axes are that of the pins, without free strains.
    masses : sequence of LinkMass
        Distributed and as many point masses in every design; no bodies.
    elements : int
    shapes : BeamShapes
        Kind of element, of Euler-Bernoulli's or Timoshenko's theory.

    Returns
    -------
    Chain
    """
    own = tuple(
        _section_of_elements(section, mass.length, shapes)
        for section, mass in zip(sections, masses, strict=True)
    )
    nodes = np.stack([node_positions(m.length, elements, m.point_positions) for m in masses])
    beams = BeamElements(shapes, cast("BeamSection", SectionStack.of(own)), np.diff(nodes))
    model = _straight_link(name, nodes, beams, masses)
    return Chain(model, nodes, beams, np.array([mass.mass_per_length for mass in masses]))


def _straight_link(
    name: str, nodes: FloatArray, beams: BeamElements, masses: Sequence[LinkMass]
) -> LinkModel:
    """Straight link of beam elements with point masses, without bodies.

    Of one design with nodes (e + 1,), or of as many as there are masses with nodes (D, e + 1).
    """

    def by_design(values: Sequence[float]) -> FloatArray:
        return np.reshape(values, nodes.shape[:-1])

    shapes = beams.shapes
    per_node = shapes.per_node
    size = per_node * nodes.shape[-1]
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
    if not any(mass.mass_per_length for mass in masses):
        # All of it is in points.
        matrices[:3], first_moment[:] = 0.0, 0.0
    positions = zip(*(mass.point_positions for mass in masses), strict=True)
    lumps = zip(*(mass.point_masses for mass in masses), strict=True)
    for place, lump in zip(positions, lumps, strict=True):
        node = np.abs(nodes - by_design(place)[..., None]).argmin(axis=-1)
        _add_point_mass(matrices[:3], node, by_design(lump))
    inertia, centrifugal, gyroscopic, stiffness, damping = map(chain_matrix, matrices)
    last, clamped = size - per_node, np.array(shapes.clamped)
    warping = np.array(shapes.warping, dtype=np.intp)
    rotary = by_design([mass.rotary_inertia for mass in masses])
    uncounted = 0.0 if shapes.has_rotary_inertia else rotary
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
        vectors=per_node * np.arange(nodes.shape[-1]) + np.array([[0], [1]]),
        uncounted_rotary_inertia=uncounted,
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


def _add_point_mass(matrices: FloatArray, node: IntArray, mass: FloatArray) -> None:
    """Add a point mass to the mass, the centrifugal mass and ``S`` of elements.

    Parameters
    ----------
    matrices : ndarray, shape (3, e, 2 p, 2 p) or (3, D, e, 2 p, 2 p)
    node, mass : ndarray, shape () or (D,)
    """
    count, per_node = matrices.shape[-3], matrices.shape[-1] // 2
    element = np.minimum(node, count - 1)
    u = per_node * (node - element)
    design = () if matrices.ndim == 4 else (np.arange(len(matrices[0])),)
    inertia, centrifugal, gyroscopic = matrices
    for matrix in (inertia, centrifugal):
        for place in (u, u + 1):
            matrix[(*design, element, place, place)] += mass
    gyroscopic[(*design, element, u, u + 1)] -= mass
    gyroscopic[(*design, element, u + 1, u)] += mass


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
    every = np.zeros((4, *nodes.shape, shapes.per_node))
    along, across, centripetal, tangential = every
    along[..., 0] = 1.0
    across[..., 1] = 1.0
    centripetal[..., 0] = nodes
    tangential[..., 1] = nodes
    tangential[..., shapes.angles] = 1.0
    return RigidFields(*every.reshape(4, *nodes.shape[:-1], -1))
