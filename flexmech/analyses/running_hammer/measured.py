"""Harmonic transfer functions from the runs of a hammer test, and how small the impacts are."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from flexmech.analyses.response.request import ResponseRequest
from flexmech.analyses.response.start import linear_start, simulation_start
from flexmech.analyses.running_hammer.plan import RunPlan
from flexmech.analyses.running_hammer.request import RunningHammerRequest
from flexmech.analyses.stability.parallel import in_order
from flexmech.arrays import ComplexArray, FloatArray, LabelledProgress, StepProgress
from flexmech.dynamical_systems import HalfSinePulse
from flexmech.errors import CRANK_SPEED, ComputationError
from flexmech.linear_system import Engine
from flexmech.linkages import ConstantSpeed
from flexmech.modal_testing import HarmonicEstimate, estimate_harmonics, with_noise
from flexmech.time_domain import (
    DrivenLinkage,
    Impact,
    LinkageUnderImpact,
    simulator,
    stretches_in_runs,
)

# Greatest change of any order by halving the impacts, over its greatest amplitude.
_HALVING = 0.01
# Of the impacts, so many are halved at first: what that changes counts for all, which are evenly
# spaced along the turn.
_HALVED = slice(None, None, 3)
# To a sixteenth of a force that moves links by 1e-4 of their length: smaller is round-off.
_MOST_HALVINGS = 4
# An order whose greatest amplitude is below this part of that of the strongest order is measured
# by the latter: where the linkage is a rotating arm, all but order 0 are round-off.
FAINT = 1e-4


@dataclass(frozen=True)
class MeasuredResponse:
    """Harmonic transfer functions from runs.

    Parameters
    ----------
    plan : RunPlan
        With the force of the impacts that were small enough.
    estimate : HarmonicEstimate
        Of all orders that were identified, guards included; with the noise asked for.
    halving_change : ndarray, shape (2 N + 1,)
        Change of each order asked for when the impacts are halved, over its greatest amplitude;
        without noise. From a third of the impacts.
    decay : ndarray, shape (K,)
        Greatest response of the last turn over the greatest of all, of each impact.
    peak_response : float
        Greatest displacement that an impact adds, in m.
    twin_defect : float
        How far the twin is from repeating itself from the first turn to the second, over its
        greatest displacement or that of an impact.
    """

    plan: RunPlan
    estimate: HarmonicEstimate
    halving_change: FloatArray
    decay: FloatArray
    peak_response: float
    twin_defect: float


def measured_response(
    run: ImpactRun, request: RunningHammerRequest, plan: RunPlan, report: LabelledProgress
) -> MeasuredResponse:
    """Hit the running linkage, and hit it half as hard until that changes nothing.

    Parameters
    ----------
    run : callable
    request : RunningHammerRequest
    plan : RunPlan
    report : callable
        Called with a label, the runs done and the runs to do.

    Returns
    -------
    MeasuredResponse

    Raises
    ------
    ComputationError
        If a run fails, or no impact is small enough.
    """
    added, twin = added_by_impacts(run, plan.pulses(), partial(report, "impacts"))
    whole = _estimated(plan, added)
    for _ in range(_MOST_HALVINGS):
        half_plan = plan.softer(0.5)
        label = partial(report, "impacts of half the force")
        pulses = half_plan.pulses()
        halved = added.copy()
        halved[_HALVED] = 2 * added_by_impacts(run, pulses[_HALVED], label, twin)[0]
        share = len(pulses[_HALVED]) / len(pulses)
        half = _estimated(plan, halved)
        change = _change(whole.response, half.response, request.orders) / share
        if change.max() < _HALVING:
            break
        plan, added = half_plan, halved / 2
        others = np.delete(np.arange(len(pulses)), _HALVED).tolist()
        added[others] = added_by_impacts(run, [pulses[n] for n in others], label, twin)[0]
        whole = _estimated(plan, added)
    else:
        raise ComputationError(
            f"halving the impacts still changes the response by {100 * change.max():.3g} % at "
            f"crank speed {CRANK_SPEED}, however small they are: the runs are not linear there; "
            "give the links more damping, or take another speed",
            crank_speed=request.speed,
        )
    size = np.abs(added).max(axis=1)
    turn = plan.steps
    unrepeated = np.abs(twin[turn : 2 * turn] - twin[:turn]).max()
    return MeasuredResponse(
        plan=plan,
        estimate=_with_noise(request, plan, added) if request.noise else whole,
        halving_change=change,
        decay=np.abs(added[:, -turn:]).max(axis=1) / size,
        peak_response=float(size.max()),
        twin_defect=float(unrepeated / max(np.abs(twin).max(), size.max())),
    )


def _estimated(plan: RunPlan, added: FloatArray) -> HarmonicEstimate:
    frequency = plan.resolution * np.arange(plan.samples // 2 + 1, dtype=float)
    force = np.array([pulse.spectrum(frequency) for pulse in plan.pulses()])
    return _identified(plan, force, _integral(plan, added))


def _with_noise(
    request: RunningHammerRequest, plan: RunPlan, added: FloatArray
) -> HarmonicEstimate:
    """With as many records of each impact as are averaged, each with noise of its own.

    A force window keeps the noise of the force channel out of the record after the pulse.
    """
    generator = np.random.default_rng([request.seed, 1])
    time = plan.step * np.arange(plan.samples, dtype=float)
    pulses = plan.pulses()
    clean = np.array([pulse.force(time) for pulse in pulses])
    during = np.array([(time >= pulse.start) & (time <= pulse.end) for pulse in pulses])
    force, response = [], []
    for _ in range(request.averages):
        force.append(_integral(plan, during * with_noise(clean, request.noise, generator)))
        response.append(_integral(plan, with_noise(added, request.noise, generator)))
    return _identified(plan, np.concatenate(force), np.concatenate(response))


def _identified(plan: RunPlan, force: ComplexArray, response: ComplexArray) -> HarmonicEstimate:
    return estimate_harmonics(
        force, response, highest_order=plan.fitted, shift=plan.turns, bins=plan.bins
    )


def _integral(plan: RunPlan, records: FloatArray) -> ComplexArray:
    """Fourier integrals of records (R, N) at the bins from zero on."""
    return np.asarray(plan.step * np.fft.rfft(records, axis=1))


def _change(whole: ComplexArray, half: ComplexArray, orders: int) -> FloatArray:
    """Change of the orders asked for, over their greatest amplitudes."""
    middle = len(whole) // 2
    asked = slice(middle - orders, middle + orders + 1)
    apart = np.abs(whole[asked] - half[asked]).max(axis=1)
    size = np.abs(whole[asked]).max(axis=1)
    return np.asarray(apart / np.maximum(size, FAINT * size.max()))


# Natural frequencies that the reduction of engines that do not simulate gets right at least.
_LEAST_MODES = 6

# From the pulses of a run to the displacement of the point that is read, in m at every step.
ImpactRun = Callable[[Sequence[HalfSinePulse]], FloatArray]


def added_by_impacts(
    run: ImpactRun,
    pulses: Sequence[HalfSinePulse],
    progress: StepProgress,
    twin: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """What each impact adds to the motion of a twin run without one.

    Every run starts from the same state at crank angle zero, so that the impact meets the motion
    that the twin has at its crank angle, and nothing of another impact.

    Parameters
    ----------
    run : callable
    pulses : sequence of HalfSinePulse
        Of K impacts.
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
    tasks: list[list[HalfSinePulse]] = [[pulse] for pulse in pulses]
    if twin is None:
        tasks.insert(0, [])
    found = []
    for done, record in enumerate(in_order(run, tasks), start=1):
        found.append(record)
        progress(done, len(tasks))
    if twin is None:
        twin = found.pop(0)
    return np.asarray(found)[:, :-1] - twin[:-1], twin


def runner(engine: Engine, request: RunningHammerRequest, plan: RunPlan, modes: int) -> ImpactRun:
    """Runs of an engine from the periodic motion at crank angle zero.

    An engine that simulates runs the nonlinear motion. The others run their own equations, at
    prestress ``equilibrium`` with links that stretch by the square of their slopes. Both begin on
    the periodic motion at large displacements; linear equations begin on their own.

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
    drive = ConstantSpeed(request.speed)
    if engine.simulates:
        return _simulated(engine, request, plan, modes)
    count = max(_LEAST_MODES, modes)
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
    linkage_hit = LinkageUnderImpact(linkage, plan.step, *points)

    def run(pulses: Sequence[HalfSinePulse]) -> FloatArray:
        return linkage_hit.run(start, plan.samples, pulses)

    return run


def _simulated(
    engine: Engine, request: RunningHammerRequest, plan: RunPlan, modes: int
) -> ImpactRun:
    drive = ConstantSpeed(request.speed)
    asked = ResponseRequest(drive, start="periodic", modes=max(_LEAST_MODES, modes))
    start = simulation_start(engine, asked, plan.step)
    point = (request.response, request.direction)

    def run(pulses: Sequence[HalfSinePulse]) -> FloatArray:
        impacts = [Impact(request.impact, request.direction, pulse) for pulse in pulses]
        found = simulator(engine).point_histories(
            drive, start, [point], plan.step, plan.samples, impacts=impacts
        )
        return found[:, 0]

    return run
