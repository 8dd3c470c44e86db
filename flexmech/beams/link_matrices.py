"""A straight link assembled of beam elements."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray
from flexmech.beams.elements import ROTATION, BeamElements
from flexmech.beams.theories import BeamShapes
from flexmech.linear_system import LinkModel, LinkReadings, RigidFields, chain_matrix
from flexmech.linkages import LinkMass
from flexmech.mesh import node_positions
from flexmech.sections import BeamSection

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
    own = _section_of_elements(section, mass.length, shapes)
    beams = BeamElements(shapes, own, np.diff(nodes), _kinked(nodes, section, mass, acting_at))
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
