"""A Campbell diagram in words: whether speeds are clear of the crank's orders, and which to avoid.

Ranges of speed that the diagram has results for: no other speed is called clear.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from flexmech.analyses.beam_theory import theory_lines, theory_reason
from flexmech.analyses.campbell.crossings import ray
from flexmech.analyses.details import (
    Range,
    details_table,
    engines_line,
    ranges_text,
    speed_name,
)
from flexmech.analyses.digits import Quantity, rounded
from flexmech.analyses.requests import fewer_modes_lines
from flexmech.analyses.summary import (
    EngineDifference,
    Summary,
    Table,
    speed_text,
    trust_line,
    warnings_of,
)
from flexmech.arrays import FloatArray, unbroken_runs
from flexmech.plots.reading import lies_in, merged, operating_speeds, speed_unit, terms_text
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
class Critical:
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
        """Errors of start and end in rad/s; not a number where the range is cut."""
        ends = zip((self.start, self.end), self.is_cut, strict=True)
        first, last = (math.nan if cut else abs(end) * self.error for end, cut in ends)
        return first, last


def summary_of(data: xr.Dataset) -> Summary:
    """Answer, table, trust, details, warnings and numbers of a Campbell diagram.

    Parameters
    ----------
    data : xarray.Dataset
        Data of a ``CampbellDiagram``.

    Returns
    -------
    Summary
    """
    difference = _difference(data)
    shown = data.isel(engine=[0]) if difference is None or difference.agree else data
    branches = [f"branch {number}" for number in data["branch"].values.tolist()]
    verdict = engines_line(data, _apart(data), "frequencies", branches)
    verdict += theory_reason(data.attrs)
    warned = difference is not None and difference.worth_a_warning
    error = float(data["discretisation_error"].max()) + float(data["fit_error"].max())
    details: tuple[Table | str, ...] = (
        *fewer_modes_lines(data.attrs),
        *filter(None, [terms_text(data)]),
        *theory_lines(data.attrs),
        *details_table(_quantities(data)),
        *str(data.attrs.get("environment_lines", "")).splitlines(),
        verdict,
    )
    warnings = (
        *_gaps(data),
        *([f"{verdict}; ask for more --elements, or a smaller --tolerance"] if warned else []),
        *warnings_of(data.attrs),
    )
    return Summary(
        _answer(data),
        _critical_table(shown) if (data["critical_gap"] == 0).any() else _band_table(data),
        trust_line(data["engine"].values.tolist(), error, difference),
        details,
        warnings,
        _numbers(data),
    )


def _answer(data: xr.Dataset) -> tuple[str, ...]:
    """Flutter, whether the operating speeds are clear of the orders, and which to avoid."""
    speeds = sorted(operating_speeds(data), key=abs, reverse=True)
    told = len(speeds) if len(speeds) <= _MOST_TOLD else 1
    sentences = [_at_speed(data, speed) for speed in speeds[:told]]
    sentences += [_at_others(data, speeds[told:])] if speeds[told:] else []
    flutters = filter(None, [str(data.attrs.get("flutter", ""))])
    return (*flutters, *sentences, _speeds_to_avoid(data))


def _numbers(data: xr.Dataset) -> tuple[Quantity, ...]:
    """Ends of all critical ranges of speed, and frequencies at the greatest operating speed."""
    unit, found = speed_unit(data), list[Quantity]()
    for met in _critical(data):
        of = f"order {met.order}, branch {met.branch}"
        ends = zip(("from", "to"), (met.start, met.end), met.end_errors, strict=True)
        for name, end, error in ends:
            value, known = from_si(end, unit), abs(from_si(error, unit))
            found.append(Quantity(f"critical_speed_{name}", value, unit, known, of))
    for speed in sorted(_computed_operating_speeds(data), key=abs)[-1:]:
        for branch in range(data.sizes["branch"]):
            bands, errors = _band_at(data, speed, branch)
            found += [
                Quantity(f"{part}_at_operating_speed", value, "Hz", away, f"branch {branch + 1}")
                for part, value, away in zip(PARTS, bands.tolist(), errors.tolist(), strict=True)
                if math.isfinite(value)
            ]
    return tuple(found)


def _quantities(data: xr.Dataset) -> Iterator[Quantity]:
    """Errors by mesh, fit and crossing of each engine, and orders met at operating speeds."""
    for n, engine in enumerate(data["engine"].values.astype(str).tolist()):
        own = data.isel(engine=n)
        mesh = f"relative error by the mesh ({int(own['elements'])} elements a link)"
        for error in own["discretisation_error"].max("branch"):
            of = f"{speed_name(data, error['check_speed'])}, {engine}"
            yield Quantity(mesh, float(error), "", of=of)
        if float(own["fit_error"]) > 0:
            yield Quantity("relative error by the fit", float(own["fit_error"]), "", of=engine)
        yield Quantity("speeds solved for", float(own["solved"].sum()), "", of=engine)
        ends = "relative error of ends of critical speeds"
        yield Quantity(ends, float(own["crossing_error"]), "", of=engine)
    for speed in operating_speeds(data):
        for met in _met_at(data, speed):
            of = f"branch {met.branch}, {speed_name(data, speed)}"
            yield Quantity("order at an operating speed", float(met.order), "", of=of)


def _computed_ranges(data: xr.Dataset) -> list[Range]:
    """Ranges of speed in which the first engine has results, ascending.

    In rad/s; a single speed between gaps is a range without width.
    """
    speeds = data["band_speed"].values.tolist()
    known = np.isfinite(data["band_frequency"].values[0]).all(axis=(1, 2))
    return [(speeds[run[0]], speeds[run[-1]]) for run in unbroken_runs(known)]


def _is_computed(data: xr.Dataset, speed: float) -> bool:
    return lies_in(data, _computed_ranges(data), speed)


def _computed_operating_speeds(data: xr.Dataset) -> list[float]:
    return [speed for speed in operating_speeds(data) if _is_computed(data, speed)]


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


def _band_table(data: xr.Dataset) -> Table:
    """Frequencies at the greatest operating speed, or at the greatest speed of the diagram."""
    ends = (end for computed in _computed_ranges(data) for end in computed)
    speed = max(_computed_operating_speeds(data) or ends, key=abs)
    rows = []
    for branch in range(data.sizes["branch"]):
        cells = (rounded(*pair) for pair in zip(*_band_at(data, speed, branch), strict=True))
        rows.append((f"f{branch + 1}", *cells))
    return Table(
        f"natural frequencies at {speed_name(data, speed)}, {data.attrs.get('mechanism', '')}",
        ("branch", "lowest Hz", "mean Hz", "highest Hz"),
        (tuple(rows),),
        caption="over the turn; no order meets a branch among the speeds asked for",
    )


def _critical_table(data: xr.Dataset) -> Table:
    """Ranges of speed in which an order meets a branch, grouped by engine and branch."""
    unit, groups = speed_unit(data), []
    for engine in data["engine"].values.tolist():
        for branch in data["branch"].values.tolist():
            own = (data["critical_engine"] == engine) & (data["critical_branch"] == branch)
            error = float(data["discretisation_error"].sel(engine=engine, branch=branch).max())
            places = np.flatnonzero(own).tolist()
            group = tuple(_row(data.isel(critical=n), unit, error) for n in places)
            groups += [group] if group else []
    captions = []
    if data["critical_starts_inside"].any() or data["critical_ends_inside"].any():
        captions.append("<, >: the order is inside the branch's band already or still there")
    headings = ["engine", "branch", "order", f"from {unit}", f"to {unit}"]
    if (data["critical_gap"] > 0).any():
        headings.append("nearest")
        captions.append("nearest: the order meets the branch nowhere and is this far from it")
    return Table(
        f"critical speeds, {data.attrs.get('mechanism', '')}",
        tuple(headings),
        tuple(tuple(row[: len(headings)] for row in group) for group in groups),
        caption="; ".join(captions),
    )


def _row(critical: xr.Dataset, unit: str, error: float) -> tuple[str, ...]:
    start, end = (
        _known(from_si(float(critical[f"critical_{end}"]), unit), error) for end in ("start", "end")
    )
    gap, nearest = float(critical["critical_gap"]), ""
    if gap > 0:
        end, nearest = "", f"{100 * gap:.1f} %"
    else:
        start = f"< {start}" if bool(critical["critical_starts_inside"]) else start
        end = f"> {end}" if bool(critical["critical_ends_inside"]) else end
    names = (str(critical[f"critical_{name}"].item()) for name in ("engine", "branch", "order"))
    return (*names, start, end, nearest)


def _known(value: float, error: float) -> str:
    """A speed with the digits that a relative error leaves known."""
    digits = int(np.clip(np.floor(-np.log10(max(error, 1e-6))) + 1, 3, 6))
    return f"{value:.{digits}g}" if value < 10**digits else f"{value:.0f}"


def _band_at(data: xr.Dataset, speed: float, branch: int) -> tuple[FloatArray, FloatArray]:
    """Lowest, mean and highest frequency of a branch at a speed in rad/s, by the first engine.

    Returns
    -------
    values, errors : ndarray, shape (3,)
        Hz; errors by mesh and fit, and between the speeds by what a cubic curve makes of it.
    """
    speeds = data["band_speed"].values
    values = data["band_frequency"].values[0, :, :, branch].T
    known = np.isfinite(values).all(axis=0)
    if not known.any():
        return np.full(3, np.nan), np.full(3, np.nan)
    at, values = speeds[known], values[:, known]
    straight = np.array([np.interp(speed, at, row) for row in values])
    curved = straight
    if len(at) >= _CUBIC:
        from scipy.interpolate import CubicSpline

        curved = np.asarray(CubicSpline(at, values, axis=1)(np.clip(speed, at[0], at[-1])))
    return curved, _error(data, branch) * curved + np.abs(curved - straight)


def _error(data: xr.Dataset, branch: int) -> float:
    """Relative error of a branch's frequencies by mesh and fit, and the engines' difference."""
    mesh = float(data["discretisation_error"].isel(branch=branch).max())
    apart = np.nan_to_num(_apart(data.isel(branch=[branch]))).max(initial=0.0)
    return max(mesh + float(data["fit_error"].max()), float(apart))


def _apart(data: xr.Dataset) -> FloatArray:
    """Relative difference of two engines' frequencies, (S, m, 3); empty with one engine."""
    values = np.stack([data[part].values[:2] for part in PARTS], axis=-1)
    return np.asarray(np.abs(values[1] / values[0] - 1)) if len(values) > 1 else np.zeros((0, 0, 3))


def _difference(data: xr.Dataset) -> EngineDifference | None:
    """That of the branches of two engines which their errors explain least, if there are two."""
    apart, mesh = _apart(data), data["discretisation_error"]
    if not np.isfinite(apart).any():
        return None
    known = np.isfinite(apart).any(axis=(0, 2))
    error = mesh.max([name for name in mesh.dims if name not in ("engine", "branch")])
    allowed = (error + data["fit_error"]).sum("engine").values
    return EngineDifference.least_explained(np.nanmax(apart[:, known], axis=(0, 2)), allowed[known])


def _critical(data: xr.Dataset) -> list[Critical]:
    """Ranges of speed in which an order meets a branch of the first engine."""
    first = data["critical_engine"] == data["engine"].values[0]
    met = data.isel(critical=np.flatnonzero(first & (data["critical_gap"] == 0)))
    columns = (
        met[f"critical_{name}"].values.tolist()
        for name in ("order", "branch", "start", "end", "starts_inside", "ends_inside")
    )
    return [
        Critical(order, branch, start, end, (before, after), _error(data, branch - 1))
        for order, branch, start, end, before, after in zip(*columns, strict=True)
    ]


def _met_at(data: xr.Dataset, speed: float) -> list[Critical]:
    return [met for met in _critical(data) if met.start <= speed <= met.end]


def _orders_text(data: xr.Dataset) -> str:
    orders = data["order"].values
    first, last = int(orders.min()), int(orders.max())
    if len(orders) <= 2:
        return f"order{'s' * (len(orders) > 1)} {' and '.join(map(str, orders.tolist()))}"
    whole = len(orders) == last - first + 1
    listed = f"{first} to {last}" if whole else ", ".join(map(str, orders.tolist()))
    return f"orders {listed}"


def _at_speed(data: xr.Dataset, speed: float) -> str:
    """Whether a speed is clear of the orders, its lowest frequency, and the nearest order."""
    name = speed_name(data, speed)
    if not _is_computed(data, speed):
        return f"Whether {name} is critical is unknown: nothing was computed there."
    bands, errors = _band_at(data, speed, 0)
    ends = [rounded(bands[n], errors[n]) for n in (0, 2)]
    first = f"f1 is {' to '.join(dict.fromkeys(ends))} Hz"
    if here := _met_at(data, speed):
        listed = "; ".join(
            f"order {met.order} meets f{met.branch} at {_range(data, [met])}" for met in here
        )
        return f"{name} is critical: {listed}; {first}."
    return f"{name} is clear of {_orders_text(data)}; {first}{_nearest(data, speed)}."


def _at_others(data: xr.Dataset, speeds: list[float]) -> str:
    """Which of several speeds are clear of the orders, critical, or not computed."""
    names: dict[str, list[str]] = {"critical": [], "clear": [], "not computed": []}
    for speed in speeds:
        state = "critical" if _met_at(data, speed) else "clear"
        state = state if _is_computed(data, speed) else "not computed"
        names[state].append(speed_name(data, speed))
    parts = [f"{', '.join(own)} {state}" for state, own in names.items() if own]
    return f"Other operating speeds: {'; '.join(parts)}."


def _range(data: xr.Dataset, met: list[Critical]) -> str:
    """Ends of ranges that overlap in the user's unit, with the digits that are known."""
    unit, texts = speed_unit(data), []
    first, last = min(met, key=lambda one: one.start), max(met, key=lambda one: one.end)
    for one, place, beyond in ((first, 0, "less"), (last, 1, "more")):
        end, error = (one.start, one.end)[place], one.end_errors[place]
        if one.is_cut[place]:
            texts.append(f"{speed_text(end, unit)} or {beyond}")
        else:
            texts.append(rounded(from_si(end, unit), abs(from_si(error, unit))))
    return f"{' to '.join(dict.fromkeys(texts))} {unit}"


def _nearest(data: xr.Dataset, speed: float) -> str:
    """The lowest order that meets the lowest branch at a speed, or nearest to it; empty at rest.

    Higher branches are met by orders so high that they excite nothing.
    """
    bands, _ = _band_at(data, speed, 0)
    if not speed or not np.isfinite(bands).all():
        return ""
    per_order = float(ray(1, speed))
    first, last = math.ceil(bands[0] / per_order), math.floor(bands[2] / per_order)
    if first <= last:
        met = _range(data, [_meeting_of(data, speed, first)])
        return f"; the lowest order that meets f1 there is {first}, at {met}"
    # The order just below the band, and the one just above it.
    found = [_meeting_of(data, speed, order) for order in {last, first} - {0}]
    nearest = min(found, key=lambda one: max(one.start - speed, speed - one.end))
    return f"; the nearest is order {nearest.order}, which meets f1 at {_range(data, [nearest])}"


def _meeting_of(data: xr.Dataset, speed: float, order: int) -> Critical:
    """The range about a speed in which any order meets the lowest branch.

    Bands beyond the speeds of the diagram are taken as at its last one.
    """
    ends = []
    for end in (0, 2):
        found = speed
        for _ in range(_STEPS):
            hertz = float(_band_at(data, found, 0)[0][end])
            found = math.copysign(2 * math.pi * hertz / order, speed)
        ends.append(found)
    return Critical(order, 1, min(ends), max(ends), (False, False), _error(data, 0))


def _speeds_to_avoid(data: xr.Dataset) -> str:
    """All critical ranges of the diagram as one sentence, and the widest range without one."""
    unit, orders = speed_unit(data), _orders_text(data)
    met, computed, unknown = _critical(data), _computed_ranges(data), ""
    low, high = np.sort(data["crank_speed"].values[[0, -1]]).tolist()
    if missing := without([(low, high)], computed):
        unknown = f"; {ranges_text(missing, unit)} nothing was computed"
    groups = [
        [one for one in met if start <= one.start and one.end <= end]
        for start, end in merged((one.start, one.end) for one in met)
    ]
    meet = f"{orders} of the crank {'meets' if data.sizes['order'] == 1 else 'meet'}"
    if not groups:
        where = ranges_text(computed, unit)
        return f"No speed {where} is critical: {meet} no frequency{unknown}."
    avoid = ", ".join(_range(data, group) for group in groups)
    if len(groups) > _MOST_LISTED:
        avoid = f"{len(groups)} ranges of speed, {_range(data, met)}"
    said = f"Avoid {avoid}: there {meet} a frequency"
    ends = [(min(o.start for o in group), max(o.end for o in group)) for group in groups]
    clear = without(computed, ends)
    if not clear:
        return f"{said}; no speed of the diagram is clear{unknown}."
    error = max(one.error for one in met)
    widest = max(clear, key=lambda ends: ends[1] - ends[0])
    first, last = (rounded(from_si(w, unit), abs(from_si(w, unit)) * error) for w in widest)
    return f"{said}; the widest range that is clear is {first} to {last} {unit}{unknown}."


def _gaps(data: xr.Dataset) -> Iterator[str]:
    """Crank speeds without a result, and why."""
    for n in range(data.sizes["gap"]):
        gap = {str(name): data[name].values[n] for name in data if data[name].dims == ("gap",)}
        where = ranges_text([(gap["gap_first"], gap["gap_last"])], speed_unit(data))
        count = int(gap["gap_count"])
        yield (
            f"gap: {gap['gap_engine']} has no result {where} "
            f"({count} speed{'' if count == 1 else 's'}): {gap['gap_reason']}"
        )
