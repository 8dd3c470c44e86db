"""The Campbell diagram: bands of natural frequencies, orders of the crank, critical speeds."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from flexmech.arrays import FloatArray, unbroken_runs
from flexmech.plots import reading, scales, style
from flexmech.plots.layout import grid, sheet
from flexmech.plots.style import (
    AXES_HEIGHT,
    BESIDE_PANELS,
    LABEL_POINTS,
    TIMES,
    Look,
    line_handle,
    line_handles,
    series_handles,
    series_line,
    series_style,
)
from flexmech.units import from_si

# Of the panel, which is read closely, on a wide and on a narrow page, where it is nearly square; in
# inches.
BANDS_HEIGHT, NARROW_BANDS_HEIGHT = 3.9, 3.0
ROOM = 1.06
"""Of the frequency axis over the highest band, whose edge is seen below the end of the axis."""
# Bands let rays and each other through; rays stand back, and what is critical stands out.
BAND: Look = {"alpha": 0.28, "lw": 0}
RAY: Look = {"color": "0.72", "lw": 0.6, "zorder": 1}
CRITICAL: Look = {"color": "0.1", "lw": 1.8, "solid_capstyle": "round", "zorder": 4}
# A speed without width, where a band has none.
POINT: Look = {"color": "0.1", "marker": "o", "ms": 3.2, "ls": "", "zorder": 4}
GAP: Look = {"facecolor": "0.94", "edgecolor": "0.75", "hatch": "////", "lw": 0}
OTHER_ENGINE: Look = {"color": "0.25", "lw": 0.7, "ls": (0.0, (4.0, 2.0)), "zorder": 3}
# Least distance of two labels of orders in inches: their height, and for each letter its width.
APART_UP, APART_LETTER = 0.13, 0.075
# Ends of a critical speed nearer to each other than this, relatively, are drawn as a point: of an
# axis of 2,000 pixels it is less than one.
NO_WIDTH = 1e-4


def plot_campbell(dataset: xr.Dataset, *, ax: Axes | None = None) -> Figure:
    """Draw bands of natural frequencies against crank speed, and where orders meet them.

    Filled is a branch from its lowest to its highest frequency over the crank angles; the line in
    it is the mean. Grey rays are the orders, multiples of the crank's turns per second; the dark
    part of a ray is inside a band: these are critical speeds. Hatched are speeds without a
    result. Of further engines the bands' ends and means are dashed lines. The axis of frequencies
    ends above the lowest band that no order reaches: those beyond it are named in the heading.

    Parameters
    ----------
    dataset : Dataset
        Of a ``CampbellDiagram`` result; frequencies in Hz, speeds in rad/s.
    ax : Axes, optional
        The user's. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    factor, shown = from_si(1.0, reading.speed_unit(dataset)), _shown_branches(dataset)
    height = NARROW_BANDS_HEIGHT if style.is_narrow() else BANDS_HEIGHT
    with sheet(grid(1, 1, height + AXES_HEIGHT), ax=ax) as drawn:
        title = "Campbell diagram" + _left_out(dataset, shown)
        drawn.header(_handles(dataset, shown), title, of=dataset)
        bands = drawn.panels[0]
        bands.set_xlim(*scales.speed_limits(dataset))
        highest = dataset["highest_frequency"].sel(branch=shown).values
        bands.set_ylim(0.0, ROOM * float(np.nanmax(highest)))
        scales.plain_numbers(bands)
        _draw_bands(bands, dataset)
        _draw_rays(bands, dataset, factor)
        _draw_critical(bands, dataset, factor)
        bands.set_ylabel("Natural frequency (Hz)")
        _draw_gaps(bands, dataset)
        drawn.label_x(f"Crank speed ({reading.speed_unit(dataset)})")
        scales.second_speed_axis(bands, dataset)
    return drawn.figure


def _shown_branches(dataset: xr.Dataset) -> list[int]:
    """Branches that orders reach, and the lowest that none reaches with those that it overlaps."""
    over, found = ("engine", "crank_speed"), list[int]()
    lowest = dataset["lowest_frequency"].min(over).fillna(np.inf).values
    highest = dataset["highest_frequency"].max(over).fillna(0.0).values
    fastest = float(np.abs(dataset["crank_speed"].values).max()) / (2 * np.pi)
    reach, top = fastest * dataset["order"].values.max(initial=0), np.inf
    for place in np.argsort(lowest, kind="stable").tolist():
        if lowest[place] > top:
            break
        found.append(place)
        if lowest[place] > reach:
            # The axis ends above this one, which others may overlap.
            top = ROOM * float(highest[found].max())
    return [int(branch) for branch in dataset["branch"].values[sorted(found)]]


def _left_out(dataset: xr.Dataset, shown: list[int]) -> str:
    """What the heading says of branches that lie above the axes."""
    names = [str(n) for n in dataset["branch"].values.tolist() if n not in shown]
    are = f"branch {names[0]} is" if len(names) == 1 else f"branches {', '.join(names)} are"
    return f"; {are} higher than orders reach" if names else ""


def critical_stretches(dataset: xr.Dataset) -> list[tuple[int, FloatArray, FloatArray]]:
    """Where orders of the crank are inside the bands of the first engine.

    Parameters
    ----------
    dataset : Dataset
        Of a ``CampbellDiagram`` result.

    Returns
    -------
    list of (int, ndarray, ndarray), shape (2,)
        Order, crank speeds in rad/s at both ends, and the order's frequencies there in Hz.
    """
    first = str(dataset["engine"].values[0])
    met = (dataset["critical_engine"].values == first) & (dataset["critical_gap"].values == 0)
    found = []
    for place in np.flatnonzero(met).tolist():
        own = dataset.isel(critical=place)
        ends = np.array([float(own["critical_start"]), float(own["critical_end"])])
        order = int(own["critical_order"])
        found.append((order, ends, order * np.abs(ends) / (2 * np.pi)))
    return found


def _draw_bands(axes: Axes, dataset: xr.Dataset) -> None:
    speed = reading.speeds_of(dataset)
    lowest, mean, highest = (
        reading.values_of(dataset[f"{name}_frequency"], "engine", "branch", "crank_speed")
        for name in ("lowest", "mean", "highest")
    )
    for branch in range(lowest.shape[1]):
        color = series_style(branch).color
        axes.fill_between(speed, lowest[0, branch], highest[0, branch], color=color, **BAND)
        # Of a band without width or of a single speed the filling does not show.
        for edge in (lowest, highest):
            axes.plot(speed, edge[0, branch], color=color, lw=0.5)
        axes.plot(speed, mean[0, branch], **series_line(branch, speed), zorder=3)
        for other in range(1, len(lowest)):
            for values in (lowest, mean, highest):
                axes.plot(speed, values[other, branch], **OTHER_ENGINE)


def _draw_rays(axes: Axes, dataset: xr.Dataset, factor: float) -> None:
    """Orders from corner to edge, labelled where they leave the axes and labels do not touch."""
    (left, right), (_, top) = axes.get_xlim(), axes.get_ylim()
    speed = np.union1d(np.linspace(left, right, 3), [min(max(0.0, left), right)])
    aside, above = dict[int, float](), dict[int, float]()
    for order in sorted(dataset["order"].values.tolist()):
        ray = order * np.abs(speed) / factor / (2 * np.pi)
        axes.plot(speed, ray, **RAY, scaley=False, scalex=False)
        leaves = 2 * np.pi * top / order * factor
        if ray[-1] <= top:
            aside[order] = float(ray[-1])
        elif leaves > left:
            above[order] = leaves
    lowest, highest = (min(aside | above, default=0), max(aside | above, default=0))
    look: Look = {"fontsize": LABEL_POINTS, "color": style.MID_GREY, "textcoords": "offset points"}
    height = NARROW_BANDS_HEIGHT if style.is_narrow() else BANDS_HEIGHT
    for order in _apart(aside, APART_UP / height * top, (lowest, highest)):
        text = (right, aside[order])
        axes.annotate(f"{order}{TIMES}", text, xytext=(3, 0), va="center", **look)
    letters = APART_LETTER * len(f"{highest}{TIMES}") / (style.figure_width() - BESIDE_PANELS)
    for order in _apart(above, letters * (right - left), (lowest, highest)):
        # Inside the axes, to the left of the ray: above stands the other axis of speed.
        place: Look = {"xytext": (-2, -3), "ha": "right", "va": "top"}
        place["bbox"] = {"facecolor": "white", "edgecolor": "none", "pad": 0.4}
        axes.annotate(f"{order}{TIMES}", (above[order], top), **place, **look)


def _apart(places: dict[int, float], least: float, ends: tuple[int, int]) -> list[int]:
    """Orders whose places are apart: first the highest of all, the lowest, then from it up."""
    kept = [ends[1]] if ends[1] in places else []
    for order in sorted(places, key=lambda one: (one != ends[0], one)):
        if all(abs(places[order] - places[other]) >= least for other in kept):
            kept.append(order)
    return sorted(kept)


def _draw_critical(axes: Axes, dataset: xr.Dataset, factor: float) -> None:
    """The parts of rays inside bands, by the first engine."""
    for _, ends, ray in critical_stretches(dataset):
        wide = ends[1] - ends[0] > NO_WIDTH * np.abs(ends).max()
        axes.plot(factor * ends, ray, **(CRITICAL if wide else POINT))


def _draw_gaps(axes: Axes, dataset: xr.Dataset) -> None:
    """Speeds without a result by the first engine, as far as the next ones with one."""
    lowest = dataset["lowest_frequency"].isel(engine=0, branch=0).values
    speed = reading.speeds_of(dataset)
    for run in unbroken_runs(~np.isfinite(lowest)):
        left, right = speed[max(run.start - 1, 0)], speed[min(run.stop, len(speed) - 1)]
        axes.axvspan(left, right, **GAP, zorder=0)
        text = "no result" if right - left > 0.2 * np.ptp(axes.get_xlim()) else "gap"
        look: Look = {"ha": "center", "va": "center", "fontsize": LABEL_POINTS, "zorder": 5}
        look["bbox"] = {"facecolor": "white", "edgecolor": "none", "pad": 1.5}
        middle, across = (left + right) / 2, axes.get_xaxis_transform()
        axes.text(middle, 0.5, text, transform=across, **look)


def _handles(dataset: xr.Dataset, shown: list[int]) -> list[Artist]:
    branches = dataset["branch"].values.tolist()
    of_all = series_handles((f"branch {n}" for n in branches), dataset["crank_speed"].values)
    handles = [handle for n, handle in zip(branches, of_all, strict=True) if n in shown]
    handles.append(Patch(color=style.MID_GREY, **BAND, label="lowest to highest"))
    handles += line_handles({"order": RAY, "critical speed": CRITICAL})
    for other in range(1, dataset.sizes["engine"]):
        handles.append(line_handle(reading.engine_label(dataset, other), **OTHER_ENGINE))
    return handles
