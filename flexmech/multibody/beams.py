"""The two beam elements of Exudyn that a link can be made of, and their coordinates."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, IntArray
from flexmech.errors import InputError
from flexmech.linear_system import RigidFields
from flexmech.mechanism import Mechanism
from flexmech.multibody.items import ItemNumber, SystemItems
from flexmech.multibody.strains import (
    Strain,
    cable_strains,
    element_shear_damping_time,
    element_shear_stiffness,
    exact_beam_strains,
)
from flexmech.sections import BeamSection


class BeamKind(ABC):
    """A kind of beam element of Exudyn, and the coordinates of a chain of them.

    Attributes
    ----------
    per_node : int
        Coordinates a node.
    vectors : tuple of tuple of int
        Pairs of a node's coordinates that turn as a vector with the link.
    clamped : int
        The node's coordinate that a clamp holds besides the position: slope or rotation.
    deflection : int or None
        The node's coordinate across the link if its slope follows from it (no shear).
    turns_arms : bool
        Whether a node's section is rigid and turns what sits off the neutral axis.
    carries_mass : bool
        Whether the elements carry the link's mass; if not, bodies at the nodes do.
    has_rotary_inertia : bool
        Whether vibration has the rotary inertia of the sections; the rigid motion always has it.
    """

    per_node: int
    vectors: tuple[tuple[int, int], ...]
    clamped: int
    deflection: int | None
    turns_arms: bool
    carries_mass: bool
    has_rotary_inertia: bool

    @abstractmethod
    def add_node(self, items: SystemItems, name: str, x: float, y: float) -> ItemNumber:
        """Node of a link along the global x axis; returns its number.

        Parameters
        ----------
        items : SystemItems
        name : str
        x, y : float
            Place along the link and distance of the neutral axis from the pins' axis in m.

        Returns
        -------
        ItemNumber
        """

    @abstractmethod
    def add_element(
        self,
        items: SystemItems,
        name: str,
        nodes: list[ItemNumber],
        length: float,
        section: BeamSection,
    ) -> ItemNumber:
        """Beam element between two nodes.

        Parameters
        ----------
        items : SystemItems
        name : str
        nodes : list of ItemNumber
            Of its two nodes.
        length : float
            In m.
        section : BeamSection

        Returns
        -------
        ItemNumber
        """

    @abstractmethod
    def shape_functions(self, fraction: FloatArray, length: FloatArray) -> FloatArray:
        """Displacement inside elements, (s, 2, 2 per_node) for places (s,)."""

    def rigid_fields(self, nodes: FloatArray) -> RigidFields:
        """Coordinates of a rigid link's accelerations."""
        along, across, centripetal, tangential = np.zeros((4, len(nodes), self.per_node))
        along[:, 0] = across[:, 1] = 1.0
        centripetal[:, 0] = tangential[:, 1] = nodes
        for slope, _ in self.vectors[1:]:
            centripetal[:, slope] = 1.0
        tangential[:, self.clamped] = 1.0
        return RigidFields(along.ravel(), across.ravel(), centripetal.ravel(), tangential.ravel())

    @abstractmethod
    def strains(
        self, displacement: FloatArray, rate: FloatArray, length: FloatArray, section: BeamSection
    ) -> list[Strain]:
        """The strains by which Exudyn's element stores energy, at its integration points.

        Parameters
        ----------
        displacement, rate : ndarray, shape (m, k * per_node)
            Coordinates of a chain of nodes, less those of the straight link along x, and their
            time derivatives, in axes that may turn with the link.
        length : ndarray, shape (k - 1,)
            Of the undeformed elements in m.
        section : BeamSection

        Returns
        -------
        list of Strain
        """

    def swell(self, mbs: Any, element: int, section: BeamSection, part: float) -> None:
        """Give an element a part of its section's free curvature and strain.

        Parameters
        ----------
        mbs : exudyn.MainSystem
        element : int
            Exudyn's number.
        section : BeamSection
        part : float
            1 for all of it.
        """
        mbs.SetObjectParameter(element, "referenceCurvature", part * section.free_curvature)

    def internal_force(
        self, displacement: FloatArray, length: FloatArray, section: BeamSection
    ) -> FloatArray:
        """Elastic forces on the nodes, the derivative of the strain energy.

        Parameters
        ----------
        displacement : ndarray, shape (m, k * per_node)
            Coordinates of a chain of nodes, less those of the straight link.
        length : ndarray, shape (k - 1,)
            Of the undeformed elements in m.
        section : BeamSection

        Returns
        -------
        ndarray, shape (m, k * per_node)
        """
        size = displacement.shape[1]
        unit_rates = np.tile(np.eye(size), (len(displacement), 1))
        strains = self.strains(np.repeat(displacement, size, axis=0), unit_rates, length, section)
        return np.asarray(sum(strain.power for strain in strains)).reshape(displacement.shape)

    def is_axial(self, count: int) -> NDArray[np.bool_]:
        """Whether coordinates of a chain of ``count`` nodes are displacements along its axis."""
        axial = np.zeros(self.per_node, dtype=bool)
        axial[[x for x, _ in self.vectors]] = True
        return np.tile(axial, count)

    def vector_pairs(self, count: int) -> tuple[IntArray, IntArray]:
        """X and y coordinates of all vectors in a chain of ``count`` nodes."""
        base = self.per_node * np.arange(count)[:, None]
        pairs = np.array(self.vectors)
        return (base + pairs[:, 0]).ravel(), (base + pairs[:, 1]).ravel()


class AncfCable(BeamKind):
    """``ObjectANCFCable2D``: position and slope vector a node, no shear, no rotary inertia."""

    per_node = 4
    vectors = ((0, 1), (2, 3))
    clamped = 3
    deflection = 1
    turns_arms = False
    carries_mass = True
    has_rotary_inertia = False

    def add_node(self, items: SystemItems, name: str, x: float, y: float) -> ItemNumber:
        """See :class:`BeamKind`."""
        return items.add("NodePoint2DSlope1", name, referenceCoordinates=[x, y, 1.0, 0.0])

    def add_element(
        self,
        items: SystemItems,
        name: str,
        nodes: list[ItemNumber],
        length: float,
        section: BeamSection,
    ) -> ItemNumber:
        """See :class:`BeamKind`."""
        return items.add(
            "ObjectANCFCable2D",
            name,
            nodeNumbers=nodes,
            length=length,
            massPerLength=section.mass_per_length,
            bendingStiffness=section.bending_stiffness,
            axialStiffness=section.axial_stiffness,
            bendingDamping=section.damping.bending * section.bending_stiffness,
            axialDamping=section.damping.axial * section.axial_stiffness,
            referenceAxialStrain=section.free_strain,
            referenceCurvature=section.free_curvature,
        )

    def swell(self, mbs: Any, element: int, section: BeamSection, part: float) -> None:
        """See :class:`BeamKind`."""
        super().swell(mbs, element, section, part)
        mbs.SetObjectParameter(element, "referenceAxialStrain", part * section.free_strain)

    def shape_functions(self, fraction: FloatArray, length: FloatArray) -> FloatArray:
        """Cubic Hermite in both directions; see :class:`BeamKind`."""
        s = fraction
        hermite = np.stack(
            [
                1 - 3 * s**2 + 2 * s**3,
                length * (s - 2 * s**2 + s**3),
                3 * s**2 - 2 * s**3,
                length * (s**3 - s**2),
            ],
            axis=-1,
        )
        values = np.zeros((len(s), 2, 8))
        values[:, 0, 0::2] = hermite
        values[:, 1, 1::2] = hermite
        return values

    def strains(
        self, displacement: FloatArray, rate: FloatArray, length: FloatArray, section: BeamSection
    ) -> list[Strain]:
        """See :class:`BeamKind`."""
        return cable_strains(displacement, rate, length, section)


class GeometricallyExactBeam(BeamKind):
    """``ObjectBeamGeometricallyExact2D``: position and rotation a node, shear, rotary inertia.

    Its mass sits at the nodes; see :mod:`flexmech.multibody.node_bodies`.
    """

    per_node = 3
    vectors = ((0, 1),)
    clamped = 2
    deflection = None
    turns_arms = True
    carries_mass = False
    has_rotary_inertia = True

    def add_node(self, items: SystemItems, name: str, x: float, y: float) -> ItemNumber:
        """See :class:`BeamKind`."""
        return items.add("NodeRigidBody2D", name, referenceCoordinates=[x, y, 0.0])

    def add_element(
        self,
        items: SystemItems,
        name: str,
        nodes: list[ItemNumber],
        length: float,
        section: BeamSection,
    ) -> ItemNumber:
        """See :class:`BeamKind`."""
        h = np.array([length])
        shear_stiffness = float(element_shear_stiffness(section, h)[0])
        shear_time = float(element_shear_damping_time(section, h)[0])
        return items.add(
            "ObjectBeamGeometricallyExact2D",
            name,
            nodeNumbers=nodes,
            length=length,
            massPerLength=0.0,
            crossSectionInertia=0.0,
            bendingStiffness=section.bending_stiffness,
            axialStiffness=section.axial_stiffness,
            shearStiffness=shear_stiffness,
            bendingDamping=section.damping.bending * section.bending_stiffness,
            axialDamping=section.damping.axial * section.axial_stiffness,
            shearDamping=shear_time * shear_stiffness,
            referenceCurvature=section.free_curvature,
        )

    def shape_functions(self, fraction: FloatArray, length: FloatArray) -> FloatArray:
        """Linear in all coordinates; see :class:`BeamKind`."""
        values = np.zeros((len(fraction), 2, 6))
        for component in (0, 1):
            values[:, component, component] = 1 - fraction
            values[:, component, component + 3] = fraction
        return values

    def strains(
        self, displacement: FloatArray, rate: FloatArray, length: FloatArray, section: BeamSection
    ) -> list[Strain]:
        """See :class:`BeamKind`."""
        return exact_beam_strains(displacement, rate, length, section)


BEAM_KINDS: dict[str, BeamKind] = {
    "ancf": AncfCable(),
    "geometrically-exact": GeometricallyExactBeam(),
}


def refuse_sections(mechanism: Mechanism, kind: str) -> None:
    """Refuse sections that an element cannot have.

    Parameters
    ----------
    mechanism : Mechanism
    kind : str
        Key of :data:`flexmech.multibody.beams.BEAM_KINDS`.

    Raises
    ------
    InputError
        If the element would ignore that a section is eccentric, or stretches without load;
        names the links.
    """
    links = mechanism.linkage.topology.links
    sections = [(link.name, mechanism.sections[link.name]) for link in links if not link.rigid]
    eccentric = [name for name, section in sections if section.is_eccentric]
    stretched = [name for name, section in sections if section.free_strain]
    if eccentric and not BEAM_KINDS[kind].turns_arms:
        raise InputError(
            f"the section of {', '.join(eccentric)} has its neutral axis or its centre of mass off "
            f"the pins' axis, which Exudyn's element {kind!r} cannot have; use element "
            "'geometrically-exact'"
        )
    if stretched and kind == "geometrically-exact":
        raise InputError(
            f"the section of {', '.join(stretched)} has a free_strain, which Exudyn's element "
            f"{kind!r} has no reference strain for; give the link its swollen length instead, or "
            "use element 'ancf'"
        )
