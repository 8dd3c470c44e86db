"""The two beam elements of Exudyn that a link can be made of, and their coordinates."""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linear_system import RigidFields
from flexmech.mechanism import Mechanism
from flexmech.multibody.beam_kind import BeamKind
from flexmech.multibody.items import ItemNumber, Made, SystemItems
from flexmech.multibody.running.user_functions import turned_frame
from flexmech.multibody.strains import (
    Strain,
    cable_strains,
    element_shear_damping_time,
    element_shear_stiffness,
    exact_beam_strains,
)
from flexmech.sections import BeamSection


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

    def rigid_fields(self, nodes: FloatArray) -> RigidFields:
        """See :class:`BeamKind`."""
        along, across, centripetal, tangential = np.zeros((4, len(nodes), 4))
        along[:, 0] = across[:, 1] = 1.0
        centripetal[:, 0], centripetal[:, 2] = nodes, 1.0
        tangential[:, 1], tangential[:, 3] = nodes, 1.0
        return RigidFields(along.ravel(), across.ravel(), centripetal.ravel(), tangential.ravel())

    def pose(self, nodes: FloatArray, origin: FloatArray, angle: float) -> FloatArray:
        """See :class:`BeamKind`."""
        cosine, sine = np.cos(angle), np.sin(angle)
        q = np.empty((len(nodes), 4))
        q[:, 0] = origin[0] + (cosine - 1) * nodes
        q[:, 1] = origin[1] + sine * nodes
        q[:, 2], q[:, 3] = cosine - 1, sine
        return q.ravel()

    def add_axis_marker(
        self,
        items: SystemItems,
        name: str,
        node: ItemNumber,
        element: ItemNumber,
        x: float,
        angle: float = 0.0,
    ) -> ItemNumber:
        """See :class:`BeamKind`."""
        if angle:
            frame = Made(turned_frame, (x, 0.0, angle))
            return items.add("MarkerBodyRigid", name, bodyNumber=element, localHT=frame)
        return items.add("MarkerBodyRigid", name, bodyNumber=element, localPosition=[x, 0.0, 0.0])

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

    def rigid_fields(self, nodes: FloatArray) -> RigidFields:
        """See :class:`BeamKind`."""
        along, across, centripetal, tangential = np.zeros((4, len(nodes), 3))
        along[:, 0] = across[:, 1] = 1.0
        centripetal[:, 0] = nodes
        tangential[:, 1], tangential[:, 2] = nodes, 1.0
        return RigidFields(along.ravel(), across.ravel(), centripetal.ravel(), tangential.ravel())

    def pose(self, nodes: FloatArray, origin: FloatArray, angle: float) -> FloatArray:
        """See :class:`BeamKind`."""
        q = np.empty((len(nodes), 3))
        q[:, 0] = origin[0] + (np.cos(angle) - 1) * nodes
        q[:, 1] = origin[1] + np.sin(angle) * nodes
        q[:, 2] = angle
        return q.ravel()

    def add_axis_marker(
        self,
        items: SystemItems,
        name: str,
        node: ItemNumber,
        element: ItemNumber,
        x: float,
        angle: float = 0.0,
    ) -> ItemNumber:
        """See :class:`BeamKind`."""
        return items.add("MarkerNodeRigid", name, nodeNumber=node)

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
