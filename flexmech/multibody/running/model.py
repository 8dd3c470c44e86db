"""A mechanism as a running Exudyn system, in ground axes, with its shaft driven.

The shaft is a hub without mass that turns about the ground's origin. The clamped link's
start is pinned to it and the link's axis there is kept parallel to it, so that the one
constraint on the hub's angle carries the whole driving torque. A shaft that is free has its
inertia on the hub instead, and a torque over time.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linkages import Clamp, Drive
from flexmech.linkages.motion import normal, turned
from flexmech.mechanics import LinkModel
from flexmech.mechanics.running import FrameMotion, Impact
from flexmech.mechanism import Mechanism
from flexmech.multibody.assembly import FrameBody, LinkAssembly
from flexmech.multibody.connectors import RunningConnectors
from flexmech.multibody.items import ItemNumber, Made, load_exudyn
from flexmech.multibody.joints import (
    add_pivots,
    add_sliders,
    add_ties,
    closed_joints,
    dependent_joints,
    hold_axis,
    joint_gaps,
    place_on_hub,
)
from flexmech.multibody.running.loads import (
    LinkEnergies,
    MotorOnHub,
    SectionCouples,
    TorqueTable,
    add_impacts,
    add_running_loads,
)
from flexmech.multibody.running.user_functions import AngleGap, Shaft, load_history

# Axis of the shaft, in ground axes in m.
_AXIS = (0.0, 0.0)


class RunningModel:
    """Exudyn system of a running mechanism.

    Parameters
    ----------
    mechanism : Mechanism
    elements : int
        Elements a link.
    kind : str
        Key of :data:`flexmech.multibody.beams.BEAM_KINDS`.
    drive : Drive
    links : sequence of LinkModel
        The links' matrices in the same coordinates, for their weight.
    duration : float
        Duration of the run in s.
    impacts : sequence of Impact
        Pulses on points of links.
    torque : TorqueTable or MotorOnHub, optional
        Torque on a free shaft; it turns as prescribed where this is left out.

    Attributes
    ----------
    assembly : LinkAssembly
        The links in ground axes.
    energies : LinkEnergies
    shaft : Shaft
    drive_constraint : ItemNumber or None
        The constraint on the hub's angle, which carries the driving torque; None where the
        shaft is free.
    constraints : dict of str to list of ItemNumber
        Constraints of each joint, without what keeps clamps and welds from turning; of a tie also
        those of joints that depend on its following end.
    sliders : dict of str to SliderJoint
        By their joints.
    connectors : RunningConnectors
        Loads and springs.
    sprung : dict of str to ItemNumber
        The spring of each joint that springs alone hold.
    joints : ClosedJoints
        What the integration rule leaves to drift.
    frame : FrameBody or None
        The frame on springs that carries the linkage and the hub.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        elements: int,
        kind: str,
        drive: Drive,
        links: Sequence[LinkModel],
        duration: float,
        impacts: Sequence[Impact] = (),
        torque: TorqueTable | MotorOnHub | None = None,
    ) -> None:
        self.torque, self.drive, self.links = torque, drive, links
        self.assembly = assembly = LinkAssembly(mechanism, elements, kind, bodies_have_mass=True)
        self.energies = LinkEnergies(assembly, links)
        self._motor = torque if isinstance(torque, MotorOnHub) else None
        self.frame = FrameBody.of(mechanism, assembly.items, assembly.system_size)
        assembly.frame = self.frame
        self._start = mechanism.linkage.motion(drive.crank_angle(0.0))
        self.shaft = Shaft(
            float(self._start.angle[assembly.base]),
            float(drive.speed),
            _plain_pieces(drive),
            is_free=torque is not None,
        )
        add_running_loads(assembly, self.energies)
        SectionCouples(assembly, links).add(drive, self.shaft, duration)
        hub, self.drive_constraint = self._add_hub()
        clamps = assembly.topology.clamps
        self.constraints = {clamp.joint: [self._add_clamp(hub, clamp)] for clamp in clamps}
        pivots = add_pivots(assembly, self._start)
        self.constraints |= {joint: [pin] for joint, pin in pivots.items()}
        ties = {tie.tie.joint: tie for tie in add_ties(assembly, self._start.angle)}
        self._dependent_joints = {
            joint: dependent_joints(assembly.topology, tie.tie.follower)
            for joint, tie in ties.items()
        }
        for joint, tie in ties.items():
            others = [ties[name].position for name in self._dependent_joints[joint] if name in ties]
            self.constraints[joint] = [tie.position, *others]
        lines = add_sliders(assembly)
        self.sliders = {line.slider.joint: line for line in lines}
        self.constraints |= {joint: [line.constraint] for joint, line in self.sliders.items()}
        self.connectors = RunningConnectors(assembly, self._start, self.shaft, links)
        self.sprung = {
            item.spring.joint: item.radial
            for item in self.connectors.joints
            if item.radial is not None
        }
        add_impacts(assembly, drive, impacts)
        assembly.mbs.Assemble()
        self._gaps = joint_gaps(assembly, self._start, self.frame)
        self.joints = closed_joints(assembly, self.shaft, self._gaps, self.frame)

    def joint_force(
        self,
        multiplier: FloatArray,
        position: FloatArray,
        sprung: Mapping[str, FloatArray],
        frame_angle: FloatArray,
    ) -> FloatArray:
        """Force on the grounded or following link at each joint in ground axes.

        Parameters
        ----------
        multiplier : ndarray, shape (m, n_multipliers)
        position : ndarray, shape (m, size)
            Coordinates of the links.
        sprung : mapping of str to ndarray, shape (m, 2)
            Forces of the joints that springs alone hold, in axes of the frame, by their names.
        frame_angle : ndarray, shape (m,)
            By which the frame, on which lines of the ground are, has turned in rad.

        Returns
        -------
        ndarray, shape (m, n_joints, 2)
            In N.
        """
        names = self.assembly.topology.joint_names
        force = np.zeros((len(multiplier), len(names), 2))
        springs = {joint: turned(values, frame_angle) for joint, values in sprung.items()}
        for joint, values in springs.items():
            force[:, names.index(joint)] = values
        for joint, constraints in self.constraints.items():
            number = names.index(joint)
            rows = np.concatenate([self._multipliers(c) for c in constraints])
            if joint not in self.sliders:
                force[:, number] = -multiplier[:, rows].reshape(len(multiplier), -1, 2).sum(axis=1)
                continue
            slider = self.sliders[joint].slider
            angle = np.full(len(multiplier), slider.direction)
            if not slider.guide:
                angle += frame_angle
            else:
                guide = self.assembly.topology.index(slider.guide)
                angle += position[:, self.assembly.parts[guide].coordinates][:, 2]
            force[:, number] = multiplier[:, rows[:1]] * normal(angle)
        for joint, dependent in self._dependent_joints.items():
            for name in springs.keys() & dependent:
                force[:, names.index(joint)] += springs[name]
        return force

    def driving_torque(
        self, time: FloatArray, position: FloatArray, velocity: FloatArray, multiplier: FloatArray
    ) -> FloatArray:
        """Torque of the drive on the shaft at instants in N m, (m,).

        Parameters
        ----------
        time : ndarray, shape (m,)
        position, velocity : ndarray, shape (m, n)
        multiplier : ndarray, shape (m, n_multipliers)
        """
        if self.torque is not None:
            return self.torque.torque_at(time, *self.against_frame(position, velocity))
        assert self.drive_constraint is not None
        return -multiplier[:, self._multipliers(self.drive_constraint)[0]]

    def against_frame(
        self, position: FloatArray, velocity: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Coordinates (m, n) and their rates with the hub's rotation against its frame."""
        if self.frame is None:
            return position, velocity
        moved = self.frame.motion(position, velocity)
        pair = ((position, moved.displacement), (velocity, moved.rate))
        place, rate = (np.column_stack([q[:, :-1], q[:, -1] - f[:, 2]]) for q, f in pair)
        return place, rate

    def set_start(
        self, position: FloatArray, velocity: FloatArray, moved: FrameMotion | None = None
    ) -> tuple[FloatArray, FloatArray]:
        """Set the state of the system at time zero.

        Parameters
        ----------
        position, velocity : ndarray, shape (size,)
        moved : FrameMotion, optional
            Displacement of a frame on springs, arrays of shape (1, 3).

        Returns
        -------
        ndarray, shape (n,)
            Exudyn's coordinates: of links and attached bodies, of a frame on springs, of a motor,
            and of the hub, which come last.
        ndarray, shape (n,)
            Their rates.
        """
        nodes = self.assembly.nodes.to_nodes(position)
        velocity = self.assembly.nodes.rate_to_nodes(position, velocity)
        hub, turning, motor = np.zeros(3), np.zeros(3), (np.zeros(0), np.zeros(0))
        if self._motor is not None:
            motor = self._motor.start(self.shaft.angle(0.0))
        if self.frame is not None:
            assert moved is not None
            nodes = np.append(nodes, moved.displacement[0])
            velocity = np.append(velocity, moved.rate[0])
            pair = moved.displacement, moved.rate
            hub[:2], turning[:2] = self.frame.frame.point_motion(_AXIS, *pair)
            hub[2], turning[2] = moved.displacement[0, 2], moved.rate[0, 2]
        hub[2] += self.shaft.angle(0.0)
        turning[2] += self.shaft.motion(0.0)[1]
        coordinates = np.concatenate([nodes, motor[0], hub])
        rates = np.concatenate([velocity, motor[1], turning])
        initial = load_exudyn().ConfigurationType.Initial
        data = self.assembly.mbs.systemData
        data.SetODE2Coordinates(coordinates, initial)
        data.SetODE2Coordinates_t(rates, initial)
        return coordinates, rates

    def greatest_gap(self, position: FloatArray, moved: FrameMotion | None = None) -> float:
        """Greatest constraint violation of the joints at time zero.

        Parameters
        ----------
        position : ndarray, shape (size,)
            At time zero.
        moved : FrameMotion, optional
            Displacement of a frame on springs, arrays of shape (1, 3).

        Returns
        -------
        float
            In m; angles count by the length of the shortest link.
        """
        nodes = self.assembly.nodes.to_nodes(position)
        if moved is not None:
            nodes = np.append(nodes, moved.displacement[0])
        length = min(link.length for link in self.assembly.topology.links)
        turn = self.shaft.angle(0.0)
        return max(
            float(np.linalg.norm(gap.gap(nodes, turn)))
            * (length if isinstance(gap, AngleGap) else 1.0)
            for gap in self._gaps
        )

    def _add_hub(self) -> tuple[ItemNumber, ItemNumber | None]:
        """Body that turns with the shaft, and the constraint on its angle, if there is one.

        Without that it has the shaft's inertia, and a torque over time or a motor turns it.
        """
        assembly, items, torque = self.assembly, self.assembly.items, self.torque
        items.begin(
            "crank drive: a hub without mass, turned by the shaft"
            if torque is None
            else "crank drive: a free hub with the shaft's inertia, turned by a torque"
        )
        of_motor = torque.add_node(items) if isinstance(torque, MotorOnHub) else []
        node = items.add("NodeRigidBody2D", "hub_node")
        on_hub = items.add("MarkerNodeRigid", "hub_axis", nodeNumber=node)
        markers = [assembly.add_ground("hub_bearing", _AXIS), on_hub]
        items.add("RevoluteJoint2D", "hub_bearing", markerNumbers=markers)
        drive = None
        if torque is None:
            # The drive stands on the frame: it prescribes the angle against the frame.
            before = assembly.add_angle_marker(None, "frame_angle")
            drive = assembly.add_constraint("crank_drive", before, node, 2, **self._turning())
        inertia = 0.0 if torque is None else float(assembly.mechanism.shaft_inertia)
        hub = items.add("ObjectRigidBody2D", "hub", nodeNumber=node, mass=0.0, inertia=inertia)
        if isinstance(torque, MotorOnHub):
            below = None if self.frame is None else self.frame.node
            torque.add_object(items, of_motor, node, below)
        elif torque is not None:
            on = [("crank_drive", on_hub, 1.0)]
            if self.frame is not None:
                reaction = self.frame.add_marker(_AXIS, "crank_drive_on_frame")
                on.append(("crank_drive_reaction", reaction, -1.0))
            for name, marker, sign in on:
                rows = np.pad(sign * torque.torque[:, None], ((0, 0), (2, 0))).tolist()
                history = self.shaft, 0.0, "time", torque.time.tolist(), rows, True
                items.add(
                    "LoadTorqueVector",
                    name,
                    markerNumber=marker,
                    loadVector=[0.0, 0.0, 1.0],
                    loadVectorUserFunction=Made(load_history, history),
                )
        return hub, drive

    def _turning(self) -> dict[str, Any]:
        """Constraint on the hub's angle: a constant speed, or angle and speed of time."""
        if self.drive.is_constant:
            return {"velocityLevel": True, "offset": self.shaft.final_speed}
        return {
            "offsetUserFunction": self.shaft.constraint_angle,
            "offsetUserFunction_t": self.shaft.constraint_speed,
        }

    def _add_clamp(self, hub: ItemNumber, clamp: Clamp) -> ItemNumber:
        """Pin a clamped end to the hub and keep the link's axis there at its angle to it.

        Returns
        -------
        ItemNumber
            Number of the pin.
        """
        assembly, items = self.assembly, self.assembly.items
        name = f"clamp_{clamp.joint}"
        items.begin(f"clamp {clamp.joint}: the link's end on the hub, its axis parallel to it")
        lever = place_on_hub(assembly, self._start, clamp.link_end)
        on_hub = assembly.add_body_frame(hub, f"{name}_on_hub", *lever)
        on_link = assembly.add_end_marker(clamp.link_end, f"{name}_on_{clamp.link_end.link}")
        pin = items.add("RevoluteJoint2D", name, markerNumbers=[on_hub, on_link])
        link = assembly.topology.index(clamp.link_end.link)
        turn = float(self._start.angle[link] - self._start.angle[assembly.base])
        hold_axis(assembly, name, hub, clamp.link_end, turn)
        return pin

    def _multipliers(self, constraint: ItemNumber) -> list[int]:
        return list(self.assembly.mbs.systemData.GetObjectLTGAE(int(constraint)))


def _plain_pieces(drive: Drive) -> tuple[Any, ...]:
    """The pieces of a law as plain numbers, which an exported script holds, from the start on."""
    law, begin = drive.law, float(drive.crank_angle(0.0))
    spans, polynomials = np.diff(law.knots), law.polynomials.copy()
    polynomials[:, 0] -= begin
    sines = (tuple(tuple(sine) for sine in rows if sine[0]) for rows in law.sines.tolist())
    times = law.knots[:-1].tolist(), spans.tolist()
    return tuple(zip(*times, map(tuple, polynomials.tolist()), sines, strict=True))
