"""Measured natural frequencies over the crank angle beside the computed ones."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.analyses.comparison.dataset import comparison_dataset
from flexmech.analyses.comparison.fit import fitted
from flexmech.analyses.comparison.frequency_problem import FrequencyProblem, nearest_mode
from flexmech.analyses.comparison.parameters import NOTHING, fitted_names
from flexmech.analyses.comparison.request import ComparisonRequest
from flexmech.analyses.requests import in_radians
from flexmech.errors import InputError, suggestion
from flexmech.linear_system import Engine
from flexmech.measured_data import MeasuredRecord
from flexmech.types import FloatArray, IntArray, StepProgress

# Crank speeds of a record that are those asked for, in rad/s.
SAME_SPEED = 1e-6
MOST_MODE = 50


def compared_over_angle(
    engine: Engine, record: MeasuredRecord, request: ComparisonRequest, progress: StepProgress
) -> xr.Dataset:
    """Lay measured natural frequencies beside computed ones, and fit stiffness.

    Parameters
    ----------
    engine : Engine
    record : MeasuredRecord
        Over the crank angle, with a column in Hz and perhaps one of the mode's number.
    request : ComparisonRequest
        With a crank speed.
    progress : callable

    Returns
    -------
    xarray.Dataset
        ``measured``, ``computed``, ``residual`` over sample, with its crank angle and mode, and
        the fit.

    Raises
    ------
    InputError
        If the record holds no frequencies, or something is fitted that they do not tell.
    ComputationError
        If the fit fails.
    """
    speed = float(request.speed or 0.0)
    column = _column(record, request.quantity)
    chosen = _at_speed(record, speed)
    frequency = np.asarray(record.quantity(column).values, dtype=float)[chosen]
    if not frequency.min() > 0:
        raise InputError(
            f"{record.source}: {column!r} has a frequency of {frequency.min():g} Hz; natural "
            "frequencies are positive: leave such rows out"
        )
    angle = _angles(record)[chosen]
    mode = _modes(engine, record, speed, angle, frequency, chosen)
    links = engine.mechanism.linkage.topology.link_names
    problem = FrequencyProblem(
        engine, speed, angle, mode, frequency, fitted_names(request.fit or (NOTHING,), links)
    )
    fit = fitted(problem, progress)
    dataset = comparison_dataset(
        engine,
        record,
        request,
        fit,
        frequency,
        fit.computed[0],
        dimension="sample",
        unit="Hz",
        column=column,
        quantity="natural frequency",
        first_frequency=float("nan"),
    )
    return dataset.assign_coords(crank_angle=("sample", angle), mode=("sample", mode)).assign_attrs(
        mode_found=int("mode" not in record.names)
    )


def _angles(record: MeasuredRecord) -> FloatArray:
    try:
        return in_radians("crank_angle", record.position)
    except InputError as error:
        raise InputError(
            f"{record.source}: its crank angle reaches {np.abs(record.position).max():.4g} rad; "
            "angles in degrees stand in a column such as crank_angle_deg, and those of more than "
            "eight turns are to be counted from zero in each turn"
        ) from error


def _column(record: MeasuredRecord, asked: str | None) -> str:
    """Name of the column of natural frequencies."""
    if asked is not None:
        quantity = record.quantity(asked)
        if quantity.unit != "Hz":
            raise InputError(
                f"quantity: {asked!r} is in {quantity.unit or '1'}; over the crank angle a column "
                "in Hz is compared with natural frequencies"
            )
        return quantity.name
    own = [quantity.name for quantity in record.quantities if quantity.unit == "Hz"]
    if len(own) == 1:
        return own[0]
    for name, reason in record.unreadable.items():
        if not own and "freq" in name.lower():
            raise InputError(reason)
    if own:
        raise InputError(
            f"{record.source}: holds {len(own)} columns of frequencies; choose one by --quantity: "
            f"{suggestion('frequency', own)}"
        )
    raise InputError(
        f"{record.source}: has no column in Hz; over the crank angle natural frequencies are "
        "compared: give a column such as frequency_Hz"
    )


def _at_speed(record: MeasuredRecord, speed: float) -> IntArray:
    """Rows that were taken at the crank speed asked for; all where the record does not tell."""
    if not record.has("crank_speed"):
        return np.arange(len(record.position))
    own = np.asarray(record.quantity("crank_speed").values, dtype=float)
    rows = np.flatnonzero(np.abs(own - speed) <= SAME_SPEED * max(1.0, abs(speed)))
    if not len(rows):
        known = ", ".join(f"{value:g}" for value in np.unique(own)[:10])
        raise InputError(
            f"{record.source}: was taken at crank speeds of {known} rad/s, not {speed:g}; give "
            "one of these with --speed"
        )
    return rows


def _modes(
    engine: Engine,
    record: MeasuredRecord,
    speed: float,
    angle: FloatArray,
    frequency: FloatArray,
    chosen: IntArray,
) -> IntArray:
    """Number of each row's mode: the record's own, or that of the nearest frequencies."""
    if not record.has("mode"):
        if len(np.unique(angle)) < len(angle):
            raise InputError(
                f"{record.source}: has several frequencies at one crank angle; add a column "
                "'mode' that numbers them from 1"
            )
        return np.full(len(angle), nearest_mode(engine, speed, angle, frequency))
    own = np.asarray(record.quantity("mode").values, dtype=float)[chosen]
    if np.any(own != np.round(own)) or own.min() < 1 or own.max() > MOST_MODE:
        raise InputError(
            f"{record.source}: the column 'mode' must number modes from 1 to {MOST_MODE}; give "
            "the lowest natural frequency number 1"
        )
    return own.astype(np.intp)
