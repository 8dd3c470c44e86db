"""Runs of a driven linkage in time from a given start.

Linear equations are integrated by the trapezoidal rule, those of links that stretch by the
square of their slopes by Lobatto's method of fourth order: what a step of them costs is spent
on the forces that are not linear, of which longer steps ask for fewer. Runs with large
displacements are those of an engine that simulates.

Joint forces, torque and energies are those of the model whose equations are integrated: velocities
and accelerations of the points of each link are exact for small displacements in rotating frames,
so that the work of the shaft's torque is the change of kinetic and strain energy plus the
dissipated energy, up to the error of the time step.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Protocol, cast

import numpy as np

from flexmech.arrays import ComplexArray, FloatArray, StepProgress, row_products
from flexmech.choices import Integrator, LinkDirection
from flexmech.dynamical_systems import VibrationState, initial_state
from flexmech.dynamical_systems.lobatto import STAGES
from flexmech.errors import ComputationError, InputError
from flexmech.linkages import Drive, RigidMotion, Topology, carried_motion, turned
from flexmech.linkages.inverse_dynamics import (
    connection_matrix,
    connection_vectors,
    connections,
    solve_connections,
)
from flexmech.linkages.motion import direction, normal
from flexmech.mechanics import (
    COORDINATES,
    CarriedLinkage,
    Engine,
    LinkInertia,
    LinkPoint,
    MovingLink,
)
from flexmech.mechanics.running.driven_connectors import LinkMotion
from flexmech.mechanics.running.driven_linkage import DrivenLinkage, StaticExpansion
from flexmech.mechanics.running.recorded_run import (
    FrameMotion,
    Impact,
    LinkState,
    Recorder,
    StepBlock,
    Trajectory,
)
from flexmech.solvers.march import LinearMarch, StretchMarch


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
            places = tuple(values[:, -COORDINATES:] for values in coordinates)
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
        stresses = zip(linkage.stress.at(time), linkage.stress.rate(time), strict=True)
        for number, (inertia, link, (stress, changing)) in enumerate(
            zip(self._inertias, moving, stresses, strict=True)
        ):
            damping = stress.damping_force(link.rate)
            inner, strain = stress.force(link.displacement), stress.potential(link.displacement)
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
            ends_of_link = unit_rates[number]
            turned = (ends_of_link.rate @ coordinates[0][:, ends_of_link.columns, None])[..., 0]
            torque += row_products(turned, shapes[:, ends_of_link.rows])
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
                    changing.potential(link.displacement),
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
        rotor = [] if linkage.rotor is None else [values[:, at] for values in coordinates[:2]]
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
            moved = [q @ rows.T for rows, (q, _, _) in zip(self._ends, elastic, strict=True)]
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


# Steps that are recorded at once. Speed and memory alone: to record a block takes about ten
# milliseconds besides its steps, and some 20 MB of a four-bar's matrices and forces.
BLOCK_STEPS = 2048
# Displacements beyond this many metres are no small vibration of any linkage.
DIVERGED = 1e6


def marching(linkage: DrivenLinkage, step: float) -> LinearMarch | StretchMarch:
    """Time integration method for a linkage.

    Parameters
    ----------
    linkage : DrivenLinkage
    step : float
        Between recorded instants, in s.

    Returns
    -------
    LinearMarch or StretchMarch
    """
    if linkage.stretch is None:
        return LinearMarch(linkage, step)
    return StretchMarch(linkage, step)


def step_lag(angle: float, *, stretches: bool) -> float:
    """Relative period error: lowering of a free vibration's frequency, to leading order.

    Parameters
    ----------
    angle : float
        Angle of the vibration in one step, in rad.
    stretches : bool
        Whether the method is that of links that stretch.

    Returns
    -------
    float
    """
    return float((STAGES * angle) ** 4 / 720 if stretches else angle**2 / 12)


def linear_run(
    linkage: DrivenLinkage,
    position: FloatArray,
    velocity: FloatArray,
    sample_time: FloatArray,
    step: float,
    progress: StepProgress | None = None,
    *,
    band: float | None = None,
) -> Trajectory:
    """Integrate the equations of motion by the method of :func:`marching`.

    Parameters
    ----------
    linkage : DrivenLinkage
    position, velocity : ndarray, shape (n,)
        Independent coordinates at time zero and their time derivatives.
    sample_time : ndarray, shape (N,)
        Increasing from zero or later, in s.
    step : float
        In s.
    progress : callable, optional
        Called with the steps done and the steps to do.
    band : float, optional
        Frequency in Hz up to which joint forces and torque are kept.

    Returns
    -------
    Trajectory

    Raises
    ------
    ComputationError
        If displacements grow beyond all bounds; names the time and the crank angle.
    """
    march, dynamics = marching(linkage, step), LinkageDynamics(linkage)
    recorder = Recorder(sample_time, step, band, march.stride)
    steps = march.stride * -(-recorder.steps // march.stride)
    start = position, velocity
    for done, time, history, expansion in _blocks(linkage, march, start, step, steps):
        recorder.add(dynamics.step_block(time, expansion, history))
        if progress is not None:
            progress(done, steps)
    run = recorder.finish()
    run = replace(
        run,
        displacement=[q @ b.T for q, b in zip(run.displacement, linkage.bases, strict=True)],
        rate=[q @ b.T for q, b in zip(run.rate, linkage.bases, strict=True)],
    )
    return run if linkage.shaft is None else linkage.shaft.turned_back(run)


def end_state(
    linkage: DrivenLinkage, position: FloatArray, velocity: FloatArray, end: float, steps: int
) -> LinkState:
    """State of the engine's links at the end of a run, of which nothing else is kept.

    Parameters
    ----------
    linkage : DrivenLinkage
    position, velocity : ndarray, shape (n,)
        Independent coordinates at time zero and their time derivatives.
    end : float
        In s.
    steps : int
        At least: a method may take its steps in groups.

    Returns
    -------
    LinkState

    Raises
    ------
    ComputationError
        If displacements grow beyond all bounds; names the time and the crank angle.
    """
    stride = (LinearMarch if linkage.stretch is None else StretchMarch).stride
    steps = stride * -(-steps // stride)
    march = marching(linkage, end / steps)
    *_, (*_, history, _) = _blocks(linkage, march, (position, velocity), end / steps, steps)
    return linkage.link_state(linkage.equations(np.array([end])), history[-1:])


def _blocks(
    linkage: DrivenLinkage,
    march: LinearMarch | StretchMarch,
    start: tuple[FloatArray, FloatArray],
    step: float,
    steps: int,
) -> Iterator[tuple[int, FloatArray, VibrationState, StaticExpansion]]:
    """Run from a position and velocity, block by block; each begins where the last one ends.

    Yields
    ------
    int
        Steps done.
    ndarray, shape (m,)
        Times of the block in s.
    VibrationState
        Arrays of shape (m, n).
    StaticExpansion

    Raises
    ------
    ComputationError
        If displacements grow beyond all bounds; names the time and the crank angle.
    """
    equations = linkage.equations(np.zeros(1))
    if linkage.stretch is not None:
        moving = [values[None] for values in start]
        pulled = linkage.stretch.nonlinear_forces(equations.motion, *moving)
        equations = replace(equations, force=equations.force - pulled)
    state = initial_state(equations, *start)
    for first in range(0, steps, BLOCK_STEPS):
        done = min(first + BLOCK_STEPS, steps)
        time = step * np.arange(first, done + 1, dtype=float)
        with np.errstate(over="ignore", invalid="ignore"):
            history, expansion = march.advance(time, state)
        _refuse_divergence(linkage, time, history)
        yield done, time, history, expansion
        state = history[-1]


def _refuse_divergence(linkage: DrivenLinkage, time: FloatArray, history: VibrationState) -> None:
    """Refuse displacements that grow beyond all bounds."""
    size = np.abs(history.position).max(axis=1)
    wrong = ~(size < DIVERGED)
    if not wrong.any():
        return
    first = float(time[np.flatnonzero(wrong)[0]])
    angle = np.degrees(float(linkage.drive.crank_angle(first)))
    raise ComputationError(
        f"the linear response (prestress '{linkage.prestress}') diverges: at time {first:.6g} s, "
        f"crank angle {angle:.6g} deg, displacements exceed any linkage; the linearized motion "
        "is unstable at this crank speed: lower it, or add the prestress that stiffens the links"
    )


class Simulator(Protocol):
    """An engine that runs the linkage with large displacements."""

    def simulate(
        self,
        drive: Drive,
        start: LinkState,
        sample_time: FloatArray,
        step: float,
        *,
        integrator: Integrator = "trapezoidal",
        progress: StepProgress | None = None,
        band: float | None = None,
        impacts: Sequence[Impact] = (),
    ) -> Trajectory:
        """Run from a state of the links.

        Parameters
        ----------
        drive : Drive
        start : LinkState
            State at time zero.
        sample_time : ndarray, shape (N,)
            Increasing, zero or later, in s.
        step : float
            Time step in s.
        integrator : {"trapezoidal", "generalized-alpha"}
        progress : callable, optional
            Called with the steps done and the steps to do.
        band : float, optional
            Frequency in Hz up to which joint forces and torque are kept.
        impacts : sequence of Impact
            Pulses on points of links, whose work the energy balance does not know.

        Returns
        -------
        Trajectory

        Raises
        ------
        ComputationError
            If a step does not converge; names its time and the crank angle.
        """

    def point_histories(
        self,
        drive: Drive,
        start: LinkState,
        points: Sequence[tuple[LinkPoint, LinkDirection]],
        step: float,
        steps: int,
        *,
        impacts: Sequence[Impact] = (),
        progress: StepProgress | None = None,
    ) -> FloatArray:
        """Displacement of points of links at every step of the trapezoidal rule.

        Parameters
        ----------
        drive : Drive
        start : LinkState
            State at time zero.
        points : sequence of (LinkPoint, {"transverse", "axial"})
        step : float
            In s.
        steps : int
        impacts : sequence of Impact
        progress : callable, optional
            Called with the steps done and the steps to do.

        Returns
        -------
        ndarray, shape (steps + 1, n_points)
            In m, in the frames of the rigid links.
        """


def simulator(engine: Engine) -> Simulator:
    """An engine that simulates; others are refused."""
    if not engine.simulates:
        raise InputError(
            f"the {engine.name} engine does not simulate the running linkage with large "
            "displacements; use the exudyn engine"
        )
    return cast(Simulator, engine)
