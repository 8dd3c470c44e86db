"""A mechanism as an Exudyn system: built once, moved through the crank angles.

The model stands in the crank's frame: the shaft's clamp is then a condition on single
coordinates with a constant constraint Jacobian, whatever the crank angle. What changes
from one position to the next are the coordinates, the ground pivots and the loads.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from flexmech.linkages import LinkEnd, RigidMotion
from flexmech.mechanism import Mechanism
from flexmech.mesh import node_positions
from flexmech.multibody.arms import Arms, LinkArms
from flexmech.multibody.beam_kind import BeamKind
from flexmech.multibody.beams import BEAM_KINDS, refuse_eccentric_sections
from flexmech.multibody.library import load_exudyn
from flexmech.multibody.node_bodies import BeamInertia, NodeBodies, point_masses_at
from flexmech.types import FloatArray

__all__ = ["LinkPart", "MultibodyModel"]


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
        Bodies at the nodes of such a link; its beams carry all mass where there are none.
    """

    positions: FloatArray
    nodes: list[int]
    elements: list[int]
    coordinates: slice
    arms: Arms | None = None
    bodies: NodeBodies | None = None


class MultibodyModel:
    """Exudyn system of a mechanism.

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
    parts : list of LinkPart
    base : int
        Link in whose frame the model stands: the clamped one.
    arms : LinkArms
    pins : list of int
        Exudyn's numbers of the pins between links, in the topology's order.

    Raises
    ------
    InputError
        If a section is eccentric and the element cannot turn arms.
    """

    def __init__(self, mechanism: Mechanism, elements: int, kind: str) -> None:
        self.mechanism = mechanism
        self.topology = mechanism.linkage.topology
        self.kind: BeamKind = BEAM_KINDS[kind]
        refuse_eccentric_sections(mechanism, kind)
        self._container = load_exudyn().SystemContainer()
        self.mbs: Any = self._container.AddSystem()
        self.base = self.topology.index(self.topology.clamps[0].held.link)
        self.parts = self._add_links(elements)
        self.size = self.parts[-1].coordinates.stop
        self.arms = LinkArms(
            [part.arms for part in self.parts], [part.coordinates for part in self.parts]
        )
        self._arm_loads: list[tuple[int, int]] = []
        self._grounds: list[tuple[int, int, float]] = []
        self._loads = self._add_loads()
        self._offsets = self._add_supports()
        self.pins = self._add_pins()
        self.mbs.Assemble()

    @property
    def nodal_force_scale(self) -> float:
        """Force between neighbouring nodes if one stood still and the other at the origin."""
        extent = sum(link.length for link in self.topology.links)
        scales = []
        for name, part in zip(self.topology.link_names, self.parts, strict=True):
            section, length = self.mechanism.sections[name], float(np.diff(part.positions).min())
            bending = 12 * section.bending_stiffness / length**2
            stiffness = max(section.axial_stiffness, section.shear_stiffness, bending) / length
            scales.append(stiffness * extent)
        return max(scales)

    @property
    def free_load(self) -> float:
        """Force by which swelling that is held back pulls and bends an element, at most."""
        forces = [0.0]
        for name, part in zip(self.topology.link_names, self.parts, strict=True):
            section, length = self.mechanism.sections[name], float(np.diff(part.positions).min())
            bending = abs(section.free_curvature) * section.bending_stiffness / length
            forces.append(bending + abs(section.free_strain) * section.axial_stiffness)
        return max(forces)

    def move_to(self, motion: RigidMotion, number: int) -> FloatArray:
        """Put the supports where position ``number`` of a batch has them.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        number : int

        Returns
        -------
        ndarray, shape (size,)
            Coordinates of the undeformed links, less the reference ones.
        """
        turn = motion.angle[number, self.base]
        cosine, sine = np.cos(turn), np.sin(turn)
        back = np.array([[cosine, sine], [-sine, cosine]])
        pose = np.empty(self.size)
        for link, part in enumerate(self.parts):
            origin = back @ motion.origin[number, link]
            angle = float(motion.angle[number, link] - turn)
            pose[part.coordinates] = self.kind.pose(part.positions, origin, angle)
        nodes = self.arms.to_nodes(pose)
        for constraint, coordinate in self._offsets:
            self.mbs.SetObjectParameter(constraint, "offset", float(nodes[coordinate]))
        for ground, first, x in self._grounds:
            place = [float(pose[first]) + x, float(pose[first + 1]), 0.0]
            self.mbs.SetObjectParameter(ground, "referencePosition", place)
        return pose

    def set_forces(self, forces: FloatArray) -> None:
        """Generalized forces on all coordinates, shape (size,), in the crank's frame."""
        at_nodes = forces.copy()
        for load, first in self._arm_loads:
            x, y = at_nodes[first : first + 2]
            self.mbs.SetLoadParameter(load, "loadVector", [float(x), float(y), 0.0])
            at_nodes[first : first + 2] = 0.0
        self.mbs.SetObjectParameter(self._loads, "forceVector", at_nodes)

    def swell(self, part: float) -> None:
        """Give all elements a part of the free strains of their sections; 1 for all of it."""
        for name, links in zip(self.topology.link_names, self.parts, strict=True):
            section = self.mechanism.sections[name]
            for element in links.elements if section.is_free_strained else ():
                self.kind.swell(self.mbs, element, section, part)

    def point_masses(self, link: int) -> FloatArray:
        """Point mass at each node of a link in kg, shape (e + 1,)."""
        name, part = self.topology.link_names[link], self.parts[link]
        return point_masses_at(self.mechanism, name, part.positions)

    def _add_links(self, elements: int) -> list[LinkPart]:
        parts, start = [], 0
        for name in self.topology.link_names:
            mass, section = self.mechanism.link_mass(name), self.mechanism.sections[name]
            positions = node_positions(mass.length, elements, mass.point_positions)
            nodes = [
                self.kind.add_node(self.mbs, float(x), section.neutral_axis) for x in positions
            ]
            inertia = BeamInertia.of(section)
            beams = [
                self.kind.add_element(self.mbs, nodes[i : i + 2], float(h), section, inertia)
                for i, h in enumerate(np.diff(positions))
            ]
            stop = start + self.kind.per_node * len(nodes)
            arms, bodies = None, None
            if section.is_eccentric:
                points = point_masses_at(self.mechanism, name, positions)
                arms = Arms(section.neutral_axis)
                bodies = NodeBodies.added(self.mbs, nodes, positions, section, points)
            part = LinkPart(positions, nodes, beams, slice(start, stop), arms, bodies)
            parts.append(part)
            start = stop
        return parts

    def _add_loads(self) -> int:
        """One object that carries forces on every coordinate and the point masses."""
        items = load_exudyn().itemInterface
        mass = np.zeros((self.size, self.size))
        for link, part in enumerate(self.parts):
            at = part.coordinates.start + self.kind.per_node * np.arange(len(part.nodes))
            if part.bodies is None:
                mass[at, at] = mass[at + 1, at + 1] = self.point_masses(link)
                continue
            for number, first in enumerate(at):
                marker = self._axis_point(part, number)
                load = items.LoadForceVector(markerNumber=marker, loadVector=[0.0, 0.0, 0.0])
                self._arm_loads.append((int(self.mbs.AddLoad(load)), int(first)))
        every = [node for part in self.parts for node in part.nodes]
        carrier = items.ObjectGenericODE2(
            nodeNumbers=every,
            massMatrix=mass if mass.any() else None,
            forceVector=np.zeros(self.size),
        )
        return int(self.mbs.AddObject(carrier))

    def _add_supports(self) -> list[tuple[int, int]]:
        """Hold clamped and pivoted coordinates; returns constraints and what they hold."""
        fixed = self._add_fixed_coordinate()
        held: list[tuple[LinkEnd, tuple[int, ...]]] = [
            (clamp.held, (0, 1, self.kind.clamped)) for clamp in self.topology.clamps
        ]
        for pivot in self.topology.pivots:
            if self._part(pivot.held).arms is None:
                held.append((pivot.held, (0, 1)))
            else:
                ground = self._pin_to_ground(pivot.held, [0.0, 0.0, 0.0])[0]
                first, x = self._end(pivot.held)[1], self._straight_place(pivot.held)[0]
                self._grounds.append((ground, first, float(x)))
        offsets = []
        for place, coordinates in held:
            node, first = self._end(place)
            for coordinate in coordinates:
                constraint = self._hold(fixed, node, coordinate)
                offsets.append((constraint, first + coordinate))
        return offsets

    def _add_fixed_coordinate(self) -> int:
        """Marker of a coordinate that stays zero."""
        items = load_exudyn().itemInterface
        ground = self.mbs.AddNode(items.NodePointGround())
        return int(self.mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=ground, coordinate=0)))

    def _hold(self, fixed: int, node: int, coordinate: int, **offset: Any) -> int:
        """Constraint that keeps a node's coordinate at an offset from the fixed one."""
        items = load_exudyn().itemInterface
        marker = self.mbs.AddMarker(
            items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate)
        )
        return int(
            self.mbs.AddObject(items.CoordinateConstraint(markerNumbers=[fixed, marker], **offset))
        )

    def _add_pins(self) -> list[int]:
        items = load_exudyn().itemInterface
        joints = []
        for pin in self.topology.pins:
            markers = [
                self._end_marker(place)
                for place in (self.topology.leader_of(pin.leader), pin.follower)
            ]
            joints.append(int(self.mbs.AddObject(items.RevoluteJoint2D(markerNumbers=markers))))
        return joints

    def _pin_to_ground(self, held: LinkEnd, place: list[float]) -> tuple[int, int]:
        """Pin a link end to a point of the ground; returns the ground's number and the pin's."""
        items = load_exudyn().itemInterface
        ground = self.mbs.AddObject(items.ObjectGround(referencePosition=place))
        markers = [
            self.mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=ground)),
            self._end_marker(held),
        ]
        pin = self.mbs.AddObject(items.RevoluteJoint2D(markerNumbers=markers))
        return int(ground), int(pin)

    def _end_marker(self, place: LinkEnd) -> int:
        """Marker of the point on the pins' axis at a link end."""
        part = self._part(place)
        if part.arms is not None:
            return self._axis_point(part, 0 if place.end == "start" else -1)
        items = load_exudyn().itemInterface
        node = items.MarkerNodePosition(nodeNumber=self._end(place)[0])
        return int(self.mbs.AddMarker(node))

    def _axis_point(self, part: LinkPart, number: int) -> int:
        """Marker of the point on the pins' axis that belongs to a node of an eccentric link."""
        assert part.arms is not None
        assert part.bodies is not None
        items = load_exudyn().itemInterface
        marker = items.MarkerBodyRigid(
            bodyNumber=part.bodies.numbers[number],
            localPosition=[0.0, -part.arms.length, 0.0],
        )
        return int(self.mbs.AddMarker(marker))

    def _part(self, place: LinkEnd) -> LinkPart:
        return self.parts[self.topology.index(place.link)]

    def _end(self, place: LinkEnd) -> tuple[int, int]:
        """Node number at a link end and the first of its coordinates."""
        part = self._part(place)
        if place.end == "start":
            return part.nodes[0], part.coordinates.start
        return part.nodes[-1], part.coordinates.stop - self.kind.per_node

    def _straight_place(self, place: LinkEnd) -> FloatArray:
        """Where a link end is in the reference configuration, shape (2,)."""
        positions = self._part(place).positions
        return np.array([positions[0 if place.end == "start" else -1], 0.0])
