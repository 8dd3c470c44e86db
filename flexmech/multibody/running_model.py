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
from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.library import load_exudyn
from flexmech.multibody.link_energies import LinkEnergies
from flexmech.multibody.node_bodies import NodeBodies
from flexmech.types import FloatArray, IntArray

__all__ = ["RunningModel"]


class RunningModel:
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
    assembly : LinkAssembly
        The links in ground axes.
    energies : LinkEnergies
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
        self.assembly = assembly = LinkAssembly(mechanism, elements, kind)
        self.drive = drive
        self.links = links
        self.energies = LinkEnergies(assembly, links)
        self.total_size = assembly.size + 3
        self._start = mechanism.linkage.motion(drive.crank_angle(0.0))
        self._lever = self._clamp_on_hub()
        self._add_loads()
        fixed = assembly.add_fixed_coordinate()
        hub, self._shaft = self._add_hub(fixed)
        self._constraints = {self._clamp.joint: [self._add_clamp(hub)]}
        self._constraints |= self._add_pivots(fixed)
        for pin, number in zip(assembly.topology.pins, assembly.add_pins(), strict=True):
            self._constraints[pin.joint] = [number]
        assembly.mbs.Assemble()
        self._pivots_on_arms = [
            (pivot.held, self._place(pivot.held))
            for pivot in assembly.topology.pivots
            if assembly.part_of(pivot.held).arms is not None
        ]
        leader_of = assembly.topology.leader_of
        pins = [(leader_of(pin.leader), pin.follower) for pin in assembly.topology.pins]
        self._pins_on_arms = [
            pair for pair in pins if any(assembly.part_of(end).arms is not None for end in pair)
        ]

    def shaft_angle(self, time: float) -> float:
        """Angle of the clamped link at its clamp in rad."""
        turned = self.drive.crank_angle(time) - self.drive.start_angle
        return float(self._start.angle[self.assembly.base] + turned)

    @property
    def joint_multipliers(self) -> IntArray:
        """Multipliers that are minus the force at each joint, shape (n_joints, 2)."""
        names = self.assembly.topology.joint_names
        found = np.zeros((len(names), 2), dtype=np.intp)
        for joint, constraints in self._constraints.items():
            found[names.index(joint)] = np.concatenate([self._multipliers(c) for c in constraints])
        return found

    @property
    def multiplier_count(self) -> int:
        """Number of all multipliers."""
        return len(self.assembly.mbs.systemData.GetAECoordinates())

    @property
    def torque_multiplier(self) -> int:
        """Multiplier that is minus the torque of the shaft."""
        return self._multipliers(self._shaft)[0]

    def set_start(self, position: FloatArray, velocity: FloatArray) -> None:
        """State at time zero.

        Parameters
        ----------
        position, velocity : ndarray, shape (size,)
        """
        nodes = self.assembly.arms.to_nodes(position)
        velocity = self.assembly.arms.rate_to_nodes(position, velocity)
        initial = load_exudyn().ConfigurationType.Initial
        speed = float(self.drive.crank_speed(0.0))
        data = self.assembly.mbs.systemData
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
        assembly, topology = self.assembly, self.assembly.topology

        def place(end: LinkEnd) -> FloatArray:
            first = assembly.end_node(end)[1]
            return np.asarray(position[first : first + 2] + assembly.reference_place(end))

        held = [clamp.held for clamp in topology.clamps]
        held += [pivot.held for pivot in topology.pivots]
        gaps = [place(end) - self._place(end) for end in held]
        gaps += [place(pin.leader) - place(pin.follower) for pin in topology.pins]
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
        node = self._node(position, self._clamp.held)
        node[0] = cosine * x - sine * y - self.assembly.reference_place(self._clamp.held)[0]
        node[1] = sine * x + cosine * y
        self.assembly.kind.align(node, angle)
        arms = self.assembly.parts[self.assembly.base].arms
        if arms is not None:
            node[:] = arms.moved(node)
        position[-1] = angle
        for held, place in self._pivots_on_arms:
            self._move_end(position, held, place)
        for leader, follower in self._pins_on_arms:
            self._move_end(position, follower, self._axis_place(position, leader))

    def _node(self, position: FloatArray, end: LinkEnd) -> FloatArray:
        """Coordinates of the node at a link end, a view of all coordinates."""
        first = self.assembly.end_node(end)[1]
        return position[first : first + self.assembly.kind.per_node]

    def _axis_place(self, position: FloatArray, end: LinkEnd) -> FloatArray:
        """Where the point on the pins' axis at a link end is, (2,), by Exudyn's coordinates."""
        node, arms = self._node(position, end), self.assembly.part_of(end).arms
        axis = node if arms is None else arms.back.moved(node)
        return np.asarray(axis[:2] + self.assembly.reference_place(end))

    def _move_end(self, position: FloatArray, end: LinkEnd, place: FloatArray) -> None:
        """Move a node so that its point on the pins' axis gets to a place."""
        self._node(position, end)[:2] += place - self._axis_place(position, end)

    def _place(self, held: LinkEnd) -> FloatArray:
        """Where a link end is at time zero, shape (2,)."""
        topology = self.assembly.topology
        link = topology.index(held.link)
        x = 0.0 if held.end == "start" else topology.links[link].length
        return self._start.position(link, x)

    def _add_loads(self) -> None:
        """Point masses and weight, node by node.

        One object over all nodes, as in the model at standstill, would make each tangent dense.
        """
        assembly, items = self.assembly, load_exudyn().itemInterface
        for link, part in enumerate(assembly.parts):
            if part.bodies is not None:
                self._add_weight(part.bodies)
                continue
            masses = assembly.point_masses(link)
            weights = self.energies.weight(link).reshape(len(part.nodes), -1)
            for node, mass, weight in zip(part.nodes, masses, weights, strict=True):
                if mass or weight.any():
                    matrix = np.diag([mass, mass] + [0.0] * (assembly.kind.per_node - 2))
                    assembly.mbs.AddObject(
                        items.ObjectGenericODE2(
                            nodeNumbers=[node], massMatrix=matrix, forceVector=weight
                        )
                    )

    def _add_weight(self, bodies: NodeBodies) -> None:
        """Weight of a link at the centres of mass of the bodies at its nodes."""
        mbs, items = self.assembly.mbs, load_exudyn().itemInterface
        x, y = self.assembly.mechanism.gravity
        if not (x or y):
            return
        for body, mass, place in zip(bodies.numbers, bodies.mass, bodies.centre, strict=True):
            centre = items.MarkerBodyRigid(bodyNumber=body, localPosition=[*map(float, place), 0.0])
            load = items.LoadForceVector(
                markerNumber=mbs.AddMarker(centre), loadVector=[mass * x, mass * y, 0.0]
            )
            mbs.AddLoad(load)

    def _add_hub(self, fixed: int) -> tuple[int, int]:
        """Body without mass that turns with the shaft, and the constraint on its angle."""
        assembly, items = self.assembly, load_exudyn().itemInterface
        node = assembly.mbs.AddNode(items.NodeRigidBody2D())
        for coordinate in (0, 1):
            assembly.add_constraint(fixed, node, coordinate)
        shaft = assembly.add_constraint(fixed, node, 2, **self._turning())
        body = items.ObjectRigidBody2D(nodeNumber=node, mass=0.0, inertia=0.0)
        return int(assembly.mbs.AddObject(body)), shaft

    def _turning(self) -> dict[str, Any]:
        """Constraint on the hub's angle: a constant speed, or angle and speed of time."""
        if self.drive.is_constant:
            return {"velocityLevel": True, "offset": self.drive.speed}
        return {
            "offsetUserFunction": lambda mbs, t, item, offset: self.shaft_angle(t),
            "offsetUserFunction_t": lambda mbs, t, item, offset: float(self.drive.crank_speed(t)),
        }

    def _clamp_on_hub(self) -> tuple[float, float]:
        """Where the clamped end is on the hub in m."""
        place, turn = self._place(self._clamp.held), -float(self._start.angle[self.assembly.base])
        cosine, sine = math.cos(turn), math.sin(turn)
        return cosine * place[0] - sine * place[1], sine * place[0] + cosine * place[1]

    def _add_clamp(self, hub: int) -> int:
        """Pin the clamped end to the hub and keep the link's axis there parallel to it.

        Returns
        -------
        int
            Exudyn's number of the pin.
        """
        assembly, items = self.assembly, load_exudyn().itemInterface
        on_hub = assembly.mbs.AddMarker(
            items.MarkerBodyRigid(bodyNumber=hub, localPosition=[*self._lever, 0.0])
        )
        node, _ = assembly.end_node(self._clamp.held)
        on_link = assembly.add_end_marker(self._clamp.held)
        pin = assembly.mbs.AddObject(items.RevoluteJoint2D(markerNumbers=[on_hub, on_link]))
        part = assembly.parts[assembly.base]
        at_start = self._clamp.held.end == "start"
        element = part.elements[0 if at_start else -1]
        x = 0.0 if at_start else float(part.positions[-1] - part.positions[-2])
        axis = assembly.kind.add_axis_marker(assembly.mbs, node, element, x)
        assembly.mbs.AddObject(
            items.GenericJoint(markerNumbers=[on_hub, axis], constrainedAxes=[0, 0, 0, 0, 0, 1])
        )
        return int(pin)

    def _add_pivots(self, fixed: int) -> dict[str, list[int]]:
        """Pin links to the ground; returns the constraints of each pivot."""
        assembly, constraints = self.assembly, {}
        for pivot in assembly.topology.pivots:
            place = self._place(pivot.held)
            if assembly.part_of(pivot.held).arms is not None:
                pin = assembly.add_ground_pin(pivot.held, [*map(float, place), 0.0])[1]
                constraints[pivot.joint] = [pin]
                continue
            node = assembly.end_node(pivot.held)[0]
            offset = place - assembly.reference_place(pivot.held)
            constraints[pivot.joint] = [
                assembly.add_constraint(fixed, node, i, offset=float(offset[i])) for i in (0, 1)
            ]
        return constraints

    @property
    def _clamp(self) -> Clamp:
        return self.assembly.topology.clamps[0]

    def _multipliers(self, constraint: int) -> list[int]:
        return list(self.assembly.mbs.systemData.GetObjectLTGAE(constraint))
