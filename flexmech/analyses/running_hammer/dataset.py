"""From runs and prediction of a hammer test to one labelled dataset."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import provenance
from flexmech.analyses.running_hammer.measured import MeasuredResponse
from flexmech.analyses.running_hammer.peaks import order_peaks
from flexmech.analyses.running_hammer.prediction import Prediction
from flexmech.analyses.running_hammer.request import RunningHammerRequest
from flexmech.linear_system import Engine
from flexmech.time_domain.equations_of_motion import stretches_in_runs
from flexmech.time_domain.integrators import step_lag
from flexmech.types import ComplexArray

OVER_BOTH = ("order", "frequency")


def dataset_of(
    engine: Engine,
    request: RunningHammerRequest,
    prediction: Prediction,
    measured: MeasuredResponse,
    frozen: ComplexArray,
) -> xr.Dataset:
    """Label what was identified and what is predicted.

    Parameters
    ----------
    engine : Engine
    request : RunningHammerRequest
    prediction : Prediction
    measured : MeasuredResponse
    frozen : ndarray of complex, shape (O, B)

    Returns
    -------
    xarray.Dataset
        Over (order, frequency), each function by its real and imaginary part; over ``order``;
        and over ``impact``.
    """
    plan, estimate = measured.plan, measured.estimate
    orders = np.arange(-request.orders, request.orders + 1)
    frequency = plan.frequency
    identified = estimate.response[orders + plan.fitted]
    predicted = prediction.response(frequency, orders)
    errors = prediction.errors(frequency, orders)
    peaks = order_peaks(predicted, identified)
    variables: dict[str, Any] = {
        **_parts("receptance", identified),
        **_parts("predicted", predicted),
        **_parts("frozen", frozen),
        "step_error": ("order", errors.steps),
        "balance_error": ("order", errors.balance),
        "reduction_error": ("order", errors.reduction),
        "halving_change": ("order", measured.halving_change),
        "predicted_peak": ("order", peaks.predicted),
        "predicted_peak_frequency": ("order", frequency[peaks.predicted_bin]),
        "identified_peak": ("order", peaks.identified),
        "identified_peak_frequency": ("order", frequency[peaks.identified_bin]),
        "bins_apart": ("order", np.abs(peaks.identified_bin - peaks.predicted_bin)),
        "impact_angle": ("impact", np.sign(request.crank_speed) * 2 * np.pi * plan.phase),
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
        provenance([engine]),
        engine=engine.name,
        element=engine.element,
        crank_speed=request.crank_speed,
        speed_unit=request.speed_unit,
        impact_point=str(request.impact),
        response_point=str(request.response),
        direction=request.direction,
        prestress=request.prestress,
        damping_ratio=np.nan if request.damping_ratio is None else request.damping_ratio,
        averages=request.averages,
        noise=request.noise,
        seed=request.seed,
        bandwidth=plan.bandwidth,
        pulse=plan.pulse,
        peak_force=plan.peak_force,
        peak_response=measured.peak_response,
        turns=plan.turns,
        turn_time=plan.turn_time,
        step=plan.step,
        step_lag=step_lag(
            2 * np.pi * plan.bandwidth * plan.step,
            stretches=stretches_in_runs(engine, request.prestress),
        ),
        highest_fitted_order=plan.fitted,
        condition=estimate.condition,
        misfit=estimate.misfit,
        twin_defect=measured.twin_defect,
        moving_modes=prediction.moving_modes,
        propagator_steps=prediction.steps,
        decay_rate=-prediction.growth_rate,
    )


def _parts(name: str, values: ComplexArray) -> dict[str, Any]:
    return {f"{name}_real": (OVER_BOTH, values.real), f"{name}_imag": (OVER_BOTH, values.imag)}
