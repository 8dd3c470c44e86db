"""Steady-state deflection against crank speed, with the critical speeds behind it."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator
from numpy.typing import ArrayLike

from flexmech.plots.style import (
    FIGURE_WIDTH,
    few_points,
    header_height,
    header_legend,
    new_figure,
    plain_numbers,
    publication_style,
    series_style,
)
from flexmech.types import FloatArray

__all__ = ["plot_speed_sweep"]


MILLI = 1e3
RPM = 30 / np.pi
PANEL_HEIGHT = 1.5
# The two axes of speed, in inches.
AXES_HEIGHT = 1.0
# One row of labels of critical speeds, in inches, and the size of its letters in points.
ROW_HEIGHT = 0.2
LABEL_POINTS = 7.0
# Mean width of these letters as a fraction of their size: f, / and 1 are narrow.
MEAN_LETTER = 0.5
# What the panels have of the figure's width, on the safe side.
PANEL_WIDTH = FIGURE_WIDTH - 0.85
BAND_OPACITY = 0.18
SUBSCRIPTS = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
# Up to this many decades the ticks stand at 1, 2 and 5, beyond it at powers of ten.
FEW_DECADES = 2.3


def plot_speed_sweep(dataset: xr.Dataset) -> Figure:
    """Draw the steady-state peak deflection of each link against crank speed.

    One panel a link. Shaded are the critical speeds: where a multiple (the order) of the
    crank's turns per second meets a natural frequency at some angle of the turn. The strip
    above the panels has a row for each mode and names the bands, f₂/5 where the fifth
    multiple meets the second frequency; names that would touch a lower order's are left out.

    Parameters
    ----------
    dataset : Dataset
        With ``peak_deflection`` (crank_speed, link) in m, ``critical_speed_low`` and
        ``critical_speed_high`` (mode, order) in rad/s, and the coordinate ``probe`` of the
        links. Peaks of full simulations, ``settled_peak`` (settled_speed, link) in m, are
        drawn as markers if there are any.

    Returns
    -------
    Figure
    """
    with publication_style():
        dataset = dataset.sortby("crank_speed")
        speed = dataset["crank_speed"].values.astype(float)
        limits = _limits(dataset)
        bands = _bands(dataset, limits)
        name = str(dataset.attrs["mechanism"])
        title = f"Steady-state peak deflection of the {name}"
        handles = _handles(dataset, bands)
        links = [str(link) for link in dataset["link"].values]
        strip = ROW_HEIGHT * len(bands) + 0.02
        panel = max(PANEL_HEIGHT, 2.6 / len(links))
        figure = new_figure(
            panel * len(links) + strip + AXES_HEIGHT + header_height(handles, title)
        )
        heights = [strip, *[panel] * len(links)]
        grid = GridSpec(len(heights), 1, figure=figure, height_ratios=heights)
        bottom = figure.add_subplot(grid[-1])
        panels = [figure.add_subplot(grid[1 + n], sharex=bottom) for n in range(len(links) - 1)]
        panels.append(bottom)
        bottom.set_xlim(*limits)
        bottom.set_xlabel("Crank speed (rad/s)")
        for axes, link in zip(panels, links, strict=True):
            axes.tick_params(labelbottom=axes is bottom)
            _draw_bands(axes, bands)
            _draw_peaks(axes, speed, dataset.sel(link=link))
            probe = str(dataset["probe"].sel(link=link).values)
            axes.set_ylabel(f"{link.capitalize()} {probe}\npeak deflection (mm)")
        _draw_strip(figure.add_subplot(grid[0], sharex=bottom), bands)
        figure.align_ylabels(panels)
        header_legend(figure, handles, title)
    return figure


def _limits(dataset: xr.Dataset) -> tuple[float, float]:
    """Range of speeds; markers of simulations do not hang over its edges."""
    speeds = dataset["crank_speed"].values.astype(float)
    low, high = float(speeds.min()), float(speeds.max())
    if low == high:
        return low - 1.0, high + 1.0
    room = 0.015 * (high - low) if "settled_peak" in dataset else 0.0
    return low - room, high + room


def _bands(
    dataset: xr.Dataset, limits: tuple[float, float]
) -> dict[int, list[tuple[str, float, float]]]:
    """Name and ends of the bands within the limits, by mode, from the lowest order on.

    A band that only reaches into the range is cut off at the edge.
    """
    order = dataset["order"].values
    found: dict[int, list[tuple[str, float, float]]] = {}
    for mode in dataset["mode"].values:
        lows = dataset["critical_speed_low"].sel(mode=mode).values
        highs = dataset["critical_speed_high"].sel(mode=mode).values
        here = []
        for number, low, high in sorted(zip(order, lows, highs, strict=True)):
            if not (high > limits[0] and low < limits[1]):
                continue
            name = f"f{int(mode)}".translate(SUBSCRIPTS) + f"/{int(number)}"
            here.append((name, max(low, limits[0]), min(high, limits[1])))
        if here:
            found[int(mode)] = here
    return found


def _merged(bands: list[tuple[str, float, float]]) -> list[tuple[float, float]]:
    """Bands of one mode without overlaps, which would look darker than they are."""
    merged: list[tuple[float, float]] = []
    for _, low, high in sorted(bands, key=lambda band: band[1]):
        if merged and low <= merged[-1][1]:
            merged[-1] = (merged[-1][0], max(high, merged[-1][1]))
        else:
            merged.append((low, high))
    return merged


def _draw_bands(axes: Axes, bands: dict[int, list[tuple[str, float, float]]]) -> None:
    for row, mode in enumerate(bands):
        for low, high in _merged(bands[mode]):
            axes.axvspan(low, high, color=_band_color(row), alpha=BAND_OPACITY, lw=0, zorder=0)


def _band_color(row: int) -> str:
    # The first two colours are those of the deflections.
    return series_style(2 + row % 4).color


def _draw_strip(axes: Axes, bands: dict[int, list[tuple[str, float, float]]]) -> None:
    """Strip above the panels: the bands' names, a row a mode, under the axis in rpm."""
    axes.set_ylim(0.0, max(len(bands), 1))
    axes.spines[["left", "bottom"]].set_visible(False)
    axes.yaxis.set_major_locator(NullLocator())
    axes.tick_params(bottom=False, labelbottom=False)
    low_edge, high_edge = axes.get_xlim()
    inch = (high_edge - low_edge) / PANEL_WIDTH
    for row, mode in enumerate(bands):
        taken: list[tuple[float, float]] = []
        for number, (name, low, high) in enumerate(bands[mode]):
            # Neighbours at two heights: wide bands of high orders overlap.
            height = row + 0.12 * (number % 2)
            axes.fill_between([low, high], height, height + 0.1, color=_band_color(row), lw=0)
            half = (MEAN_LETTER * len(name) + 0.4) * LABEL_POINTS / 72 * inch / 2
            # Near an edge the name moves inwards as far as it must.
            middle = min(max((low + high) / 2, low_edge + half), high_edge - half)
            left, right = middle - half, middle + half
            # A band that barely reaches into the range has no name, which would stand beside it.
            if low <= middle <= high and all(right < start or left > end for start, end in taken):
                taken.append((left, right))
                axes.text(middle, row + 0.6, name, ha="center", va="center", fontsize=LABEL_POINTS)
    top = axes.secondary_xaxis("top", functions=(_rpm, _radians_a_second))
    top.set_xlabel("Crank speed (rpm)")


def _rpm(speed: ArrayLike) -> FloatArray:
    return np.asarray(speed, dtype=float) * RPM


def _radians_a_second(speed: ArrayLike) -> FloatArray:
    return np.asarray(speed, dtype=float) / RPM


def _draw_peaks(axes: Axes, speed: FloatArray, link: xr.Dataset) -> None:
    """Peaks of one link in mm, on a logarithmic axis if they allow it."""
    line, marks = series_style(0), series_style(1)
    drawn = [MILLI * link["peak_deflection"].values.astype(float)]
    axes.plot(speed, drawn[0], color=line.color, marker="o" if few_points(speed) else "", ms=3)
    if "settled_peak" in link:
        drawn.append(MILLI * link["settled_peak"].values.astype(float))
        axes.plot(
            link["settled_speed"].values.astype(float),
            drawn[1],
            ls="",
            marker=marks.marker,
            ms=4.2,
            mfc="white",
            mec=marks.color,
            mew=1.0,
            zorder=3,
        )
    values = np.concatenate(drawn)
    positive = values[np.isfinite(values) & (values > 0)]
    if positive.size == 0:
        plain_numbers(axes)
        return
    low, high = 0.8 * float(positive.min()), 1.25 * float(positive.max())
    few = np.log10(high / low) <= FEW_DECADES
    axes.set_yscale("log")
    axes.set_ylim(low, high)
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if few else (1.0,), numticks=9))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())


def _handles(dataset: xr.Dataset, bands: dict[int, list[tuple[str, float, float]]]) -> list[Artist]:
    marks = series_style(1)
    handles: list[Artist] = [Line2D([], [], color=series_style(0).color, label="steady state")]
    if "settled_peak" in dataset:
        handles.append(
            Line2D(
                [],
                [],
                ls="",
                marker=marks.marker,
                ms=4.2,
                mfc="white",
                mec=marks.color,
                label="settled simulation",
            )
        )
    for row, mode in enumerate(bands):
        label = f"f{mode}".translate(SUBSCRIPTS) + "/order"
        handles.append(Patch(color=_band_color(row), alpha=2 * BAND_OPACITY, lw=0, label=label))
    return handles
