"""What a Campbell diagram answers: whether a speed is clear of the crank's orders."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import xarray as xr

from flexmech.analyses.campbell.crossings import ray
from flexmech.analyses.campbell.words import (
    computed_ranges,
    is_computed,
    not_computed,
    without,
)
from flexmech.analyses.digits import Quantity, rounded
from flexmech.analyses.summary import EngineDifference, Table, speed_text, trust_line
from flexmech.arrays import FloatArray
from flexmech.plots.reading import merged, speed_unit
from flexmech.units import from_si

PARTS = ("lowest_frequency", "mean_frequency", "highest_frequency")
# Operating speeds that have a sentence each; of more the greatest has, and the others share one.
_MOST_TOLD = 2
# Ranges that one sentence can list.
_MOST_LISTED = 4
# Speeds of a range that a cubic curve needs.
_CUBIC = 4
# A speed meets the range of an order by which the range itself changes: few steps settle it.
_STEPS = 8


@dataclass(frozen=True)
class CriticalRange:
    """Speeds at which an order meets a branch of the first engine.

    Parameters
    ----------
    order, branch : int
        Counted from 1.
    start, end : float
        In rad/s, the smaller first.
    is_cut : tuple of bool
        Whether the diagram begins or ends inside of the range, so that its own end is beyond.
    error : float
        Relative, of an end that is not cut.
    """

    order: int
    branch: int
    start: float
    end: float
    is_cut: tuple[bool, bool]
    error: float

    @property
    def end_errors(self) -> tuple[float, float]:
        """Of start and end in rad/s; not a number where the range is cut."""
        ends = zip((self.start, self.end), self.is_cut, strict=True)
        first, last = (math.nan if cut else abs(end) * self.error for end, cut in ends)
        return first, last


def operating_speeds(dataset: xr.Dataset) -> list[float]:
    """Operating speeds of the model file among the speeds of the diagram, in rad/s."""
    named = [float(speed) for speed in str(dataset.attrs.get("operating_speeds", "")).split()]
    low, high = np.sort(dataset["crank_speed"].values[[0, -1]])
    # What went through another unit may be off by its last digits.
    slack = 1e-9 * max(abs(low), abs(high))
    return [speed for speed in named if low - slack <= speed <= high + slack]


def answer(dataset: xr.Dataset) -> tuple[str, ...]:
    """Flutter, whether the operating speeds are clear of the orders, and which to avoid."""
    speeds = sorted(operating_speeds(dataset), key=abs, reverse=True)
    told = len(speeds) if len(speeds) <= _MOST_TOLD else 1
    sentences = [_at_speed(dataset, speed) for speed in speeds[:told]]
    sentences += [_at_others(dataset, speeds[told:])] if speeds[told:] else []
    flutters = filter(None, [str(dataset.attrs.get("flutter", ""))])
    return (*flutters, *sentences, _speeds_to_avoid(dataset))


def numbers(dataset: xr.Dataset) -> tuple[Quantity, ...]:
    """Ends of all critical ranges of speed, and frequencies at the greatest operating speed."""
    unit, found = speed_unit(dataset), list[Quantity]()
    for met in critical_ranges(dataset):
        of = f"order {met.order}, branch {met.branch}"
        ends = zip(("from", "to"), (met.start, met.end), met.end_errors, strict=True)
        found += [
            Quantity(
                f"critical_speed_{name}", from_si(end, unit), unit, abs(from_si(error, unit)), of
            )
            for name, end, error in ends
        ]
    named = [speed for speed in operating_speeds(dataset) if is_computed(dataset, speed)]
    for speed in sorted(named, key=abs)[-1:]:
        for branch in range(dataset.sizes["branch"]):
            bands, errors = band_at(dataset, speed, branch)
            found += [
                Quantity(f"{part}_at_operating_speed", value, "Hz", away, f"branch {branch + 1}")
                for part, value, away in zip(PARTS, bands.tolist(), errors.tolist(), strict=True)
                if math.isfinite(value)
            ]
    return tuple(found)


def band_table(dataset: xr.Dataset) -> Table:
    """Frequencies at the greatest operating speed, or at the greatest speed of the diagram."""
    unit = speed_unit(dataset)
    named = [speed for speed in operating_speeds(dataset) if is_computed(dataset, speed)]
    every = (end for ends in computed_ranges(dataset) for end in ends)
    speed = max(named or every, key=abs)
    rows = []
    for branch in range(dataset.sizes["branch"]):
        bands, errors = band_at(dataset, speed, branch)
        cells = (rounded(*pair) for pair in zip(bands, errors, strict=True))
        rows.append((f"f{branch + 1}", *cells))
    return Table(
        f"natural frequencies at {speed_text(speed, unit)} {unit}, "
        f"{dataset.attrs.get('mechanism', '')}",
        ("branch", "lowest Hz", "mean Hz", "highest Hz"),
        (tuple(rows),),
        caption="over the turn; no order meets a branch among the speeds asked for",
    )


def band_at(dataset: xr.Dataset, speed: float, branch: int) -> tuple[FloatArray, FloatArray]:
    """Lowest, mean and highest frequency of a branch at a speed, by the first engine.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of the diagram.
    speed : float
        Crank speed in rad/s.
    branch : int
        Counted from 0.

    Returns
    -------
    values, errors : ndarray, shape (3,)
        Hz; errors by mesh and fit, and between the speeds by what a cubic curve makes of it.
    """
    speeds = dataset["band_speed"].values
    values = dataset["band_frequency"].values[0, :, :, branch].T
    known = np.isfinite(values).all(axis=0)
    if not known.any():
        return np.full(3, np.nan), np.full(3, np.nan)
    at, values = speeds[known], values[:, known]
    straight = np.array([np.interp(speed, at, row) for row in values])
    curved = straight
    if len(at) >= _CUBIC:
        from scipy.interpolate import CubicSpline

        curved = np.asarray(CubicSpline(at, values, axis=1)(np.clip(speed, at[0], at[-1])))
    return curved, _error(dataset, branch) * curved + np.abs(curved - straight)


def _error(dataset: xr.Dataset, branch: int) -> float:
    """Relative error of a branch's frequencies by mesh and fit, and the engines' difference."""
    mesh = float(dataset["discretisation_error"].isel(branch=branch).max())
    fit = float(dataset["fit_error"].max())
    apart = engines_apart(dataset.isel(branch=[branch]))
    return max(mesh + fit, apart if math.isfinite(apart) else 0.0)


def engines_apart(dataset: xr.Dataset) -> float:
    """Greatest relative difference of two engines' frequencies; not a number with one engine."""
    if dataset.sizes["engine"] < 2:
        return math.nan
    values = np.stack([dataset[part].values[:2] for part in PARTS])
    apart = np.abs(values[:, 1] / values[:, 0] - 1)
    return float(np.nanmax(apart)) if np.isfinite(apart).any() else math.nan


def engine_difference(dataset: xr.Dataset) -> EngineDifference | None:
    """That of the branches of two engines which their errors explain least.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of the diagram.

    Returns
    -------
    EngineDifference or None
        None where there are no two engines' frequencies to compare.
    """
    apart, allowed = [], []
    for branch in range(dataset.sizes["branch"]):
        own = dataset.isel(branch=[branch])
        difference = engines_apart(own)
        if not math.isfinite(difference):
            continue
        mesh = own["discretisation_error"]
        error = mesh.max([name for name in mesh.dims if name != "engine"]) + own["fit_error"]
        apart.append(difference)
        allowed.append(float(error.sum()))
    return EngineDifference.least_explained(apart, allowed) if apart else None


def trust(dataset: xr.Dataset) -> str:
    """How far frequencies and critical speeds are known."""
    names = [str(name) for name in dataset["engine"].values]
    error = float(dataset["discretisation_error"].max()) + float(dataset["fit_error"].max())
    return trust_line(names, error, engine_difference(dataset))


def critical_ranges(dataset: xr.Dataset) -> list[CriticalRange]:
    """Ranges of speed in which an order meets a branch of the first engine.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of the diagram.

    Returns
    -------
    list of CriticalRange
    """
    own = (dataset["critical_engine"] == dataset["engine"].values[0]) & (
        dataset["critical_gap"] == 0
    )
    met = dataset.isel(critical=np.flatnonzero(own.values))
    columns = (
        met[f"critical_{name}"].values.tolist()
        for name in ("order", "branch", "start", "end", "starts_inside", "ends_inside")
    )
    return [
        CriticalRange(order, branch, start, end, (before, after), _error(dataset, branch - 1))
        for order, branch, start, end, before, after in zip(*columns, strict=True)
    ]


def _orders_text(dataset: xr.Dataset) -> str:
    orders = dataset["order"].values
    first, last = int(orders.min()), int(orders.max())
    if len(orders) <= 2:
        return f"order{'s' * (len(orders) > 1)} {' and '.join(map(str, orders.tolist()))}"
    whole = len(orders) == last - first + 1
    listed = f"{first} to {last}" if whole else ", ".join(map(str, orders.tolist()))
    return f"orders {listed}"


def _meet(dataset: xr.Dataset) -> str:
    return "meets" if dataset.sizes["order"] == 1 else "meet"


def _at_speed(dataset: xr.Dataset, speed: float) -> str:
    """Whether a speed is clear of the orders, its lowest frequency, and the nearest order."""
    name = _name(dataset, speed)
    if not is_computed(dataset, speed):
        return f"Whether {name} is critical is not known: nothing was computed there."
    bands, errors = band_at(dataset, speed, 0)
    ends = [rounded(bands[n], errors[n]) for n in (0, 2)]
    first = f"f1 is {' to '.join(dict.fromkeys(ends))} Hz"
    if here := _met_at(dataset, speed):
        listed = "; ".join(
            f"order {met.order} meets f{met.branch} at {_range(dataset, [met])}" for met in here
        )
        return f"{name} is critical: {listed}; {first}."
    nearest = _nearest(dataset, speed)
    return f"{name} is clear of {_orders_text(dataset)}; {first}{nearest}."


def _at_others(dataset: xr.Dataset, speeds: list[float]) -> str:
    """Which of several speeds are clear of the orders, critical, or not computed."""
    states, parts = [_state(dataset, speed) for speed in speeds], []
    for word in ("critical", "clear", "not computed"):
        names = [_name(dataset, w) for w, each in zip(speeds, states, strict=True) if each == word]
        if names:
            parts.append(f"{', '.join(names)} {'is' if len(names) == 1 else 'are'} {word}")
    return f"Of the other operating speeds {'; '.join(parts)}."


def _state(dataset: xr.Dataset, speed: float) -> str:
    if not is_computed(dataset, speed):
        return "not computed"
    return "critical" if _met_at(dataset, speed) else "clear"


def _name(dataset: xr.Dataset, speed: float) -> str:
    unit = speed_unit(dataset)
    return f"{speed_text(speed, unit)} {unit}"


def _met_at(dataset: xr.Dataset, speed: float) -> list[CriticalRange]:
    return [met for met in critical_ranges(dataset) if met.start <= speed <= met.end]


def _range(dataset: xr.Dataset, met: list[CriticalRange]) -> str:
    """Ends of ranges that overlap in the user's unit, with the digits that are known."""
    unit, texts = speed_unit(dataset), []
    first, last = min(met, key=lambda one: one.start), max(met, key=lambda one: one.end)
    for one, place, beyond in ((first, 0, "less"), (last, 1, "more")):
        end, error = (one.start, one.end)[place], one.end_errors[place]
        if one.is_cut[place]:
            texts.append(f"{speed_text(end, unit)} or {beyond}")
        else:
            texts.append(rounded(from_si(end, unit), abs(from_si(error, unit))))
    return f"{' to '.join(dict.fromkeys(texts))} {unit}"


def _nearest(dataset: xr.Dataset, speed: float) -> str:
    """The lowest order that meets the lowest branch at a speed, or nearest to it; empty at rest.

    Higher branches are met by orders so high that they excite nothing.
    """
    bands, _ = band_at(dataset, speed, 0)
    if not speed or not np.isfinite(bands).all():
        return ""
    per_order = float(ray(1, speed))
    first, last = math.ceil(bands[0] / per_order), math.floor(bands[2] / per_order)
    if first <= last:
        met = _range(dataset, [_meeting_of(dataset, speed, first)])
        return f"; the lowest order that meets f1 there is {first}, at {met}"
    found = list[CriticalRange]()
    # The order just below the band, and the one just above it.
    for order in {last, first} - {0}:
        found.append(_meeting_of(dataset, speed, order))
    nearest = min(found, key=lambda one: max(one.start - speed, speed - one.end))
    return f"; the nearest is order {nearest.order}, which meets f1 at {_range(dataset, [nearest])}"


def _meeting_of(dataset: xr.Dataset, speed: float, order: int) -> CriticalRange:
    """The range about a speed in which any order meets the lowest branch."""
    low, high = sorted(_meeting(dataset, speed, order, end) for end in (0, 2))
    return CriticalRange(order, 1, low, high, (False, False), _error(dataset, 0))


def _meeting(dataset: xr.Dataset, speed: float, order: int, end: int) -> float:
    """Speed in rad/s at which an order meets an end of the lowest branch's band.

    Bands beyond the speeds of the diagram are taken as at its last one.
    """
    found = speed
    for _ in range(_STEPS):
        hertz = float(band_at(dataset, found, 0)[0][end])
        found = math.copysign(2 * math.pi * hertz / order, speed)
    return found


def _speeds_to_avoid(dataset: xr.Dataset) -> str:
    """All critical ranges of the diagram as one sentence, and the widest range without one."""
    unit, orders = speed_unit(dataset), _orders_text(dataset)
    met, computed, unknown = critical_ranges(dataset), computed_ranges(dataset), ""
    if missing := not_computed(dataset):
        unknown = f"; {missing}"
    groups = [
        [one for one in met if start <= one.start and one.end <= end]
        for start, end in merged((one.start, one.end) for one in met)
    ]
    if not groups:
        ranges = [f"from {' to '.join(speed_text(w, unit) for w in ends)}" for ends in computed]
        return (
            f"No speed {' and '.join(ranges)} {unit} is critical: {orders} of the crank "
            f"{_meet(dataset)} no frequency{unknown}."
        )
    if len(groups) > _MOST_LISTED:
        avoid = f"{len(groups)} ranges of speed, {_range(dataset, met)}"
    else:
        avoid = ", ".join(_range(dataset, group) for group in groups)
    said = f"Avoid {avoid}: there {orders} of the crank {_meet(dataset)} a frequency"
    clear = without(computed, [_ends(group) for group in groups])
    if not clear:
        return f"{said}; no speed of the diagram is clear{unknown}."
    error = max(one.error for one in met)
    widest = max(clear, key=lambda ends: ends[1] - ends[0])
    first, last = (rounded(from_si(w, unit), abs(from_si(w, unit)) * error) for w in widest)
    return f"{said}; the widest range that is clear is {first} to {last} {unit}{unknown}."


def _ends(group: list[CriticalRange]) -> tuple[float, float]:
    return min(one.start for one in group), max(one.end for one in group)
