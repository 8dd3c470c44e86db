"""Steady-state deflection against crank speed, with the critical speeds behind it."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import NullLocator

from flexmech.plots import reading, scales, style
from flexmech.plots.layout import AxesLike, Layout, grid, sheet
from flexmech.plots.spectra import ONE_LINK
from flexmech.plots.style import Look, line_handle, series_line, series_style
from flexmech.units import from_si

# Millimetres in a metre.
MILLI = 1e3
# Of a link in inches.
PANEL_HEIGHT = 1.5
# The two axes of speed, in inches.
AXES_HEIGHT = 1.0
# One row of labels of critical speeds, in inches, and the size of its letters in points.
ROW_HEIGHT = 0.2
LABEL_POINTS = 7.0
# Mean width of these letters as a fraction of their size: f, / and 1 are narrow.
MEAN_LETTER = 0.5
# What the panels leave of the figure's width in inches, on the safe side.
BESIDE_PANELS = 0.85
# Bands of several modes lie over each other, and the curve over all of them.
BAND_OPACITY = 0.18
ENDS = ["critical_speed_low", "critical_speed_high"]
SETTLED: Look = {"ls": "", "marker": "s", "ms": 4.2, "mfc": "white", "mec": series_style(1).color}

Bands = dict[int, list[tuple[str, float, float]]]
"""Name and ends of critical speeds by mode, from the lowest order on."""


def plot_speed_sweep(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the steady-state peak deflection of each link against crank speed.

    One panel a link. Shaded are the critical speeds: where a multiple (the order) of the
    crank's turns per second meets a natural frequency at some angle of the turn. The strip
    above the panels of a new figure has a row for each mode and names the bands, f₂/5 where
    the fifth multiple meets the second frequency; names that would touch a lower order's are
    left out.

    Parameters
    ----------
    dataset : Dataset
        With ``peak_deflection`` (crank_speed, link) in m, ``critical_speed_low`` and
        ``critical_speed_high`` (mode, order) in rad/s, and the coordinate ``probe`` of the
        links. Peaks of full simulations, ``settled_peak`` (settled_speed, link) in m, are
        drawn as markers if there are any.
    ax : Axes or sequence of Axes, optional
        The user's, one a link. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    dataset, unit = dataset.sortby("crank_speed"), reading.speed_unit(dataset)
    factor, links = from_si(1.0, unit), reading.names_of(dataset, "link")
    # Markers of simulations do not hang over the edges.
    limits = scales.speed_limits(dataset, 0.015 if "settled_peak" in dataset else 0.0)
    bands = _bands(dataset, factor, limits)
    with sheet(_layout(len(links), len(bands)), ax=ax, fewer=ONE_LINK) as drawn:
        drawn.header(_handles(dataset, bands), "Steady-state peak deflection", of=dataset)
        for axes, link in zip(drawn.panels, links, strict=True):
            axes.set_xlim(*limits)
            for row, mode in enumerate(bands):
                for low, high in _merged(bands[mode]):
                    axes.axvspan(low, high, color=_color(row), alpha=BAND_OPACITY, lw=0, zorder=0)
            _draw_peaks(axes, dataset.sel(link=link))
            axes.set_ylabel(f"{reading.link_label(dataset, link)}\npeak deflection (mm)")
        drawn.label_x(f"Crank speed ({unit})")
        top = drawn.figure.axes[0] if drawn.is_new else drawn.panels[0]
        if drawn.is_new:
            _draw_strip(top, bands)
        scales.second_speed_axis(top, dataset)
    return drawn.figure


def _layout(links: int, modes: int) -> Layout:
    """A panel a link under a strip with a row a mode, which is a panel in new figures alone."""
    heights = [ROW_HEIGHT * modes + 0.02, *[max(PANEL_HEIGHT, 2.6 / links)] * links]
    whole = grid(links + 1, 1, sum(heights) + AXES_HEIGHT, sharex=True, height_ratios=heights)
    return Layout(links, whole.height, lambda figure: whole.make(figure)[1:])


def _bands(dataset: xr.Dataset, factor: float, limits: tuple[float, float]) -> Bands:
    """Bands within the limits; one that only reaches into the range is cut off at the edge."""
    ordered, bands = dataset[ENDS].sortby("order"), Bands()
    lows, highs = (factor * reading.values_of(ordered[end], "mode", "order") for end in ENDS)
    for row, mode in enumerate(ordered["mode"].values.tolist()):
        for column, order in enumerate(ordered["order"].values.tolist()):
            low, high = float(lows[row, column]), float(highs[row, column])
            if high > limits[0] and low < limits[1]:
                cut = (
                    f"f{reading.subscripts(mode)}/{order}",
                    max(low, limits[0]),
                    min(high, limits[1]),
                )
                bands.setdefault(mode, []).append(cut)
    return bands


def _merged(bands: list[tuple[str, float, float]]) -> list[tuple[float, float]]:
    """Bands of one mode without overlaps, which would look darker than they are."""
    merged: list[tuple[float, float]] = []
    for _, low, high in sorted(bands, key=lambda band: band[1]):
        if merged and low <= merged[-1][1]:
            merged[-1] = (merged[-1][0], max(high, merged[-1][1]))
        else:
            merged.append((low, high))
    return merged


def _color(row: int) -> str:
    # The first two colours are those of the deflections.
    return series_style(2 + row % 4).color


def _draw_strip(axes: Axes, bands: Bands) -> None:
    """Strip above the panels with the bands' names, a row a mode."""
    axes.set_ylim(0.0, max(len(bands), 1))
    axes.spines[["left", "bottom"]].set_visible(False)
    axes.yaxis.set_major_locator(NullLocator())
    axes.tick_params(bottom=False, labelbottom=False)
    low_edge, high_edge = axes.get_xlim()
    inch = (high_edge - low_edge) / (style.figure_width() - BESIDE_PANELS)
    for row, mode in enumerate(bands):
        free = np.inf
        for number, (name, low, high) in enumerate(bands[mode]):
            # Neighbours at two heights: wide bands of high orders overlap.
            height = row + 0.12 * (number % 2)
            axes.fill_between([low, high], height, height + 0.1, color=_color(row), lw=0)
            half = (MEAN_LETTER * len(name) + 0.4) * LABEL_POINTS / 72 * inch / 2
            # Near an edge the name moves inwards as far as it must.
            middle = min(max((low + high) / 2, low_edge + half), high_edge - half)
            # A band that barely reaches into the range has no name, which would stand beside it.
            if low <= middle <= high and middle + half < free:
                free = middle - half
                axes.text(middle, row + 0.6, name, ha="center", va="center", fontsize=LABEL_POINTS)


def _draw_peaks(axes: Axes, link: xr.Dataset) -> None:
    """Peaks of one link in mm, on a logarithmic axis if they allow it."""
    speed = reading.speeds_of(link)
    drawn = [MILLI * link["peak_deflection"].values.astype(float)]
    axes.plot(speed, drawn[0], **series_line(0, speed))
    if "settled_peak" in link:
        drawn.append(MILLI * link["settled_peak"].values.astype(float))
        axes.plot(reading.speeds_of(link, "settled_speed"), drawn[1], **SETTLED, zorder=3)
    values = np.concatenate(drawn)
    positive = values[np.isfinite(values) & (values > 0)]
    if positive.size == 0:
        scales.plain_numbers(axes)
        return
    low, high = 0.8 * float(positive.min()), 1.25 * float(positive.max())
    scales.log_scale(axes, low, high, plain=True)


def _handles(dataset: xr.Dataset, bands: Bands) -> list[Artist]:
    handles = [line_handle("steady state", color=series_style(0).color)]
    if "settled_peak" in dataset:
        handles.append(line_handle("settled simulation", **SETTLED))
    for row, mode in enumerate(bands):
        look: Look = {"color": _color(row), "alpha": 2 * BAND_OPACITY, "lw": 0}
        handles.append(Patch(**look, label=f"f{reading.subscripts(mode)}/order"))
    return handles
