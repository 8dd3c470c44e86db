"""A mechanism as a running Exudyn system, in ground axes, with its shaft driven.

The shaft is a hub without mass that turns about the ground's origin. The clamped link's
start is pinned to it and the link's axis there is kept parallel to it, so that the one
constraint on the hub's angle carries the whole driving torque.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from flexmech.linear_system import LinkModel
from flexmech.linkages import Clamp, CrankDrive, LinkEnd
from flexmech.mechanism import Mechanism
from flexmech.multibody.library import load_exudyn
from flexmech.multibody.model import MultibodyModel
from flexmech.multibody.node_bodies import NodeBodies
from flexmech.types import FloatArray, IntArray

__all__ = ["RunningModel"]


class RunningModel(MultibodyModel):
    """Exudyn system of a running mechanism.

    Parameters
    ----------
    mechanism : Mechanism
    elements : int
        Elements a link.
    kind : str
        Key of :data:`flexmech.multibody.beams.BEAM_KINDS`.
    drive : CrankDrive
    links : sequence of LinkModel
        The links' matrices in the same coordinates, for their weight.

    Attributes
    ----------
    total_size : int
        Coordinates of the links and the hub, which come last.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        elements: int,
        kind: str,
        drive: CrankDrive,
        links: Sequence[LinkModel],
    ) -> None:
        self.drive = drive
        self.links = links
        self._start = mechanism.linkage.motion(drive.crank_angle(0.0))
        self._connections: list[tuple[str, list[int]]] = []
        super().__init__(mechanism, elements, kind)
        for pin, number in zip(self.topology.pins, self.pins, strict=True):
            self._connections.append((pin.joint, [number]))
        self.total_size = self.size + 3
        first = self._end(self._clamp.held)[1]
        self._clamped = slice(first, first + self.kind.per_node)
        self._clamped_x = float(self._straight_place(self._clamp.held)[0])
        self._pivots_on_arms = [
            (pivot.held, self._place(pivot.held))
            for pivot in self.topology.pivots
            if self._part(pivot.held).arms is not None
        ]
        pins = [(self.topology.leader_of(p.leader), p.follower) for p in self.topology.pins]
        self._pins_on_arms = [
            pair for pair in pins if any(self._part(end).arms is not None for end in pair)
        ]

    def shaft_angle(self, time: float) -> float:
        """Angle of the clamped link at its clamp in rad."""
        turned = self.drive.crank_angle(time) - self.drive.start_angle
        return float(self._start.angle[self.base] + turned)

    @property
    def joint_multipliers(self) -> IntArray:
        """Multipliers that are minus the force at each joint, shape (n_joints, 2)."""
        names = self.topology.joint_names
        found = np.zeros((len(names), 2), dtype=np.intp)
        for joint, constraints in self._connections:
            found[names.index(joint)] = np.concatenate([self._multipliers(c) for c in constraints])
        return found

    @property
    def multiplier_count(self) -> int:
        """Number of all multipliers."""
        return len(self.mbs.systemData.GetAECoordinates())

    @property
    def torque_multiplier(self) -> int:
        """Multiplier that is minus the torque of the shaft."""
        return self._multipliers(self._shaft)[0]

    def weight(self, link: int) -> FloatArray:
        """Generalized weight of a link in ground axes, shape (n_link,)."""
        x, y = self.mechanism.gravity
        fields = self.links[link].fields
        return self.links[link].mass @ (x * fields.along + y * fields.across)

    def kinetic_energy(self, link: int, position: FloatArray, velocity: FloatArray) -> FloatArray:
        """Kinetic energy of a link.

        Parameters
        ----------
        link : int
        position, velocity : ndarray, shape (m, n_link)
            Its coordinates in ground axes.

        Returns
        -------
        ndarray, shape (m,)
        """
        mass, arms = self.links[link].mass, self.parts[link].arms
        if arms is None:
            return np.asarray(np.sum(velocity @ mass * velocity, axis=1) / 2)
        # By the nodes only the first moments of the bodies there turn with the sections.
        rate = arms.moved_rate(position, velocity)
        mass = arms.back.matrix(np.zeros(len(mass)), mass)
        angles = np.arange(2, len(mass), self.kind.per_node)
        moment = -mass[angles - 2, angles]
        turn, spin = position[:, angles], rate[:, angles]
        turned = (1 - np.cos(turn)) * rate[:, angles - 2] - np.sin(turn) * rate[:, angles - 1]
        energy = np.sum(rate @ mass * rate, axis=1) / 2
        return np.asarray(energy + (spin * turned) @ moment)

    def gravity_energy(self, link: int, position: FloatArray) -> FloatArray:
        """Potential of a link's weight but for a constant.

        Parameters
        ----------
        link : int
        position : ndarray, shape (m, n_link)
            Its coordinates in ground axes.

        Returns
        -------
        ndarray, shape (m,)
        """
        part = self.parts[link]
        if part.bodies is None or part.arms is None:
            return np.asarray(-position @ self.weight(link))
        x, y = self.mechanism.gravity
        nodes = part.arms.moved(position).reshape(len(position), -1, self.kind.per_node)
        arm, turn = part.bodies.centre, nodes[..., 2]
        lifted = x * (nodes[..., 0] - arm * np.sin(turn)) + y * (nodes[..., 1] + arm * np.cos(turn))
        return np.asarray(-lifted @ part.bodies.mass)

    def set_start(self, position: FloatArray, velocity: FloatArray) -> None:
        """State at time zero.

        Parameters
        ----------
        position, velocity : ndarray, shape (size,)
        """
        nodes = self.arms.to_nodes(position)
        velocity = self.arms.rate_to_nodes(position, velocity)
        initial = load_exudyn().ConfigurationType.Initial
        speed = float(self.drive.crank_speed(0.0))
        data = self.mbs.systemData
        data.SetODE2Coordinates([*nodes, 0.0, 0.0, self.shaft_angle(0.0)], initial)
        data.SetODE2Coordinates_t([*velocity, 0.0, 0.0, speed], initial)

    def greatest_gap(self, position: FloatArray) -> float:
        """Greatest displacement between link ends or supports that a joint holds together.

        Parameters
        ----------
        position : ndarray, shape (size,)
            At time zero.

        Returns
        -------
        float
            In m.
        """

        def place(end: LinkEnd) -> FloatArray:
            first = self._end(end)[1]
            return np.asarray(position[first : first + 2] + self._straight_place(end))

        held = [clamp.held for clamp in self.topology.clamps]
        held += [pivot.held for pivot in self.topology.pivots]
        gaps = [place(end) - self._place(end) for end in held]
        gaps += [place(pin.leader) - place(pin.follower) for pin in self.topology.pins]
        return float(np.max(np.linalg.norm(gaps, axis=1)))

    def put_joints_in_place(self, position: FloatArray, time: float) -> None:
        """Put hub and clamp where the shaft has them, and pins on arms together, in place.

        Constraints on velocities leave the place to the integration rule, whose error in
        the clamped direction, ``(speed * step)**3 / 12`` a step, would add up; so would that
        of pins whose arms vibrate. Pins between nodes are linear in them and do not part.

        Parameters
        ----------
        position : ndarray, shape (total_size,)
            Exudyn's coordinates.
        time : float
            In s.
        """
        angle = self.shaft_angle(time)
        cosine, sine = math.cos(angle), math.sin(angle)
        x, y = self._lever
        node = position[self._clamped]
        node[0] = cosine * x - sine * y - self._clamped_x
        node[1] = sine * x + cosine * y
        self.kind.align(node, angle)
        arms = self.parts[self.base].arms
        if arms is not None:
            node[:] = arms.moved(node)
        position[-1] = angle
        for held, place in self._pivots_on_arms:
            self._move_end(position, held, place)
        for leader, follower in self._pins_on_arms:
            self._move_end(position, follower, self._axis_place(position, leader))

    def _axis_place(self, position: FloatArray, end: LinkEnd) -> FloatArray:
        """Where the point on the pins' axis at a link end is, (2,), by Exudyn's coordinates."""
        first, arms = self._end(end)[1], self._part(end).arms
        node = position[first : first + self.kind.per_node]
        axis = node if arms is None else arms.back.moved(node)
        return np.asarray(axis[:2] + self._straight_place(end))

    def _move_end(self, position: FloatArray, end: LinkEnd, place: FloatArray) -> None:
        """Move a node so that its point on the pins' axis gets to a place."""
        first = self._end(end)[1]
        position[first : first + 2] += place - self._axis_place(position, end)

    def _add_supports(self) -> list[tuple[int, int]]:
        """Hub, shaft and pivots; nothing whose offset moves with the crank angle."""
        fixed = self._add_fixed_coordinate()
        hub = self._add_hub(fixed)
        self._add_clamp(hub)
        for pivot in self.topology.pivots:
            if self._part(pivot.held).arms is not None:
                place = [*map(float, self._place(pivot.held)), 0.0]
                self._connections.append((pivot.joint, [self._pin_to_ground(pivot.held, place)[1]]))
                continue
            node = self._end(pivot.held)[0]
            offset = self._place(pivot.held) - self._straight_place(pivot.held)
            held = [self._hold(fixed, node, i, offset=float(offset[i])) for i in (0, 1)]
            self._connections.append((pivot.joint, held))
        return []

    def _place(self, held: LinkEnd) -> FloatArray:
        """Where a link end is at time zero, shape (2,)."""
        link = self.topology.index(held.link)
        x = 0.0 if held.end == "start" else self.topology.links[link].length
        return self._start.position(link, x)

    def _add_loads(self) -> int:
        """Point masses and weight, node by node; returns their number.

        One object over all nodes, as in the base class, would make each tangent dense.
        """
        items = load_exudyn().itemInterface
        carriers = 0
        for link, part in enumerate(self.parts):
            if part.bodies is not None:
                self._add_weight(part.bodies)
                carriers += len(part.nodes)
                continue
            masses = self.point_masses(link)
            weights = self.weight(link).reshape(len(part.nodes), -1)
            for node, mass, weight in zip(part.nodes, masses, weights, strict=True):
                if mass or weight.any():
                    matrix = np.diag([mass, mass] + [0.0] * (self.kind.per_node - 2))
                    self.mbs.AddObject(
                        items.ObjectGenericODE2(
                            nodeNumbers=[node], massMatrix=matrix, forceVector=weight
                        )
                    )
                    carriers += 1
        return carriers

    def _add_weight(self, bodies: NodeBodies) -> None:
        """Weight of an eccentric link at the centres of mass of the bodies at its nodes."""
        items = load_exudyn().itemInterface
        x, y = self.mechanism.gravity
        if not (x or y):
            return
        for body, mass, arm in zip(bodies.numbers, bodies.mass, bodies.centre, strict=True):
            centre = items.MarkerBodyRigid(bodyNumber=body, localPosition=[0.0, arm, 0.0])
            load = items.LoadForceVector(
                markerNumber=self.mbs.AddMarker(centre), loadVector=[mass * x, mass * y, 0.0]
            )
            self.mbs.AddLoad(load)

    def _add_hub(self, fixed: int) -> int:
        """Body without mass that turns with the shaft; returns its number."""
        items = load_exudyn().itemInterface
        node = self.mbs.AddNode(items.NodeRigidBody2D())
        for coordinate in (0, 1):
            self._hold(fixed, node, coordinate)
        self._shaft = self._hold(fixed, node, 2, **self._turning())
        return int(
            self.mbs.AddObject(items.ObjectRigidBody2D(nodeNumber=node, mass=0.0, inertia=0.0))
        )

    def _turning(self) -> dict[str, Any]:
        """Constraint on the hub's angle: a constant speed, or angle and speed of time."""
        if self.drive.is_constant:
            return {"velocityLevel": True, "offset": self.drive.speed}
        return {
            "offsetUserFunction": lambda mbs, t, item, offset: self.shaft_angle(t),
            "offsetUserFunction_t": lambda mbs, t, item, offset: float(self.drive.crank_speed(t)),
        }

    def _add_clamp(self, hub: int) -> None:
        """Pin the clamped end to the hub and keep the link's axis there parallel to it."""
        items = load_exudyn().itemInterface
        place, turn = self._place(self._clamp.held), -float(self._start.angle[self.base])
        cosine, sine = math.cos(turn), math.sin(turn)
        self._lever = (cosine * place[0] - sine * place[1], sine * place[0] + cosine * place[1])
        on_hub = self.mbs.AddMarker(
            items.MarkerBodyRigid(bodyNumber=hub, localPosition=[*self._lever, 0.0])
        )
        node, _ = self._end(self._clamp.held)
        on_link = self._end_marker(self._clamp.held)
        pin = self.mbs.AddObject(items.RevoluteJoint2D(markerNumbers=[on_hub, on_link]))
        self._connections.append((self._clamp.joint, [int(pin)]))
        part = self.parts[self.base]
        at_start = self._clamp.held.end == "start"
        element = part.elements[0 if at_start else -1]
        x = 0.0 if at_start else float(part.positions[-1] - part.positions[-2])
        axis = self.kind.add_axis_marker(self.mbs, node, element, x)
        self.mbs.AddObject(
            items.GenericJoint(markerNumbers=[on_hub, axis], constrainedAxes=[0, 0, 0, 0, 0, 1])
        )

    @property
    def _clamp(self) -> Clamp:
        return self.topology.clamps[0]

    def _multipliers(self, constraint: int) -> list[int]:
        return list(self.mbs.systemData.GetObjectLTGAE(constraint))
