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
from flexmech.linkages import Clamp, CrankDrive, LinkEnd, LockedCrank
from flexmech.mechanism import Mechanism
from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.impacts import add_impacts
from flexmech.multibody.items import ItemNumber
from flexmech.multibody.library import load_exudyn
from flexmech.multibody.link_energies import LinkEnergies
from flexmech.multibody.node_bodies import NodeBodies
from flexmech.multibody.user_functions import AxisPoint, HubClamp, Joints, Shaft
from flexmech.time_domain import Impact
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
    drive : CrankDrive or LockedCrank
    links : sequence of LinkModel
        The links' matrices in the same coordinates, for their weight.
    impacts : sequence of Impact
        Pulses on points of links.

    Attributes
    ----------
    assembly : LinkAssembly
        The links in ground axes.
    energies : LinkEnergies
    shaft : Shaft
    drive_constraint : ItemNumber
        The constraint on the hub's angle, which carries the driving torque.
    constraints : dict of str to list of ItemNumber
        Of each joint, without what keeps the clamp from turning.
    joints : Joints
        What the integration rule leaves to drift.
    total_size : int
        Coordinates of the links and the hub, which come last.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        elements: int,
        kind: str,
        drive: CrankDrive | LockedCrank,
        links: Sequence[LinkModel],
        impacts: Sequence[Impact] = (),
    ) -> None:
        self.assembly = assembly = LinkAssembly(mechanism, elements, kind)
        self.drive = drive
        self.links = links
        self.energies = LinkEnergies(assembly, links)
        self.total_size = assembly.size + 3
        self._start = mechanism.linkage.motion(drive.crank_angle(0.0))
        self.shaft = Shaft(
            float(self._start.angle[assembly.base]), float(drive.speed), float(drive.run_up_time)
        )
        self._lever = self._clamp_on_hub()
        self._add_loads()
        assembly.items.begin("crank drive: a hub without mass, turned by the shaft")
        fixed = assembly.add_fixed_coordinate()
        hub, self.drive_constraint = self._add_hub(fixed)
        self.constraints = {self._clamp.joint: [self._add_clamp(hub)]}
        self.constraints |= self._add_pivots(fixed)
        for pin, number in zip(assembly.topology.pins, assembly.add_pins(), strict=True):
            self.constraints[pin.joint] = [number]
        add_impacts(assembly, drive, impacts)
        assembly.mbs.Assemble()
        self.joints = self._joints()

    @property
    def joint_multipliers(self) -> IntArray:
        """Multipliers that are minus the force at each joint, shape (n_joints, 2)."""
        names = self.assembly.topology.joint_names
        found = np.zeros((len(names), 2), dtype=np.intp)
        for joint, constraints in self.constraints.items():
            found[names.index(joint)] = np.concatenate([self._multipliers(c) for c in constraints])
        return found

    @property
    def multiplier_count(self) -> int:
        """Number of all multipliers."""
        return len(self.assembly.mbs.systemData.GetAECoordinates())

    @property
    def torque_multiplier(self) -> int:
        """Multiplier that is minus the torque of the shaft."""
        return self._multipliers(self.drive_constraint)[0]

    def set_start(
        self, position: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Give the system its state at time zero.

        Parameters
        ----------
        position, velocity : ndarray, shape (size,)

        Returns
        -------
        ndarray, shape (total_size,)
            Exudyn's coordinates, those of the hub last.
        ndarray, shape (total_size,)
            Their rates.
        """
        nodes = self.assembly.arms.to_nodes(position)
        velocity = self.assembly.arms.rate_to_nodes(position, velocity)
        coordinates = np.array([*nodes, 0.0, 0.0, self.shaft.angle(0.0)])
        rates = np.array([*velocity, 0.0, 0.0, self.shaft.speed(0.0)])
        initial = load_exudyn().ConfigurationType.Initial
        data = self.assembly.mbs.systemData
        data.SetODE2Coordinates(coordinates, initial)
        data.SetODE2Coordinates_t(rates, initial)
        return coordinates, rates

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

    def _joints(self) -> Joints:
        """What the integration rule leaves to drift."""
        assembly, topology = self.assembly, self.assembly.topology
        eccentric = {
            name
            for name, part in zip(topology.link_names, assembly.parts, strict=True)
            if part.arms is not None
        }
        pins = [(topology.leader_of(pin.leader), pin.follower) for pin in topology.pins]
        return Joints(
            self.shaft,
            HubClamp(
                self._axis_point(self._clamp.held), self._lever, len(assembly.kind.vectors) == 2
            ),
            [
                (self._axis_point(pivot.held), _pair(self._place(pivot.held)))
                for pivot in topology.pivots
                if pivot.held.link in eccentric
            ],
            [
                (self._axis_point(leader), self._axis_point(follower))
                for leader, follower in pins
                if eccentric & {leader.link, follower.link}
            ],
        )

    def _axis_point(self, end: LinkEnd) -> AxisPoint:
        """The point on the pins' axis at a link end, by Exudyn's coordinates."""
        arms = self.assembly.part_of(end).arms
        return AxisPoint(
            first=self.assembly.end_node(end)[1],
            x=float(self.assembly.reference_place(end)[0]),
            arm=0.0 if arms is None else float(arms.length),
        )

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
        assembly = self.assembly
        for link, part in enumerate(assembly.parts):
            name = assembly.topology.link_names[link]
            if part.bodies is not None:
                self._add_weight(name, part.bodies)
                continue
            assembly.items.begin(f"{name}: point masses and weight")
            masses = assembly.point_masses(link)
            weights = self.energies.weight(link).reshape(len(part.nodes), -1)
            for number, (node, mass, weight) in enumerate(
                zip(part.nodes, masses, weights, strict=True)
            ):
                if mass or weight.any():
                    matrix = np.diag([mass, mass] + [0.0] * (assembly.kind.per_node - 2))
                    assembly.items.add(
                        "ObjectGenericODE2",
                        f"{name}_load_{number}",
                        nodeNumbers=[node],
                        massMatrix=matrix,
                        forceVector=weight,
                    )

    def _add_weight(self, link: str, bodies: NodeBodies) -> None:
        """Weight of a link at the centres of mass of the bodies at its nodes."""
        items = self.assembly.items
        x, y = self.assembly.mechanism.gravity
        if not (x or y):
            return
        items.begin(f"{link}: weight")
        pairs = zip(bodies.numbers, bodies.mass, bodies.centre, strict=True)
        for number, (body, mass, place) in enumerate(pairs):
            name = f"{link}_weight_{number}"
            centre = items.add(
                "MarkerBodyRigid",
                f"{name}_centre",
                bodyNumber=body,
                localPosition=[*map(float, place), 0.0],
            )
            force = [float(mass * x), float(mass * y), 0.0]
            items.add("LoadForceVector", name, markerNumber=centre, loadVector=force)

    def _add_hub(self, fixed: ItemNumber) -> tuple[ItemNumber, ItemNumber]:
        """Body without mass that turns with the shaft, and the constraint on its angle."""
        assembly, items = self.assembly, self.assembly.items
        node = items.add("NodeRigidBody2D", "hub_node")
        for coordinate, axis in enumerate("xy"):
            assembly.add_constraint(f"hub_{axis}", fixed, node, coordinate)
        drive = assembly.add_constraint("crank_drive", fixed, node, 2, **self._turning())
        return items.add("ObjectRigidBody2D", "hub", nodeNumber=node, mass=0.0, inertia=0.0), drive

    def _turning(self) -> dict[str, Any]:
        """Constraint on the hub's angle: a constant speed, or angle and speed of time."""
        if self.drive.is_constant:
            return {"velocityLevel": True, "offset": self.shaft.final_speed}
        return {
            "offsetUserFunction": self.shaft.constraint_angle,
            "offsetUserFunction_t": self.shaft.constraint_speed,
        }

    def _clamp_on_hub(self) -> tuple[float, float]:
        """Where the clamped end is on the hub in m."""
        place, turn = self._place(self._clamp.held), -self.shaft.start_angle
        cosine, sine = math.cos(turn), math.sin(turn)
        x, y = map(float, place)
        return cosine * x - sine * y, sine * x + cosine * y

    def _add_clamp(self, hub: ItemNumber) -> ItemNumber:
        """Pin the clamped end to the hub and keep the link's axis there parallel to it.

        Returns
        -------
        ItemNumber
            Of the pin.
        """
        assembly, items, clamp = self.assembly, self.assembly.items, self._clamp
        name = f"clamp_{clamp.joint}"
        items.begin(f"clamp {clamp.joint}: the link's end on the hub, its axis parallel to it")
        on_hub = items.add(
            "MarkerBodyRigid", f"{name}_on_hub", bodyNumber=hub, localPosition=[*self._lever, 0.0]
        )
        node, _ = assembly.end_node(clamp.held)
        on_link = assembly.add_end_marker(clamp.held, f"{name}_on_{clamp.held.link}")
        pin = items.add("RevoluteJoint2D", name, markerNumbers=[on_hub, on_link])
        part = assembly.parts[assembly.base]
        at_start = clamp.held.end == "start"
        element = part.elements[0 if at_start else -1]
        x = 0.0 if at_start else float(part.positions[-1] - part.positions[-2])
        axis = assembly.kind.add_axis_marker(items, f"{name}_axis", node, element, x)
        items.add(
            "GenericJoint",
            f"{name}_rotation",
            markerNumbers=[on_hub, axis],
            constrainedAxes=[0, 0, 0, 0, 0, 1],
        )
        return pin

    def _add_pivots(self, fixed: ItemNumber) -> dict[str, list[ItemNumber]]:
        """Pin links to the ground; returns the constraints of each pivot."""
        assembly, constraints = self.assembly, {}
        for pivot in assembly.topology.pivots:
            name, place = f"pivot_{pivot.joint}", self._place(pivot.held)
            assembly.items.begin(f"pivot {pivot.joint}")
            if assembly.part_of(pivot.held).arms is not None:
                pin = assembly.add_ground_pin(name, pivot.held, [*map(float, place), 0.0])[1]
                constraints[pivot.joint] = [pin]
                continue
            node = assembly.end_node(pivot.held)[0]
            offset = place - assembly.reference_place(pivot.held)
            constraints[pivot.joint] = [
                assembly.add_constraint(f"{name}_{axis}", fixed, node, i, offset=float(offset[i]))
                for i, axis in enumerate("xy")
            ]
        return constraints

    @property
    def _clamp(self) -> Clamp:
        return self.assembly.topology.clamps[0]

    def _multipliers(self, constraint: ItemNumber) -> list[int]:
        return list(self.assembly.mbs.systemData.GetObjectLTGAE(int(constraint)))


def _pair(place: FloatArray) -> tuple[float, float]:
    return float(place[0]), float(place[1])
