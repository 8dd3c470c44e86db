"""Runs of one engine: start, time step, and the checks of step and mesh."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from flexmech.analyses.response.measurements import deflections
from flexmech.analyses.response.request import ResponseRequest
from flexmech.analyses.response.start import linear_start, simulation_start
from flexmech.errors import ComputationError
from flexmech.linear_system import Engine
from flexmech.time_domain import Trajectory, linear_run, simulator
from flexmech.time_domain.driven_linkage import DETAIL, DrivenLinkage, is_reduced
from flexmech.types import FloatArray, LabelledProgress, StepProgress

__all__ = ["EngineRun", "mesh_error", "run_engine"]

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


def run_engine(
    engine: Engine,
    request: ResponseRequest,
    sample_time: FloatArray,
    highest: float,
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
        return _run(engine, request, sample_time, step, progress, detail)

    if request.step is None:
        interval = float(sample_time[1] - sample_time[0])
        step = interval / np.ceil(interval * highest * STEPS_PER_PERIOD)
        trajectory, step_error = _with_halved_steps(engine, run, step)
    else:
        trajectory, finer = run(request.step), run(request.step / 2)
        # Second order: the asked run is off by 4/3 of what halving changes.
        step_error = 4 / 3 * _difference(engine, trajectory, finer)
    reduction_error = 0.0
    if not engine.simulates and is_reduced(engine):
        reduction_error = _difference(engine, trajectory, run(trajectory.step, 2 * DETAIL))
    return EngineRun(engine, trajectory, step_error, reduction_error)


def _with_halved_steps(
    engine: Engine, run: Callable[[float], Trajectory], step: float
) -> tuple[Trajectory, float]:
    """The first run whose step is short enough, and its estimated error."""
    coarse = run(step)
    for _ in range(MOST_HALVINGS):
        step /= 2
        fine = run(step)
        # Second order: the finer run is off by a third of what halving has changed.
        error = _difference(engine, coarse, fine) / 3
        if error <= STEP_TOLERANCE:
            return fine, error
        logger.info("%s: step %.3g s, error %.1e of the peak deflection", engine.name, step, error)
        coarse = fine
    raise ComputationError(
        f"no time step is short enough for the {engine.name} run: with {step:.3g} s deflections "
        f"are still off by about {100 * error:.3g} % of their peak; run fewer revolutions, add "
        "damping, or give a step of your own"
    )


def mesh_error(run: EngineRun, request: ResponseRequest, report: LabelledProgress) -> float:
    """How much twice the elements change the deflections, relative to their peak.

    Parameters
    ----------
    run : EngineRun
    request : ResponseRequest
    report : callable
        Progress: called with a label, the steps done and the steps to do.

    Returns
    -------
    float

    Raises
    ------
    ComputationError
        If the run on the finer mesh fails.
    """
    finer = run.engine.with_(elements=2 * run.engine.elements)
    progress = partial(report, f"{finer.name} on twice the elements")
    trajectory = _run(finer, request, run.trajectory.time, run.trajectory.step, progress)
    return _difference(run.engine, run.trajectory, trajectory, finer)


def _difference(
    engine: Engine, first: Trajectory, second: Trajectory, finer: Engine | None = None
) -> float:
    """Greatest difference of deflections over their peak; round-off of the lengths is none.

    The second run is of the same engine, or of a finer one.
    """
    before, after = deflections(engine, first), deflections(finer or engine, second)
    extent = sum(link.length for link in engine.mechanism.linkage.topology.links)
    peak = max(float(np.abs(after).max()), NO_DEFLECTION * extent)
    return float(np.abs(before - after).max() / peak)


def _run(
    engine: Engine,
    request: ResponseRequest,
    sample_time: FloatArray,
    step: float,
    progress: StepProgress,
    detail: float = DETAIL,
) -> Trajectory:
    """Simulate, or integrate the linear equations with component modes of some detail."""
    if engine.simulates:
        return simulator(engine).simulate(
            request.drive,
            simulation_start(engine, request, step),
            sample_time,
            step,
            integrator=request.integrator,
            progress=progress,
        )
    linkage = DrivenLinkage(
        engine, request.drive, request.prestress, modes=request.modes, detail=detail
    )
    state = linear_start(linkage, request, step)
    return linear_run(linkage, state.position, state.velocity, sample_time, step, progress)
