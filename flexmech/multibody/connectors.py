"""Loads, springs and sprung joints of a mechanism as items of an Exudyn system.

Each is one load or one connector: a spring between two points, a spring on the angle between two
nodes, or one in both directions between two link ends. Their stiffness is taken off when Exudyn
linearizes the links: springs join links and belong to the linkage. In a static model they are moved
through the crank angles; in a running one they act by themselves, with user functions for loads.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

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
    turned,
)
from flexmech.linkages.applied_forces import Moved, SpringLine, forces_of_loads, joint_gap
from flexmech.linkages.topology import leading_end
from flexmech.mechanics import Connectors, LinkModel, deformations
from flexmech.mechanics.running import ConnectorWork
from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.items import ItemNumber, Made, load_exudyn
from flexmech.multibody.running.user_functions import Shaft, load_history


@dataclass(frozen=True)
class SpringItem:
    """A spring in the system.

    Parameters
    ----------
    spring : Spring
    number : ItemNumber
    markers : list of ItemNumber
        Markers of its first and its second end.
    """

    spring: Spring
    number: ItemNumber
    markers: list[ItemNumber]


@dataclass(frozen=True)
class JointSpringItem:
    """Springs in a joint: torsional, and in a sprung joint radial.

    Parameters
    ----------
    spring : JointSpring
    ends : tuple of LinkEnd and LinkEnd or None
        The follower, and the leader; None at a pivot.
    turning, radial : ItemNumber or None
    drag : tuple of ItemNumber
        Torques on the following and the leading end, for what a damper carries at standstill.
    """

    spring: JointSpring
    ends: tuple[LinkEnd, LinkEnd | None]
    turning: ItemNumber | None
    radial: ItemNumber | None
    drag: tuple[ItemNumber, ...]


class ConnectorItems:
    """Loads and springs in a system that is not assembled yet.

    Parameters
    ----------
    assembly : LinkAssembly
    start : RigidMotion
        In any one position, of shape (); of a system that runs at time zero.
    shaft : Shaft, optional
        Shaft of a system that runs: loads over time then are among them.

    Attributes
    ----------
    loads : list of tuple of Load, ItemNumber and bool
        Forces, and torques, for which the last is true.
    springs : list of SpringItem
    joints : list of JointSpringItem
    """

    def __init__(
        self, assembly: LinkAssembly, start: RigidMotion, shaft: Shaft | None = None
    ) -> None:
        self.assembly, self._topology = assembly, assembly.topology
        self._start, self._shaft = start, shaft
        # By how much the clamped link is ahead of the crank.
        self._lead = 0.0 if shaft is None else shaft.start_angle - float(start.crank_angle)
        self.loads: list[tuple[Load, ItemNumber, bool]] = []
        mechanism = assembly.mechanism
        for load in mechanism.loads:
            if shaft is not None or load.over != "time":
                self._add_load(load)
        self.springs = [self._add_spring(spring) for spring in mechanism.springs]
        self.joints = [self._add_joint_spring(spring) for spring in mechanism.joint_springs]

    def _add_load(self, load: Load) -> None:
        items, name = self.assembly.items, f"load_{load.name}"
        items.begin(f"load {load.name}")
        marker = self._add_point(load.point, f"{name}_point")
        given: dict[str, Any] = {"markerNumber": marker, "loadVector": [0.0, 0.0, 0.0]}
        rows = np.column_stack([load.force, load.torque]).tolist()
        for is_torque, values in ((False, load.force), (True, load.torque)):
            if not np.any(values):
                continue
            if self._shaft is not None:
                over = self._shaft, self._lead, load.over, list(map(float, load.at))
                given["loadVectorUserFunction"] = Made(load_history, (*over, rows, is_torque))
            if is_torque:
                number = items.add("LoadTorqueVector", f"{name}_torque", **given)
            else:
                follows = {"bodyFixed": load.axes == "link"}
                number = items.add("LoadForceVector", f"{name}_force", **given, **follows)
            self.loads.append((load, number, is_torque))

    def _add_point(self, point: AttachmentPoint, name: str) -> ItemNumber:
        """Marker of a point of the ground, or on a link's axis, which turns with the link there."""
        if point.is_ground:
            return self.assembly.add_ground(name, (point.x, point.y))
        part = self.assembly.parts[self._topology.index(point.link)]
        return self.assembly.add_axis_marker(part, point.x, name)

    def _add_spring(self, spring: Spring) -> SpringItem:
        items, name = self.assembly.items, f"spring_{spring.name}"
        items.begin(f"spring {spring.name}")
        ends = ("first", spring.first), ("second", spring.second)
        markers = [self._add_point(point, f"{name}_{end}") for end, point in ends]
        number = items.add(
            "SpringDamper",
            name,
            markerNumbers=markers,
            stiffness=spring.stiffness,
            damping=spring.damping,
            referenceLength=spring.free_length,
        )
        return SpringItem(spring, number, markers)

    def _add_joint_spring(self, spring: JointSpring) -> JointSpringItem:
        assembly, items, name = self.assembly, self.assembly.items, f"spring_in_{spring.joint}"
        follower, leader = self._topology.pinned_ends[spring.joint]
        items.begin(f"spring in joint {spring.joint}")
        turning = radial = None
        drag: list[ItemNumber] = []
        if spring.torsional_stiffness or spring.torsional_damping:
            angles = [
                assembly.add_angle_marker(end, f"{name}_{which}_angle")
                for which, end in (("leading", leader), ("following", follower))
            ]
            turning = items.add(
                "CoordinateSpringDamper",
                f"{name}_torsional",
                markerNumbers=angles,
                stiffness=spring.torsional_stiffness,
                damping=spring.torsional_damping,
                offset=self._offset_at_start(spring),
            )
            if spring.torsional_damping and self._shaft is None:
                drag = [
                    items.add("LoadCoordinate", f"{name}_drag_{i}", markerNumber=marker, load=0.0)
                    for i, marker in enumerate(reversed(angles[-2 if leader else -1 :]))
                ]
        if spring.joint in self._topology.sprung_joints:
            if leader is None:
                place = self._start.position(*self._topology.end_place(follower))
                before = assembly.add_ground(name, place.tolist())
            else:
                root = leading_end(leader, self._topology.rigid_ties)
                before = assembly.add_end_marker(root, f"{name}_on_{root.link}")
            # In this order Exudyn's sensor gives the force on the follower.
            markers = [assembly.add_end_marker(follower, f"{name}_on_{follower.link}"), before]
            radial = items.add(
                "CartesianSpringDamper",
                f"{name}_radial",
                markerNumbers=markers,
                stiffness=[spring.radial_stiffness or 0.0] * 2 + [0.0],
                damping=[spring.radial_damping] * 2 + [0.0],
            )
        ends = follower, leader
        return JointSpringItem(spring, ends, turning, radial, tuple(drag))

    def _offset_at_start(self, spring: JointSpring) -> float:
        """Free angle of a spring in a joint, beside whole turns in the angles of a start."""
        angles = continuous_angles(self.assembly.mechanism.linkage, self._start)
        jumped = self._topology.joint_angle(spring.joint, self._start.angle - angles)
        return float(jumped) + spring.free_angle


class StaticConnectors(ConnectorItems):
    """Connectors with the forces of a chosen position.

    Dampers carry what the rigid motion puts on them. Loads over time are not among them.

    Parameters
    ----------
    assembly, start
        As of :class:`ConnectorItems`.
    """

    def __init__(self, assembly: LinkAssembly, start: RigidMotion) -> None:
        super().__init__(assembly, start)
        self._motion: RigidMotion | None = None
        self._angles: FloatArray = np.zeros((0, 0))
        self._values: dict[str, FloatArray] = {}
        self._approach: dict[str, FloatArray] = {}

    def activate(self, active: bool) -> None:
        """Activate or deactivate the springs."""
        numbers = [item.number for item in self.springs]
        for item in self.joints:
            numbers += [number for number in (item.turning, item.radial) if number is not None]
        for number in numbers:
            self.assembly.mbs.SetObjectParameter(number, "activeConnector", active)

    def move_to(self, motion: RigidMotion, number: int, pose: FloatArray) -> None:
        """Set forces, free lengths and places of the ground.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        number : int
            Number of the position.
        pose : ndarray, shape (size,)
            Coordinates of the undeformed links in the model's axes.
        """
        self._turn = -motion.angle[number, self.assembly.base]
        angle = motion.crank_angle[number]
        self._values = {load.name: load.values(angle) for load, _, _ in self.loads}
        self.scale(1.0)
        if self._motion is not motion:
            linkage = self.assembly.mechanism.linkage
            self._motion, self._angles = motion, continuous_angles(linkage, motion)
        one = slice(number, number + 1)
        for spring in self.springs:
            self._set_spring(spring, motion.at(one))
        for joint in self.joints:
            self._set_joint(joint, motion.at(one), self._angles[one], pose)

    def scale(self, fraction: float) -> None:
        """Apply a part of the loads."""
        for load, number, is_torque in self.loads:
            x, y, torque = self._values[load.name]
            if load.axes == "ground":
                x, y = turned(np.array([x, y]), self._turn)
            value = (
                [0.0, 0.0, fraction * torque] if is_torque else [fraction * x, fraction * y, 0.0]
            )
            self.assembly.mbs.SetLoadParameter(number, "loadVector", value)

    def converge(self) -> bool:
        """Update the directions of damper forces; returns whether the forces change."""
        mbs, changed = self.assembly.mbs, False
        for item in self.springs:
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
            np.array(self.assembly.mbs.GetMarkerOutput(int(marker), kind))[:2]
            for marker in item.markers
        )
        return np.asarray((second - first) / np.linalg.norm(second - first))

    @property
    def scale_of_forces(self) -> float:
        """Sum of the absolute loads, in N and N m."""
        return float(sum(np.abs(value).sum() for value in self._values.values()))

    def _set_spring(self, item: SpringItem, motion: RigidMotion) -> None:
        spring = item.spring
        if spring.damping:
            line = SpringLine.of(spring, self._topology, motion)
            force = spring.damping * float(line.rate[0])
            self.assembly.mbs.SetObjectParameter(item.number, "force", force)
            self._approach[spring.name] = turned(line.relative_velocity[0], self._turn)

    def _set_joint(
        self, item: JointSpringItem, motion: RigidMotion, angles: FloatArray, pose: FloatArray
    ) -> None:
        assembly, spring, (follower, leader) = self.assembly, item.spring, item.ends
        if item.turning is not None:
            gap, rates = joint_gap(self._topology, motion, spring, angles)
            model_angle = pose[assembly.angle_coordinate(follower)]
            if leader is not None:
                model_angle -= pose[assembly.angle_coordinate(leader)]
            offset = float(model_angle - gap[0, 2] + spring.free_angle)
            assembly.mbs.SetObjectParameter(item.turning, "offset", offset)
            for load, sign in zip(item.drag, (-1.0, 1.0), strict=False):
                torque = float(sign * spring.torsional_damping * rates[0, 2])
                assembly.mbs.SetLoadParameter(load, "load", torque)


class RunningConnectors(ConnectorItems):
    """Connectors of a running system, and the energy and power that they give.

    Parameters
    ----------
    assembly, start, shaft
        As of :class:`ConnectorItems`.
    links : sequence of LinkModel
        In the system's coordinates.
    """

    def __init__(
        self,
        assembly: LinkAssembly,
        start: RigidMotion,
        shaft: Shaft,
        links: Sequence[LinkModel],
    ) -> None:
        super().__init__(assembly, start, shaft)
        self._all = Connectors(assembly.mechanism, links)
        self._angle = shaft.angle
        # A radial spring's marker is on the end that carries the place of the leading one.
        self._leading_places = {
            self._topology.end_place(leader): self._topology.end_place(
                leading_end(leader, self._topology.rigid_ties)
            )
            for item in self.joints
            if item.radial is not None and (leader := item.ends[1]) is not None
        }

    def work(
        self,
        time: FloatArray,
        motion: RigidMotion,
        displacement: Sequence[FloatArray],
        rate: Sequence[FloatArray],
        carried: RigidMotion,
    ) -> ConnectorWork:
        """Energy and power at instants of a run.

        Parameters
        ----------
        time : ndarray, shape (m,)
        motion : RigidMotion
            At these times.
        displacement, rate : sequence of ndarray, shape (m, n_link)
            Displacement of the links in their frames, in m and rad, and its rate.
        carried : RigidMotion
            The motion in ground axes, where ``motion`` is in those of a frame on springs.

        Returns
        -------
        ConnectorWork
        """
        power, pushed = np.zeros(len(time)), self._moved(carried, displacement, rate)
        crank_angle = np.array([self._angle(t) for t in time]) - self._lead
        prescribed = replace(carried, crank_angle=crank_angle)
        mechanism = self.assembly.mechanism
        for one in forces_of_loads(self._topology, prescribed, mechanism.loads, time, pushed):
            drift = pushed(one.link, float(one.x))[1]
            power += one.power(carried) + np.sum(one.force * drift[:, :2], axis=1)
            power += one.torque * drift[:, 2]
        moved = self._moved(motion, displacement, rate)
        return ConnectorWork.of(deformations(mechanism, motion, moved), power)

    def joint_forces(
        self,
        motion: RigidMotion,
        displacement: Sequence[FloatArray],
        rate: Sequence[FloatArray],
    ) -> dict[str, FloatArray]:
        """Force of each sprung joint on its grounded or following link, (m, 2), by name.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (m,).
        displacement, rate : sequence of ndarray, shape (m, n_link)
            Displacement of the links in their frames, in m and rad, and its rate.
        """
        forces, moved = {}, self._moved(motion, displacement, rate)
        for item in self.joints:
            if item.radial is not None:
                spring = item.spring
                gap, drift = joint_gap(self._topology, motion, spring, motion.angle, moved)
                force = (spring.radial_stiffness or 0.0) * gap + spring.radial_damping * drift
                forces[spring.joint] = -force[:, :2]
        return forces

    def _moved(
        self,
        motion: RigidMotion,
        displacement: Sequence[FloatArray],
        rate: Sequence[FloatArray],
    ) -> Moved:
        by_links = self._all.moved(motion, displacement, rate)

        def moved(link: int, x: float) -> tuple[FloatArray, FloatArray]:
            values = by_links(link, x)
            place = by_links(*self._leading_places.get((link, x), (link, x)))
            for value, leading in zip(values, place, strict=True):
                value[:, :2] = leading[:, :2]
            return values

        return moved
