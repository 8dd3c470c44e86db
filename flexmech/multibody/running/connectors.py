"""Loads and springs of a running linkage, and the energy that they take and give."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linear_system import LinkModel
from flexmech.linkages import AttachmentPoint, LinkEnd, RigidMotion, continuous_angles
from flexmech.linkages.motion import direction, normal
from flexmech.multibody.connectors import Connectors, JointSpringItem, LoadItem, angle_of_end
from flexmech.multibody.items import Made
from flexmech.multibody.link_parts import BeamPart, RigidPart
from flexmech.multibody.node_directions import leading_end
from flexmech.multibody.running.user_functions import Shaft, load_history
from flexmech.time_domain import ConnectorWork


class RunningConnectors:
    """Connectors of a running system that is not assembled yet.

    Parameters
    ----------
    connectors : Connectors
        Of the system.
    links : sequence of LinkModel
    shaft : Shaft
    start : RigidMotion
        At time zero, of shape ().
    """

    def __init__(
        self,
        connectors: Connectors,
        links: tuple[LinkModel, ...] | list[LinkModel],
        shaft: Shaft,
        start: RigidMotion,
    ) -> None:
        self._all = connectors
        self._links = links
        self._shaft = shaft
        # By how much the clamped link is ahead of the crank.
        self._lead = shaft.start_angle - float(start.crank_angle)
        self._offsets: dict[str, float] = {}
        self._set(start)

    def work(self, time: FloatArray, position: FloatArray, velocity: FloatArray) -> ConnectorWork:
        """Energy and power at instants of a run.

        Parameters
        ----------
        time : ndarray, shape (m,)
        position, velocity : ndarray, shape (m, size)
            Coordinates of the links in ground axes.

        Returns
        -------
        ConnectorWork
        """
        power = np.zeros(len(time))
        for item in self._all.loads:
            power += self._load_power(item, time, position, velocity)
        return ConnectorWork.of(self._deformations(time, position, velocity), power)

    def _deformations(
        self, time: FloatArray, position: FloatArray, velocity: FloatArray
    ) -> Iterator[tuple[float, FloatArray, float, FloatArray]]:
        """Stiffness, deformation, damping and rate of each spring."""
        for each in self._all.springs:
            spring = each.spring
            ends = [self._point(end, position, velocity) for end in (spring.first, spring.second)]
            line, approach = ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]
            length = np.linalg.norm(line, axis=1)
            rate = np.sum(line * approach, axis=1) / np.where(length > 0, length, 1.0)
            yield spring.stiffness, length - spring.free_length, spring.damping, rate
        for joint in self._all.joints:
            own = joint.spring
            if joint.turning is not None:
                turned = self._turned(joint, time, position)
                rate = self._opening(joint, velocity)
                yield own.torsional_stiffness, turned, own.torsional_damping, rate
            if joint.radial is not None:
                apart, drift = self._apart(joint, position, velocity)
                for way in range(2):
                    own_way = apart[:, way], own.radial_damping, drift[:, way]
                    yield own.radial_stiffness or 0.0, *own_way

    def joint_forces(self, position: FloatArray, velocity: FloatArray) -> dict[str, FloatArray]:
        """Force of each sprung joint on its held or following link, (m, 2), by its name."""
        forces = {}
        for item in self._all.joints:
            if item.radial is not None:
                apart, drift = self._apart(item, position, velocity)
                own = item.spring
                force = (own.radial_stiffness or 0.0) * apart + own.radial_damping * drift
                forces[own.joint] = -force
        return forces

    def _set(self, start: RigidMotion) -> None:
        """Give the items what the start decides, before they are assembled."""
        assembly = self._all.assembly
        for item in self._all.loads:
            load = item.load
            rows = [
                [*map(float, pair), float(t)]
                for pair, t in zip(load.force, load.torque, strict=True)
            ]
            for number, is_torque in ((item.force, False), (item.torque, True)):
                if number is None:
                    continue
                history = Made(
                    load_history,
                    (
                        self._shaft,
                        self._lead,
                        load.over,
                        list(map(float, load.at)),
                        rows,
                        is_torque,
                    ),
                )
                assembly.items.change(number, "loadVectorUserFunction", history)
        if not self._all.joints:
            return
        linkage = assembly.mechanism.linkage
        angles = continuous_angles(linkage, start)
        for joint in self._all.joints:
            links = [(sign, assembly.topology.index(end.link)) for sign, end in self._sides(joint)]
            if joint.turning is not None:
                opening = sum(float(sign * angles[link]) for sign, link in links)
                stands = sum(float(sign * start.angle[link]) for sign, link in links)
                offset = stands - opening + joint.spring.free_angle
                self._offsets[joint.spring.joint] = offset
                assembly.items.change(joint.turning, "offset", offset)
            if joint.ground is not None:
                link = links[0][1]
                end = joint.follower.end
                x = 0.0 if end == "start" else assembly.topology.links[link].length
                place = [*map(float, start.position(link, x)), 0.0]
                assembly.items.change(joint.ground, "referencePosition", place)

    def _sides(self, item: JointSpringItem) -> list[tuple[float, LinkEnd]]:
        sides = [(1.0, item.follower)]
        return sides if item.leader is None else [*sides, (-1.0, item.leader)]

    def _opening(self, item: JointSpringItem, values: FloatArray) -> FloatArray:
        """Angle between the links of a joint by coordinates, or its rate by velocities."""
        sides = self._sides(item)
        angles = (sign * values[:, angle_of_end(self._all.assembly, end)] for sign, end in sides)
        return np.asarray(sum(angles))

    def _turned(self, item: JointSpringItem, time: FloatArray, position: FloatArray) -> FloatArray:
        """Angle by which a spring is wound, whole turns included.

        The angle of a cable's slope is known but for whole turns, of which the rigid linkage has
        as many.
        """
        assembly, own = self._all.assembly, item.spring
        turned = self._opening(item, position) - self._offsets[own.joint]
        linkage = assembly.mechanism.linkage
        angles = continuous_angles(linkage, linkage.motion(self._crank(time), 1.0))
        ends = [(sign, assembly.topology.index(end.link)) for sign, end in self._sides(item)]
        rigid = sum(sign * angles[:, link] for sign, link in ends) - own.free_angle
        return np.asarray(turned + 2 * np.pi * np.round((rigid - turned) / (2 * np.pi)))

    def _crank(self, time: FloatArray) -> FloatArray:
        """Crank angles at some times as they are prescribed."""
        return np.array([self._shaft.angle(t) for t in time]) - self._lead

    def _apart(
        self, item: JointSpringItem, position: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Displacement between the ends of a sprung joint and its rate, (m, 2)."""
        assembly = self._all.assembly
        place, rate = self._end(item.follower, position, velocity)
        if item.leader is None:
            ground = assembly.items.value(item.ground, "referencePosition")
            return place - np.asarray(ground)[:2], rate
        root = leading_end(assembly.topology, item.leader)
        before, moving = self._end(root, position, velocity)
        return place - before, rate - moving

    def _end(
        self, end: LinkEnd, position: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        part = self._all.assembly.part_of(end)
        x = 0.0 if end.end == "start" else part.length
        return self._point(AttachmentPoint(end.link, x), position, velocity)

    def _load_power(
        self, item: LoadItem, time: FloatArray, position: FloatArray, velocity: FloatArray
    ) -> FloatArray:
        load = item.load
        values = load.values(self._crank(time), time)
        force = values[:, :2]
        angle, spin = self._turning(load.point, position, velocity)
        if load.axes == "link":
            force = force[:, :1] * direction(angle) + force[:, 1:] * normal(angle)
        _, rate = self._point(load.point, position, velocity)
        return np.asarray(np.sum(force * rate, axis=1) + values[:, 2] * spin)

    def _point(
        self, point: AttachmentPoint, position: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Place and velocity of a point in ground axes, (m, 2)."""
        if point.is_ground:
            place = np.broadcast_to((point.x, point.y), (len(position), 2))
            return place, np.zeros_like(place)
        number = self._all.assembly.topology.index(point.link)
        part = self._all.assembly.parts[number]
        own, rate = position[:, part.coordinates], velocity[:, part.coordinates]
        if isinstance(part, RigidPart):
            along, across = direction(own[:, 2]), normal(own[:, 2])
            return own[:, :2] + point.x * along, rate[:, :2] + rate[:, 2:] * point.x * across
        if part.polar is not None:
            own, rate = part.polar.moved(own), part.polar.moved_rate(own, rate)
        fraction = np.array([point.x / part.length])
        rows = self._links[number].readings.displacement_at(fraction)[0]
        return (own + part.straight) @ rows.T, rate @ rows.T

    def _turning(
        self, point: AttachmentPoint, position: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Angle of a link at a point and its rate; zero where none is asked for."""
        part = self._all.assembly.parts[self._all.assembly.topology.index(point.link)]
        own, rate = position[:, part.coordinates], velocity[:, part.coordinates]
        if isinstance(part, RigidPart):
            return own[:, 2], rate[:, 2]
        angle = self._angle(part, point.x)
        if angle is None:
            return np.zeros(len(own)), np.zeros(len(own))
        return own[:, angle], rate[:, angle]

    def _angle(self, part: BeamPart, x: float) -> int | None:
        """Coordinate of a beam that is its angle at a node."""
        node = int(np.argmin(np.abs(part.positions - x)))
        angle = part.kind.per_node * node + part.kind.clamped
        return angle if part.rotation[angle] else None
