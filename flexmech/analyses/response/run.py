"""Runs of one engine: start, time step, and the checks of step and mesh.

How far two runs of an engine differ, and what is left of that as their error.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from flexmech.analyses.extremes import peaks_between
from flexmech.analyses.response.measurements import deflections
from flexmech.analyses.response.motor_passes import MotorPasses
from flexmech.analyses.response.path import path_deviation
from flexmech.analyses.response.plan import RunPlan
from flexmech.analyses.response.request import ResponseRequest
from flexmech.analyses.response.sprung_frame import rotation_error
from flexmech.analyses.response.start import linear_start, simulation_start
from flexmech.analyses.response.stresses import greatest_stresses
from flexmech.arrays import ROUND_OFF, FloatArray, LabelledProgress, StepProgress
from flexmech.dynamical_systems import LowPass
from flexmech.dynamical_systems.lobatto import STAGES
from flexmech.errors import ComputationError
from flexmech.linkages import Drive, MotorRun
from flexmech.mechanics import Engine
from flexmech.mechanics.running import (
    DETAIL,
    DrivenLinkage,
    Recorder,
    ShaftTorque,
    Trajectory,
    is_reduced,
    stretches_in_runs,
)
from flexmech.solvers import UnbalancedStepError, linear_run, simulator, step_lag

# What is left of an error, over what the last halving has changed, of a run or of the extrapolated
# one. Of second order that is a third, and of the extrapolated run far less but where motion is too
# fast for the steps. Where links stretch fast motion is resolved last: 0.1 to 1.2 were left of
# deflections and 0.1 to 0.9 of joint forces, in runs of random mechanisms.
_LEFT, _LEFT_WHERE_LINKS_STRETCH = 1 / 3, 2 / 3
# A vibration that has run out of phase by so much in the longer of two steps, in rad, is not
# resolved: extrapolation from the two does not mend it. Up to twice as much, a third of what
# halving changes is a bound.
_OUT_OF_PHASE = 1.0
# Forces below this part of the greatest are the round-off of none.
_NO_FORCE = 1e-9


def order_of_steps(*, stretches: bool) -> int:
    """Order of the method's error, by which runs with two steps are extrapolated.

    Parameters
    ----------
    stretches : bool
        Whether the method is that of links that stretch.
    """
    return 4 if stretches else 2


@dataclass(frozen=True)
class RunError:
    """How far histories and their peaks are off, each over its own peak.

    A vibration that runs out of phase changes a history far more than its peak.

    Parameters
    ----------
    linkage : float
        Change of the deflections of all links, over the greatest peak among them, fast or not:
        what a step is chosen by.
    of : dict of str to ndarray
        ``deflection`` and ``peak_deflection``, ``stress`` and ``peak_stress`` of each link
        (n_links,), ``force`` and ``peak_force`` of each joint (n_joints,), ``path`` and
        ``peak_path`` of each point that moves, ``torque`` and ``peak_torque`` (1,).
    """

    linkage: float
    of: dict[str, FloatArray]

    def with_all(self, value: float) -> RunError:
        """The same, with one error of everything."""
        return RunError(value, {name: np.full_like(own, value) for name, own in self.of.items()})

    def __mul__(self, factor: float) -> RunError:
        """The same, a factor greater."""
        of = {name: factor * value for name, value in self.of.items()}
        return RunError(factor * self.linkage, of)


@dataclass(frozen=True)
class Remainder:
    """What is left of a change of the histories, as their error.

    Parameters
    ----------
    part : float
        Part of the change.
    fast : float
        Part of the change that vibrates faster than ``resolved``.
    resolved : float
        In Hz.
    """

    part: float = 1.0
    fast: float = 1.0
    resolved: float = np.inf

    @classmethod
    def by_halving(cls, step: float, duration: float, *, stretches: bool) -> Remainder:
        """What is left of the change by halving a step, by extrapolation from both.

        A vibration that is out of phase in both runs, each by any angle, is off by up to
        ``2^p / (2^p - 1)`` of the greatest change, with the order p of the method.

        Parameters
        ----------
        step : float
            The longer one, in s.
        duration : float
            Duration of the run in s, in which a vibration runs out of phase.
        stretches : bool
            Whether the method is that of links that stretch.
        """
        order = order_of_steps(stretches=stretches)
        part = _LEFT_WHERE_LINKS_STRETCH if stretches else _LEFT
        # The phase goes with the power p + 1 of the frequency.
        phase = duration / step * step_lag(1.0, stretches=stretches)
        resolved = (_OUT_OF_PHASE / phase) ** (1 / (order + 1)) / (2 * np.pi * step)
        return cls(part, 2**order / (2**order - 1), resolved)


def difference_of_runs(
    first: tuple[Engine, Trajectory],
    finer: tuple[Engine, Trajectory],
    drive: Drive,
    left: Remainder | None = None,
) -> RunError:
    """Greatest differences over the peaks, or what is left of them; none of round-off of nothing.

    Peaks of histories whose fast parts are not resolved are off by as much as these.

    Parameters
    ----------
    first, finer : tuple of Engine and Trajectory
        At the same samples.
    drive : Drive
    left : Remainder, optional
        What is left of the differences; all by default.

    Returns
    -------
    RunError
    """
    left = Remainder() if left is None else left
    before, after = _histories(*first, drive), _histories(*finer, drive)
    engine, second = finer
    extent = sum(link.length for link in engine.mechanism.linkage.topology.links)
    nothing = _NO_FORCE * max(float(second.peak_joint_force.max()), np.finfo(float).tiny)
    deflected, stressed = (_sizes(after[of][0]).max(axis=0) for of in ("deflection", "stress"))
    scales = {
        "deflection": np.maximum(deflected, ROUND_OFF * extent),
        # Of links whose stress is not known it is zero.
        "stress": np.where(stressed > 0, stressed, 1.0),
        "force": np.maximum(second.peak_joint_force, nothing),
        "torque": np.maximum(second.peak_driving_torque, nothing * extent),
    }
    if "path" in after:
        scales["path"] = np.maximum(after["path"][1], ROUND_OFF * extent)
    if "frame" in after:
        scales["frame"] = np.maximum(after["frame"][1], ROUND_OFF * extent)
    errors: dict[str, FloatArray] = {}
    linkage = 0.0
    for name, scale in scales.items():
        (was, reached), (now, reaches) = before[name], after[name]
        change = now - was
        fast = (left.fast - left.part) * _faster(change, second.time, left.resolved)
        apart = _sizes(left.part * change + fast).max(axis=0)
        higher = np.maximum(np.abs(reaches - reached), _at_peaks(_sizes(was), _sizes(now)))
        peak = left.part * higher + _sizes(fast).max(axis=0)
        errors |= {name: apart / scale, f"peak_{name}": peak / scale}
        if name == "deflection":
            linkage = float(left.part * _sizes(change).max() / scale.max())
    return RunError(linkage, errors)


def _histories(
    engine: Engine, run: Trajectory, drive: Drive
) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Histories (N, k, components) of what has an error, and their peaks (k,)."""
    deflection, stress = (
        deflections(engine, run.displacement),
        greatest_stresses(engine, run, drive),
    )
    found = {
        "deflection": (deflection[..., None], peaks_between(deflection, run.time)[0]),
        "stress": (stress[..., None], peaks_between(stress, run.time)[0]),
        "force": (run.joint_force, run.peak_joint_force),
        "torque": (run.driving_torque[:, None, None], np.array([run.peak_driving_torque])),
    }
    deviation = path_deviation(engine, run, drive.motion(engine.mechanism.linkage, run.time))
    if deviation.size:
        found["path"] = deviation, peaks_between(_sizes(deviation), run.time)[0]
    if run.frame is not None:
        moved = run.frame.displacement[:, None, :2]
        found["frame"] = moved, _sizes(moved).max(axis=0)
    return found


def _faster(history: FloatArray, time: FloatArray, frequency: float) -> FloatArray:
    """What histories (N, k, components) have of vibration faster than a frequency in Hz."""
    smooth = LowPass(frequency, float(time[1] - time[0]))
    if not smooth.half:
        return np.zeros_like(history)
    columns = history.reshape(len(history), -1)
    slow = np.concatenate([smooth.add(columns), smooth.finish()])
    return np.asarray(history - slow.reshape(history.shape))


def _sizes(history: FloatArray) -> FloatArray:
    """Lengths (N, k) of vectors (N, k, components)."""
    return np.asarray(np.linalg.norm(history, axis=-1))


def _at_peaks(first: FloatArray, second: FloatArray) -> FloatArray:
    """How far sizes (N, k) of histories differ where the second of them peak, (k,).

    Two peaks at different instants may be equally high by chance; at one instant a shift of
    phase counts in second order alone, and what else is off shows.
    """
    columns, number = np.arange(second.shape[1]), second.argmax(axis=0)
    return np.asarray(np.abs(second - first)[number, columns])


logger = logging.getLogger(__name__)


# Steps in a period of the highest frequency asked for, and of the end of the band of forces, to
# begin with: a filter of forces needs more than six where links stretch.
_STEPS_PER_PERIOD, _STEPS_PER_BAND = 8, 6.2
# A free vibration runs out of phase in proportion to the time that it has run; the step is halved
# until the estimated error of the deflections is below this part of their peak. Joint forces, whose
# fast parts count for more, are told with an error of their own.
_STEP_TOLERANCE = 2e-2
# A step of which a 32nd part is still too long is no step to begin with.
_MOST_HALVINGS = 5


@dataclass(frozen=True)
class EngineRun:
    """A run and how far its time step may be trusted.

    Parameters
    ----------
    engine : Engine
    trajectory : Trajectory
        At the refined samples; forces and torque as far as the band lets them through.
    plain : Trajectory
        A run with one step, not extrapolated from several: other runs with this step tell what
        something else changes.
    step_error : RunError
        Estimated error by the time step (Richardson, from runs with other steps).
    reduction_error : RunError
        How much twice the detail of the component modes changes; zero for a simulation,
        which has no component modes.
    rotation_error : RunError
        By the rotation of a frame on springs in linear equations; zero of others.
    """

    engine: Engine
    trajectory: Trajectory
    plain: Trajectory
    step_error: RunError
    reduction_error: RunError
    rotation_error: RunError


def run_engine(
    engine: Engine, request: ResponseRequest, plan: RunPlan, report: LabelledProgress
) -> EngineRun:
    """Run, and run again with half the step.

    Parameters
    ----------
    engine : Engine
    request : ResponseRequest
    plan : RunPlan
    report : callable
        Progress: called with a label, the steps done and the steps to do.

    Returns
    -------
    EngineRun
        With the step asked for; else extrapolated from two steps to none, with the first of
        which deflections are estimated to be within two hundredths of their peak.

    Raises
    ------
    ComputationError
        If a run fails, or no step is short enough.
    """
    passes = MotorPasses(request.drive) if isinstance(request.drive, MotorRun) else None

    def run(step: float, detail: float = DETAIL) -> Trajectory:
        progress = partial(report, engine.name)
        return _run(engine, request, plan, step, progress, detail, passes)

    def difference(
        first: Trajectory, second: Trajectory, left: Remainder | None = None
    ) -> RunError:
        return difference_of_runs((engine, first), (engine, second), request.drive, left)

    def judged(trajectory: Trajectory, plain: Trajectory, step_error: RunError) -> EngineRun:
        reduction_error = step_error * 0.0
        if not engine.simulates and is_reduced(engine):
            finer = run(plain.step, 2 * DETAIL)
            reduction_error = difference(plain, finer)
        rotation = step_error.with_all(rotation_error(engine, trajectory))
        return EngineRun(engine, trajectory, plain, step_error, reduction_error, rotation)

    if request.step is not None:
        trajectory, finer = run(request.step), run(request.step / 2)
        # Second order: the asked run is off by 4/3 of what halving changes.
        return judged(trajectory, trajectory, difference(trajectory, finer) * (4 / 3))
    interval = float(plan.time[1] - plan.time[0])
    fastest = max(_STEPS_PER_PERIOD * plan.highest, _STEPS_PER_BAND * plan.band)
    stretches = stretches_in_runs(engine, request.prestress)
    duration = float(plan.time[-1] - plan.time[0])
    near_enough = partial(
        _extrapolated, engine, run, difference, duration=duration, stretches=stretches
    )
    step = interval / np.ceil(interval * fastest)
    for _ in range(_MOST_HALVINGS):
        try:
            return judged(*near_enough(step))
        except UnbalancedStepError:
            step /= 2
            logger.info("%s: no balance in a step; begins with %.3g s", engine.name, step)
    return judged(*near_enough(step))


def _extrapolated(
    engine: Engine,
    run: Callable[[float], Trajectory],
    difference: Callable[[Trajectory, Trajectory, Remainder], RunError],
    step: float,
    *,
    duration: float,
    stretches: bool,
) -> tuple[Trajectory, Trajectory, RunError]:
    """The first run, extrapolated from two steps, that is near enough.

    Returns
    -------
    Trajectory
        Extrapolated.
    Trajectory
        With the greater one of its steps.
    RunError
        Estimated: a part of what halving the step has changed, of the run or, where that is less,
        of the extrapolated one. What is not resolved is told, and no shorter step is sought for it.
    """
    order = order_of_steps(stretches=stretches)
    coarse, before = run(step), None
    for _ in range(_MOST_HALVINGS + 1):
        fine = run(coarse.step / 2)
        found = fine.extrapolated(coarse, order)
        left = Remainder.by_halving(coarse.step, duration, stretches=stretches)
        errors = [difference(coarse, fine, left)]
        if before is not None:
            errors.append(difference(before, found, left))
        error = min(errors, key=lambda each: each.linkage)
        if error.linkage <= _STEP_TOLERANCE:
            return found, coarse, error
        logger.info("%s: step %.3g s, error %.1e", engine.name, fine.step, error.linkage)
        coarse, before = fine, found
    raise ComputationError(
        f"no time step is short enough for the {engine.name} run: with {coarse.step:.3g} s "
        f"deflections are still off by about {100 * error.linkage:.3g} % of their peak; run fewer "
        "revolutions, add damping, or give a step of your own"
    )


def mesh_error(
    run: EngineRun, request: ResponseRequest, plan: RunPlan, report: LabelledProgress
) -> RunError:
    """How much twice the elements change a run.

    Parameters
    ----------
    run : EngineRun
    request : ResponseRequest
    plan : RunPlan
    report : callable
        Progress: called with a label, the steps done and the steps to do.

    Returns
    -------
    RunError

    Raises
    ------
    ComputationError
        If the run on the finer mesh fails.
    """
    finer = run.engine.with_(elements=2 * run.engine.elements)
    progress = partial(report, f"{finer.name} on twice the elements")
    trajectory = _run(finer, request, plan, run.plain.step, progress)
    return difference_of_runs((run.engine, run.plain), (finer, trajectory), request.drive)


def _run(
    engine: Engine,
    request: ResponseRequest,
    plan: RunPlan,
    step: float,
    progress: StepProgress,
    detail: float = DETAIL,
    passes: MotorPasses | None = None,
) -> Trajectory:
    """Simulate, or integrate the equations in link frames with component modes of some detail."""
    if engine.simulates:
        return simulator(engine).simulate(
            request.drive,
            simulation_start(engine, request, step),
            plan.time,
            step,
            integrator=request.integrator,
            progress=progress,
            band=plan.band,
        )

    def integrated(drive: Drive, torque: ShaftTorque | None = None) -> Trajectory:
        linkage = DrivenLinkage(
            engine,
            drive,
            request.prestress,
            modes=request.modes,
            detail=detail,
            stretches=stretches_in_runs(engine, request.prestress),
            shaft_torque=torque,
        )
        state = linear_start(linkage, request, step)
        if linkage.rotor is not None:
            state = linkage.rotor.started(state, linkage.rotor_coordinate)
        return linear_run(
            linkage, state.position, state.velocity, plan.time, step, progress, band=plan.band
        )

    if not isinstance(request.drive, MotorRun):
        return integrated(request.drive)
    steps = Recorder(plan.time, step, plan.band).steps + STAGES
    own = passes or MotorPasses(request.drive)
    return own.trajectory(integrated, step * steps, step)
