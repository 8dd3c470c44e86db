"""Runs of the linkage with an impact, and of its twin without one."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from flexmech.analyses.response.request import ResponseRequest
from flexmech.analyses.response.start import linear_start
from flexmech.analyses.running_hammer.plan import RunPlan
from flexmech.analyses.running_hammer.request import RunningHammerRequest
from flexmech.analyses.stability.parallel import in_order
from flexmech.dynamical_systems import HalfSinePulse
from flexmech.linear_system import Engine
from flexmech.linkages import CrankDrive
from flexmech.time_domain.equations_of_motion import DrivenLinkage, stretches_in_runs
from flexmech.time_domain.integrators import StruckLinkage
from flexmech.time_domain.periodic_motion import nonlinear_orbit
from flexmech.time_domain.recorded_runs import Impact, LinkState, simulator
from flexmech.types import FloatArray, StepProgress

# Natural frequencies that the reduction of engines that do not simulate gets right at least.
LEAST_MODES = 6
ORBIT_SAMPLES = 8

Struck = Callable[[Sequence[HalfSinePulse]], FloatArray]
"""From the pulses of a run to the displacement of the point that is read, in m at every step."""


def added_by_impacts(
    run: Struck, plan: RunPlan, progress: StepProgress, twin: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """What each impact adds to the motion of a twin run without one.

    Every run starts from the same state at crank angle zero, so that the impact meets the motion
    that the twin has at its crank angle, and nothing of another impact.

    Parameters
    ----------
    run : callable
    plan : RunPlan
    progress : callable
        Called with the runs done and the runs to do.
    twin : ndarray, shape (N + 1,), optional
        If it has been run already.

    Returns
    -------
    ndarray, shape (K, N)
        In m, at every time step.
    ndarray, shape (N + 1,)
        The twin.
    """
    tasks: list[list[HalfSinePulse]] = [[pulse] for pulse in plan.pulses()]
    if twin is None:
        tasks.insert(0, [])
    found = []
    for done, record in enumerate(in_order(run, tasks), start=1):
        found.append(record)
        progress(done, len(tasks))
    if twin is None:
        twin = found.pop(0)
    return np.asarray(found)[:, :-1] - twin[:-1], twin


def runner(engine: Engine, request: RunningHammerRequest, plan: RunPlan, modes: int) -> Struck:
    """Runs of an engine from the periodic motion at crank angle zero.

    An engine that simulates runs the nonlinear motion from the periodic motion at large
    displacements. The others run their own equations, at prestress ``equilibrium`` with links that
    stretch by the square of their slopes, from the periodic motion of their linear ones.

    Parameters
    ----------
    engine : Engine
    request : RunningHammerRequest
    plan : RunPlan
    modes : int
        Number of natural frequencies that a reduction must get right.

    Returns
    -------
    callable

    Raises
    ------
    ComputationError
        If there is no periodic motion.
    """
    drive = CrankDrive(request.crank_speed)
    if engine.simulates:
        return _simulated(engine, request, plan, drive)
    count = max(LEAST_MODES, modes)
    linkage = DrivenLinkage(
        engine,
        drive,
        request.prestress,
        modes=count,
        with_energy=False,
        stretches=stretches_in_runs(engine, request.prestress),
    )
    asked = ResponseRequest(drive, start="periodic", prestress=request.prestress, modes=count)
    start = linear_start(linkage, asked, plan.step)

    points = (request.impact, request.response, request.direction)
    struck = StruckLinkage(linkage, plan.step, *points)

    def run(pulses: Sequence[HalfSinePulse]) -> FloatArray:
        return struck.run(start, plan.samples, pulses)

    return run


def _simulated(
    engine: Engine, request: RunningHammerRequest, plan: RunPlan, drive: CrankDrive
) -> Struck:
    orbit = nonlinear_orbit(engine, request.crank_speed, ORBIT_SAMPLES)
    start = LinkState([q[0] for q in orbit.displacement], [rate[0] for rate in orbit.rate])
    point = (request.response, request.direction)

    def run(pulses: Sequence[HalfSinePulse]) -> FloatArray:
        impacts = [Impact(request.impact, request.direction, pulse) for pulse in pulses]
        found = simulator(engine).point_histories(
            drive, start, [point], plan.step, plan.samples, impacts=impacts
        )
        return found[:, 0]

    return run
