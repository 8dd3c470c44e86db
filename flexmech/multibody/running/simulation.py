"""The running linkage in Exudyn's implicit integrators, recorded at every step."""

from __future__ import annotations

import contextlib
import io
import sys
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.choices import Integrator, LinkDirection
from flexmech.errors import InputError
from flexmech.linear_system import LinkModel, LinkPoint, displacement_row
from flexmech.linkages import MotorRun, RigidMotion, Topology, carried_motion
from flexmech.multibody.items import Setting, applied, solver_settings
from flexmech.multibody.library import load_exudyn
from flexmech.multibody.link_parts import MovingFrames
from flexmech.multibody.running.connectors import SectionCouples
from flexmech.multibody.running.model import RunningModel
from flexmech.time_domain import (
    FrameMotion,
    LinkState,
    Recorder,
    ShaftMotion,
    StepBlock,
    UnbalancedStepError,
)

# How far a start may tear a joint apart, relative to the length of all links: above what a reduced
# start leaves, 1e-9, and below the deflections of any run.
START_GAP = 1e-6

# Steps that are handed to the recorder at once. Memory alone.
BLOCK_STEPS = 2000
# Steps between reports of progress, a tenth of a second of work.
PROGRESS_STEPS = 100


class PointRecorder:
    """Displacements of points of links at every step, without energies and forces.

    Parameters
    ----------
    topology : Topology
    links : sequence of LinkModel
        Unreduced.
    points : sequence of (LinkPoint, {"transverse", "axial"})

    Raises
    ------
    InputError
        If a point is on no link.
    """

    def __init__(
        self,
        topology: Topology,
        links: Sequence[LinkModel],
        points: Sequence[tuple[LinkPoint, LinkDirection]],
    ) -> None:
        self._rows = []
        for point, direction in points:
            link = point.index(topology)
            self._rows.append((link, displacement_row(links[link], point.fraction, direction)))
        self._parts: list[FloatArray] = []

    def add(self, displacement: Sequence[FloatArray]) -> None:
        """Take the links' displacements (m, n_link) of the next steps.

        The first one repeats the last step of the block before.
        """
        moved = np.stack([displacement[link] @ row for link, row in self._rows], axis=1)
        self._parts.append(moved[1:] if self._parts else moved)

    def finish(self) -> FloatArray:
        """Displacements at all steps in m, shape (steps + 1, n_points)."""
        return np.concatenate(self._parts)


class Simulation:
    """One run of a mechanism from time zero.

    Parameters
    ----------
    model : RunningModel
    step : float
        Time step in s.
    steps : int
        Number of steps.
    integrator : {"generalized-alpha", "trapezoidal"}
    """

    def __init__(
        self, model: RunningModel, step: float, steps: int, integrator: Integrator
    ) -> None:
        self.model, self.integrator = model, integrator
        self.step, self.steps = step, steps
        self._frames = MovingFrames(model.assembly.parts)
        self._couples = SectionCouples(model.assembly, model.links)

    def run(
        self,
        start: LinkState,
        recorder: Recorder | PointRecorder,
        progress: Callable[[int, int], None] | None = None,
    ) -> None:
        """Integrate and pass every step to a recorder.

        Parameters
        ----------
        start : LinkState
        recorder : Recorder | PointRecorder
        progress : callable, optional
            Called with the steps done and their total, every hundred steps.

        Raises
        ------
        InputError
            If the start does not keep the joints together.
        UnbalancedStepError
            If a step does not converge; names its time and the crank angle.
        """
        self.set_start(start)
        steps = _Steps(self, recorder, progress)
        self.model.assembly.mbs.SetPostStepUserFunction(steps.take)
        settings = applied(self.settings())
        exudyn = load_exudyn()
        refused = False
        with contextlib.redirect_stdout(io.StringIO()):
            try:
                self.model.assembly.mbs.SolveDynamic(settings)
            except (exudyn.SolverError, exudyn.InternalError):  # the latter if values overflow
                refused = True
        if steps.failure is not None:
            raise steps.failure
        steps.hand_over()
        if refused or steps.last < self.steps:
            raise self._failure(steps.last + 1)

    @property
    def drifts(self) -> bool:
        """Whether velocity constraints alone let the clamp and pins on arms drift."""
        return self.integrator == "trapezoidal"

    def displacement(self, time: FloatArray, position: FloatArray) -> list[FloatArray]:
        """Displacements of links, each (m, n_link), in the frames of the prescribed motion.

        Parameters
        ----------
        time : ndarray, shape (m,)
        position : ndarray, shape (m, total_size)
            Exudyn's coordinates.

        Returns
        -------
        list of ndarray
        """
        assembly = self.model.assembly
        position = assembly.nodes.to_axis(position[:, : assembly.size])
        return self._frames.to_frames(self._motion(time), position, np.zeros_like(position))[0]

    def block(
        self, time: FloatArray, position: FloatArray, velocity: FloatArray, multiplier: FloatArray
    ) -> StepBlock:
        """Physical quantities of consecutive steps.

        Parameters
        ----------
        time : ndarray, shape (m,)
        position, velocity : ndarray, shape (m, total_size)
            Exudyn's coordinates.
        multiplier : ndarray, shape (m, n_multipliers)

        Returns
        -------
        StepBlock
        """
        assembly, energies = self.model.assembly, self.model.energies
        shaft = self._shaft_motion(time, position, velocity)
        torque = self.model.driving_torque(time, position, velocity, multiplier)
        motion = self._motion(time) if shaft is None else self._displaced_motion(time, shaft)
        frame = self._frame_motion(position, velocity)
        carried, turn = motion, np.zeros(len(time))
        if frame is not None:
            carried = self._carried(motion, frame)
            turn = frame.displacement[:, 2]
        links = slice(0, assembly.size)
        position, velocity = position[:, links], velocity[:, links]
        position, velocity = (
            assembly.nodes.to_axis(position),
            assembly.nodes.rate_to_axis(position, velocity),
        )
        displacement, rate = self._frames.to_frames(carried, position, velocity)
        kinetic, strain, gravity, dissipation = np.zeros((4, len(time)))
        for number, part in enumerate(assembly.parts):
            own = part.coordinates
            kinetic += energies.kinetic(number, position[:, own], velocity[:, own])
            gravity += energies.gravity(number, position[:, own])
        for number, beam in assembly.beams:
            moved, speed = displacement[number], rate[number]
            if (mapped := beam.node_map) is not None:
                moved, speed = mapped.to_nodes(moved), mapped.rate_to_nodes(moved, speed)
            for part_of in beam.kind.strains(moved, speed, np.diff(beam.positions), beam.section):
                strain += part_of.energy
                dissipation += part_of.dissipation
        if shaft is not None:
            inertia = assembly.mechanism.shaft_inertia
            kinetic += inertia * motion.crank_speed**2 / 2
        work = self.model.connectors.work(time, motion, displacement, rate, carried)
        sprung = self.model.connectors.joint_forces(motion, displacement, rate)
        strain += work.stored
        dissipation += work.dissipation
        turning, power = self._couples.energy_and_power(
            self._motion(time), carried, displacement, rate
        )
        block = StepBlock(
            time=time,
            crank_speed=motion.crank_speed,
            displacement=displacement,
            rate=rate,
            joint_force=self.model.joint_force(multiplier, position, sprung, turn),
            driving_torque=torque,
            kinetic_energy=kinetic + turning,
            strain_energy=strain,
            gravity_energy=gravity,
            dissipation_power=dissipation,
            prestress_power=work.power + power,
            shaft=shaft,
        )
        body, weight = self.model.frame, assembly.mechanism.gravity
        return block if body is None or frame is None else body.added(block, frame, weight)

    def _frame_motion(self, position: FloatArray, velocity: FloatArray) -> FrameMotion | None:
        """Motion of a frame on springs; None of one that stands."""
        frame = self.model.frame
        return None if frame is None else frame.motion(position, velocity)

    def _carried(self, motion: RigidMotion, moved: FrameMotion) -> RigidMotion:
        """Motion of the rigid linkage on its frame, whose acceleration does not count here."""
        assert self.model.frame is not None
        centre = self.model.frame.frame.centre
        return carried_motion(centre, motion, moved.displacement, moved.rate)

    def _shaft_motion(
        self, time: FloatArray, position: FloatArray, velocity: FloatArray
    ) -> ShaftMotion | None:
        """Rotation of a free shaft against its prescribed angle; None of a prescribed one."""
        shaft = self.model.shaft
        if not shaft.is_free:
            return None
        mean = np.array([shaft.motion(t) for t in time.tolist()])
        return ShaftMotion(position[:, -1] - mean[:, 0], velocity[:, -1] - mean[:, 1])

    def _displaced_motion(self, time: FloatArray, shaft: ShaftMotion) -> RigidMotion:
        """Motion of the rigid linkage with a free shaft; a state needs no acceleration."""
        mean, linkage = self._motion(time), self.model.assembly.mechanism.linkage
        return linkage.motion(mean.crank_angle + shaft.rotation, mean.crank_speed + shaft.rate)

    def _motion(self, time: FloatArray) -> RigidMotion:
        return self.model.drive.motion(self.model.assembly.mechanism.linkage, time)

    def set_start(self, start: LinkState) -> tuple[FloatArray, FloatArray]:
        """Set the state of the system at time zero.

        Parameters
        ----------
        start : LinkState

        Returns
        -------
        ndarray, shape (total_size,)
            Exudyn's coordinates.
        ndarray, shape (total_size,)
            Their rates.

        Raises
        ------
        InputError
            If the start does not keep the joints together.
        """
        batch = [[values[None] for values in part] for part in (start.displacement, start.rate)]
        motion, moved = self._motion(np.zeros(1)), None
        if self.model.frame is not None:
            moved = start.moved
            motion = self._carried(motion, moved)
        position, velocity = self._frames.to_absolute(motion, *batch)
        gap = self.model.greatest_gap(position[0], moved)
        allowed = START_GAP * sum(link.length for link in self.model.assembly.topology.links)
        if gap > allowed:
            raise InputError(
                f"the start displaces link ends that a joint holds by {gap:.3g} m (at most "
                f"{allowed:.3g} m); take a start whose displacements agree at the joints"
            )
        return self.model.set_start(position[0], velocity[0], moved)

    def settings(self) -> dict[str, Setting]:
        """Settings of the solver, by their paths in ``exudyn.SimulationSettings``."""
        return solver_settings(
            self.step, self.steps, self.integrator, self.model.assembly.nodal_force_scale
        )

    def _failure(self, number: int) -> UnbalancedStepError:
        """Error for a step that did not converge."""
        residual = float(self.model.assembly.mbs.sys["dynamicSolver"].conv.residual)
        cause = f"Newton's method does not converge (residual {residual:.3g} N)"
        if not np.isfinite(residual):
            cause = "the values are not finite"
        return _step_error(self, number, cause)


class _Steps:
    """Copies every step into a block and hands full blocks to the recorder."""

    def __init__(
        self,
        simulation: Simulation,
        recorder: Recorder | PointRecorder,
        progress: Callable[[int, int], None] | None,
    ) -> None:
        self.failure: BaseException | None = None
        self._simulation = simulation
        self._recorder = recorder
        self._progress = progress
        self._out = sys.stdout
        self._first = self._count = 0
        size = simulation.model.total_size
        multipliers = simulation.model.multiplier_count
        # Exudyn's own time, the sum of its steps, at which the shaft's angle is prescribed.
        self._time: FloatArray = np.empty(BLOCK_STEPS)
        self._position: FloatArray = np.empty((BLOCK_STEPS, size))
        self._velocity: FloatArray = np.empty((BLOCK_STEPS, size))
        self._multiplier: FloatArray = np.empty((BLOCK_STEPS, multipliers))

    @property
    def last(self) -> int:
        """Number of the last step taken; 0 is the start."""
        return self._first + self._count - 1

    def take(self, mbs: Any, time: float) -> bool:
        """Exudyn's user function after the start and after every step; false stops it.

        An exception must not pass through Exudyn, which would turn it into one of its own.
        """
        try:
            self._copy(mbs.systemData, time)
            if self._count == BLOCK_STEPS:
                self.hand_over()
            if self._progress is not None and self.last % PROGRESS_STEPS == 0:
                with contextlib.redirect_stdout(self._out):
                    self._progress(self.last, self._simulation.steps)
        except BaseException as failure:
            self.failure = failure
            return False
        return True

    def hand_over(self) -> None:
        """Give the block to the recorder; its last step becomes the first of the next."""
        count = self._count
        if count < 2:
            return
        blocks = (self._time, self._position, self._velocity, self._multiplier)
        time, position, velocity, multiplier = (values[:count].copy() for values in blocks)
        finite = np.isfinite([position.sum(1), velocity.sum(1), multiplier.sum(1)]).all(axis=0)
        if not finite.all():
            first_bad = self._first + int(np.argmin(finite))
            raise _step_error(self._simulation, first_bad, "the values are not finite")
        if isinstance(self._recorder, PointRecorder):
            self._recorder.add(self._simulation.displacement(time, position))
        else:
            block = self._simulation.block(time, position, velocity, multiplier)
            if block.shaft is not None and not isinstance(self._simulation.model.drive, MotorRun):
                block.shaft.refuse_runaway(self._simulation.model.drive, time)
            self._recorder.add(block)
        for values in blocks:
            values[0] = values[count - 1]
        self._first, self._count = self._first + count - 1, 1

    def _copy(self, data: Any, time: float) -> None:
        row = self._count
        position = data.GetODE2Coordinates()
        if self._simulation.drifts:
            self._simulation.model.joints.correct_coordinates(position, time)
            data.SetODE2Coordinates(position)
        self._time[row] = time
        self._position[row] = position
        self._velocity[row] = data.GetODE2Coordinates_t()
        self._multiplier[row] = data.GetAECoordinates()
        self._count += 1


def _step_error(simulation: Simulation, number: int, cause: str) -> UnbalancedStepError:
    time = number * simulation.step
    angle = float(np.degrees(simulation.model.drive.crank_angle(time)))
    return UnbalancedStepError(
        f"the simulation stops at {time:.6g} s, crank angle {angle:.6g} deg: {cause}; take a "
        f"step smaller than {simulation.step:.3g} s or a lower crank speed"
    )
