"""Studies of designs: outputs over what varies, shares of inputs, and what the best costs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from flexmech.analyses import Table
from flexmech.arrays import FloatArray
from flexmech.plots.designs.reading import (
    bounds,
    goals_of,
    label,
    outputs_of,
    short_name,
    shown,
    varying,
)
from flexmech.plots.reading import degrees
from flexmech.report import panel
from flexmech.report.results import Results
from flexmech.studies import DesignSweep, Optimum, Uncertainty
from flexmech.units import from_si

# Of a sweep, variables with a plot of their own, and outputs above each other in each.
MOST_VARIABLES, MOST_OUTPUTS = 4, 6
# Of Sobol's indices: what they are called, and how far beside their input they stand.
SHARES = (("first_order", "first order", -0.08), ("total", "total", 0.08))
# Percentiles of frequencies, in the order in which they are drawn: an interval, the median on it.
BANDS = ((2.5, "95 % of the designs"), (97.5, "95 % of the designs"), (50.0, "median"))


@panel.shows(DesignSweep)
def sweep_panel(result: DesignSweep, results: Results) -> panel.Panel:
    """Outputs over every variable with their limits, and the best designs."""
    data = result.dataset
    known = data.isel(design=np.flatnonzero(data["status"].values == "ok"))
    variables, outputs = varying(data), outputs_of(data)
    thinned = [f"plots over {name}" for name in variables[MOST_VARIABLES:]]
    thinned += [f"plots of {name}" for name in outputs[MOST_OUTPUTS:]]
    plots: tuple[panel.Plot, ...] = ()
    if known.sizes["design"]:
        shown_outputs = outputs[:MOST_OUTPUTS]
        plots = tuple(
            _over_variable(known, name, shown_outputs, number)
            for number, name in enumerate(variables[:MOST_VARIABLES])
        )
    return panel.panel_of("designs", result.summary(), plots=plots, thinned=tuple(thinned))


def _over_variable(
    known: xr.Dataset, variable: str, outputs: Sequence[str], number: int
) -> panel.Plot:
    """Outputs above each other over one variable, designs beyond a limit in another colour."""
    x, key = _along(known[variable])
    bounded = any(bounds(known[name]) for name in outputs)
    within = known["within"].values if bounded else np.ones(x.size, dtype=bool)
    traces = list[panel.Trace]()
    groups = [(within, "keeps every limit" if bounded else "designs"), (~within, "beyond a limit")]
    for row, name in enumerate(outputs):
        y = shown(known[name])
        for colour, (which, word) in enumerate(groups):
            if which.any():
                at = x[which], y[which]
                points = panel.Trace(word, *at, colour, "points", axis=row, legend=row == 0)
                traces.append(points)
        for bound in bounds(known[name]):
            at = np.array([x.min(), x.max()]), np.full(2, bound)
            # The legend names limits once, wherever the first of them is.
            first = all(trace.name != "limit" for trace in traces)
            line = panel.Trace("limit", *at, panel.GREY, "dash", axis=row, legend=first)
            traces.append(line)
    words = label(known[variable])
    return panel.Plot(
        f"designs-{number + 1}",
        words,
        tuple(panel.YAxis(label(known[name])) for name in outputs),
        tuple(traces),
        f"{', '.join(map(label, (known[name] for name in outputs)))} of the designs over {words}",
        tick=1.0 if known[variable].dtype.kind == "U" else None,
        height=panel.FRAME_HEIGHT + 150 * len(outputs),
        title=f"Over {words}{key}",
    )


def _along(values: xr.DataArray) -> tuple[FloatArray, str]:
    """Places along an axis, and a key to them: texts stand there by their number."""
    if values.dtype.kind != "U":
        return shown(values), ""
    names, place = np.unique(values.values, return_inverse=True)
    return place.astype(float) + 1, f": {_numbered(names.tolist())}"


def _numbered(names: Sequence[str]) -> str:
    return ", ".join(f"{number}: {name}" for number, name in enumerate(names, 1))


@panel.shows(Uncertainty)
def uncertainty_panel(result: Uncertainty, results: Results) -> panel.Panel:
    """How many designs are below each value, shares of the inputs, and bands of frequencies."""
    data = result.dataset
    known = data.isel(design=np.flatnonzero(data["status"].values == "ok"))
    outputs = data["output"].values.tolist()
    plots = [_cumulated(known, name) for name in outputs[:MOST_OUTPUTS]]
    if "total" in data:
        plots.append(_shares(data, outputs[:MOST_OUTPUTS]))
    if "frequency_percentile" in data:
        plots.append(_bands(data["frequency_percentile"]))
    thinned = tuple(f"plots of {name}" for name in outputs[MOST_OUTPUTS:])
    return panel.panel_of("uncertainty", result.summary(), plots=tuple(plots), thinned=thinned)


def _cumulated(known: xr.Dataset, output: str) -> panel.Plot:
    """Part of the designs at or below each value; median, 95 % interval and limits across it."""
    values = np.sort(shown(known[output]))
    part = 100.0 * np.arange(1, values.size + 1) / values.size
    ends = np.array([0.0, 100.0])
    traces = [panel.Trace("designs", values, part, 0, width=2.4)]
    own, unit = known.sel(output=output), known[output].attrs["shown_unit"]
    looks: tuple[tuple[str, panel.Look, tuple[str, ...]], ...] = (
        ("median", "solid", ("p50",)),
        ("2.5 and 97.5 %", "dot", ("p2_5", "p97_5")),
    )
    for word, look, names in looks:
        for number, name in enumerate(names):
            at = np.full(2, from_si(float(own[name]), unit))
            traces.append(panel.Trace(word, at, ends, panel.GREY, look, legend=number == 0))
    for number, bound in enumerate(bounds(known[output])):
        at = np.full(2, bound)
        traces.append(panel.Trace("limit", at, ends, 1, "dash", legend=number == 0))
    words = label(known[output])
    return panel.Plot(
        f"distribution-{output}",
        words,
        (panel.YAxis("designs at or below (%)"),),
        tuple(traces),
        f"Part of the designs whose {words} is at or below each value, its median, the interval "
        "that holds 95 % of them, and limits",
        title=f"Distribution of {output}",
    )


def _shares(data: xr.Dataset, outputs: Sequence[str]) -> panel.Plot:
    """Sobol's indices as points with their intervals, outputs above each other."""
    inputs = data["input"].values.tolist()
    place = np.arange(1.0, len(inputs) + 1)
    traces = list[panel.Trace]()
    for axis, output in enumerate(outputs):
        own = data.sel(output=output)
        for colour, (name, words, beside) in enumerate(SHARES):
            x, value = place + beside, own[name].values
            points = panel.Trace(words, x, value, colour, "points", 9.0, axis=axis, legend=not axis)
            # One broken line a group: from one end of each interval to the other.
            gap = np.full(x.size, np.nan)
            ends = np.stack([own[f"{name}_low"].values, own[f"{name}_high"].values, gap], axis=-1)
            line = panel.Trace(
                words, np.repeat(x, 3), ends.ravel(), colour, axis=axis, legend=False
            )
            traces += [points, line]
    return panel.Plot(
        "sensitivity",
        "input",
        tuple(panel.YAxis(f"share in {output}") for output in outputs),
        tuple(traces),
        f"Share of {', '.join(inputs)} in the variance of {', '.join(outputs)}, and its interval",
        tick=1.0,
        height=panel.FRAME_HEIGHT + 150 * len(outputs),
        title=f"Share of each input in the variance: {_numbered([*map(short_name, inputs)])}",
    )


def _bands(bands: xr.DataArray) -> panel.Plot:
    """Median and interval of the frequencies over the crank angle, modes above each other."""
    angle, modes = degrees(bands["crank_angle"]), bands["mode"].values.tolist()
    traces = list[panel.Trace]()
    for axis, mode in enumerate(modes):
        own = bands.sel(mode=mode)
        for number, (part, word) in enumerate(BANDS):
            look: Any = {"fill": "to previous"} if number == 1 else {}
            look |= {"width": 2.4 if word == "median" else 0.8, "axis": axis}
            # The legend names the interval once, and the median.
            look["legend"] = not axis and number > 0
            followed: panel.Choice | None = {} if word == "median" else None
            values = own.sel(percentile=part).values
            traces.append(panel.Trace(word, angle, values, 0, followed=followed, **look))
    return panel.over_angle(
        "frequency-bands",
        tuple(panel.YAxis(f"mode {mode} (Hz)") for mode in reversed(modes)),
        [replace(trace, axis=len(modes) - 1 - trace.axis) for trace in traces],
        text="Median of the natural frequencies over the crank angle, and the interval that "
        "holds 95 % of the designs",
        height=panel.FRAME_HEIGHT + 150 * len(modes),
        title=f"Natural frequencies of {bands.attrs['designs']} designs",
    )


@panel.shows(Optimum)
def optimum_panel(result: Optimum, results: Results) -> panel.Panel:
    """What one goal costs of the other, the search, and what both engines say of the best."""
    data, goals = result.dataset, goals_of(result.dataset)
    plots = [_search(data, goals)]
    if len(goals) > 1:
        plots.insert(0, _front(data, goals))
    said = result.summary()
    return panel.panel_of(
        "optimum",
        said,
        plots=tuple(plots),
        folded=(_checked(data),),
        engines=" and ".join(data["checking_engine"].values.tolist()),
    )


def _front(data: xr.Dataset, goals: Sequence[tuple[str, str]]) -> panel.Plot:
    """Best designs of the first two goals or more, the others above each other."""
    best = data.sortby(goals[0][1])
    x, others = shown(best[goals[0][1]]), goals[1:]
    traces = [
        panel.Trace("best designs", x, shown(best[name]), axis, "points", axis=axis, legend=False)
        for axis, (_, name) in enumerate(others)
    ]
    return panel.Plot(
        "pareto",
        f"{label(best[goals[0][1]])}, {goals[0][0]}",
        tuple(panel.YAxis(f"{label(best[name])}, {sense}") for sense, name in others),
        tuple(traces),
        "Designs that no other is better than in every goal",
        height=panel.FRAME_HEIGHT + 220 * len(others),
        title="What one goal costs of the other",
    )


def _search(data: xr.Dataset, goals: Sequence[tuple[str, str]]) -> panel.Plot:
    """The best of every goal so far; it stays until a better one is found."""
    at, traces = data["evaluations"].values.astype(float), list[panel.Trace]()
    for axis, (_, name) in enumerate(goals):
        own = shown(data["history"].sel(goal=name).assign_attrs(data[name].attrs))
        x, y = np.repeat(at, 2)[1:], np.repeat(own, 2)[:-1]
        traces.append(panel.Trace("best so far", x, y, axis, axis=axis, legend=False))
    return panel.Plot(
        "search",
        "designs computed",
        tuple(panel.YAxis(f"{label(data[name])}, {sense}") for sense, name in goals),
        tuple(traces),
        "Best design so far that keeps every limit, over the number of designs computed",
        height=panel.FRAME_HEIGHT + 150 * len(goals),
        title="The search",
    )


def _checked(data: xr.Dataset) -> Table:
    """Outputs of the best design as both engines compute them anew."""
    engines = data["checking_engine"].values.tolist()
    rows = []
    for name in outputs_of(data):
        unit = data[name].attrs["shown_unit"]
        found = data["checked"].sel(output=name).values.tolist()
        error = 100 * float(data["relative_error"].sel(output=name))
        rows.append(
            (name, unit, *(f"{from_si(value, unit):.6g}" for value in found), f"{error:.2g}")
        )
    headings = ("output", "unit", *engines, "error (%)")
    return Table("The best design computed anew", headings, (tuple(rows),), text_columns=2)
