"""Forces on the links of a model at standstill, which keep their direction.

A rigid link may turn under them. What distributed forces do to it then is told by their sum,
their moment and their virial about the link's start, the sum of force times place: the sum acts
at the start, and a couple of forces at start and end has the moment and the virial.

Loads and springs of a model at standstill, moved through the crank angles.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linkages import AttachmentPoint, RigidMotion, continuous_angles
from flexmech.linkages.motion import direction, normal
from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.connectors import Connectors, JointSpringItem, SpringItem, angle_of_end
from flexmech.multibody.items import ItemNumber
from flexmech.multibody.library import load_exudyn
from flexmech.multibody.link_parts import BeamPart, RigidPart


class StaticLoads:
    """Loads on every coordinate of the links, set anew for each position.

    Parameters
    ----------
    assembly : LinkAssembly
        Not assembled yet; the point masses of its cables are added along.
    """

    def __init__(self, assembly: LinkAssembly) -> None:
        self._assembly = assembly
        self._at_points: list[tuple[ItemNumber, int]] = []
        self._couples: dict[int, tuple[ItemNumber, ItemNumber]] = {}
        self._nodal = self._add_nodal_forces()
        for link, part in enumerate(assembly.parts):
            if isinstance(part, RigidPart):
                self._couples[link] = self._add_couple(f"load_{link}", part.body, part.length)
        for count, attached in enumerate(assembly.attached):
            name, length = f"attached_load_{count}", assembly.parts[attached.link].length
            couple = self._add_couple(name, attached.number, length)
            self._couples[len(assembly.parts) + count] = couple

    def set(self, forces: FloatArray, couples: FloatArray) -> None:
        """Give the forces.

        Parameters
        ----------
        forces : ndarray, shape (size,)
            Generalized forces on the coordinates of all links, in the crank's frame. The moment
            on a rigid link is not read.
        couples : ndarray, shape (n_links + n_attached, 2)
            Force at the end of each rigid link, with its opposite at the start, in the crank's
            frame; and those of each attached body, as far apart as the ends of its link.
        """
        mbs, at_nodes = self._assembly.mbs, forces.copy()
        for load, first in self._at_points:
            _set_load(mbs, load, at_nodes[first : first + 2])
            at_nodes[first : first + 2] = 0.0
        for number, (at_start, at_end) in self._couples.items():
            couple, carried = couples[number], np.zeros(2)
            if number < len(self._assembly.parts):
                own = self._assembly.parts[number].coordinates
                carried = forces[own][:2]
                at_nodes[own] = 0.0
            _set_load(mbs, at_start, carried - couple)
            _set_load(mbs, at_end, couple)
        if self._nodal is not None:
            mbs.SetObjectParameter(self._nodal, "forceVector", at_nodes[self._elastic])

    def _add_nodal_forces(self) -> ItemNumber | None:
        """One object that carries forces on every coordinate and the point masses."""
        assembly = self._assembly
        elastic = np.zeros(assembly.size, dtype=bool)
        mass = np.zeros((assembly.size, assembly.size))
        for link, part in assembly.beams:
            elastic[part.coordinates] = True
            at = part.coordinates.start + assembly.kind.per_node * np.arange(len(part.nodes))
            if part.bodies is None:
                mass[at, at] = mass[at + 1, at + 1] = assembly.point_masses(part)
            if part.arms is not None:
                self._add_points(link, part, at.tolist())
        self._elastic = np.flatnonzero(elastic)
        every = [node for _, part in assembly.beams for node in part.nodes]
        if not every:
            return None
        return assembly.items.add(
            "ObjectGenericODE2",
            "loads",
            nodeNumbers=every,
            massMatrix=mass[np.ix_(elastic, elastic)] if mass.any() else None,
            forceVector=np.zeros(len(self._elastic)),
        )

    def _add_points(self, link: int, part: BeamPart, first: list[int]) -> None:
        """Forces on points of the pins' axis, off the nodes of an eccentric link."""
        for number, coordinate in enumerate(first):
            name = f"load_{link}_{number}"
            marker = self._assembly.add_axis_point(part, number, f"{name}_point")
            self._at_points.append((self._add_load(name, marker), coordinate))

    def _add_couple(
        self, name: str, body: ItemNumber, length: float
    ) -> tuple[ItemNumber, ItemNumber]:
        """Forces at the node of a body and at a length from it along its link."""
        start, end = (
            self._add_load(
                f"{name}_{i}", self._assembly.add_body_frame(body, f"{name}_point_{i}", x)
            )
            for i, x in enumerate((0.0, length))
        )
        return start, end

    def _add_load(self, name: str, marker: ItemNumber) -> ItemNumber:
        return self._assembly.items.add(
            "LoadForceVector", name, markerNumber=marker, loadVector=[0.0, 0.0, 0.0]
        )


def _set_load(mbs: Any, load: ItemNumber, force: FloatArray) -> None:
    mbs.SetLoadParameter(load, "loadVector", [float(force[0]), float(force[1]), 0.0])


# Change of a damper's force, relative to it, that is none.
SETTLED = 1e-12


class StaticConnectors:
    """Connectors whose forces are those of one position after the other.

    Dampers carry what the rigid motion puts on them. Loads over time are not among them.

    Parameters
    ----------
    connectors : Connectors
        Of the model.
    """

    def __init__(self, connectors: Connectors) -> None:
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
        """Let a part of the loads act."""
        mbs, base = self._all.assembly.mbs, self._turn
        for item, (x, y, torque) in zip(self._all.loads, self._values, strict=True):
            if item.load.axes == "ground":
                x, y = _turned(np.array([x, y]), -base)
            if item.force is not None:
                mbs.SetLoadParameter(item.force, "loadVector", [part * x, part * y, 0.0])
            if item.torque is not None:
                mbs.SetLoadParameter(item.torque, "loadVector", [0.0, 0.0, part * torque])

    def converge(self) -> bool:
        """Let dampers act along their lines as they are now; whether that changes their forces."""
        mbs, changed = self._all.assembly.mbs, False
        for item in self._all.springs:
            if item.spring.damping:
                along, _ = self._line(item)
                before = mbs.GetObjectParameter(item.number, "force")
                force = item.spring.damping * float(along @ self._approach[item.spring.name])
                mbs.SetObjectParameter(item.number, "force", force)
                changed = changed or abs(force - before) > SETTLED * (abs(force) + abs(before))
        return changed

    def virial(self, state: FloatArray) -> FloatArray:
        """Products of the forces on rigid links and their places from the start.

        Parameters
        ----------
        state : ndarray, shape (size,)
            Coordinates of all links after a static solution.

        Returns
        -------
        ndarray, shape (n_links,)
            In N m; zero of elastic links.
        """
        assembly = self._all.assembly
        total = np.zeros(len(assembly.parts))

        def add(point: AttachmentPoint, force: FloatArray, in_link_axes: bool = False) -> None:
            link = -1 if point.is_ground else assembly.topology.index(point.link)
            part = assembly.parts[link]
            if link < 0 or not isinstance(part, RigidPart):
                return
            angle = float(state[part.coordinates][2])
            along = np.array([1.0, 0.0]) if in_link_axes else direction(np.array(angle))
            total[link] += point.x * float(force @ along)

        for item, (x, y, _) in zip(self._all.loads, self._values, strict=True):
            force, turns = np.array([x, y]), item.load.axes == "link"
            add(item.load.point, force if turns else _turned(force, -self._turn), turns)
        for each in self._all.springs:
            spring, (along, length) = each.spring, self._line(each)
            pull = spring.stiffness * (length - spring.free_length)
            pull += assembly.mbs.GetObjectParameter(each.number, "force")
            add(spring.first, pull * along)
            add(spring.second, -pull * along)
        for joint in self._all.joints:
            force = self._radial_force(joint, state)
            for end, sign in ((joint.follower, 1.0), (joint.leader, -1.0)):
                if end is not None and joint.radial is not None:
                    link = assembly.topology.links[assembly.topology.index(end.link)]
                    x = 0.0 if end.end == "start" else link.length
                    add(AttachmentPoint(end.link, x), sign * force)
        return total

    def _radial_force(self, item: JointSpringItem, state: FloatArray) -> FloatArray:
        """Force of a joint's radial spring on the following end in the model's axes, (2,)."""
        if item.radial is None:
            return np.zeros(2)
        assembly = self._all.assembly
        place = assembly.part_of(item.follower).end_place(item.follower.end, state)
        if item.leader is not None:
            before = assembly.part_of(item.leader).end_place(item.leader.end, state)
        else:
            ground = assembly.mbs.GetObjectParameter(item.ground, "referencePosition")
            before = np.array(ground)[:2]
        return -(item.spring.radial_stiffness or 0.0) * np.asarray(place - before)

    def _line(self, item: SpringItem) -> tuple[FloatArray, float]:
        """Direction from the first to the second end in the model's axes, and length in m."""
        kind = load_exudyn().OutputVariableType.Position
        first, second = (
            np.array(self._all.assembly.mbs.GetMarkerOutput(int(marker), kind))[:2]
            for marker in item.markers
        )
        length = float(np.linalg.norm(second - first))
        return (second - first) / length, length

    @property
    def scale_of_forces(self) -> float:
        """Sum of what the loads push with, in N and N m."""
        return float(sum(np.abs(value).sum() for value in self._values))

    def _set_spring(self, item: SpringItem, motion: RigidMotion, number: int) -> None:
        mbs, spring = self._all.assembly.mbs, item.spring
        for point, ground in item.grounds:
            self._put(ground, np.array([point.x, point.y]))
        if spring.damping:
            ends = [self._point(motion, number, end) for end in (spring.first, spring.second)]
            line, approach = ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]
            rate = float(line @ approach / np.linalg.norm(line))
            mbs.SetObjectParameter(item.number, "force", spring.damping * rate)
            self._approach[spring.name] = _turned(approach, -self._turn)

    def _set_joint(
        self, item: JointSpringItem, motion: RigidMotion, number: int, pose: FloatArray
    ) -> None:
        assembly, own = self._all.assembly, item.spring
        ends = [(1.0, item.follower)]
        if item.leader is not None:
            ends.append((-1.0, item.leader))
        links = [(sign, assembly.topology.index(end.link)) for sign, end in ends]
        if item.turning is not None:
            angles = self._continuous(motion)[number]
            opening = sum(sign * angles[link] for sign, link in links)
            rate = sum(sign * motion.angular_velocity[number, link] for sign, link in links)
            stands = sum(sign * pose[angle_of_end(assembly, end)] for sign, end in ends)
            offset = stands - opening + own.free_angle
            for load, sign in zip(item.drag, (-1.0, 1.0), strict=False):
                torque = float(sign * own.torsional_damping * rate)
                assembly.mbs.SetLoadParameter(load, "load", torque)
            assembly.mbs.SetObjectParameter(item.turning, "offset", float(offset))
        if item.ground is not None:
            link = links[0][1]
            x = 0.0 if item.follower.end == "start" else assembly.topology.links[link].length
            self._put(item.ground, motion.position(link, x)[number])

    def _continuous(self, motion: RigidMotion) -> FloatArray:
        if self._motion is not motion:
            linkage = self._all.assembly.mechanism.linkage
            self._motion, self._angles = motion, continuous_angles(linkage, motion)
        return self._angles

    def _point(
        self, motion: RigidMotion, number: int, point: AttachmentPoint
    ) -> tuple[FloatArray, FloatArray]:
        """Place and velocity of a point of the rigid linkage in ground axes."""
        if point.is_ground:
            return np.array([point.x, point.y]), np.zeros(2)
        link = self._all.assembly.topology.index(point.link)
        return motion.position(link, point.x)[number], motion.velocity(link, point.x)[number]

    def _put(self, ground: ItemNumber, place: FloatArray) -> None:
        """Put a ground where it is in the model's axes."""
        x, y = _turned(place, -self._turn)
        position = [float(x), float(y), 0.0]
        self._all.assembly.mbs.SetObjectParameter(ground, "referencePosition", position)


def _turned(vector: FloatArray, angle: float) -> FloatArray:
    turn = np.array(angle)
    return np.asarray(vector[0] * direction(turn) + vector[1] * normal(turn))
