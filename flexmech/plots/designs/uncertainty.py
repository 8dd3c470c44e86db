"""How uncertain outputs are, and which input makes them so."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

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
from flexmech.plots.drawing import draw
from flexmech.plots.layout import AxesLike, sheet, tiles
from flexmech.plots.picture import Curve, Pane, Picture, Span, over_angles
from flexmech.plots.reading import degrees, mode_label
from flexmech.plots.style import (
    MID_GREY,
    Look,
    line_handle,
    series_line,
    series_style,
)
from flexmech.units import from_si

# Percentiles of frequencies: of the interval of 95 % its lower end, the median, its upper end.
BAND = (2.5, 50.0, 97.5)
# Bars of a distribution at most.
MOST_BARS = 60
# Percentiles of outputs: look and name in the legend.
PERCENTILES: Mapping[str, tuple[Look, str]] = {
    "p50": ({"color": "black", "lw": 1.2}, "median"),
    "p2_5": ({"color": "black", "lw": 0.9, "ls": ":"}, "2.5 and 97.5 %"),
    "p97_5": ({"color": "black", "lw": 0.9, "ls": ":"}, "2.5 and 97.5 %"),
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
    outputs = outputs_of(dataset)
    panes = [distribution_pane(dataset, name) for name in outputs]
    title, label_y = "Distribution of the outputs", "Probability density"
    picture = Picture(panes, "", dataset, title, label_y)
    return draw(picture, tiles(len(outputs), 2, PANEL), ax=ax)


def distribution_pane(dataset: xr.Dataset, output: str) -> Pane:
    """How often an output takes its values among the designs; median, 95 % interval and limits.

    Parameters
    ----------
    dataset : Dataset
        Of an ``Uncertainty``.
    output : str

    Returns
    -------
    Pane
    """
    known = computed(dataset)
    values, unit = shown(known[output]), dataset[output].attrs["shown_unit"]
    count = min(int(known.sizes["design"] ** 0.5), MOST_BARS)
    heights, edges = np.histogram(values, count, density=True)
    x, y = np.repeat(edges, 2)[1:-1], np.repeat(heights, 2)
    bars = Curve(x, 0.0 * y, {"color": series_style(0).color, "alpha": 0.5, "lw": 0}, upto=y)
    places = [(from_si(float(dataset[p].sel(output=output)), unit), p) for p in PERCENTILES]
    spans = [Span(at, at, *PERCENTILES[name], upright=True) for at, name in places]
    limit = BOUND | {"color": series_style(1).color}
    spans += [Span(at, at, limit, "limit", upright=True) for at in bounds(known[output])]
    ends = 0.0, 1.05 * float(heights.max())
    return Pane("", (bars,), spans=spans, limits=ends, along=label(known[output]))


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
    layout = tiles(dataset["frequency_percentile"].sizes["mode"], 3, PANEL)
    return draw(frequency_bands_picture(dataset), layout, ax=ax)


def frequency_bands_picture(dataset: xr.Dataset) -> Picture:
    """Median and 95 % interval of the frequencies, as of plot_frequency_bands."""
    bands = dataset["frequency_percentile"]
    angles, panes = degrees(bands["crank_angle"]), []
    shade: Look = {"color": series_style(0).color, "alpha": 0.3, "lw": 0}
    for mode in bands["mode"].values.tolist():
        low, median, high = (bands.sel(mode=mode, percentile=part).values for part in BAND)
        line = Curve(angles, median, series_line(0), "median")
        interval = Curve(angles, low, shade, "95 % of the designs", upto=high)
        panes.append(Pane("", (line, interval), title=mode_label([mode])))
    title = f"Natural frequencies of {bands.attrs['designs']} designs"
    return over_angles(angles, panes, dataset, title, "Frequency (Hz)")
