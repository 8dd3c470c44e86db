"""Links of a mechanism in an Exudyn system, and the markers that joints need.

Static and running models differ in their loads, their supports and their drive. Both have one
assembly, add these to it in their own order, and assemble the system.

A frame on springs is a rigid body under the linkage.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linkages import LinkEnd, RigidMotion
from flexmech.mechanics.running import FrameMotion, StepBlock
from flexmech.mechanism import Mechanism, SprungFrame
from flexmech.multibody.beams import BEAM_KINDS, BeamKind
from flexmech.multibody.items import ItemNumber, Made, SystemItems
from flexmech.multibody.links import (
    Arms,
    BeamPart,
    LinkNodes,
    LinkPart,
    PolarSlopes,
    add_attached_bodies,
    add_links,
    turn_vectors,
)
from flexmech.multibody.running.user_functions import JoinedEnd, turned_frame


@dataclass(frozen=True)
class FrameBody:
    """Rigid body of a frame, with its springs and its weight.

    Parameters
    ----------
    frame : SprungFrame
    items : SystemItems
    first : int
        Its first coordinate in the system.
    node, body : ItemNumber
    """

    frame: SprungFrame
    items: SystemItems
    first: int
    node: ItemNumber
    body: ItemNumber

    @classmethod
    def of(cls, mechanism: Mechanism, items: SystemItems, first: int) -> FrameBody | None:
        """Add the frame of a mechanism to a system; None where it stands.

        Parameters
        ----------
        mechanism : Mechanism
        items : SystemItems
        first : int
            Number of coordinates that the system has.
        """
        frame = mechanism.frame
        if frame is None:
            return None
        items.begin("frame: a rigid body on springs")
        node = items.add("NodeRigidBody2D", "frame_node", referenceCoordinates=[*frame.centre, 0.0])
        body = items.add(
            "ObjectRigidBody2D",
            "frame",
            nodeNumber=node,
            mass=frame.mass,
            inertia=frame.inertia,
        )
        made = cls(frame, items, first, node, body)
        made._add_springs()
        if any(mechanism.gravity):
            marker = items.add("MarkerNodeRigid", "frame_centre", nodeNumber=node)
            weight = [*(frame.mass * value for value in mechanism.gravity), 0.0]
            items.add("LoadForceVector", "frame_weight", markerNumber=marker, loadVector=weight)
        return made

    def _add_springs(self) -> None:
        for number, spring in enumerate(self.frame.springs):
            name = f"frame_spring_{number}"
            floor = self.items.add(
                "ObjectGround", f"{name}_floor", referencePosition=[*spring.point, 0.0]
            )
            markers = [
                self.items.add("MarkerBodyPosition", f"{name}_on_floor", bodyNumber=floor),
                self.add_marker(spring.point, f"{name}_on_frame"),
            ]
            self.items.add(
                "CartesianSpringDamper",
                name,
                markerNumbers=markers,
                stiffness=[*spring.stiffness, 0.0],
                damping=[*spring.damping, 0.0],
            )

    def add_marker(self, place: tuple[float, float], name: str) -> ItemNumber:
        """Add a marker at a place, in ground axes in m, of the frame as it is drawn."""
        x, y = self._lever(place)
        return self.items.add(
            "MarkerBodyRigid", name, bodyNumber=self.body, localPosition=[x, y, 0.0]
        )

    def add_angle_marker(self, name: str) -> ItemNumber:
        """Add a marker of its angle."""
        return self.items.add("MarkerNodeCoordinate", name, nodeNumber=self.node, coordinate=2)

    def joined(self, place: tuple[float, float]) -> JoinedEnd:
        """A point of it, by its place in ground axes in m as it is drawn."""
        return JoinedEnd(self.first, self.frame.centre, self._lever(place), has_slope=False)

    def motion(self, position: FloatArray, velocity: FloatArray) -> FrameMotion:
        """Its motion from coordinates (m, total_size) of the system and their rates."""
        columns = slice(self.first, self.first + 3)
        return FrameMotion(position[:, columns], velocity[:, columns])

    def added(
        self, block: StepBlock, moved: FrameMotion, gravity: tuple[float, float]
    ) -> StepBlock:
        """Records of steps with the motion of the frame and its energies.

        Parameters
        ----------
        block : StepBlock
        moved : FrameMotion
        gravity : tuple of float
            In m/s^2.
        """
        pair = moved.displacement, moved.rate
        ends = [self.frame.point_motion(spring.point, *pair) for spring in self.frame.springs]
        places, rates = (np.array(values) for values in zip(*ends, strict=True))
        stiffness, damping = (
            np.array([getattr(spring, name) for spring in self.frame.springs])[:, None]
            for name in ("stiffness", "damping")
        )
        kinetic = moved.rate**2 @ np.diag(self.frame.inertia_matrix) / 2
        centre = np.asarray(self.frame.centre) + moved.displacement[:, :2]
        strain = (stiffness * places**2).sum(axis=(0, 2)) / 2
        dissipated = (damping * rates**2).sum(axis=(0, 2))
        return replace(
            block,
            kinetic_energy=block.kinetic_energy + kinetic,
            strain_energy=block.strain_energy + strain,
            gravity_energy=block.gravity_energy - self.frame.mass * centre @ np.asarray(gravity),
            dissipation_power=block.dissipation_power + dissipated,
            frame=moved,
        )

    def _lever(self, place: tuple[float, float]) -> tuple[float, float]:
        """From the centre to a place in m."""
        x, y = self.frame.centre
        return float(place[0]) - x, float(place[1]) - y


class LinkAssembly:
    """Links in an Exudyn system, in the reference configuration along the global x axis.

    Coordinates are those of the pins' axis, less the reference ones, unless Exudyn's own are
    spoken of: these are the nodes', and :attr:`nodes` leads from the one to the other.

    Parameters
    ----------
    mechanism : Mechanism
    elements : int
        Elements a link.
    kind : str
        Key of :data:`flexmech.multibody.beams.BEAM_KINDS`.
    bodies_have_mass : bool
        Whether attached bodies have; their matrices are added to the links' at standstill.

    Attributes
    ----------
    items : SystemItems
    mbs : exudyn.MainSystem
        Its system.
    parts : list of LinkPart
        In the topology's order.
    attached : list of AttachedPart
        Bodies on elastic links.
    size : int
        Number of coordinates of all links.
    system_size : int
        Number of Exudyn's coordinates of links and attached bodies.
    nodes : LinkNodes
    ground : ItemNumber
        A body that stands still, with a marker for all that is joined to it.
    fixed : ItemNumber
        Marker of a coordinate that stays zero.
    base : int
        The clamped link.
    frame : FrameBody or None
        The frame on springs of a running system, which carries what stands on the ground.
    """

    def __init__(
        self, mechanism: Mechanism, elements: int, kind: str, bodies_have_mass: bool
    ) -> None:
        self.mechanism = mechanism
        self.topology = mechanism.linkage.topology
        self.kind: BeamKind = BEAM_KINDS[kind]
        self.items = SystemItems()
        self.frame: FrameBody | None = None
        self.mbs = self.items.mbs
        self.base = self.topology.index(self.topology.clamps[0].link_end.link)
        self.parts = add_links(self.items, mechanism, self.kind, elements)
        self.size = self.parts[-1].coordinates.stop
        self._angles = np.flatnonzero(np.concatenate([part.rotation for part in self.parts]))
        self.attached = add_attached_bodies(self.items, mechanism, self.parts, bodies_have_mass)
        body_coordinates = [
            coordinate
            for body in (() if self.kind.has_angles else self.attached)
            for coordinate in (body.place, body.place + 1, body.angle)
        ]
        self.system_size = self.size + len(body_coordinates)
        maps = [(part.node_map, part.coordinates.start) for _, part in self.beams]
        mapped = (Arms if self.kind.has_angles else PolarSlopes).joined(maps)
        self.nodes = LinkNodes(mapped, self.size, body_coordinates)
        self.items.begin("the ground")
        self.ground = self.items.add("ObjectGround", "ground")
        ground_node = self.items.add("NodePointGround", "ground_node")
        self.fixed = self.items.mark_coordinate("ground_coordinate", ground_node, 0)

    @property
    def beams(self) -> Iterator[tuple[int, BeamPart]]:
        """Number and part of each elastic link."""
        for number, part in enumerate(self.parts):
            if isinstance(part, BeamPart):
                yield number, part

    @property
    def nodal_force_scale(self) -> float:
        """Scale of nodal forces: that between neighbouring nodes displaced by a position."""
        extent = sum(link.length for link in self.topology.links)
        scales = []
        for _, part in self.beams:
            section, length = part.section, float(np.diff(part.positions).min())
            bending = 12 * section.bending_stiffness / length**2
            stiffness = max(section.axial_stiffness, section.shear_stiffness, bending) / length
            scales.append(stiffness * extent)
        return max(scales, default=0.0)

    def part_of(self, place: LinkEnd) -> LinkPart:
        """Part of the link of an end."""
        return self.parts[self.topology.index(place.link)]

    def end_node(self, place: LinkEnd) -> ItemNumber:
        """Node at a link end; of a rigid link the one at its start."""
        return self.part_of(place).nodes[0 if place.end == "start" else -1]

    def turning_coordinate(self, place: LinkEnd) -> int | None:
        """Coordinate of that node that is its angle; None where it has a slope vector."""
        kind = self.part_of(place).kind
        return kind.clamped if kind.has_angles else None

    def angle_coordinate(self, place: LinkEnd) -> int:
        """Number of the angle at a link end among the coordinates of all links."""
        return self.first_coordinate(place) + self.part_of(place).kind.clamped

    def first_coordinate(self, place: LinkEnd) -> int:
        """First coordinate of that node among those of all links."""
        return int(self.part_of(place).firsts[0 if place.end == "start" else -1])

    def poses(self, origin: FloatArray, angle: FloatArray) -> FloatArray:
        """Coordinates of undeformed links, less the reference ones, (m, size).

        Parameters
        ----------
        origin : ndarray, shape (m, n_links, 2)
            Origin of the starts of the links in m.
        angle : ndarray, shape (m, n_links)
            In rad.
        """
        poses = [part.pose(origin[:, n], angle[:, n]) for n, part in enumerate(self.parts)]
        return np.concatenate(poses, axis=1)

    def turned(self, values: FloatArray, angle: FloatArray) -> FloatArray:
        """Coordinates (m, size) with the vectors of each link rotated by its angle (m, n_links)."""
        turned = values.copy()
        for number, part in enumerate(self.parts):
            turn_vectors(turned[:, part.coordinates], part.vectors, angle[:, number])
        return turned

    def deformation(self, state: FloatArray, pose: FloatArray) -> FloatArray:
        """Difference of coordinates (m, size), with angles within half a turn."""
        change = state - pose
        angles = self._angles
        change[:, angles] -= 2 * np.pi * np.round(change[:, angles] / (2 * np.pi))
        return np.asarray(change)

    def by_links(self, values: FloatArray) -> list[FloatArray]:
        """Coordinates (..., size) of all links as those of each, (..., n_link)."""
        return [values[..., part.coordinates] for part in self.parts]

    def in_ground_axes(
        self, motion: RigidMotion, displacement: Sequence[FloatArray], rate: Sequence[FloatArray]
    ) -> tuple[FloatArray, FloatArray]:
        """Coordinates and velocities of links that are displaced in their moving frames.

        They are Exudyn's where the nodes are on the pins' axis, and lead to them by
        :attr:`nodes` where not.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (m,).
        displacement, rate : sequence of ndarray, shape (m, n_link)

        Returns
        -------
        position, velocity : ndarray, shape (m, size)
        """
        local = np.concatenate(displacement, axis=1)
        moving = np.concatenate(rate, axis=1) + self._carried(motion, local)
        position = self.poses(motion.origin, motion.angle) + self.turned(local, motion.angle)
        return position, self._drift(motion) + self.turned(moving, motion.angle)

    def in_link_frames(
        self, motion: RigidMotion, position: FloatArray, velocity: FloatArray
    ) -> tuple[list[FloatArray], list[FloatArray]]:
        """Displacement and rate of links in their frames; undoes :meth:`in_ground_axes`.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (m,).
        position, velocity : ndarray, shape (m, size)

        Returns
        -------
        displacement, rate : list of ndarray, shape (m, n_link)
        """
        change = self.deformation(position, self.poses(motion.origin, motion.angle))
        local = self.turned(change, -motion.angle)
        moving = self.turned(velocity - self._drift(motion), -motion.angle)
        return self.by_links(local), self.by_links(moving - self._carried(motion, local))

    def _drift(self, motion: RigidMotion) -> FloatArray:
        """Velocities by the origins and the spins of the links' frames, (m, size)."""
        place, spin = motion.origin_velocity, motion.angular_velocity
        drifts = [part.rigid(place[:, n], spin[:, n]) for n, part in enumerate(self.parts)]
        return np.concatenate(drifts, axis=1)

    def _carried(self, motion: RigidMotion, local: FloatArray) -> FloatArray:
        """Velocities of vectors, displaced by ``local``, in frames that turn, (m, size)."""
        moved = zip(self.parts, motion.angular_velocity.T, self.by_links(local), strict=True)
        carried = [
            spin[:, None] * part.quarter_turned(part.straight + values)
            for part, spin, values in moved
        ]
        return np.concatenate(carried, axis=1)

    def add_constraint(
        self, name: str, before: ItemNumber, node: ItemNumber, coordinate: int, **offset: Any
    ) -> ItemNumber:
        """Keep a node's coordinate at an offset from another one.

        Further arguments go to Exudyn's constraint and prescribe the offset; it is zero without.

        Parameters
        ----------
        name : str
        before : ItemNumber
            Marker of the other coordinate, such as :attr:`fixed`.
        node : ItemNumber
        coordinate : int
            Which of the node's coordinates.

        Returns
        -------
        ItemNumber
        """
        markers = [before, self.items.mark_coordinate(f"{name}_coordinate", node, coordinate)]
        return self.items.add("CoordinateConstraint", name, markerNumbers=markers, **offset)

    def add_ground(self, name: str, place: Sequence[float]) -> ItemNumber:
        """Add a marker of a place of the ground, or of a frame on springs.

        Parameters
        ----------
        name : str
            Name of what stands on it.
        place : sequence of float
            X and y in ground axes in m; of a frame as it is drawn.

        Returns
        -------
        ItemNumber
        """
        x, y = map(float, place)
        if self.frame is not None:
            return self.frame.add_marker((x, y), f"{name}_on_frame")
        return self.items.mark_place(f"{name}_on_ground", self.ground, x, y)

    def add_end_marker(self, place: LinkEnd, name: str) -> ItemNumber:
        """Add a marker of the point on the pins' axis at a link end."""
        part = self.part_of(place)
        beyond_nodes = place.end == "end" and part.length != part.positions[-1]
        if beyond_nodes or part.axis_below:
            return self.add_frame_marker(place, name)
        return self.items.add("MarkerNodePosition", name, nodeNumber=self.end_node(place))

    def add_frame_marker(self, place: LinkEnd, name: str, angle: float = 0.0) -> ItemNumber:
        """Add a marker of that point, which turns with the link; see :meth:`add_axis_marker`.

        Parameters
        ----------
        place : LinkEnd
        name : str
        angle : float
            By which the marker is turned against the axis, in rad.
        """
        part = self.part_of(place)
        return self.add_axis_marker(part, 0.0 if place.end == "start" else part.length, name, angle)

    def add_angle_marker(self, end: LinkEnd | None, name: str) -> ItemNumber:
        """Add a marker of the angle at a link end; at a cable's a body has a node of its own.

        Without an end it is that of the ground, or of a frame on springs.
        """
        if end is None:
            return self.fixed if self.frame is None else self.frame.add_angle_marker(name)
        turning, node = self.turning_coordinate(end), self.end_node(end)
        if turning is None:
            place = self.first_coordinate(end)
            [node] = [body.body.node for body in self.attached if body.place == place][:1]
            turning = 2
        return self.items.mark_coordinate(name, node, turning)

    def add_axis_marker(
        self, part: LinkPart, x: float, name: str, angle: float = 0.0
    ) -> ItemNumber:
        """Add a marker of a point on the pins' axis, which turns with the link there.

        Parameters
        ----------
        part : LinkPart
        x : float
            Distance of the point from the link's start in m; of exact beams that of a node.
        name : str
        angle : float
            By which the marker is turned against the axis, in rad.

        Returns
        -------
        ItemNumber
        """
        if part.bodies and isinstance(part, BeamPart) and not (part.axis_below or angle):
            number = int(np.argmin(np.abs(part.positions - x)))
            return self.items.add("MarkerNodeRigid", name, nodeNumber=part.nodes[number])
        body, along, across = self.body_place(part, x)
        return self.add_body_frame(body, name, along, across, angle)

    def body_place(self, part: LinkPart, x: float) -> tuple[ItemNumber, float, float]:
        """Body at a point on the pins' axis of a link, and the point's place on it in m.

        Parameters
        ----------
        part : LinkPart
        x : float
            As of :meth:`add_axis_marker`.
        """
        if not isinstance(part, BeamPart):
            return part.bodies[0], x, 0.0
        if part.bodies:
            number = int(np.argmin(np.abs(part.positions - x)))
            return part.bodies[number], 0.0, -part.axis_below
        element = int(np.searchsorted(part.positions, x, side="right")) - 1
        element = min(max(element, 0), len(part.elements) - 1)
        return part.elements[element], float(x - part.positions[element]), 0.0

    def add_body_frame(
        self, body: ItemNumber, name: str, x: float, y: float = 0.0, angle: float = 0.0
    ) -> ItemNumber:
        """Add a marker at a place of a body.

        Parameters
        ----------
        body : ItemNumber
        name : str
        x, y : float
            In m.
        angle : float
            By which the marker is turned against the body, in rad.

        Returns
        -------
        ItemNumber
        """
        if not angle:
            return self.items.mark_place(name, body, x, y)
        frame = Made(turned_frame, (x, y, angle))
        return self.items.add("MarkerBodyRigid", name, bodyNumber=body, localHT=frame)
