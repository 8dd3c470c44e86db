"""Joint forces, torque and energies of a linkage by its linear equations of motion.

Everything is that of the model whose equations are integrated: velocities and accelerations
of the points of each link are exact for small displacements in rotating frames, so that the
work of the shaft's torque is the change of kinetic and strain energy plus the dissipated energy, up
to the error of the time step.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flexmech.arrays import ComplexArray, FloatArray, row_products
from flexmech.dynamical_systems import VibrationState
from flexmech.linear_system import COORDINATES, CarriedLinkage, LinkInertia, MovingLink
from flexmech.linkages import RigidMotion, Topology, carried_motion, turned
from flexmech.linkages.connection_forces import (
    connection_matrix,
    connection_vectors,
    connections,
    solve_connections,
)
from flexmech.linkages.motion import direction, normal
from flexmech.time_domain.equations_of_motion.driven_connectors import LinkMotion
from flexmech.time_domain.equations_of_motion.driven_linkage import DrivenLinkage, StaticExpansion
from flexmech.time_domain.recorded_runs.recording import StepBlock
from flexmech.time_domain.recorded_runs.states import FrameMotion


class LinkageDynamics:
    """Joint forces, driving torque and energies of a driven linkage.

    Parameters
    ----------
    linkage : DrivenLinkage
    """

    def __init__(self, linkage: DrivenLinkage) -> None:
        self.linkage = linkage
        self._inertias = [
            LinkInertia.of(model, full, basis)
            for model, full, basis in zip(
                linkage.links, linkage.unreduced, linkage.run_bases, strict=True
            )
        ]
        both = np.array([0.0, 1.0])
        self._ends = [
            np.array([1, 1j]) @ link.readings.displacement_at(both) for link in linkage.links
        ]

    def step_block(
        self, time: FloatArray, expansion: StaticExpansion, vibration: VibrationState
    ) -> StepBlock:
        """Records of consecutive time steps.

        Parameters
        ----------
        time : ndarray, shape (m,)
        expansion : StaticExpansion
            At these times.
        vibration : VibrationState
            Arrays of shape (m, n).

        Returns
        -------
        StepBlock
            In the reduced links' coordinates.
        """
        linkage, motion = self.linkage, self.linkage.motion(time)
        frames, gravity = linkage.frames, np.asarray(linkage.engine.mechanism.gravity)
        coordinates = expansion.expanded(vibration)
        elastic = frames.link_motion(motion, *coordinates)
        unit = linkage.engine.mechanism.linkage.motion(motion.crank_angle, 1.0)
        # In ground axes, if a frame on springs carries the linkage.
        whole, turning_alone = motion, unit
        if linkage.carried is not None:
            places = tuple(part[:, -COORDINATES:] for part in coordinates)
            centre = linkage.carried.frame.centre
            whole = carried_motion(centre, motion, *places)
            turning_alone = carried_motion(centre, unit, places[0], np.zeros_like(places[0]))
        moving = [
            MovingLink.of(number, parts, whole, turning_alone, gravity)
            for number, parts in enumerate(elastic)
        ]
        # How dependent ends move in their link's frame at constant z.
        unit_rates = frames.dependent_rows(unit)
        totals = np.zeros((6, len(time)))
        ends, fields, moments = [], [], []
        acting = linkage.connectors.acting(time, motion, elastic, unit, coordinates[0], whole)
        pushed_shapes, pushed_fields, pushed_power, work = acting
        for number, (inertia, link, stress) in enumerate(
            zip(self._inertias, moving, linkage.stress.at(time), strict=True)
        ):
            damping = stress.damping_force(link.rate)
            inner, strain, prestress = stress.of(link.displacement)
            if linkage.stretch is not None:
                second = linkage.stretch.links[number]
                pulled, damped = second.nonlinear_forces(link.displacement, link.rate)
                inner, damping = inner + pulled, damping + damped
                strain = strain + second.energy(link.displacement)
            shapes = inertia.shape_forces(link) + inner + damping
            rigid = inertia.field_forces(link)
            ends.append(shapes - pushed_shapes[number])
            fields.append(rigid - pushed_fields[number])
            turning = inertia.turning_power(link)
            moments.append(fields[-1][:, 2] + turning)
            # Virtual power at unit crank speed: the rigid link, its pins' displacements as
            # they turn, and the rest of its displacement as it turns with the frame.
            torque = row_products(link.virtual_velocity, rigid) + link.virtual_turn * turning
            for end in unit_rates[number]:
                turned = (end.rate @ coordinates[0][:, end.columns, None])[..., 0]
                torque += row_products(turned, shapes[:, end.rows])
            weight = inertia.gravity_energy(
                whole.origin[:, number], whole.angle[:, number], link.displacement, gravity
            )
            totals += np.stack(
                [
                    torque,
                    inertia.kinetic_energy(link),
                    strain,
                    weight,
                    row_products(link.rate, damping),
                    prestress,
                ]
            )
        torque, kinetic, strain, weight, dissipated, prestress = totals
        if linkage.stretch is not None:
            torque = torque + linkage.stretch.virtual_power(motion, unit, *coordinates[:2])
        block = StepBlock(
            time=time,
            crank_speed=motion.crank_speed,
            displacement=[q for q, _, _ in elastic],
            rate=[rate for _, rate, _ in elastic],
            joint_force=self._joint_forces(motion, elastic, ends, fields, moments),
            driving_torque=torque - pushed_power,
            kinetic_energy=kinetic,
            strain_energy=strain + work.stored,
            gravity_energy=weight,
            dissipation_power=dissipated + work.dissipation,
            prestress_power=prestress + work.power,
        )
        if linkage.carried is not None:
            block = _on_its_frame(block, linkage.carried, places[0], places[1])
        if linkage.shaft is None:
            return block
        at = linkage.rotor_coordinate
        rotor = [] if linkage.rotor is None else [part[:, at] for part in coordinates[:2]]
        return linkage.shaft.carried(block, motion, rotor)

    def _joint_forces(
        self,
        motion: RigidMotion,
        elastic: LinkMotion,
        ends: list[FloatArray],
        fields: list[FloatArray],
        moments: list[FloatArray],
    ) -> FloatArray:
        """Force on the grounded or following link at each joint in ground axes, (m, joints, 2).

        The force of a pin balances its follower's end; that of a clamp or pivot balances its
        link as a whole. Where there are welds, lines or rigid links, the forces of all joints
        balance all links, displaced as they are.
        """
        topology = self.linkage.engine.mechanism.linkage.topology
        needed = [_to_ground(f[:, :2], motion.angle[:, i]) for i, f in enumerate(fields)]
        if topology.welds or topology.sliders or any(link.rigid for link in topology.links):
            whole = [np.column_stack(pair) for pair in zip(needed, moments, strict=True)]
            moved = [q @ own.T for own, (q, _, _) in zip(self._ends, elastic, strict=True)]
            displaced = np.stack(moved, axis=1) * np.exp(1j * motion.angle[..., None])
            return _balanced_forces(topology, motion, np.concatenate(whole, axis=1), displaced)
        forces = {}
        for pin in topology.pins:
            link = topology.index(pin.follower.link)
            pair = self.linkage.links[link].end_displacement(pin.follower.end)
            force = _to_ground(ends[link][:, pair], motion.angle[:, link])
            forces[pin.joint] = force
            needed[link] = needed[link] - force
            leader = topology.index(pin.leader.link)
            needed[leader] = needed[leader] + force
        grounded = [(clamp.joint, clamp.link_end) for clamp in topology.clamps]
        grounded += [(pivot.joint, pivot.link_end) for pivot in topology.pivots]
        for joint, end in grounded:
            forces[joint] = needed[topology.index(end.link)]
        return np.stack([forces[name] for name in topology.joint_names], axis=1)


def _on_its_frame(
    block: StepBlock, carried: CarriedLinkage, place: FloatArray, rate: FloatArray
) -> StepBlock:
    """Records with the motion (m, 3) of the frame and its energies, and forces in ground axes."""
    frame = carried.frame
    weight = -(np.asarray(frame.centre) + place[:, :2]) @ np.asarray(carried.gravity)
    return replace(
        block,
        joint_force=turned(block.joint_force, place[:, 2, None]),
        kinetic_energy=block.kinetic_energy + row_products(rate, rate @ frame.inertia_matrix) / 2,
        strain_energy=block.strain_energy + row_products(place, place @ frame.stiffness) / 2,
        gravity_energy=block.gravity_energy + frame.mass * weight,
        dissipation_power=block.dissipation_power + row_products(rate, rate @ frame.damping),
        frame=FrameMotion(place, rate),
    )


def _balanced_forces(
    topology: Topology, motion: RigidMotion, needed: FloatArray, displaced: ComplexArray
) -> FloatArray:
    """Joint forces (m, joints, 2) from force and moment balance of all displaced links."""
    matrix = connection_matrix(topology, motion, displaced)
    solved = solve_connections(topology, motion, -needed, matrix)
    vectors = solved[..., None] * connection_vectors(topology, matrix)
    forces = np.zeros((len(solved), len(topology.joint_names), 2))
    for number, unknown in enumerate(connections(topology)):
        forces[:, topology.joint_names.index(unknown.joint)] += vectors[:, number]
    return forces


def _to_ground(vector: FloatArray, angle: FloatArray) -> FloatArray:
    """Vectors (m, 2) from a link's frame to ground axes."""
    return vector[:, :1] * direction(angle) + vector[:, 1:] * normal(angle)
