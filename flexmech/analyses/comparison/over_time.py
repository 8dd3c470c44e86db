"""A record over time beside the running linkage."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr

from flexmech.analyses.comparison.dataset import CURVES, comparison_dataset
from flexmech.analyses.comparison.fit import fitted
from flexmech.analyses.comparison.parameters import DAMPING, fitted_names
from flexmech.analyses.comparison.quantities import matched
from flexmech.analyses.comparison.request import ComparisonRequest
from flexmech.analyses.comparison.time_problem import TimeProblem
from flexmech.analyses.response.spectra import amplitude_spectrum
from flexmech.errors import CRANK_SPEED, InputError
from flexmech.linear_system import Engine
from flexmech.measured_data import MeasuredRecord, sampling_interval
from flexmech.types import FloatArray, StepProgress

CRANK_ANGLE = "crank_angle"
# Relative difference of the record's own crank speed from the one given that is no rounding.
SPEED_TOLERANCE = 0.01
# Where less than the other part is explained, a gauge turned the other way is tried.
LITTLE_EXPLAINED = 0.5
# Spectra reach this far above the fastest moving mode.
SPECTRUM_REACH = 1.5


def compared_over_time(
    engine: Engine, record: MeasuredRecord, request: ComparisonRequest, progress: StepProgress
) -> xr.Dataset:
    """Align a record with the running linkage, and fit.

    Parameters
    ----------
    engine : Engine
    record : MeasuredRecord
        Over time.
    request : ComparisonRequest
        With a crank speed.
    progress : callable

    Returns
    -------
    xarray.Dataset
        ``measured``, ``computed``, ``residual`` and ``periodic`` over time, their spectra, the
        crank angle, and the fit.

    Raises
    ------
    InputError
        If the record has gaps or unequal steps, is too short or of another crank speed.
    ComputationError
        If the fit fails.
    """
    assert request.speed is not None
    pair = matched(record, request.quantity, engine)
    interval = sampling_interval(record.position, record.source, record.rounding)
    time: FloatArray = interval * np.arange(len(record.position), dtype=float)
    links = engine.mechanism.linkage.topology.link_names
    problem = TimeProblem(
        engine,
        request.speed,
        pair.gauge,
        time,
        np.asarray(pair.measured.values, dtype=float),
        _crank_angle(record, request.speed, time),
        fitted_names(request.fit or (DAMPING,), links),
        record.source,
    )
    fit = fitted(problem, progress)
    dataset = comparison_dataset(
        engine,
        record,
        request,
        fit,
        problem.record,
        fit.computed[0],
        dimension="time",
        unit=pair.gauge.unit,
        column=pair.measured.header or pair.measured.name,
        quantity=pair.gauge.column,
        first_frequency=problem.first_frequency,
    )
    values = dict(zip([p.name for p in fit.parameters], fit.values.tolist(), strict=True))
    angle = problem.crank_angle(values)
    dataset["periodic"] = "time", problem.forced(fit.values.tolist())
    dataset["periodic"].attrs.update(units=pair.gauge.unit or "1", long_name="periodic motion")
    dataset = dataset.assign_coords(
        time=record.position[0] + time, crank_angle=("time", angle)
    ).merge(_spectra(dataset, interval, problem.fastest_frequency))
    return dataset.assign_attrs(
        free_states=problem.linear_unknowns,
        bow=problem.bow(fit.values.tolist()),
        aligned_by="record" if problem.angle is None else "crank angle column",
        start_angle=float(np.mod(angle[0], 2 * np.pi)),
        turned_unexplained=_turned(problem, fit.unexplained),
    )


def _crank_angle(record: MeasuredRecord, speed: float, time: FloatArray) -> FloatArray | None:
    """Crank angle at each sample in rad, where the record has it, at a constant speed."""
    if CRANK_ANGLE not in (*record.names, *record.unreadable):
        return None
    column = record.quantity(CRANK_ANGLE)
    if column.unit != "rad":
        raise InputError(
            f"{record.source}: {column.header!r} is no angle; give the crank angle in deg or rad, "
            "or leave its column out"
        )
    own, start = np.polyfit(time, np.unwrap(np.asarray(column.values, dtype=float)), 1)
    if abs(own - speed) > SPEED_TOLERANCE * abs(speed):
        raise InputError(
            f"{record.source}: its crank turns at {own:.5g} rad/s ({own * 30 / np.pi:.5g} rpm) by "
            f"the column {column.header!r}, not at {CRANK_SPEED}; give that speed",
            crank_speed=speed,
        )
    return np.asarray(start + own * time)


def _turned(problem: TimeProblem, unexplained: float) -> float:
    """Part that remains unexplained of the record with the other sign, if little is explained."""
    if unexplained < LITTLE_EXPLAINED:
        return float("nan")
    other = replace(problem, record=-problem.record)
    start = {parameter.name: parameter.start for parameter in other.parameters}
    spread = float(np.sum((problem.record - problem.record.mean()) ** 2))
    return other.misfit(start) / spread


def _spectra(dataset: xr.Dataset, interval: float, fastest: float) -> xr.Dataset:
    """Amplitude spectra of the three curves under a Hann window."""
    curves = np.stack([dataset[name].values for name in CURVES])
    frequency, amplitude = amplitude_spectrum(curves, interval, SPECTRUM_REACH * fastest)
    spectrum = xr.DataArray(
        amplitude,
        dims=("curve", "spectrum_frequency"),
        coords={"curve": list(CURVES), "spectrum_frequency": frequency},
        attrs={"units": dataset.measured.attrs["units"], "long_name": "amplitude"},
    )
    return xr.Dataset({"spectrum": spectrum})
