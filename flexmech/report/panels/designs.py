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
    search_panes,
    variables_of,
    varying,
)
from flexmech.plots.picture import Picture
from flexmech.report import panel
from flexmech.report.panel import Plot, plotted
from flexmech.report.results import Results
from flexmech.studies import DesignSweep, Optimum, Uncertainty
from flexmech.units import from_si

# Of a sweep, variables with a plot of their own, and outputs above each other in each.
MOST_VARIABLES, MOST_OUTPUTS = 4, 6


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
    return panel.panel_of("designs", result.said, plots=tuple(shown), thinned=tuple(thinned))


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
        shares = plots.plot_sensitivity.picture(data.sel(output=outputs[:MOST_OUTPUTS]))
        shown.append(plotted("sensitivity", shares, "Share of each input in the variance"))
    if "frequency_percentile" in data:
        shown.append(plotted("frequency-bands", plots.plot_frequency_bands.picture(data)))
    thinned = tuple(f"plots of {name}" for name in outputs[MOST_OUTPUTS:])
    return panel.panel_of("uncertainty", result.said, plots=tuple(shown), thinned=thinned)


def _distribution(data: xr.Dataset, output: str) -> Plot:
    pane = replace(distribution_pane(data, output), label="Probability density")
    picture = Picture([pane], pane.along, data)
    return plotted(f"distribution-{output}", picture, f"Distribution of {output}")


@panel.shows(Optimum)
def optimum_panel(result: Optimum, results: Results) -> panel.Panel:
    """What one goal costs of the other, the search, and what both engines say of the best."""
    data, goals = result.dataset, goals_of(result.dataset)
    shown = [
        plotted(f"search-{n}", Picture(panes := search_panes(data, name), panes[0].along, data), "")
        for n, name in enumerate(variables_of(data)[:MOST_VARIABLES], 1)
    ]
    if len(goals) > 1:
        front = pareto_picture(data)
        front = replace(front, x_label=front.panes[0].along)
        shown.insert(0, plotted("pareto", front, "What one goal costs of the other"))
    return panel.panel_of(
        "optimum",
        result.said,
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
