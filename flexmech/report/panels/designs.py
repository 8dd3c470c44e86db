"""Studies of designs: outputs over what varies, shares of inputs, and what the best costs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from flexmech import plots
from flexmech.analyses import Table
from flexmech.plots.designs import (
    design_pane,
    distribution_pane,
    goals_of,
    key_of,
    label,
    outputs_of,
    pareto_picture,
    short_name,
    varying,
)
from flexmech.plots.picture import Curve, Pane, Picture
from flexmech.plots.style import series_line
from flexmech.report import panel
from flexmech.report.panel import Plot, plotted
from flexmech.report.results import Results
from flexmech.studies import DesignSweep, Optimum, Uncertainty
from flexmech.units import from_si

# Of a sweep, variables with a plot of their own, and outputs above each other in each.
MOST_VARIABLES, MOST_OUTPUTS = 4, 6
# Shares of Sobol's indices: what they are called, and how far beside their input they stand.
SHARES = (("first_order", "first order", -0.08), ("total", "total", 0.08))


@panel.shows(DesignSweep)
def sweep_panel(result: DesignSweep, results: Results) -> panel.Panel:
    """Outputs over every variable with their limits, and the best designs."""
    data = result.dataset
    known = data.isel(design=np.flatnonzero(data["status"].values == "ok"))
    variables, outputs = varying(data), outputs_of(data)
    thinned = [f"plots over {name}" for name in variables[MOST_VARIABLES:]]
    thinned += [f"plots of {name}" for name in outputs[MOST_OUTPUTS:]]
    shown = [
        _over_variable(known, name, outputs[:MOST_OUTPUTS], number)
        for number, name in enumerate(variables[:MOST_VARIABLES], 1)
        if known.sizes["design"]
    ]
    return panel.panel_of("designs", result.summary(), plots=tuple(shown), thinned=tuple(thinned))


def _over_variable(known: xr.Dataset, variable: str, outputs: Sequence[str], number: int) -> Plot:
    """Outputs above each other over one variable."""
    panes = tuple(design_pane(known, name, variable) for name in outputs)
    words = label(known[variable])
    picture = Picture(panes, words, known)
    return plotted(f"designs-{number}", picture, f"Over {key_of(known[variable]) or words}")


@panel.shows(Uncertainty)
def uncertainty_panel(result: Uncertainty, results: Results) -> panel.Panel:
    """How many designs are below each value, shares of the inputs, and bands of frequencies."""
    data, outputs = result.dataset, result.dataset["output"].values.tolist()
    known = (data["status"].values == "ok").any()
    shown = [_distribution(data, name) for name in outputs[:MOST_OUTPUTS] if known]
    if "total" in data:
        shown.append(_shares(data, outputs[:MOST_OUTPUTS]))
    if "frequency_percentile" in data:
        shown.append(plotted("frequency-bands", plots.plot_frequency_bands.picture(data)))
    thinned = tuple(f"plots of {name}" for name in outputs[MOST_OUTPUTS:])
    return panel.panel_of("uncertainty", result.summary(), plots=tuple(shown), thinned=thinned)


def _distribution(data: xr.Dataset, output: str) -> Plot:
    pane = replace(distribution_pane(data, output), label="Probability density")
    picture = Picture([pane], pane.along, data)
    return plotted(f"distribution-{output}", picture, f"Distribution of {output}")


def _shares(data: xr.Dataset, outputs: Sequence[str]) -> Plot:
    """Sobol's indices as points with their intervals, outputs above each other."""
    names = tuple(map(short_name, data["input"].values.tolist()))
    place, panes = np.arange(1.0, len(names) + 1), []
    for output in outputs:
        own, curves = data.sel(output=output), list[Curve]()
        for colour, (name, words, beside) in enumerate(SHARES):
            x, look = place + beside, series_line(colour)
            points = look | {"ls": "", "marker": "o", "ms": 6.0}
            curves.append(Curve(x, own[name].values, points, words))
            # One broken line a group: from one end of each interval to the other.
            gap = np.full(x.size, np.nan)
            ends = np.stack([own[f"{name}_low"].values, own[f"{name}_high"].values, gap], axis=-1)
            curves.append(Curve(np.repeat(x, 3), ends.ravel(), look, followed=None))
        panes.append(Pane(f"Share in {output}", curves, named=names))
    picture = Picture(panes, "Input", data)
    return plotted("sensitivity", picture, "Share of each input in the variance")


@panel.shows(Optimum)
def optimum_panel(result: Optimum, results: Results) -> panel.Panel:
    """What one goal costs of the other, the search, and what both engines say of the best."""
    data, goals = result.dataset, goals_of(result.dataset)
    shown = [plotted("search", plots.plot_search.picture(data), "The search")]
    if len(goals) > 1:
        front = pareto_picture(data)
        front = replace(front, x_label=front.panes[0].along)
        shown.insert(0, plotted("pareto", front, "What one goal costs of the other"))
    return panel.panel_of(
        "optimum",
        result.summary(),
        plots=tuple(shown),
        folded=(_checked(data),),
        engines=" and ".join(data["checking_engine"].values.tolist()),
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
