"""How uncertain outputs are, and which input makes them so."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from flexmech.errors import InputError
from flexmech.plots.designs.reading import (
    BOUND,
    PANEL,
    bounds,
    computed,
    label,
    outputs_of,
    short_name,
    shown,
)
from flexmech.plots.layout import AxesLike, sheet, tiles
from flexmech.plots.reading import degrees, mode_label
from flexmech.plots.scales import crank_angle_axis
from flexmech.plots.style import (
    MID_GREY,
    Look,
    line_handle,
    line_handles,
    series_handle,
    series_line,
    series_style,
)
from flexmech.units import from_si

# Percentiles of frequencies: of the interval of 95 % its lower end, the median, its upper end.
BAND = (2.5, 50.0, 97.5)
# Bars of a distribution at most.
MOST_BARS = 60
PERCENTILES: Mapping[str, Look] = {
    "p2_5": {"color": "black", "lw": 0.9, "ls": ":"},
    "p50": {"color": "black", "lw": 1.2},
    "p97_5": {"color": "black", "lw": 0.9, "ls": ":"},
}


def plot_sensitivity(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the share of every input in the variance of every output, with its interval.

    Parameters
    ----------
    dataset : Dataset
        Of an ``Uncertainty``.
    ax : Axes or sequence of Axes, optional
        The user's, one for each output. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If there are no shares, as of correlated inputs.
    """
    if "total" not in dataset:
        raise InputError(dataset.attrs["no_shares"])
    outputs = dataset["output"].values.tolist()
    height = max(PANEL, 0.5 + 0.3 * dataset.sizes["input"])
    with sheet(tiles(len(outputs), 2, height), ax=ax) as drawn:
        looks = {"first_order": series_style(0).color, "total": series_style(1).color}
        handles = [
            line_handle(name.replace("_", " "), ls="", marker="s", ms=5, color=colour)
            for name, colour in looks.items()
        ]
        drawn.header(handles, "Share of each input in the variance (Sobol)", of=dataset)
        for axes, output in zip(drawn.panels, outputs, strict=True):
            _shares(axes, dataset.sel(output=output), looks)
            axes.set_title(output, loc="left")
        drawn.label_x("Share of the variance (-)")
    return drawn.figure


def _shares(axes: Axes, own: xr.Dataset, looks: Mapping[str, str]) -> None:
    """Bars of one output with their intervals; none of an output that does not vary."""
    names = own["input"].values.tolist()
    place = np.arange(len(names))
    for number, (name, colour) in enumerate(looks.items()):
        y = place + 0.2 * (2 * number - 1)
        axes.barh(y, np.nan_to_num(own[name].values), height=0.36, color=colour)
        axes.hlines(y, own[f"{name}_low"], own[f"{name}_high"], color="black", lw=0.8)
    axes.set_yticks(place, [short_name(name) for name in names])
    axes.set_ylim(len(names) - 0.5, -0.5)
    if not np.isfinite(own["total"].values).any():
        axes.text(0.5, 0.5, "does not vary", transform=axes.transAxes, ha="center", va="center")
    axes.axvline(0.0, color=MID_GREY, lw=0.6)


def plot_distributions(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the distribution of every output, its percentiles and its limit.

    Parameters
    ----------
    dataset : Dataset
        Of an ``Uncertainty``.
    ax : Axes or sequence of Axes, optional
        The user's, one for each output. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If no design can be computed.
    """
    known = computed(dataset)
    outputs, limit = outputs_of(dataset), BOUND | {"color": series_style(1).color}
    with sheet(tiles(len(outputs), 2, PANEL), ax=ax) as drawn:
        looks = {"median": PERCENTILES["p50"], "2.5 and 97.5 %": PERCENTILES["p2_5"]}
        if any(bounds(dataset[name]) for name in outputs):
            looks["limit"] = limit
        drawn.header(line_handles(looks), "Distribution of the outputs", of=dataset)
        for axes, output in zip(drawn.panels, outputs, strict=True):
            unit = dataset[output].attrs["shown_unit"]
            axes.hist(
                *(shown(known[output]), min(int(known.sizes["design"] ** 0.5), MOST_BARS)),
                density=True,
                color=series_style(0).color,
                alpha=0.5,
            )
            for name, look in PERCENTILES.items():
                axes.axvline(from_si(float(dataset[name].sel(output=output)), unit), **look)
            for bound in bounds(known[output]):
                axes.axvline(bound, **limit)
            axes.set_xlabel(label(known[output]))
        drawn.label_y("Probability density")
    return drawn.figure


def plot_frequency_bands(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the median of the natural frequencies over the crank angle, and where 95 % lie.

    Parameters
    ----------
    dataset : Dataset
        Of an ``Uncertainty`` whose outputs are found from natural frequencies.
    ax : Axes or sequence of Axes, optional
        The user's, one for each mode. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If there are no frequencies over the crank angle.
    """
    if "frequency_percentile" not in dataset:
        raise InputError(
            "there are no frequencies over the crank angle; ask for lowest_frequency or another "
            "output that is found from natural frequencies"
        )
    bands = dataset["frequency_percentile"]
    angles, modes = degrees(bands["crank_angle"]), bands["mode"].values.tolist()
    shade: dict[str, Any] = {"color": series_style(0).color, "alpha": 0.3, "lw": 0}
    with sheet(tiles(len(modes), 3, PANEL), ax=ax) as drawn:
        handles = [series_handle(0, "median"), Patch(**shade, label="95 % of the designs")]
        heading = f"Natural frequencies of {bands.attrs['designs']} designs"
        drawn.header(handles, heading, of=dataset)
        for axes, mode in zip(drawn.panels, modes, strict=True):
            low, median, high = (bands.sel(mode=mode).sel(percentile=part) for part in BAND)
            axes.fill_between(angles, low, high, **shade)
            axes.plot(angles, median, **series_line(0))
            axes.set_title(mode_label([mode]))
            crank_angle_axis(axes, angles, narrow=True)
        drawn.label_x("Crank angle (deg)")
        drawn.label_y("Frequency (Hz)")
    return drawn.figure
