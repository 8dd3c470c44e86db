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
from flexmech.multibody.library import load_exudyn
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
    nodes, elements : list of int
        Exudyn's numbers.
    coordinates : slice
        Where the link's coordinates are in the system's.
    arms : Arms, optional
        From the pins' axis to the nodes; None where the section is not eccentric and the
        nodes are on it.
    bodies : NodeBodies, optional
        Bodies at the nodes, which carry all mass; its beams do where there are none.
    """

    positions: FloatArray
    nodes: list[int]
    elements: list[int]
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
    mbs : exudyn.MainSystem
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
        self._container = load_exudyn().SystemContainer()
        self.mbs: Any = self._container.AddSystem()
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

    def end_node(self, place: LinkEnd) -> tuple[int, int]:
        """Node number at a link end and the first of its coordinates."""
        part = self.part_of(place)
        if place.end == "start":
            return part.nodes[0], part.coordinates.start
        return part.nodes[-1], part.coordinates.stop - self.kind.per_node

    def reference_place(self, place: LinkEnd) -> FloatArray:
        """Where a link end is in the reference configuration, shape (2,)."""
        positions = self.part_of(place).positions
        return np.array([positions[0 if place.end == "start" else -1], 0.0])

    def add_fixed_coordinate(self) -> int:
        """Add a coordinate that stays zero; returns its marker."""
        items = load_exudyn().itemInterface
        ground = self.mbs.AddNode(items.NodePointGround())
        return int(self.mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0)))

    def add_constraint(self, fixed: int, node: int, coordinate: int, **offset: Any) -> int:
        """Keep a node's coordinate at an offset from the fixed one.

        Further arguments go to Exudyn's constraint and prescribe the offset; it is zero without.

        Parameters
        ----------
        fixed : int
            Marker of :meth:`add_fixed_coordinate`.
        node, coordinate : int
            Exudyn's number of the node, and which of its coordinates.

        Returns
        -------
        int
            Exudyn's number of the constraint.
        """
        items = load_exudyn().itemInterface
        marker = self.mbs.AddMarker(
            items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate)
        )
        return int(
            self.mbs.AddObject(items.CoordinateConstraint(markerNumbers=[fixed, marker], **offset))
        )

    def add_pins(self) -> list[int]:
        """Pin the links together; returns the pins' numbers in the topology's order."""
        items = load_exudyn().itemInterface
        joints = []
        for pin in self.topology.pins:
            markers = [
                self.add_end_marker(place)
                for place in (self.topology.leader_of(pin.leader), pin.follower)
            ]
            joints.append(int(self.mbs.AddObject(items.RevoluteJoint2D(markerNumbers=markers))))
        return joints

    def add_ground_pin(self, held: LinkEnd, place: list[float]) -> tuple[int, int]:
        """Pin a link end to a point of the ground; returns the ground's number and the pin's."""
        items = load_exudyn().itemInterface
        ground = self.mbs.AddObject(items.ObjectGround(referencePosition=place))
        markers = [
            self.mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=ground)),
            self.add_end_marker(held),
        ]
        pin = self.mbs.AddObject(items.RevoluteJoint2D(markerNumbers=markers))
        return int(ground), int(pin)

    def add_end_marker(self, place: LinkEnd) -> int:
        """Add a marker of the point on the pins' axis at a link end."""
        part = self.part_of(place)
        if part.arms is not None:
            return self.add_axis_point(part, 0 if place.end == "start" else -1)
        items = load_exudyn().itemInterface
        node = items.MarkerNodePosition(nodeNumber=self.end_node(place)[0])
        return int(self.mbs.AddMarker(node))

    def add_axis_point(self, part: LinkPart, number: int) -> int:
        """Add a marker of the point on the pins' axis at a node of an eccentric link."""
        assert part.arms is not None
        assert part.bodies is not None
        items = load_exudyn().itemInterface
        marker = items.MarkerBodyRigid(
            bodyNumber=part.bodies.numbers[number],
            localPosition=[0.0, -part.arms.length, 0.0],
        )
        return int(self.mbs.AddMarker(marker))

    def _add_links(self, elements: int) -> list[LinkPart]:
        parts, start = [], 0
        for name, section in zip(self.topology.link_names, self.sections, strict=True):
            mass = self.mechanism.link_mass(name)
            positions = node_positions(mass.length, elements, mass.point_positions)
            nodes = [
                self.kind.add_node(self.mbs, float(x), section.neutral_axis) for x in positions
            ]
            beams = [
                self.kind.add_element(self.mbs, nodes[i : i + 2], float(h), section)
                for i, h in enumerate(np.diff(positions))
            ]
            stop = start + self.kind.per_node * len(nodes)
            arms = Arms(section.neutral_axis) if section.is_eccentric else None
            bodies = None
            if not self.kind.carries_mass:
                points = point_masses_at(self.mechanism, name, positions)
                bodies = NodeBodies.added(self.mbs, nodes, positions, section, points)
            parts.append(LinkPart(positions, nodes, beams, slice(start, stop), arms, bodies))
            start = stop
        return parts
