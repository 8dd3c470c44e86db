"""The Campbell diagram: bands of natural frequencies, orders of the crank, critical speeds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import xarray as xr

from flexmech.arrays import FloatArray, unbroken_runs
from flexmech.plots import reading, scales, style
from flexmech.plots.drawing import figure
from flexmech.plots.layout import grid
from flexmech.plots.picture import HATCHES, Curve, Pane, Picture, Span
from flexmech.plots.style import (
    AXES_HEIGHT,
    BESIDE_PANELS,
    TIMES,
    Look,
    series_line,
    series_style,
)
from flexmech.units import from_si

# Height of the panel, which is read closely, on a wide and on a narrow page, where it is nearly
# square; in inches.
BANDS_HEIGHT, NARROW_BANDS_HEIGHT = 3.9, 3.0
# Height in inches that a page shows as one pane of a picture.
PANE_HEIGHT = 1.7
ROOM = 1.06
"""Upper end of the frequency axis over the highest band, so that its edge is visible."""
# Bands let rays and each other through; rays stand back, and what is critical stands out.
BAND: Look = {"alpha": 0.28, "lw": 0}
RAY: Look = {"color": "0.72", "lw": 0.6, "zorder": 1}
CRITICAL: Look = {"color": "0.1", "lw": 1.8, "solid_capstyle": "round", "zorder": 4}
# A speed without width, where a band has none.
POINT: Look = {"color": "0.1", "marker": "o", "ms": 3.2, "ls": "", "zorder": 4}
AMPLIFIED: Look = {"color": "0.1", "marker": "o", "ms": 4.5, "mfc": "white", "ls": "", "zorder": 5}
# Less is no resonance that counts.
LEAST_AMPLIFIED = 1.05
GAP: Look = {"facecolor": "0.94", "edgecolor": "0.75", "hatch": "////", "lw": 0, "zorder": 0}
OPERATING: Look = {"color": style.MID_GREY, "lw": 1.0, "ls": ":", "zorder": 2}
OTHER_ENGINE: Look = {"color": "0.25", "lw": 0.7, "ls": (0.0, (4.0, 2.0)), "zorder": 3}
# Least distance of two labels of orders in inches: up by their height, or across by their letters.
APART_UP, APART_LETTER = 0.13, 0.075
# Ends of a critical speed nearer to each other than this, relatively, are drawn as a point: of an
# axis of 2,000 pixels it is less than one.
NO_WIDTH = 1e-4


@figure
def plot_campbell(dataset: xr.Dataset) -> Picture:
    """Draw bands of natural frequencies against crank speed, and where orders meet them.

    Filled is a branch from its lowest to its highest frequency over the crank angles; the line in
    it is the mean. Grey rays are the orders, multiples of the crank's turns per second; the dark
    part of a ray is inside a band: these are critical speeds. A circle on it is where the running
    linkage is amplified most, with its greatest deflection over that without vibration. Hatched are
    speeds without a result. Bands and means of further engines are dashed lines. Dotted lines are
    the operating speeds of the model file. Bands that no order reaches are named in the heading,
    and are left out above the axis; where orders reach none, the lowest is drawn.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``CampbellDiagram`` result; frequencies in Hz, speeds in rad/s.
    ax : Axes, optional
        The user's. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    shown = _shown_branches(dataset)
    top = ROOM * float(np.nanmax(dataset["highest_frequency"].sel(branch=shown).values))
    pane = Pane(
        "Natural frequency (Hz)",
        (
            *_bands_of(dataset, shown),
            *_rays(dataset, top),
            *_critical(dataset),
            *_amplified(dataset, top),
        ),
        spans=(*_gaps(dataset), *_operating_speeds(dataset)),
        limits=(0.0, top),
        height=1.25 * BANDS_HEIGHT / PANE_HEIGHT,
    )
    label = f"Crank speed ({reading.speed_unit(dataset)})"
    title, speeds = "Campbell diagram" + _left_out(dataset, shown), reading.speeds_of(dataset)
    height = NARROW_BANDS_HEIGHT if style.is_narrow() else BANDS_HEIGHT
    layout = grid(1, 1, height + AXES_HEIGHT)
    return Picture([pane], label, dataset, title, over="speed", places=speeds, layout=layout)


def _shown_branches(dataset: xr.Dataset) -> list[int]:
    """Branches that orders reach, or else the lowest, and those that overlap them."""
    over = ("engine", "crank_speed")
    lowest = dataset["lowest_frequency"].min(over).fillna(np.inf).values
    highest = dataset["highest_frequency"].max(over).fillna(0.0).values
    fastest = float(np.abs(dataset["crank_speed"].values).max()) / (2 * np.pi)
    upper_end = max(fastest * dataset["order"].values.max(initial=0), lowest.min())
    shown = np.zeros(len(lowest), dtype=bool)
    for branch in np.argsort(lowest, kind="stable").tolist():
        if lowest[branch] <= upper_end:
            shown[branch] = True
            upper_end = max(upper_end, ROOM * float(highest[branch]))
    return [int(branch) for branch in dataset["branch"].values[shown]]


def _left_out(dataset: xr.Dataset, shown: list[int]) -> str:
    """Sentence of the heading on branches that lie above the axes."""
    names = [str(n) for n in dataset["branch"].values.tolist() if n not in shown]
    are = f"branch {names[0]} is" if len(names) == 1 else f"branches {', '.join(names)} are"
    return f"; {are} higher than orders reach" if names else ""


def critical_stretches(dataset: xr.Dataset) -> list[tuple[int, FloatArray, FloatArray]]:
    """Where orders of the crank are inside the bands of the first engine.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``CampbellDiagram`` result.

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
        band = {"color": color, "hatch": HATCHES[branch % len(HATCHES)]} | BAND
        bands.append(Curve(speed, edges[0], band, "lowest to highest", upto=edges[1]))
        # The filling of a band without width or of a single speed does not show.
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
    # The highest, the lowest, then upward.
    wanted = sorted(ends, key=lambda one: (one != max(ends), one != min(ends), one))
    labelled = _apart({n: ends[n] for n in wanted}, len(f"{max(orders, default=0)}{TIMES}"))
    return [
        replace(ray, label=f"{order}{TIMES}" if order in labelled else "")
        for order, ray in zip(orders, rays, strict=True)
    ]


def _apart(ends: Mapping[int, tuple[float, float]], letters: int) -> list[int]:
    """Those whose labels, at parts of the axes, do not touch those of others before them."""
    high = NARROW_BANDS_HEIGHT if style.is_narrow() else BANDS_HEIGHT
    across = APART_LETTER * letters / (style.figure_width() - BESIDE_PANELS)
    kept = list[int]()
    for number, (x, y) in ends.items():
        others = [ends[other] for other in kept]
        if all(abs(x - u) >= across or abs(y - v) >= APART_UP / high for u, v in others):
            kept.append(number)
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


def _amplified(dataset: xr.Dataset, top: float) -> list[Curve]:
    """Peaks of the amplification in the ranges of the first engine, those at no end of the map."""
    left, right = scales.speed_limits(dataset)
    factor, peaks = from_si(1.0, reading.speed_unit(dataset)), dict[float, tuple[float, float]]()
    slowest, fastest = np.sort(dataset["crank_speed"].values)[[0, -1]]
    own = dataset.isel(critical=np.flatnonzero(dataset["critical_engine"] == dataset["engine"][0]))
    columns = (own[f"critical_{name}"].values for name in ("resonance", "order", "amplification"))
    for speed, order, amplified in zip(*columns, strict=True):
        if slowest < speed < fastest and amplified >= LEAST_AMPLIFIED:
            peaks.setdefault(factor * speed, (order * abs(speed) / (2 * np.pi), amplified))
    # The greatest are labelled first.
    points = sorted(peaks.items(), key=lambda point: -point[1][1])
    ends = {n: ((x - left) / (right - left), y / top) for n, (x, (y, _)) in enumerate(points)}
    labelled = _apart(ends, len("1.23"))
    name = "amplification of the deflection"
    return [
        Curve(np.array([x]), np.array([y]), AMPLIFIED, name, label=f"{size:.2f}" * (n in labelled))
        for n, (x, (y, size)) in enumerate(points)
    ]


def _operating_speeds(dataset: xr.Dataset) -> tuple[Span, ...]:
    """Operating speeds of the model file within the diagram."""
    factor = from_si(1.0, reading.speed_unit(dataset))
    places = [factor * speed for speed in reading.operating_speeds(dataset)]
    return tuple(Span(at, at, OPERATING, "operating speed", upright=True) for at in places)


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
