"""Loads, springs and sprung joints of a mechanism as items of an Exudyn system.

Each is one load or one connector: a spring between two points, a spring on the angle between two
nodes, or one in both directions between two link ends. Their stiffness is taken off when Exudyn
linearizes the links: springs join links and belong to the linkage.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.linkages import AttachmentPoint, JointSpring, LinkEnd, Load, Spring
from flexmech.linkages.topology import leading_end
from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.items import ItemNumber
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
