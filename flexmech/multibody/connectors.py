"""Loads, springs and sprung joints of a mechanism as items of an Exudyn system.

Each is one load or one connector: a spring between two points, a spring on the angle between two
nodes, or one in both directions between two link ends. Their stiffness is taken off when Exudyn
linearizes the links: springs join links and belong to the linkage. In a static model they are moved
through the crank angles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.arrays import ROUND_OFF, FloatArray
from flexmech.linkages import (
    AttachmentPoint,
    JointSpring,
    LinkEnd,
    Load,
    RigidMotion,
    Spring,
    continuous_angles,
)
from flexmech.linkages.applied_forces import SpringLine, joint_gap
from flexmech.linkages.motion import direction, normal
from flexmech.linkages.topology import leading_end
from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.items import ItemNumber
from flexmech.multibody.library import load_exudyn
from flexmech.multibody.link_parts import BeamPart


def add_angle_marker(assembly: LinkAssembly, end: LinkEnd, name: str) -> ItemNumber:
    """Add a marker of the angle at a link end, as a coordinate.

    Parameters
    ----------
    assembly : LinkAssembly
    end : LinkEnd
        At a cable, one at which a body has a node of its own.
    name : str

    Returns
    -------
    ItemNumber
    """
    turning, node = assembly.turning_coordinate(end), assembly.end_node(end)
    if turning is None:
        part = assembly.part_of(end)
        assert isinstance(part, BeamPart)
        number = 0 if end.end == "start" else len(part.nodes) - 1
        link = assembly.topology.index(end.link)
        node = next(
            body.own_node
            for body in assembly.attached
            if body.link == link and body.node == number and body.own_node is not None
        )
        turning = 2
    return assembly.items.add("MarkerNodeCoordinate", name, nodeNumber=node, coordinate=turning)


def angle_of_end(assembly: LinkAssembly, end: LinkEnd) -> int:
    """Number of the angle at a link end among the coordinates of all links."""
    turning = assembly.turning_coordinate(end)
    first = assembly.first_coordinate(end)
    return first + (assembly.kind.clamped if turning is None else turning)


@dataclass(frozen=True)
class LoadItem:
    """A load: its force and its torque, each if it has one."""

    load: Load
    force: ItemNumber | None
    torque: ItemNumber | None


@dataclass(frozen=True)
class SpringItem:
    """A spring in the system.

    Parameters
    ----------
    spring : Spring
    number : ItemNumber
    markers : tuple of ItemNumber
        Of its first and its second end.
    grounds : tuple
        Ends on the ground and the ground of each.
    """

    spring: Spring
    number: ItemNumber
    markers: tuple[ItemNumber, ...]
    grounds: tuple[tuple[AttachmentPoint, ItemNumber], ...]


@dataclass(frozen=True)
class JointSpringItem:
    """Springs in a joint: torsional, and in a sprung joint radial.

    Parameters
    ----------
    spring : JointSpring
    follower : LinkEnd
    leader : LinkEnd or None
        None at a pivot.
    turning, radial : ItemNumber or None
    drag : tuple of ItemNumber
        Torques on the following and the leading end, for what a damper carries at standstill.
    ground : ItemNumber or None
        Of a sprung pivot.
    """

    spring: JointSpring
    follower: LinkEnd
    leader: LinkEnd | None
    turning: ItemNumber | None
    radial: ItemNumber | None
    drag: tuple[ItemNumber, ...]
    ground: ItemNumber | None


class ConnectorItems:
    """Loads and springs in a system that is not assembled yet.

    Parameters
    ----------
    assembly : LinkAssembly
    fixed : ItemNumber
        Marker of a coordinate that stays zero.
    runs : bool
        Whether the system moves: loads over time then are among them.

    Attributes
    ----------
    loads : list of LoadItem
    springs : list of SpringItem
    joints : list of JointSpringItem
    """

    def __init__(self, assembly: LinkAssembly, fixed: ItemNumber, runs: bool) -> None:
        self.assembly = assembly
        self._runs = runs
        mechanism = assembly.mechanism
        self.loads = [
            self._add_load(load) for load in mechanism.loads if runs or load.over != "time"
        ]
        self.springs = [self._add_spring(spring) for spring in mechanism.springs]
        self.joints = [self._add_joint_spring(own, fixed) for own in mechanism.joint_springs]

    @property
    def any(self) -> bool:
        """Whether there is a load or a spring."""
        return bool(self.loads or self.springs or self.joints)

    def activate(self, active: bool) -> None:
        """Activate or deactivate the springs."""
        numbers = [item.number for item in self.springs]
        for item in self.joints:
            numbers += [number for number in (item.turning, item.radial) if number is not None]
        for number in numbers:
            self.assembly.mbs.SetObjectParameter(number, "activeConnector", active)

    def _add_load(self, load: Load) -> LoadItem:
        items, name = self.assembly.items, f"load_{load.name}"
        items.begin(f"load {load.name}")
        marker = self._add_point(load.point, f"{name}_point")
        force = torque = None
        if np.any(load.force):
            force = items.add(
                "LoadForceVector",
                f"{name}_force",
                markerNumber=marker,
                bodyFixed=load.axes == "link",
                loadVector=[0.0, 0.0, 0.0],
            )
        if np.any(load.torque):
            torque = items.add(
                "LoadTorqueVector",
                f"{name}_torque",
                markerNumber=marker,
                loadVector=[0.0, 0.0, 0.0],
            )
        return LoadItem(load, force, torque)

    def _add_point(self, point: AttachmentPoint, name: str) -> ItemNumber:
        """Marker of a point on a link's axis, which turns with the link there."""
        part = self.assembly.parts[self.assembly.topology.index(point.link)]
        return self.assembly.add_axis_marker(part, point.x, name)

    def _add_spring(self, spring: Spring) -> SpringItem:
        items, name = self.assembly.items, f"spring_{spring.name}"
        items.begin(f"spring {spring.name}")
        markers, grounds = [], []
        for end, point in (("first", spring.first), ("second", spring.second)):
            if point.is_ground:
                ground, marker = self.assembly.add_ground(f"{name}_{end}", (point.x, point.y))
                grounds.append((point, ground))
            else:
                marker = self._add_point(point, f"{name}_{end}")
            markers.append(marker)
        number = items.add(
            "SpringDamper",
            name,
            markerNumbers=markers,
            stiffness=spring.stiffness,
            damping=spring.damping,
            referenceLength=spring.free_length,
        )
        return SpringItem(spring, number, tuple(markers), tuple(grounds))

    def _add_joint_spring(self, own: JointSpring, fixed: ItemNumber) -> JointSpringItem:
        assembly, items, name = self.assembly, self.assembly.items, f"spring_in_{own.joint}"
        follower, leader = assembly.topology.pinned_ends[own.joint]
        items.begin(f"spring in joint {own.joint}")
        turning = radial = ground = None
        drag: list[ItemNumber] = []
        if own.torsional_stiffness or own.torsional_damping:
            angles = [
                fixed if end is None else add_angle_marker(assembly, end, f"{name}_{which}_angle")
                for which, end in (("leading", leader), ("following", follower))
            ]
            turning = items.add(
                "CoordinateSpringDamper",
                f"{name}_torsional",
                markerNumbers=angles,
                stiffness=own.torsional_stiffness,
                damping=own.torsional_damping,
            )
            if own.torsional_damping and not self._runs:
                drag = [
                    items.add("LoadCoordinate", f"{name}_drag_{i}", markerNumber=marker, load=0.0)
                    for i, marker in enumerate(reversed(angles[-2 if leader else -1 :]))
                ]
        if own.joint in assembly.topology.sprung_joints:
            if leader is None:
                ground, before = assembly.add_ground(name, (0.0, 0.0))
            else:
                root = leading_end(leader, assembly.topology.rigid_ties)
                before = assembly.add_end_marker(root, f"{name}_on_{root.link}")
            # In this order Exudyn's sensor gives the force on the follower.
            markers = [assembly.add_end_marker(follower, f"{name}_on_{follower.link}"), before]
            radial = items.add(
                "CartesianSpringDamper",
                f"{name}_radial",
                markerNumbers=markers,
                stiffness=[own.radial_stiffness or 0.0] * 2 + [0.0],
                damping=[own.radial_damping] * 2 + [0.0],
            )
        return JointSpringItem(own, follower, leader, turning, radial, tuple(drag), ground)


class StaticConnectors:
    """Connectors with the forces of a chosen position.

    Dampers carry what the rigid motion puts on them. Loads over time are not among them.

    Parameters
    ----------
    connectors : ConnectorItems
        Of the model.
    """

    def __init__(self, connectors: ConnectorItems) -> None:
        self._all = connectors
        self._motion: RigidMotion | None = None
        self._angles: FloatArray = np.zeros((0, 0))
        self._part = 1.0
        self._values: list[FloatArray] = []
        self._approach: dict[str, FloatArray] = {}

    def move_to(self, motion: RigidMotion, number: int, pose: FloatArray) -> None:
        """Set forces, free lengths and places of the ground.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        number : int
            Of the position.
        pose : ndarray, shape (size,)
            Coordinates of the undeformed links in the model's axes.
        """
        assembly = self._all.assembly
        self._turn = float(motion.angle[number, assembly.base])
        angle = motion.crank_angle[number]
        self._values = [item.load.values(angle) for item in self._all.loads]
        self.scale(1.0)
        for item in self._all.springs:
            self._set_spring(item, motion, number)
        for joint in self._all.joints:
            self._set_joint(joint, motion, number, pose)

    def scale(self, part: float) -> None:
        """Apply a part of the loads."""
        mbs, base = self._all.assembly.mbs, self._turn
        for item, (x, y, torque) in zip(self._all.loads, self._values, strict=True):
            if item.load.axes == "ground":
                x, y = _turned(np.array([x, y]), -base)
            if item.force is not None:
                mbs.SetLoadParameter(item.force, "loadVector", [part * x, part * y, 0.0])
            if item.torque is not None:
                mbs.SetLoadParameter(item.torque, "loadVector", [0.0, 0.0, part * torque])

    def converge(self) -> bool:
        """Update the directions of damper forces; returns whether the forces change."""
        mbs, changed = self._all.assembly.mbs, False
        for item in self._all.springs:
            if item.spring.damping:
                along = self._along(item)
                before = mbs.GetObjectParameter(item.number, "force")
                force = item.spring.damping * float(along @ self._approach[item.spring.name])
                mbs.SetObjectParameter(item.number, "force", force)
                changed = changed or abs(force - before) > ROUND_OFF * (abs(force) + abs(before))
        return changed

    def _along(self, item: SpringItem) -> FloatArray:
        """Direction from the first to the second end in the model's axes."""
        kind = load_exudyn().OutputVariableType.Position
        first, second = (
            np.array(self._all.assembly.mbs.GetMarkerOutput(int(marker), kind))[:2]
            for marker in item.markers
        )
        return np.asarray((second - first) / np.linalg.norm(second - first))

    @property
    def scale_of_forces(self) -> float:
        """Sum of the absolute loads, in N and N m."""
        return float(sum(np.abs(value).sum() for value in self._values))

    def _set_spring(self, item: SpringItem, motion: RigidMotion, number: int) -> None:
        mbs, spring = self._all.assembly.mbs, item.spring
        for point, ground in item.grounds:
            self._put(ground, np.array([point.x, point.y]))
        if spring.damping:
            there = motion.at(slice(number, number + 1))
            line = SpringLine.of(spring, self._all.assembly.topology, there)
            mbs.SetObjectParameter(item.number, "force", spring.damping * float(line.rate[0]))
            self._approach[spring.name] = _turned(line.relative_velocity[0], -self._turn)

    def _set_joint(
        self, item: JointSpringItem, motion: RigidMotion, number: int, pose: FloatArray
    ) -> None:
        assembly, own = self._all.assembly, item.spring
        ends = [(1.0, item.follower)]
        if item.leader is not None:
            ends.append((-1.0, item.leader))
        if item.turning is not None:
            there = motion.at(slice(number, number + 1))
            angles = self._continuous(motion)[number : number + 1]
            joint_angle, rate = (x[0, 2] for x in joint_gap(assembly.topology, there, own, angles))
            model_angle = sum(sign * pose[angle_of_end(assembly, end)] for sign, end in ends)
            offset = model_angle - joint_angle + own.free_angle
            for load, sign in zip(item.drag, (-1.0, 1.0), strict=False):
                torque = float(sign * own.torsional_damping * rate)
                assembly.mbs.SetLoadParameter(load, "load", torque)
            assembly.mbs.SetObjectParameter(item.turning, "offset", float(offset))
        if item.ground is not None:
            place = assembly.topology.end_place(item.follower)
            self._put(item.ground, motion.position(*place)[number])

    def _continuous(self, motion: RigidMotion) -> FloatArray:
        if self._motion is not motion:
            linkage = self._all.assembly.mechanism.linkage
            self._motion, self._angles = motion, continuous_angles(linkage, motion)
        return self._angles

    def _put(self, ground: ItemNumber, place: FloatArray) -> None:
        """Set a ground point in the model's axes."""
        x, y = _turned(place, -self._turn)
        position = [float(x), float(y), 0.0]
        self._all.assembly.mbs.SetObjectParameter(ground, "referencePosition", position)


def _turned(vector: FloatArray, angle: float) -> FloatArray:
    turn = np.array(angle)
    return np.asarray(vector[0] * direction(turn) + vector[1] * normal(turn))
