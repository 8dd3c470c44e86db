"""A hammer test on the running linkage: runs, identification and prediction."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from flexmech.analyses.beam_theory import theory_attributes
from flexmech.analyses.crank_speeds import GREATEST, RAD_S, asked_speeds, in_unit
from flexmech.analyses.damping_ratios import (
    CountedLoss,
    lowest_frequency,
    with_damping_ratio,
    with_damping_time,
)
from flexmech.analyses.datasets import attributes_of, complex_parts, provenance, with_units
from flexmech.analyses.hammer.request import middle_of
from flexmech.analyses.requests import engine_of
from flexmech.analyses.running_hammer.measured import MeasuredResponse, measured_response, runner
from flexmech.analyses.running_hammer.plan import GUARD_ORDERS, planned
from flexmech.analyses.running_hammer.prediction import (
    Prediction,
    frozen_response,
    predicted_linkage,
)
from flexmech.analyses.running_hammer.request import RunningHammerRequest
from flexmech.analyses.running_hammer.result import RunningHammerTest
from flexmech.arrays import ComplexArray, IntArray, LabelledProgress, silent
from flexmech.errors import InputError
from flexmech.linear_system import Engine
from flexmech.linkages import refuse_passing
from flexmech.mechanism import Mechanism
from flexmech.threads import one_thread
from flexmech.time_domain import step_lag, stretches_in_runs

# Of the first natural frequency at rest: the bandwidth, if none is asked for. It holds the first
# resonance and the beginning of what lies between it and the second.
_BANDWIDTH = 2.0
# Natural frequencies that elements which were not asked for must be fit for: those that the orders
# asked for and their guards reach at usual crank speeds.
_MODES = 6
# How far from the predicted peak the identified one is sought: in bins, and of its frequency. That
# is beyond what damping shifts, and nearer than the next resonance.
_BINS, _NEAR = 5, 0.05
# What a dataset has of the request as it is.
_OF_REQUEST = ["direction", "prestress", "averages", "noise", "seed"]


def running_hammer_test(
    engine: Engine | Mechanism,
    speed: RunningHammerRequest | float | None = None,
    *,
    speed_unit: str | None = None,
    progress: LabelledProgress | None = None,
) -> RunningHammerTest:
    """Hit the running linkage with a hammer: harmonic transfer functions H_n(f).

    The running linkage is a periodic system: a force at f answers at f and at f plus or minus
    multiples of the crank's frequency. H_n(f) is the response at f + n f_crank to a force at f, in
    the axes of the links' rigid frames, with phases that count from crank angle 0. Impacts at
    evenly spaced, jittered crank angles tell the orders apart; a twin run without an impact is
    subtracted. The time-varying linear model predicts the same functions.

    Parameters
    ----------
    engine : Engine or Mechanism
        Exudyn runs the nonlinear motion, the reference engine its own equations; of a mechanism
        that one is made.
    speed : float or RunningHammerRequest, optional
        Crank speed in ``speed_unit``, or all that a test can be asked to be. Left out: the greatest
        speed at which the mechanism operates.
    speed_unit : str, optional
        Unit of the speed, such as ``"rpm"``, in which the result speaks of it. Left out: rad/s,
        that of the request, or that of the model file for the mechanism's speed.
    progress : callable, optional
        Called as ``progress(label, done, total)``.

    Returns
    -------
    RunningHammerTest

    Raises
    ------
    InputError
        If a point is on no link of the linkage, the linkage is not damped, or the record cannot
        be as asked for.
    ComputationError
        If vibrations grow at this crank speed, or a run fails.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> engine = flexmech.ReferenceEngine(mechanism, elements=2)
    >>> hit, seen = map(flexmech.LinkPoint.parse, ("coupler:0.5", "rocker:0.5"))
    >>> request = flexmech.RunningHammerRequest(
    ...     20.0, hit, seen, prestress="axial", damping_ratio=0.1, bandwidth=60.0, orders=1
    ... )
    >>> found = flexmech.running_hammer_test(engine, request)
    >>> found.peaks()["order"].tolist()
    [-1, 0, 1]
    """
    chosen, report = engine_of(engine).fit_for(_MODES), progress or silent
    request = _request(speed, speed_unit, chosen.mechanism)
    with one_thread():
        for point in (request.impact, request.response):
            point.index(chosen.mechanism.linkage.topology)
        # A crank that cannot turn round shows itself here, before anything is computed.
        turn = np.linspace(0.0, 2 * np.pi, 73)
        chosen.mechanism.linkage.motion(turn, 1.0)
        refuse_passing(chosen.mechanism.linkage, turn)
        attributes = theory_attributes([chosen], _MODES)
        if request.damping_ratio is not None:
            chosen = with_damping_ratio(chosen, request.damping_ratio)
        else:
            loss = CountedLoss.of(chosen)
            chosen = loss.engine(chosen)
            attributes |= loss.attributes
        bandwidth = _bandwidth(chosen, request)
        fitted = request.orders + GUARD_ORDERS
        crank = abs(request.speed) / (2 * np.pi)
        prediction = predicted_linkage(chosen, request, bandwidth + fitted * crank)
        plan = planned(chosen, request, prediction, bandwidth)
        run = runner(chosen, request, plan, prediction.modes)
        measured = measured_response(run, request, plan, report)
        orders = np.arange(-request.orders, request.orders + 1)
        frozen = frozen_response(chosen, request, plan.frequency, orders)
        dataset = _dataset(chosen, request, prediction, measured, frozen)
    dataset.attrs |= attributes
    return RunningHammerTest(with_units(dataset, "running_hammer"))


def _request(
    speed: RunningHammerRequest | float | None, unit: str | None, mechanism: Mechanism
) -> RunningHammerRequest:
    """All that a test is asked to be; as it is usual where the speed alone is given."""
    if isinstance(speed, RunningHammerRequest):
        if unit is not None:
            raise InputError("speed_unit: the request has its own; give it there")
        return speed
    if speed is None:
        speeds, shown = asked_speeds(None, unit, mechanism, GREATEST)
        speed, unit = float(in_unit(speeds, shown)[0]), shown
    middle = middle_of(mechanism.linkage.topology)
    return RunningHammerRequest(speed, middle, middle, speed_unit=unit)


def _bandwidth(engine: Engine, request: RunningHammerRequest) -> float:
    """Highest frequency of the input in Hz."""
    if request.bandwidth is not None:
        return request.bandwidth
    undamped = with_damping_time(engine, 0.0)
    chosen = _BANDWIDTH * lowest_frequency(undamped) / (2 * np.pi)
    return chosen if request.pulse is None else min(chosen, 1 / request.pulse)


def _dataset(
    engine: Engine,
    request: RunningHammerRequest,
    prediction: Prediction,
    measured: MeasuredResponse,
    frozen: ComplexArray,
) -> xr.Dataset:
    """Label what was identified and what is predicted, over order, frequency and impact."""
    plan, estimate = measured.plan, measured.estimate
    orders = np.arange(-request.orders, request.orders + 1)
    frequency = plan.frequency
    identified = estimate.response[orders + plan.fitted]
    predicted = prediction.response(frequency, orders)
    errors = prediction.errors(frequency, orders)
    at, found = _peak_bins(predicted, identified)
    rows = np.arange(len(orders))
    variables: dict[str, Any] = {
        **complex_parts("receptance", ("order", "frequency"), identified),
        **complex_parts("predicted", ("order", "frequency"), predicted),
        **complex_parts("frozen", ("order", "frequency"), frozen),
        "step_error": ("order", errors.steps),
        "balance_error": ("order", errors.balance),
        "reduction_error": ("order", errors.reduction),
        "halving_change": ("order", measured.halving_change),
        "predicted_peak": ("order", np.abs(predicted)[rows, at]),
        "predicted_peak_frequency": ("order", frequency[at]),
        "identified_peak": ("order", np.abs(identified)[rows, found]),
        "identified_peak_frequency": ("order", frequency[found]),
        "bins_apart": ("order", np.abs(found - at)),
        "impact_angle": ("impact", np.sign(request.speed) * 2 * np.pi * plan.phase),
        "decay": ("impact", measured.decay),
    }
    dataset = xr.Dataset(
        variables,
        coords={
            "order": orders,
            "frequency": frequency,
            "impact": np.arange(1, len(plan.phase) + 1),
        },
    )
    return dataset.assign_attrs(
        provenance([engine])
        | attributes_of(request, *_OF_REQUEST)
        | attributes_of(plan, "bandwidth", "pulse", "peak_force", "turns", "turn_time", "step")
        | attributes_of(measured, "peak_response", "twin_defect")
        | attributes_of(estimate, "condition", "misfit"),
        crank_speed=request.speed,
        speed_unit=request.speed_unit or RAD_S,
        engine=engine.name,
        element=engine.element,
        impact_point=str(request.impact),
        response_point=str(request.response),
        damping_ratio=np.nan if request.damping_ratio is None else request.damping_ratio,
        step_lag=step_lag(
            2 * np.pi * plan.bandwidth * plan.step,
            stretches=stretches_in_runs(engine, request.prestress),
        ),
        highest_fitted_order=plan.fitted,
        moving_modes=prediction.moving_modes,
        propagator_steps=prediction.steps,
        decay_rate=-prediction.growth_rate,
    )


def _peak_bins(predicted: ComplexArray, identified: ComplexArray) -> tuple[IntArray, IntArray]:
    """Bins (O,) of the greatest amplitude predicted of each order, and identified near it."""
    amplitude, other = np.abs(predicted), np.abs(identified)
    own = amplitude.argmax(axis=1)
    reach = np.maximum(_BINS, _NEAR * own)
    place = np.arange(amplitude.shape[1])
    near = np.where(np.abs(place - own[:, None]) <= reach[:, None], other, -1.0)
    return own, near.argmax(axis=1)
