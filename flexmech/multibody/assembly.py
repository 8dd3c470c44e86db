"""Links of a mechanism in an Exudyn system, their pins and the markers that joints need.

What stands still and what runs differ in their loads, their supports and their drive. Both
hold one assembly, add these to it in their own order, and have the system assembled.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmech.linkages import LinkEnd
from flexmech.mechanism import Mechanism
from flexmech.mesh import node_positions
from flexmech.multibody.arms import Arms, LinkArms
from flexmech.multibody.beam_kind import BeamKind
from flexmech.multibody.beams import BEAM_KINDS
from flexmech.multibody.items import ItemNumber, SystemItems
from flexmech.multibody.node_bodies import NodeBodies, point_masses_at
from flexmech.types import FloatArray

__all__ = ["LinkAssembly", "LinkPart"]


@dataclass(frozen=True)
class LinkPart:
    """One link in the Exudyn system.

    Parameters
    ----------
    positions : ndarray, shape (e + 1,)
        Node positions along the link in m.
    nodes, elements : list of ItemNumber
    coordinates : slice
        Where the link's coordinates are in the system's.
    arms : Arms, optional
        From the pins' axis to the nodes; None where the section is not eccentric and the
        nodes are on it.
    bodies : NodeBodies, optional
        Bodies at the nodes, which carry all mass; its beams do where there are none.
    """

    positions: FloatArray
    nodes: list[ItemNumber]
    elements: list[ItemNumber]
    coordinates: slice
    arms: Arms | None = None
    bodies: NodeBodies | None = None


class LinkAssembly:
    """Links along the global x axis, one upon the other, until a state is given to them.

    Coordinates are those of the pins' axis, less the reference ones, unless Exudyn's own are
    spoken of: these are the nodes', and :attr:`arms` leads from the one to the other.

    Parameters
    ----------
    mechanism : Mechanism
    elements : int
        Elements a link.
    kind : str
        Key of :data:`flexmech.multibody.beams.BEAM_KINDS`.

    Attributes
    ----------
    items : SystemItems
    mbs : exudyn.MainSystem
        Its system.
    sections : list of BeamSection
    parts : list of LinkPart
        In the topology's order, as the sections.
    size : int
        Number of coordinates of all links.
    arms : LinkArms
    base : int
        The clamped link.
    """

    def __init__(self, mechanism: Mechanism, elements: int, kind: str) -> None:
        self.mechanism = mechanism
        self.topology = mechanism.linkage.topology
        self.sections = [mechanism.sections[name] for name in self.topology.link_names]
        self.kind: BeamKind = BEAM_KINDS[kind]
        self.items = SystemItems()
        self.mbs = self.items.mbs
        self.base = self.topology.index(self.topology.clamps[0].held.link)
        self.parts = self._add_links(elements)
        self.size = self.parts[-1].coordinates.stop
        self.arms = LinkArms(
            [part.arms for part in self.parts], [part.coordinates for part in self.parts]
        )

    @property
    def nodal_force_scale(self) -> float:
        """Force between neighbouring nodes if one stood still and the other at the origin."""
        extent = sum(link.length for link in self.topology.links)
        scales = []
        for section, part in zip(self.sections, self.parts, strict=True):
            length = float(np.diff(part.positions).min())
            bending = 12 * section.bending_stiffness / length**2
            stiffness = max(section.axial_stiffness, section.shear_stiffness, bending) / length
            scales.append(stiffness * extent)
        return max(scales)

    def point_masses(self, link: int) -> FloatArray:
        """Point mass at each node of a link in kg, shape (e + 1,)."""
        name, part = self.topology.link_names[link], self.parts[link]
        return point_masses_at(self.mechanism, name, part.positions)

    def part_of(self, place: LinkEnd) -> LinkPart:
        """The link that an end belongs to."""
        return self.parts[self.topology.index(place.link)]

    def end_node(self, place: LinkEnd) -> tuple[ItemNumber, int]:
        """Node number at a link end and the first of its coordinates."""
        part = self.part_of(place)
        if place.end == "start":
            return part.nodes[0], part.coordinates.start
        return part.nodes[-1], part.coordinates.stop - self.kind.per_node

    def reference_place(self, place: LinkEnd) -> FloatArray:
        """Where a link end is in the reference configuration, shape (2,)."""
        positions = self.part_of(place).positions
        return np.array([positions[0 if place.end == "start" else -1], 0.0])

    def add_fixed_coordinate(self) -> ItemNumber:
        """Add a coordinate that stays zero; returns its marker."""
        ground = self.items.add("NodePointGround", "ground_node")
        return self.items.add(
            "MarkerNodeCoordinate", "ground_coordinate", nodeNumber=ground, coordinate=0
        )

    def add_constraint(
        self, name: str, fixed: ItemNumber, node: ItemNumber, coordinate: int, **offset: Any
    ) -> ItemNumber:
        """Keep a node's coordinate at an offset from the fixed one.

        Further arguments go to Exudyn's constraint and prescribe the offset; it is zero without.

        Parameters
        ----------
        name : str
        fixed : ItemNumber
            Marker of :meth:`add_fixed_coordinate`.
        node : ItemNumber
        coordinate : int
            Which of the node's coordinates.

        Returns
        -------
        ItemNumber
        """
        marker = self.items.add(
            "MarkerNodeCoordinate", f"{name}_coordinate", nodeNumber=node, coordinate=coordinate
        )
        return self.items.add("CoordinateConstraint", name, markerNumbers=[fixed, marker], **offset)

    def add_pins(self) -> list[ItemNumber]:
        """Pin the links together; returns the pins' numbers in the topology's order."""
        joints = []
        for pin in self.topology.pins:
            name = f"pin_{pin.joint}"
            self.items.begin(f"pin {pin.joint}")
            markers = [
                self.add_end_marker(place, f"{name}_on_{place.link}")
                for place in (self.topology.leader_of(pin.leader), pin.follower)
            ]
            joints.append(self.items.add("RevoluteJoint2D", name, markerNumbers=markers))
        return joints

    def add_ground_pin(
        self, name: str, held: LinkEnd, place: list[float]
    ) -> tuple[ItemNumber, ItemNumber]:
        """Pin a link end to a point of the ground.

        Parameters
        ----------
        name : str
            Of the pin.
        held : LinkEnd
        place : list of float
            In m.

        Returns
        -------
        ItemNumber
            Of the ground.
        ItemNumber
            Of the pin.
        """
        items = self.items
        ground = items.add("ObjectGround", f"{name}_ground", referencePosition=place)
        markers = [
            items.add("MarkerBodyPosition", f"{name}_on_ground", bodyNumber=ground),
            self.add_end_marker(held, f"{name}_on_{held.link}"),
        ]
        return ground, items.add("RevoluteJoint2D", name, markerNumbers=markers)

    def add_end_marker(self, place: LinkEnd, name: str) -> ItemNumber:
        """Add a marker of the point on the pins' axis at a link end."""
        part = self.part_of(place)
        if part.arms is not None:
            return self.add_axis_point(part, 0 if place.end == "start" else -1, name)
        return self.items.add("MarkerNodePosition", name, nodeNumber=self.end_node(place)[0])

    def add_axis_point(self, part: LinkPart, number: int, name: str) -> ItemNumber:
        """Add a marker of the point on the pins' axis at a node of an eccentric link.

        Parameters
        ----------
        part : LinkPart
        number : int
            Of the node in the link.
        name : str
            Of the marker.

        Returns
        -------
        ItemNumber
        """
        assert part.arms is not None
        assert part.bodies is not None
        return self.items.add(
            "MarkerBodyRigid",
            name,
            bodyNumber=part.bodies.numbers[number],
            localPosition=[0.0, -part.arms.length, 0.0],
        )

    def _add_links(self, elements: int) -> list[LinkPart]:
        parts, start = [], 0
        for name, section in zip(self.topology.link_names, self.sections, strict=True):
            mass = self.mechanism.link_mass(name)
            positions = node_positions(mass.length, elements, mass.point_positions)
            self.items.begin(f"{name}: nodes, in the undeformed link along the x axis")
            nodes = [
                self.kind.add_node(self.items, f"{name}_node_{i}", float(x), section.neutral_axis)
                for i, x in enumerate(positions)
            ]
            self.items.begin(f"{name}: beam elements")
            beams = [
                self.kind.add_element(
                    self.items, f"{name}_element_{i}", nodes[i : i + 2], float(h), section
                )
                for i, h in enumerate(np.diff(positions))
            ]
            stop = start + self.kind.per_node * len(nodes)
            arms = Arms(section.neutral_axis) if section.is_eccentric else None
            bodies = None
            if not self.kind.carries_mass:
                points = point_masses_at(self.mechanism, name, positions)
                bodies = NodeBodies.added(self.items, name, nodes, positions, section, points)
            parts.append(LinkPart(positions, nodes, beams, slice(start, stop), arms, bodies))
            start = stop
        return parts
