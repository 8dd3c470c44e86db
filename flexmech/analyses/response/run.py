"""Runs of one engine: start, time step, and the checks of step and mesh."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import astuple, dataclass
from functools import partial

import numpy as np

from flexmech.analyses.response.measurements import NO_DEFLECTION, deflections, peaks_between
from flexmech.analyses.response.request import ResponseRequest
from flexmech.analyses.response.start import linear_start, simulation_start
from flexmech.errors import ComputationError
from flexmech.linear_system import Engine
from flexmech.time_domain import DrivenLinkage, Trajectory, linear_run
from flexmech.time_domain.equations_of_motion import DETAIL, is_reduced, stretches_in_runs
from flexmech.time_domain.integrators import UnbalancedStepError, simulator
from flexmech.types import FloatArray, LabelledProgress, StepProgress

logger = logging.getLogger(__name__)


# Steps in a period of the highest frequency asked for, to begin with; half as many where the
# error of the step is of fourth order.
STEPS_PER_PERIOD = 40
# A free vibration runs out of phase in proportion to the time that it has run; the step is
# halved until the estimated error of the deflections is below this part of their peak.
STEP_TOLERANCE = 2e-2
MOST_HALVINGS = 5
# What is left of an error, over what the last halving of the step has changed: of second order; and
# where links stretch, whose step is of fourth order, but whose fast motion is resolved last. There
# 0.1 to 1.2 were left of deflections and 0.1 to 0.9 of joint forces, in runs of random mechanisms.
LEFT, LEFT_WHERE_LINKS_STRETCH = 1 / 3, 2 / 3
# Forces below this part of the greatest are the round-off of none.
NO_FORCE = 1e-9


@dataclass(frozen=True)
class RunError:
    """How far histories and their peaks are off, each over its own peak.

    A vibration that runs out of phase changes a history far more than its peak.

    Parameters
    ----------
    linkage : float
        Of the deflections of all links, over the greatest peak among them: what a step is
        chosen by.
    deflection, peak_deflection : ndarray, shape (n_links,)
        Of each link over its own peak.
    force, peak_force : ndarray, shape (n_joints,)
        Of each joint over its own peak.
    torque, peak_torque : float
    """

    linkage: float
    deflection: FloatArray
    peak_deflection: FloatArray
    force: FloatArray
    peak_force: FloatArray
    torque: float
    peak_torque: float

    def __mul__(self, factor: float) -> RunError:
        """The same, a factor greater."""
        return RunError(*(factor * value for value in astuple(self)))


@dataclass(frozen=True)
class EngineRun:
    """A run and how far its time step may be trusted.

    Parameters
    ----------
    engine : Engine
    trajectory : Trajectory
        At the refined samples; forces and torque as far as the band lets them through.
    band : float
        In Hz.
    step_error : RunError
        Estimated error by the time step (Richardson, from a run with another step).
    reduction_error : RunError
        How much twice the detail of the component modes changes; zero for a simulation,
        which has no component modes.
    """

    engine: Engine
    trajectory: Trajectory
    band: float
    step_error: RunError
    reduction_error: RunError


def run_engine(
    engine: Engine,
    request: ResponseRequest,
    sample_time: FloatArray,
    highest: float,
    band: float,
    report: LabelledProgress,
) -> EngineRun:
    """Run, and run again with half the step.

    Parameters
    ----------
    engine : Engine
    request : ResponseRequest
    sample_time : ndarray, shape (N,)
        Evenly spaced, in s.
    highest : float
        Highest frequency of interest in Hz.
    band : float
        Frequency in Hz up to which forces and torque count.
    report : callable
        Progress: called with a label, the steps done and the steps to do.

    Returns
    -------
    EngineRun
        With the step asked for; else with the first whose deflections are estimated to be
        within two hundredths of their peak.

    Raises
    ------
    ComputationError
        If a run fails, or no step is short enough.
    """

    def run(step: float, detail: float = DETAIL) -> Trajectory:
        progress = partial(report, engine.name)
        return _run(engine, request, sample_time, step, band, progress, detail)

    def judged(trajectory: Trajectory, step_error: RunError) -> EngineRun:
        reduction_error = _difference(engine, trajectory, trajectory)
        if not engine.simulates and is_reduced(engine):
            finer = run(trajectory.step, 2 * DETAIL)
            reduction_error = _difference(engine, trajectory, finer)
        return EngineRun(engine, trajectory, band, step_error, reduction_error)

    if request.step is not None:
        trajectory, finer = run(request.step), run(request.step / 2)
        # Second order: the asked run is off by 4/3 of what halving changes.
        return judged(trajectory, _difference(engine, trajectory, finer) * (4 / 3))
    interval = float(sample_time[1] - sample_time[0])
    steps, stretches = interval * highest * STEPS_PER_PERIOD, False
    if stretches_in_runs(engine, request.prestress):
        steps, stretches = steps / 2, True
    left = LEFT_WHERE_LINKS_STRETCH if stretches else LEFT
    step = interval / np.ceil(steps)
    for _ in range(MOST_HALVINGS):
        try:
            return judged(*_with_halved_steps(engine, run, step, left))
        except UnbalancedStepError:
            step /= 2
            logger.info("%s: no balance in a step; begins with %.3g s", engine.name, step)
    return judged(*_with_halved_steps(engine, run, step, left))


def _with_halved_steps(
    engine: Engine, run: Callable[[float], Trajectory], step: float, left: float
) -> tuple[Trajectory, RunError]:
    """The first run whose step is short enough, and its estimated error.

    That is a part ``left`` of what halving the step has changed.
    """
    coarse = run(step)
    for _ in range(MOST_HALVINGS):
        step /= 2
        fine = run(step)
        error = _difference(engine, coarse, fine) * left
        if error.linkage <= STEP_TOLERANCE:
            return fine, error
        logger.info(
            "%s: step %.3g s, error %.1e of the peak deflection",
            engine.name,
            step,
            error.linkage,
        )
        coarse = fine
    raise ComputationError(
        f"no time step is short enough for the {engine.name} run: with {step:.3g} s deflections "
        f"are still off by about {100 * error.linkage:.3g} % of their peak; run fewer "
        "revolutions, add damping, or give a step of your own"
    )


def mesh_error(run: EngineRun, request: ResponseRequest, report: LabelledProgress) -> RunError:
    """How much twice the elements change a run.

    Parameters
    ----------
    run : EngineRun
    request : ResponseRequest
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
    was = run.trajectory
    trajectory = _run(finer, request, was.time, was.step, run.band, progress)
    return _difference(run.engine, was, trajectory, finer)


def _difference(
    engine: Engine, first: Trajectory, second: Trajectory, finer: Engine | None = None
) -> RunError:
    """Greatest differences over the peaks; round-off of what is nothing is none.

    The second run is of the same engine, or of a finer one.
    """
    before, after = deflections(engine, first), deflections(finer or engine, second)
    extent = sum(link.length for link in engine.mechanism.linkage.topology.links)
    deflection = np.maximum(np.abs(after).max(axis=0), NO_DEFLECTION * extent)
    apart = np.abs(before - after).max(axis=0)
    reached, reaches = (peaks_between(history, first.time)[0] for history in (before, after))
    nothing = NO_FORCE * max(float(second.peak_joint_force.max()), np.finfo(float).tiny)
    force = np.maximum(second.peak_joint_force, nothing)
    torque = max(second.peak_driving_torque, nothing * extent)
    forces_apart = np.linalg.norm(second.joint_force - first.joint_force, axis=-1).max(axis=0)
    sizes = (np.linalg.norm(run.joint_force, axis=-1) for run in (first, second))
    torques = (run.driving_torque[:, None] for run in (first, second))
    higher = np.abs(second.peak_joint_force - first.peak_joint_force)
    stronger = abs(second.peak_driving_torque - first.peak_driving_torque)
    return RunError(
        linkage=float(apart.max() / deflection.max()),
        deflection=apart / deflection,
        peak_deflection=np.maximum(np.abs(reaches - reached), _at_peaks(before, after))
        / deflection,
        force=forces_apart / force,
        peak_force=np.maximum(higher, _at_peaks(*sizes)) / force,
        torque=float(np.abs(second.driving_torque - first.driving_torque).max() / torque),
        peak_torque=max(stronger, float(_at_peaks(*torques)[0])) / torque,
    )


def _at_peaks(first: FloatArray, second: FloatArray) -> FloatArray:
    """How far histories (N, k) differ in size where the second of them peak, (k,).

    Two peaks at different instants may be equally high by chance; at one instant a shift of
    phase counts in second order alone, and what else is off shows.
    """
    columns, number = np.arange(second.shape[1]), np.abs(second).argmax(axis=0)
    return np.asarray(np.abs(np.abs(second) - np.abs(first))[number, columns])


def _run(
    engine: Engine,
    request: ResponseRequest,
    sample_time: FloatArray,
    step: float,
    band: float,
    progress: StepProgress,
    detail: float = DETAIL,
) -> Trajectory:
    """Simulate, or integrate the equations in link frames with component modes of some detail."""
    if engine.simulates:
        return simulator(engine).simulate(
            request.drive,
            simulation_start(engine, request, step),
            sample_time,
            step,
            integrator=request.integrator,
            progress=progress,
            band=band,
        )
    linkage = DrivenLinkage(
        engine,
        request.drive,
        request.prestress,
        modes=request.modes,
        detail=detail,
        stretches=stretches_in_runs(engine, request.prestress),
    )
    state = linear_start(linkage, request, step)
    return linear_run(
        linkage, state.position, state.velocity, sample_time, step, progress, band=band
    )
