"""Measured natural frequencies over the crank angle beside the computed ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr

from flexmech.analyses.comparison.fit import Fit
from flexmech.analyses.comparison.problem import (
    DAMPING,
    GAIN,
    NOTHING,
    OFFSET,
    ComparisonRequest,
    LinearTerms,
    RecordProblem,
    fitted_engine,
    fitted_names,
    rows_taken_at,
)
from flexmech.analyses.crank_speeds import RAD_S, in_unit
from flexmech.analyses.frequencies.positions import natural_frequencies
from flexmech.analyses.requests import in_radians
from flexmech.arrays import FloatArray, IntArray
from flexmech.errors import InputError, suggestion
from flexmech.measured_data import MeasuredRecord
from flexmech.mechanics import Engine
from flexmech.units import from_si

# Crank speeds of a record that are those asked for, but for rounding, in rad/s.
_SAME_SPEED = 1e-6
# A number beyond it is taken for a slip: no test tells so many modes apart.
_MOST_MODE = 50
# Modes among which a record without their numbers is placed: a test seldom tells more.
_CANDIDATES = 6
# Relative: a record is placed at a mode that is so near to it on average, and the only one so near,
# where the next one is so many times as far.
_NEAR, _TIMES_FARTHER = 0.025, 3.0
# A message names so many of the nearest modes.
_MODES_NAMED = 3


@dataclass(frozen=True, kw_only=True)
class FrequencyProblem(RecordProblem):
    """Natural frequencies of modes at crank angles, in Hz.

    Parameters
    ----------
    engine : Engine
    record : ndarray, shape (N,)
    names : tuple of str
    column, unit, quantity : str
    crank_speed : float
        In rad/s.
    angle : ndarray, shape (N,)
        In rad.
    mode : ndarray of int, shape (N,)
        From 1.
    mode_found : bool
        Whether the mode was found by its frequencies.
    """

    crank_speed: float
    angle: FloatArray
    mode: IntArray
    mode_found: bool

    dimension = "sample"

    def linear_terms(self, values: Mapping[str, float]) -> LinearTerms:
        """Computed frequencies (N,); no gain is fitted to them."""
        engine = fitted_engine(self.engine, values)
        frequencies = _frequencies(engine, self.crank_speed, self.angle, int(self.mode.max()))
        of_modes = frequencies[np.arange(len(self.angle)), self.mode - 1]
        return LinearTerms({GAIN: np.asarray(of_modes)})

    def labelled(self, dataset: xr.Dataset, fit: Fit) -> xr.Dataset:
        """The dataset with crank angle and mode of each sample."""
        angle, mode = ("sample", self.angle), ("sample", self.mode)
        labelled = dataset.assign_coords(crank_angle=angle, mode=mode)
        return labelled.assign_attrs(mode_found=int(self.mode_found))


def frequency_problem(
    engine: Engine, record: MeasuredRecord, request: ComparisonRequest
) -> FrequencyProblem:
    """Read natural frequencies over the crank angle, with their modes.

    Parameters
    ----------
    engine : Engine
    record : MeasuredRecord
        Over the crank angle, with a column in Hz and perhaps one of the mode's number.
    request : ComparisonRequest
        With a crank speed.

    Returns
    -------
    FrequencyProblem

    Raises
    ------
    InputError
        If the record holds no frequencies, or something is fitted that they do not tell.
    """
    speed = float(request.crank_speed or 0.0)
    column = _column(record, request.quantity)
    chosen = _at_speed(record, speed, request.speed_unit or RAD_S)
    frequency = np.asarray(record.quantity(column).values, dtype=float)[chosen]
    if not frequency.min() > 0:
        raise InputError(
            f"{record.source}: {column!r} has a frequency of {frequency.min():g} Hz; natural "
            "frequencies are positive: leave such rows out"
        )
    links = engine.mechanism.linkage.topology.link_names
    names = fitted_names(request.fit or (NOTHING,), links)
    if any(name.startswith(DAMPING) for name in names):
        raise InputError(
            "fit: natural frequencies hardly change with damping and do not tell it; fit "
            "stiffness:LINK, or give a record over time or a frequency-response function"
        )
    if OFFSET in names or GAIN in names:
        raise InputError("fit: frequencies have no offset and no gain; fit stiffness:LINK")
    angle = _angles(record)[chosen]
    mode = _modes(engine, record, speed, angle, frequency, chosen)
    return FrequencyProblem(
        engine=engine,
        record=frequency,
        names=names,
        column=column,
        unit="Hz",
        quantity="natural frequency",
        crank_speed=speed,
        angle=angle,
        mode=mode,
        mode_found=not record.has("mode"),
    )


def _frequencies(engine: Engine, crank_speed: float, angle: FloatArray, modes: int) -> FloatArray:
    prestress = "equilibrium" if crank_speed else engine.prestress_at_rest
    return natural_frequencies(engine, angle, crank_speed, modes=modes, prestress=prestress)


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
    names = [quantity.name for quantity in record.quantities if quantity.unit == "Hz"]
    if len(names) == 1:
        return names[0]
    if names:
        raise InputError(
            f"{record.source}: holds {len(names)} columns of frequencies; choose one by "
            f"--quantity: {suggestion('frequency', names)}"
        )
    for name, reason in record.unreadable.items():
        if "freq" in name.lower():
            raise InputError(reason)
    raise InputError(
        f"{record.source}: has no column in Hz; over the crank angle natural frequencies are "
        "compared: give a column such as frequency_Hz"
    )


def _at_speed(record: MeasuredRecord, speed: float, unit: str = RAD_S) -> IntArray:
    """Rows that were taken at the crank speed asked for; all where the record does not tell."""
    if not record.has("crank_speed"):
        return np.arange(len(record.position))
    speeds = np.asarray(record.quantity("crank_speed").values, dtype=float)
    near = np.abs(speeds - speed) <= _SAME_SPEED * max(1.0, abs(speed))
    known, asked = in_unit(speeds, unit), from_si(speed, unit)
    return rows_taken_at(record, near, known, asked, "speed", unit)


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
        computed = _frequencies(engine, speed, angle, _CANDIDATES)
        apart = np.abs(computed / frequency[:, None] - 1).mean(axis=0)
        nearest, next_one = np.sort(apart)[:2] if len(apart) > 1 else (apart[0], np.inf)
        if nearest > _NEAR or next_one < max(_NEAR, _TIMES_FARTHER * nearest):
            nearest_modes = sorted(np.argsort(apart)[:_MODES_NAMED])
            far = ", ".join(f"from mode {n + 1} by {100 * apart[n]:.3g} %" for n in nearest_modes)
            raise InputError(
                f"{record.source}: does not name the modes of its frequencies, and no single "
                f"mode is near them: they differ {far}; add a column 'mode' that numbers "
                "them from 1 (1 for fundamental frequencies)"
            )
        return np.full(len(angle), int(apart.argmin()) + 1)
    numbers = np.asarray(record.quantity("mode").values, dtype=float)[chosen]
    if np.any(numbers != np.round(numbers)) or numbers.min() < 1 or numbers.max() > _MOST_MODE:
        raise InputError(
            f"{record.source}: the column 'mode' must number modes from 1 to {_MOST_MODE}; give "
            "the lowest natural frequency number 1"
        )
    return numbers.astype(np.intp)
