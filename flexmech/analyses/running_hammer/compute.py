"""A hammer test on the running linkage: runs, identification and prediction."""

from __future__ import annotations

import numpy as np

from flexmech.analyses.beam_theory import theory_attributes
from flexmech.analyses.damping_ratios import lowest_frequency, with_damping_ratio, with_damping_time
from flexmech.analyses.datasets import with_units
from flexmech.analyses.requests import engine_of
from flexmech.analyses.running_hammer.dataset import dataset_of
from flexmech.analyses.running_hammer.measured import measured_response
from flexmech.analyses.running_hammer.plan import GUARD_ORDERS, planned
from flexmech.analyses.running_hammer.prediction import frozen_response, predicted_linkage
from flexmech.analyses.running_hammer.request import RunningHammerRequest
from flexmech.analyses.running_hammer.result import RunningHammerTest
from flexmech.analyses.running_hammer.runs import runner
from flexmech.linear_system import Engine
from flexmech.numbers import check_instance
from flexmech.threads import one_thread
from flexmech.types import LabelledProgress, silent

# Of the first natural frequency at rest: the bandwidth, if none is asked for.
BANDWIDTH = 2.0
# Natural frequencies that elements which were not asked for must be fit for.
MODES = 6


def running_hammer_test(
    engine: Engine,
    request: RunningHammerRequest,
    *,
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
    engine : Engine
        Exudyn runs the nonlinear motion, the reference engine its own equations.
    request : RunningHammerRequest
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
    check_instance(
        request,
        RunningHammerRequest,
        "request",
        "write flexmech.RunningHammerRequest(20.0, impact, response, damping_ratio=0.005)",
    )
    report = progress or silent
    with one_thread():
        chosen = engine_of(engine).fit_for(MODES)
        if chosen.simulates:
            chosen.require_no_connectors("the running hammer test by Exudyn's runs")
        for point in (request.impact, request.response):
            point.index(chosen.mechanism.linkage.topology)
        # A crank that cannot turn round shows itself here, before anything is computed.
        chosen.mechanism.linkage.motion(np.linspace(0.0, 2 * np.pi, 73), 1.0)
        if request.damping_ratio is not None:
            chosen = with_damping_ratio(chosen, request.damping_ratio)
        bandwidth = _bandwidth(chosen, request)
        fitted = request.orders + GUARD_ORDERS
        crank = abs(request.crank_speed) / (2 * np.pi)
        prediction = predicted_linkage(chosen, request, bandwidth + fitted * crank)
        plan = planned(chosen, request, prediction, bandwidth)
        run = runner(chosen, request, plan, prediction.modes)
        measured = measured_response(run, request, plan, report)
        orders = np.arange(-request.orders, request.orders + 1)
        frozen = frozen_response(chosen, request, plan.frequency, orders)
        dataset = dataset_of(chosen, request, prediction, measured, frozen)
    dataset.attrs |= theory_attributes([chosen], MODES)
    return RunningHammerTest(with_units(dataset, "running_hammer"))


def _bandwidth(engine: Engine, request: RunningHammerRequest) -> float:
    """Highest frequency of the input in Hz."""
    if request.bandwidth is not None:
        return request.bandwidth
    undamped = with_damping_time(engine, 0.0)
    chosen = BANDWIDTH * lowest_frequency(undamped) / (2 * np.pi)
    return chosen if request.pulse is None else min(chosen, 1 / request.pulse)
