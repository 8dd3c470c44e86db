"""Runs of one engine: start, time step, and the checks of step and mesh."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from flexmech.analyses.response.motor_passes import MotorPasses
from flexmech.analyses.response.plan import RunPlan
from flexmech.analyses.response.request import ResponseRequest
from flexmech.analyses.response.run_errors import (
    Remainder,
    RunError,
    difference_of_runs,
    order_of_steps,
)
from flexmech.analyses.response.sprung_frame import rotation_error
from flexmech.analyses.response.start import linear_start, simulation_start
from flexmech.arrays import LabelledProgress, StepProgress
from flexmech.dynamical_systems.lobatto import STAGES
from flexmech.errors import ComputationError
from flexmech.linear_system import Engine
from flexmech.linkages import Drive, MotorRun
from flexmech.time_domain import (
    DETAIL,
    DrivenLinkage,
    Recorder,
    ShaftTorque,
    Trajectory,
    UnbalancedStepError,
    is_reduced,
    linear_run,
    simulator,
    stretches_in_runs,
)

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
