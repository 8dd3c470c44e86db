"""The running linkage in Exudyn's implicit integrators, recorded at every step."""

from __future__ import annotations

import contextlib
import io
import math
import sys
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.choices import Integrator, LinkDirection
from flexmech.errors import InputError
from flexmech.linkages import MotorRun, RigidMotion, Topology, carried_motion
from flexmech.mechanics import LinkModel, LinkPoint, displacement_row
from flexmech.mechanics.running import FrameMotion, LinkState, Recorder, ShaftMotion, StepBlock
from flexmech.multibody.assembly import FrameBody
from flexmech.multibody.items import Setting, applied, load_exudyn, solver_settings
from flexmech.multibody.running.loads import MotorOnHub, SectionCouples
from flexmech.multibody.running.model import RunningModel
from flexmech.solvers import UnbalancedStepError

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
        numbers = [point.index(topology) for point, _ in points]
        self._rows = [
            (number, displacement_row(links[number], point.fraction, direction))
            for number, (point, direction) in zip(numbers, points, strict=True)
        ]
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
        self._couples = SectionCouples(model.assembly, model.links)
        # Number of the first step kept. Kept are Exudyn's own time, the sum of its steps, at which
        # the shaft's angle is prescribed, its coordinates, their rates and the multipliers.
        self._first = 0
        self._rows: list[tuple[float, FloatArray, FloatArray, FloatArray]] = []

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
        system, exudyn, out = self.model.assembly.mbs, load_exudyn(), sys.stdout
        failures: list[BaseException] = []

        def take(mbs: Any, time: float) -> bool:
            """Keep the start, or a step; false stops the run.

            An exception must not pass through Exudyn, which would turn it into one of its own.
            """
            try:
                self._keep(mbs.systemData, time)
                if len(self._rows) == BLOCK_STEPS:
                    self._hand_over(recorder)
                if progress is not None and self._last % PROGRESS_STEPS == 0:
                    with contextlib.redirect_stdout(out):
                        progress(self._last, self.steps)
            except BaseException as failure:
                failures.append(failure)
                return False
            return True

        system.SetPostStepUserFunction(take)
        refused = False
        with contextlib.redirect_stdout(io.StringIO()):
            try:
                system.SolveDynamic(applied(self.settings()))
            except (exudyn.SolverError, exudyn.InternalError):  # the latter if values overflow
                refused = True
        if failures:
            raise failures[0]
        self._hand_over(recorder)
        if refused or self._last < self.steps:
            residual = float(system.sys["dynamicSolver"].conv.residual)
            raise self._error_of_step(self._last + 1, residual)

    @property
    def drifts(self) -> bool:
        """Whether velocity constraints alone let the clamp and pins on arms drift."""
        return self.integrator == "trapezoidal"

    def displacement(self, time: FloatArray, position: FloatArray) -> list[FloatArray]:
        """Displacements of links, each (m, n_link), in the frames of the prescribed motion.

        Parameters
        ----------
        time : ndarray, shape (m,)
        position : ndarray, shape (m, n)
            Exudyn's coordinates.

        Returns
        -------
        list of ndarray
        """
        assembly = self.model.assembly
        position = assembly.nodes.to_axis(position[:, : assembly.size])
        return assembly.in_link_frames(self._motion(time), position, np.zeros_like(position))[0]

    def block(
        self, time: FloatArray, position: FloatArray, velocity: FloatArray, multiplier: FloatArray
    ) -> StepBlock:
        """Physical quantities of consecutive steps.

        Parameters
        ----------
        time : ndarray, shape (m,)
        position, velocity : ndarray, shape (m, n)
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
        frame, carried, turn, spin = None, motion, *np.zeros((2, len(time)))
        if (body := self.model.frame) is not None:
            frame = body.motion(position, velocity)
            carried = _carried(body, motion, frame)
            turn, spin = frame.displacement[:, 2], frame.rate[:, 2]
        states = self.model.against_frame(position, velocity)
        links = slice(0, assembly.size)
        velocity = assembly.nodes.rate_to_axis(position[:, links], velocity[:, links])
        position = assembly.nodes.to_axis(position[:, links])
        displacement, rate = assembly.in_link_frames(carried, position, velocity)
        nodes = assembly.nodes.to_nodes(position)
        kinetic = energies.kinetic(nodes, assembly.nodes.rate_to_nodes(position, velocity))
        strain, dissipation = np.zeros((2, len(time)))
        for number, beam in assembly.beams:
            moved = beam.node_map.to_nodes(displacement[number])
            speed = beam.node_map.rate_to_nodes(displacement[number], rate[number])
            for part_of in beam.kind.strains(moved, speed, np.diff(beam.positions), beam.section):
                strain += part_of.energy
                dissipation += part_of.dissipation
        if shaft is not None:
            inertia = assembly.mechanism.shaft_inertia
            kinetic += inertia * (motion.crank_speed + spin) ** 2 / 2
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
            gravity_energy=energies.gravity(nodes),
            dissipation_power=dissipation,
            prestress_power=work.power + power,
            shaft=shaft,
        )
        if body is None or frame is None:
            return block
        block = body.added(block, frame, assembly.mechanism.gravity)
        motor = self.model.torque
        return motor.on_frame(block, *states) if isinstance(motor, MotorOnHub) else block

    def _shaft_motion(
        self, time: FloatArray, position: FloatArray, velocity: FloatArray
    ) -> ShaftMotion | None:
        """Rotation of a free shaft against its prescribed angle; None of a prescribed one."""
        shaft = self.model.shaft
        if not shaft.is_free:
            return None
        mean = np.array([shaft.motion(t) for t in time.tolist()])
        place, rate = self.model.against_frame(position, velocity)
        return ShaftMotion(place[:, -1] - mean[:, 0], rate[:, -1] - mean[:, 1])

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
        ndarray, shape (n,)
            Exudyn's coordinates.
        ndarray, shape (n,)
            Their rates.

        Raises
        ------
        InputError
            If the start does not keep the joints together.
        """
        batch = [[values[None] for values in state] for state in (start.displacement, start.rate)]
        motion, moved = self._motion(np.zeros(1)), None
        if self.model.frame is not None:
            moved = start.moved
            motion = _carried(self.model.frame, motion, moved)
        position, velocity = self.model.assembly.in_ground_axes(motion, *batch)
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

    @property
    def _last(self) -> int:
        """Number of the last step taken; 0 is the start."""
        return self._first + len(self._rows) - 1

    def _keep(self, data: Any, time: float) -> None:
        position = data.GetODE2Coordinates()
        if self.drifts:
            self.model.joints.correct_coordinates(position, time)
            data.SetODE2Coordinates(position)
        self._rows.append((time, position, data.GetODE2Coordinates_t(), data.GetAECoordinates()))

    def _hand_over(self, recorder: Recorder | PointRecorder) -> None:
        """Give what is kept to the recorder; its last step becomes the first of the next."""
        if len(self._rows) < 2:
            return
        columns = zip(*self._rows, strict=True)
        time, position, velocity, multiplier = (np.array(values) for values in columns)
        finite = np.isfinite([position.sum(1), velocity.sum(1), multiplier.sum(1)]).all(axis=0)
        if not finite.all():
            raise self._error_of_step(self._first + int(np.argmin(finite)))
        if isinstance(recorder, PointRecorder):
            recorder.add(self.displacement(time, position))
        else:
            block = self.block(time, position, velocity, multiplier)
            if block.shaft is not None and not isinstance(self.model.drive, MotorRun):
                block.shaft.refuse_runaway(self.model.drive, time)
            recorder.add(block)
        self._first, self._rows = self._last, self._rows[-1:]

    def _error_of_step(self, number: int, residual: float = math.inf) -> UnbalancedStepError:
        """Error for a step that did not converge, or gave no finite values."""
        cause = f"Newton's method does not converge (residual {residual:.3g} N)"
        if not math.isfinite(residual):
            cause = "the values are not finite"
        time = number * self.step
        angle = float(np.degrees(self.model.drive.crank_angle(time)))
        return UnbalancedStepError(
            f"the simulation stops at {time:.6g} s, crank angle {angle:.6g} deg: {cause}; take a "
            f"step smaller than {self.step:.3g} s or a lower crank speed"
        )


def _carried(body: FrameBody, motion: RigidMotion, moved: FrameMotion) -> RigidMotion:
    """Motion of the rigid linkage on its frame, whose acceleration does not count here."""
    return carried_motion(body.frame.centre, motion, moved.displacement, moved.rate)
