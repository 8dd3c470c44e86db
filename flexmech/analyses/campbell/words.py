"""What a Campbell diagram says: the table of critical speeds and the lines below it.

Ranges of speed that a Campbell diagram has results for: no other speed is called clear.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from flexmech.analyses.beam_theory import theory_reason
from flexmech.analyses.summary import Table, speed_text
from flexmech.arrays import unbroken_runs
from flexmech.plots.reading import speed_unit
from flexmech.units import from_si

# From one speed to another in rad/s.
Range = tuple[float, float]


def computed_ranges(dataset: xr.Dataset) -> list[Range]:
    """Ranges of speed in which the first engine has results, ascending.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of the diagram.

    Returns
    -------
    list of tuple of float
        In rad/s; a single speed between gaps is a range without width.
    """
    speeds = dataset["band_speed"].values.tolist()
    known = np.isfinite(dataset["band_frequency"].values[0]).all(axis=(1, 2))
    return [(speeds[run[0]], speeds[run[-1]]) for run in unbroken_runs(known)]


def is_computed(dataset: xr.Dataset, speed: float) -> bool:
    """Whether the first engine has results at a speed in rad/s.

    What went through another unit may be off by its last digits.
    """
    slack = 1e-9 * float(np.abs(dataset["crank_speed"].values).max())
    return any(low - slack <= speed <= high + slack for low, high in computed_ranges(dataset))


def not_computed(dataset: xr.Dataset) -> str:
    """The ranges of the diagram without results, in words; empty where there are none.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of the diagram.

    Returns
    -------
    str
        Such as ``"from 139.5 to 900 rad/s nothing was computed"``.
    """
    low, high = np.sort(dataset["crank_speed"].values[[0, -1]]).tolist()
    unit = speed_unit(dataset)
    between = without([(low, high)], computed_ranges(dataset))
    listed = [
        f"from {speed_text(first, unit)} to {speed_text(last, unit)}" for first, last in between
    ]
    return f"{' and '.join(listed)} {unit} nothing was computed" if listed else ""


def without(ranges: Sequence[Range], left_out: Sequence[Range]) -> list[Range]:
    """What is left of ranges when others are taken out, ascending.

    Parameters
    ----------
    ranges, left_out : sequence of tuple of float

    Returns
    -------
    list of tuple of float

    Examples
    --------
    >>> without([(0.0, 5.0), (7.0, 9.0)], [(1.0, 2.0), (4.0, 8.0)])
    [(0.0, 1.0), (2.0, 4.0), (8.0, 9.0)]
    """
    rest = sorted(ranges)
    for start, end in left_out:
        rest = [
            part
            for low, high in rest
            for part in ((low, min(high, start)), (max(low, end), high))
            if part[0] < part[1]
        ]
    return rest


def critical_table(dataset: xr.Dataset) -> Table:
    """Ranges of speed in which an order meets a branch, grouped by engine and branch."""
    unit = speed_unit(dataset)
    names = [str(name) for name in dataset["engine"].values]
    groups = []
    for engine in names:
        for branch in dataset["branch"].values.tolist():
            own = (dataset["critical_engine"] == engine) & (dataset["critical_branch"] == branch)
            rows = dataset.isel(critical=np.flatnonzero(own))
            error = float(dataset["discretisation_error"].sel(engine=engine, branch=branch).max())
            group = tuple(
                _row(rows.isel(critical=n), unit, error) for n in range(rows.sizes["critical"])
            )
            groups += [group] if group else []
    met = dataset["critical_gap"].values == 0
    captions = []
    if not groups:
        captions.append("no order meets a branch at the speeds that were computed")
    if dataset["critical_starts_inside"].any() or dataset["critical_ends_inside"].any():
        captions.append("<, >: the order is inside the branch's band already or still there")
    headings = ["engine", "branch", "order", f"from {unit}", f"to {unit}"]
    if not met.all():
        headings.append("nearest")
        captions.append("nearest: the order meets the branch nowhere and is this far from it")
    return Table(
        f"critical speeds, {dataset.attrs.get('mechanism', '')}",
        tuple(headings),
        tuple(tuple(row[: len(headings)] for row in group) for group in groups),
        caption="; ".join(captions),
    )


def operating_lines(dataset: xr.Dataset) -> list[str]:
    """Which orders meet a branch at the operating speeds of the model file, by the first engine."""
    speeds = [float(speed) for speed in str(dataset.attrs.get("operating_speeds", "")).split()]
    unit, found = speed_unit(dataset), []
    first = dataset["critical_engine"] == dataset["engine"].values[0]
    critical = dataset.isel(
        critical=np.flatnonzero(first.values & (dataset["critical_gap"].values == 0))
    )
    low, high = np.sort(dataset["crank_speed"].values[[0, -1]])
    for speed in speeds:
        name = f"{speed_text(speed, unit)} {unit}"
        if not low <= speed <= high:
            found.append(f"{name} is not among the speeds asked for")
            continue
        if not is_computed(dataset, speed):
            found.append(f"at {name} nothing was computed")
            continue
        ends = critical["critical_start"].values, critical["critical_end"].values
        here = critical.isel(critical=np.flatnonzero((ends[0] <= speed) & (speed <= ends[1])))
        pairs = zip(here["critical_order"].values, here["critical_branch"].values, strict=True)
        met = ", ".join(f"order {order} (branch {branch})" for order, branch in pairs)
        found.append(f"{name} is met by {met or 'none of these orders'}")
    return [f"operating speeds of the model file: {'; '.join(found)}"] if found else []


def gap_lines(dataset: xr.Dataset) -> list[str]:
    """Crank speeds without a result, and why."""
    unit, lines = speed_unit(dataset), []
    for n in range(dataset.sizes["gap"]):
        gap = dataset.isel(gap=n)
        first, last = (speed_text(gap[f"gap_{end}"], unit) for end in ("first", "last"))
        where = f"at {first} {unit}" if first == last else f"from {first} to {last} {unit}"
        count = int(gap["gap_count"])
        lines.append(
            f"gap: {gap['gap_engine'].item()} has no result {where} "
            f"({count} speed{'' if count == 1 else 's'}): {gap['gap_reason'].item()}"
        )
    return lines


def error_lines(dataset: xr.Dataset) -> list[str]:
    """Errors of the frequencies by mesh and fit, and of the critical speeds."""
    lines, unit = [], speed_unit(dataset)
    for n, name in enumerate(dataset["engine"].values):
        own = dataset.isel(engine=n)
        exists = np.isfinite(own["lowest_frequency"].isel(branch=0).values)
        solved, count = int(own["solved"].sum()), int(exists.sum())
        line = (
            f"errors, {name}: mesh ({int(own['elements'])} elements a link, estimated) at most "
            f"{_by_speed(own, unit)} of the frequency"
        )
        if float(own["fit_error"]) > 0:
            line += (
                f"; fit in speed, at speeds that it was not made of, at most "
                f"{float(own['fit_error']):.1e} ({solved} of {count} speeds solved)"
            )
        lines.append(
            f"{line}; ends of critical speeds solved to {float(own['crossing_error']):.0e}"
        )
    return lines


def disagreement(dataset: xr.Dataset, *, warned: bool) -> list[str]:
    """What to do where two engines differ by more than their errors explain."""
    if not warned:
        return []
    return [f"{verdict(dataset)}; ask for more --elements, or a smaller --tolerance"]


def verdict(dataset: xr.Dataset) -> str:
    """How far two engines' bands differ; or that only one ran."""
    names = [str(name) for name in dataset["engine"].values]
    if len(names) < 2:
        return f"engines: no comparison was made, only the {names[0]} engine ran"
    parts = ("lowest_frequency", "mean_frequency", "highest_frequency")
    values = np.stack([dataset[part].values[:2] for part in parts], axis=-1)
    apart = np.abs(values[1] / values[0] - 1)
    if not np.isfinite(apart).any():
        return "engines: no comparison is possible, at no speed have both a result"
    speed, branch, _ = np.unravel_index(int(np.nanargmax(apart)), apart.shape)
    unit = speed_unit(dataset)
    where = speed_text(dataset["crank_speed"][speed], unit)
    return (
        f"engines: {names[0]} and {names[1]} differ by at most {float(np.nanmax(apart)):.2e} of "
        f"the frequency, at {where} {unit}, branch {branch + 1}{theory_reason(dataset.attrs)}"
    )


def _by_speed(dataset: xr.Dataset, unit: str) -> str:
    """Error of the mesh at each of the speeds checked, such as "1e-04 at 0, 2e-04 at 20 rad/s"."""
    errors = dataset["discretisation_error"].max("branch").values
    speeds = [speed_text(w, unit) for w in dataset["check_speed"].values]
    pairs = [f"{e:.1e} at {w}" for e, w in zip(errors, speeds, strict=True) if np.isfinite(e)]
    return f"{', '.join(pairs)} {unit}"


def _row(critical: xr.Dataset, unit: str, error: float) -> tuple[str, ...]:
    ends = [from_si(float(critical[f"critical_{end}"]), unit) for end in ("start", "end")]
    start, end = (_known(value, error) for value in ends)
    gap = float(critical["critical_gap"])
    if gap > 0:
        end, nearest = "", f"{100 * gap:.1f} %"
    else:
        nearest = ""
        start = f"< {start}" if bool(critical["critical_starts_inside"]) else start
        end = f"> {end}" if bool(critical["critical_ends_inside"]) else end
    engine = str(critical["critical_engine"].item())
    branch, order = (int(critical[f"critical_{name}"]) for name in ("branch", "order"))
    return engine, str(branch), str(order), start, end, nearest


def _known(value: float, error: float) -> str:
    """A speed with the digits that a relative error leaves known."""
    digits = int(np.clip(np.floor(-np.log10(max(error, 1e-6))) + 1, 3, 6))
    return f"{value:.{digits}g}" if value < 10**digits else f"{value:.0f}"
