"""Runs of one engine: start, time step, and the checks of step and mesh."""

from __future__ import annotations

import logging
from dataclasses import dataclass

import numpy as np

from flexmech.analyses.frequencies import natural_frequencies
from flexmech.analyses.response.measurements import deflections
from flexmech.analyses.response.request import ResponseRequest
from flexmech.analyses.response.start import linear_start, simulation_start
from flexmech.analyses.turn import sampled_turn
from flexmech.errors import ComputationError
from flexmech.linear_system import Engine
from flexmech.time_domain import (
    DETAIL,
    DrivenLinkage,
    Trajectory,
    is_reduced,
    linear_run,
    simulator,
)
from flexmech.types import FloatArray, StepProgress

__all__ = ["EngineRun", "highest_frequency", "mesh_error", "run_engine"]

logger = logging.getLogger(__name__)


# Steps in a period of the highest frequency asked for, to begin with.
STEPS_PER_PERIOD = 40
# A free vibration runs out of phase in proportion to the time that it has run; the step is
# halved until the estimated error of the deflections is below this part of their peak.
STEP_TOLERANCE = 2e-2
MOST_HALVINGS = 5
# Deflections below this part of the links' lengths are the round-off of none at all.
NO_DEFLECTION = 1e-12


@dataclass(frozen=True)
class EngineRun:
    """A run and how far its time step may be trusted.

    Parameters
    ----------
    engine : Engine
    trajectory : Trajectory
        At the refined samples.
    step_error : float
        Estimated error of the deflections by the time step (Richardson, from a run with
        another step), relative to their peak.
    reduction_error : float
        How much twice the detail of the component modes changes the deflections, relative
        to their peak; zero for a simulation, which has no component modes.
    """

    engine: Engine
    trajectory: Trajectory
    step_error: float
    reduction_error: float


def highest_frequency(engine: Engine, request: ResponseRequest) -> float:
    """Greatest value over a turn of the highest natural frequency asked for, at rest; Hz."""
    frequency = natural_frequencies(
        engine,
        sampled_turn(request.drive.start_angle),
        modes=request.modes,
        prestress=engine.prestress_at_rest,
        rotation_terms=False,
    )
    return float(frequency.max())


def run_engine(
    engine: Engine,
    request: ResponseRequest,
    sample_time: FloatArray,
    highest: float,
    progress: StepProgress | None = None,
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
    progress : callable, optional

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
    if request.step is not None:
        asked = _run(engine, request, sample_time, request.step, progress)
        finer = _run(engine, request, sample_time, request.step / 2, progress)
        # Second order: the asked run is off by 4/3 of what halving changes.
        return _checked(engine, request, asked, 4 / 3 * _difference(engine, asked, finer))
    interval = float(sample_time[1] - sample_time[0])
    step = interval / np.ceil(interval * highest * STEPS_PER_PERIOD)
    coarse = _run(engine, request, sample_time, step, progress)
    for _ in range(MOST_HALVINGS):
        step /= 2
        fine = _run(engine, request, sample_time, step, progress)
        # Second order: the finer run is off by a third of what halving has changed.
        error = _difference(engine, coarse, fine) / 3
        if error <= STEP_TOLERANCE:
            return _checked(engine, request, fine, error)
        logger.info("%s: step %.3g s, error %.1e of the peak deflection", engine.name, step, error)
        coarse = fine
    raise ComputationError(
        f"no time step is short enough for the {engine.name} run: with {step:.3g} s deflections "
        f"are still off by about {100 * error:.3g} % of their peak; run fewer revolutions, add "
        "damping, or give a step of your own"
    )


def _checked(
    engine: Engine, request: ResponseRequest, trajectory: Trajectory, step_error: float
) -> EngineRun:
    """A run with the error of its component modes."""
    if engine.simulates or not is_reduced(engine):
        return EngineRun(engine, trajectory, step_error, 0.0)
    finer = _linear_run(engine, request, trajectory.time, trajectory.step, None, detail=2 * DETAIL)
    return EngineRun(engine, trajectory, step_error, _difference(engine, trajectory, finer))


def mesh_error(
    run: EngineRun, request: ResponseRequest, progress: StepProgress | None = None
) -> float:
    """How much twice the elements change the deflections, relative to their peak.

    Parameters
    ----------
    run : EngineRun
    request : ResponseRequest
    progress : callable, optional

    Returns
    -------
    float

    Raises
    ------
    ComputationError
        If the run on the finer mesh fails.
    """
    finer = run.engine.with_(elements=2 * run.engine.elements)
    trajectory = _run(finer, request, run.trajectory.time, run.trajectory.step, progress)
    first, second = deflections(run.engine, run.trajectory), deflections(finer, trajectory)
    return _relative(run.engine, first, second)


def _difference(engine: Engine, first: Trajectory, second: Trajectory) -> float:
    return _relative(engine, deflections(engine, first), deflections(engine, second))


def _relative(engine: Engine, first: FloatArray, second: FloatArray) -> float:
    """Greatest difference of deflections over their peak; round-off of the lengths is none."""
    extent = sum(link.length for link in engine.mechanism.linkage.topology.links)
    peak = max(float(np.abs(second).max()), NO_DEFLECTION * extent)
    return float(np.abs(first - second).max() / peak)


def _run(
    engine: Engine,
    request: ResponseRequest,
    sample_time: FloatArray,
    step: float,
    progress: StepProgress | None,
) -> Trajectory:
    if engine.simulates:
        start = simulation_start(engine, request, step)
        return simulator(engine).simulate(
            request.drive,
            start,
            sample_time,
            step,
            integrator=request.integrator,
            progress=progress,
        )
    return _linear_run(engine, request, sample_time, step, progress, detail=DETAIL)


def _linear_run(
    engine: Engine,
    request: ResponseRequest,
    sample_time: FloatArray,
    step: float,
    progress: StepProgress | None,
    *,
    detail: float,
) -> Trajectory:
    linkage = DrivenLinkage(
        engine, request.drive, request.prestress, modes=request.modes, detail=detail
    )
    state = linear_start(linkage, request, step)
    return linear_run(linkage, state.position, state.velocity, sample_time, step, progress)
