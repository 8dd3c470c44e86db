"""Critical speeds: the Campbell diagram, and steady-state deflection against crank speed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import NullLocator

from flexmech.arrays import FloatArray, unbroken_runs
from flexmech.plots import reading, scales, style
from flexmech.plots.drawing import draw
from flexmech.plots.layout import AxesLike, Layout, grid, sheet
from flexmech.plots.picture import Curve, Pane, Picture, Span
from flexmech.plots.spectra import ONE_LINK
from flexmech.plots.style import (
    AXES_HEIGHT,
    BESIDE_PANELS,
    LABEL_POINTS,
    TIMES,
    Look,
    line_handle,
    series_line,
    series_style,
)
from flexmech.units import from_si

# Of the panel of bands, which is read closely, on a wide and on a narrow page, where it is nearly
# square, and of that of peaks, which has half the height; in inches.
BANDS_HEIGHT, NARROW_BANDS_HEIGHT, PEAKS_HEIGHT = 3.9, 3.0, 1.7
ROOM = 1.06
"""Of the frequency axis over the highest band, whose edge is seen below the end of the axis."""
# Bands let rays and each other through; rays stand back, and what is critical stands out.
BAND: Look = {"alpha": 0.28, "lw": 0}
RAY: Look = {"color": "0.72", "lw": 0.6, "zorder": 1}
CRITICAL: Look = {"color": "0.1", "lw": 1.8, "solid_capstyle": "round", "zorder": 4}
# A speed without width, where a band has none.
POINT: Look = {"color": "0.1", "marker": "o", "ms": 3.2, "ls": "", "zorder": 4}
GAP: Look = {"facecolor": "0.94", "edgecolor": "0.75", "hatch": "////", "lw": 0, "zorder": 0}
OTHER_ENGINE: Look = {"color": "0.25", "lw": 0.7, "ls": (0.0, (4.0, 2.0)), "zorder": 3}
PEAK_GREYS = ("0.1", "0.35", "0.55")
# Least distance of two labels of orders in inches: up by their height, or across by their letters.
APART_UP, APART_LETTER = 0.13, 0.075
# Ends of a critical speed nearer to each other than this, relatively, are drawn as a point: of an
# axis of 2,000 pixels it is less than one.
NO_WIDTH = 1e-4
BOTH = "choose nothing, or give two Axes: one for the bands and one for the peaks"

# Of a link, four of which fit a page, and what the axes of speed and the strip's edge take, in
# inches.
LINK_HEIGHT, SWEEP_AXES_HEIGHT = 1.5, 1.0
# One row of labels of critical speeds, in inches: letters of 7 points and a mark below them.
ROW_HEIGHT = 0.2
# Mean width of these letters as a fraction of their size: f, / and 1 are narrow.
MEAN_LETTER = 0.5
# Bands of several modes lie over each other, and the curve over all of them: three are no wall.
BAND_OPACITY = 0.18
ENDS = ["critical_speed_low", "critical_speed_high"]
SETTLED: Look = {"ls": "", "marker": "s", "ms": 4.2, "mfc": "white", "mec": series_style(1).color}

Bands = dict[int, list[tuple[str, float, float]]]
"""Name and ends of critical speeds by mode, from the lowest order on."""


def plot_campbell(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw bands of natural frequencies against crank speed, and where orders meet them.

    Filled is a branch from its lowest to its highest frequency over the crank angles; the line in
    it is the mean. Grey rays are the orders, multiples of the crank's turns per second; the dark
    part of a ray is inside a band: these are critical speeds. Hatched are speeds without a
    result. Where there are peaks of the periodic motion, they stand below over the quasi-static
    ones. Of further engines the bands' ends and means are dashed lines. The axis of frequencies
    ends above the lowest band that no order reaches: those beyond it are named in the heading.

    Parameters
    ----------
    dataset : Dataset
        Of a ``CampbellDiagram`` result; frequencies in Hz, speeds in rad/s.
    ax : Axes or sequence of Axes, optional
        The user's: one, or two where there are peaks of the periodic motion. Left out: a new
        figure is made.

    Returns
    -------
    Figure
    """
    picture, high = campbell_picture(dataset), style.is_narrow()
    heights = [NARROW_BANDS_HEIGHT if high else BANDS_HEIGHT, PEAKS_HEIGHT][: len(picture.panes)]
    layout = grid(len(heights), 1, sum(heights) + AXES_HEIGHT, sharex=True, height_ratios=heights)
    return draw(picture, layout, ax=ax, fewer=BOTH)


def campbell_picture(dataset: xr.Dataset) -> Picture:
    """Bands of frequencies, rays of orders and critical speeds, as of plot_campbell."""
    shown = _shown_branches(dataset)
    top = ROOM * float(np.nanmax(dataset["highest_frequency"].sel(branch=shown).values))
    panes = [
        Pane(
            "Natural frequency (Hz)",
            (*_bands_of(dataset, shown), *_rays(dataset, top), *_critical(dataset)),
            spans=_gaps(dataset),
            limits=(0.0, top),
            height=1.25 * BANDS_HEIGHT / PEAKS_HEIGHT,
        )
    ]
    if "peak_ratio" in dataset:
        panes.append(_peaks(dataset))
    label = f"Crank speed ({reading.speed_unit(dataset)})"
    title, speeds = "Campbell diagram" + _left_out(dataset, shown), reading.speeds_of(dataset)
    return Picture(panes, label, dataset, title, over="speed", places=speeds)


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


def _bands_of(dataset: xr.Dataset, shown: list[int]) -> list[Curve]:
    """Each branch from its lowest to its highest frequency, and its mean; dashed of others."""
    speed, curves, bands = reading.speeds_of(dataset), list[Curve](), list[Curve]()
    lowest, mean, highest = (
        reading.values_of(dataset[f"{name}_frequency"], "engine", "branch", "crank_speed")
        for name in ("lowest", "mean", "highest")
    )
    for branch, number in enumerate(dataset["branch"].values.tolist()):
        color, name = series_style(branch).color, f"branch {number}" if number in shown else ""
        line = series_line(branch, speed) | {"zorder": 3}
        curves.append(Curve(speed, mean[0, branch], line, name))
        edges = lowest[0, branch], highest[0, branch]
        band = {"color": color} | BAND
        bands.append(Curve(speed, edges[0], band, "lowest to highest", upto=edges[1]))
        # Of a band without width or of a single speed the filling does not show.
        edge: Look = {"color": color, "lw": 0.5}
        bands += [Curve(speed, values, edge, followed=None) for values in edges]
    curves += bands
    for engine in range(1, len(lowest)):
        name = reading.engine_label(dataset, engine)
        for values in (lowest[engine], mean[engine], highest[engine]):
            curves += [Curve(speed, one, OTHER_ENGINE, name) for one in values]
    return curves


def _rays(dataset: xr.Dataset, top: float) -> list[Curve]:
    """Orders of the crank up to the edges of the axes, labelled where labels do not touch."""
    factor = from_si(1.0, reading.speed_unit(dataset))
    left, right = scales.speed_limits(dataset)
    corners = np.union1d(np.linspace(left, right, 3), [min(max(0.0, left), right)])
    orders, ends = dataset["order"].values.tolist(), dict[int, tuple[float, float]]()
    rays = list[Curve]()
    for order in orders:
        # Beyond the top there is nothing to meet.
        most = 2 * np.pi * top / order * factor
        x = np.unique(np.clip(corners, -most, most))
        y = order * np.abs(x) / factor / (2 * np.pi)
        rays.append(Curve(x, y, RAY, "order of the crank"))
        if x[-1] > left:
            ends[order] = float(x[-1]) / (right - left), float(y[-1]) / top
    labelled = _apart(ends, len(f"{max(orders, default=0)}{TIMES}"))
    return [
        replace(ray, label=f"{order}{TIMES}" if order in labelled else "")
        for order, ray in zip(orders, rays, strict=True)
    ]


def _apart(ends: dict[int, tuple[float, float]], letters: int) -> list[int]:
    """Orders whose rays end apart, at parts of the axes: the highest, the lowest, then upward."""
    high = NARROW_BANDS_HEIGHT if style.is_narrow() else BANDS_HEIGHT
    across = APART_LETTER * letters / (style.figure_width() - BESIDE_PANELS)
    kept = list[int]()
    for order in sorted(ends, key=lambda one: (one != max(ends), one != min(ends), one)):
        (x, y), others = ends[order], [ends[other] for other in kept]
        if all(abs(x - u) >= across or abs(y - v) >= APART_UP / high for u, v in others):
            kept.append(order)
    return kept


def _critical(dataset: xr.Dataset) -> list[Curve]:
    """The parts of rays inside bands, by the first engine; a point where one has no width."""
    factor = from_si(1.0, reading.speed_unit(dataset))
    return [
        Curve(
            *(factor * ends, ray),
            CRITICAL if ends[1] - ends[0] > NO_WIDTH * np.abs(ends).max() else POINT,
            "critical speed",
        )
        for _, ends, ray in critical_stretches(dataset)
    ]


def _gaps(dataset: xr.Dataset) -> tuple[Span, ...]:
    """Speeds without a result by the first engine, as far as the next ones with one."""
    lowest = dataset["lowest_frequency"].isel(engine=0, branch=0).values
    speed = reading.speeds_of(dataset)
    return tuple(
        Span(
            *(speed[max(run.start - 1, 0)], speed[min(run.stop, len(speed) - 1)]),
            *(GAP, "no result"),
            upright=True,
        )
        for run in unbroken_runs(~np.isfinite(lowest))
    )


def _peaks(dataset: xr.Dataset) -> Pane:
    """Peaks of the periodic motion over the quasi-static ones, on a logarithmic axis."""
    speed = reading.speeds_of(dataset, "response_speed")
    ratio = reading.values_of(dataset["peak_ratio"], "link", "response_speed")
    curves = []
    for number, link in enumerate(reading.names_of(dataset, "link")):
        # Greys, for the colours are those of the branches.
        color = PEAK_GREYS[number % len(PEAK_GREYS)]
        look: Look = {"color": color, "ls": series_style(number).linestyle, "lw": 1.1}
        name = reading.link_label(dataset, link).lower()
        curves.append(Curve(speed, ratio[number], look, name))
    limits = None
    if ratio.size:
        limits = min(0.9, 0.9 * float(ratio.min())), max(2.0, 1.25 * float(ratio.max()))
    return Pane(
        "Peak deflection over\nquasi-static peak",
        curves,
        spans=(Span(1.0, 1.0, RAY), *_gaps(dataset)),
        limits=limits,
        scale="plain log",
        height=1.25,
    )


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
    with sheet(_sweep_layout(len(links), len(bands)), ax=ax, fewer=ONE_LINK) as drawn:
        drawn.header(_sweep_handles(dataset, bands), "Steady-state peak deflection", of=dataset)
        for axes, link in zip(drawn.panels, links, strict=True):
            axes.set_xlim(*limits)
            for row, mode in enumerate(bands):
                # Overlaps would look darker than they are.
                for low, high in reading.merged((low, high) for _, low, high in bands[mode]):
                    axes.axvspan(low, high, color=_color(row), alpha=BAND_OPACITY, lw=0, zorder=0)
            _draw_peaks_of_link(axes, dataset.sel(link=link))
            axes.set_ylabel(f"{reading.link_label(dataset, link)}\npeak deflection (mm)")
        drawn.label_x(f"Crank speed ({unit})")
        top = drawn.figure.axes[0] if drawn.is_new else drawn.panels[0]
        if drawn.is_new:
            _draw_strip(top, bands)
        scales.second_speed_axis(top, dataset)
    return drawn.figure


def _sweep_layout(links: int, modes: int) -> Layout:
    """A panel a link under a strip with a row a mode, which is a panel in new figures alone."""
    heights = [ROW_HEIGHT * modes + 0.02, *[max(LINK_HEIGHT, 2.6 / links)] * links]
    whole = grid(links + 1, 1, sum(heights) + SWEEP_AXES_HEIGHT, sharex=True, height_ratios=heights)
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


def _draw_peaks_of_link(axes: Axes, link: xr.Dataset) -> None:
    """Peaks of one link in mm, on a logarithmic axis if they allow it."""
    speed = reading.speeds_of(link)
    drawn = [1e3 * link["peak_deflection"].values.astype(float)]
    axes.plot(speed, drawn[0], **series_line(0, speed))
    if "settled_peak" in link:
        drawn.append(1e3 * link["settled_peak"].values.astype(float))
        axes.plot(reading.speeds_of(link, "settled_speed"), drawn[1], **SETTLED, zorder=3)
    values = np.concatenate(drawn)
    positive = values[np.isfinite(values) & (values > 0)]
    if positive.size == 0:
        scales.plain_numbers(axes)
        return
    low, high = 0.8 * float(positive.min()), 1.25 * float(positive.max())
    scales.log_scale(axes, low, high, plain=True)


def _sweep_handles(dataset: xr.Dataset, bands: Bands) -> list[Artist]:
    handles = [line_handle("steady state", color=series_style(0).color)]
    if "settled_peak" in dataset:
        handles.append(line_handle("settled simulation", **SETTLED))
    for row, mode in enumerate(bands):
        look: Look = {"color": _color(row), "alpha": 2 * BAND_OPACITY, "lw": 0}
        handles.append(Patch(**look, label=f"f{reading.subscripts(mode)}/order"))
    return handles
