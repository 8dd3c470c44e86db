"""Floquet modes over crank speed: their frequencies, and the harmonics that they are made of."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.plots import style
from flexmech.plots.campbell import ROOM
from flexmech.plots.drawing import draw
from flexmech.plots.layout import AxesLike, Sheet, grid, sheet, tiles
from flexmech.plots.picture import Curve, Pane, Picture
from flexmech.plots.reading import cell_edges, speed_unit, speeds_of, spread, values_of
from flexmech.plots.stability import NOTHING, speed_spans
from flexmech.plots.style import Look, series_style

# Of a figure on a wide and on a narrow page, where it is nearly square, and of a panel of a branch,
# three rows of which fit half a page; in inches.
HEIGHT, NARROW_HEIGHT, PANEL_HEIGHT = 3.9, 3.2, 1.45
# Points are seen on it.
FILL: Look = {"alpha": 0.22, "lw": 0}
# Of marks, in points: they show where many branches lie close to each other.
POINT_SIZE = 2.2
# Of the axes' height: distance of two numbers at the edge, so that they do not touch.
NUMBER_HEIGHT = 0.035
# Of the lowest mean frequency, at which the axis begins: the linkage may be near to buckling, where
# the lowest frequency is zero, which has no place on a logarithmic axis.
LOWEST_PART = 0.4
# Harmonics of the lowest branches are drawn: those of the natural frequencies asked for by default.
MOST_BRANCHES = 4
# Lesser parts of a mode are white: they are of the order of the harmonics left out.
LEAST_SHARE = 1e-4


def plot_floquet_frequencies(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the Floquet frequencies of the first engine over the bands of moving frequencies.

    A point is the frequency of a Floquet mode's largest harmonic. Filled is each natural
    frequency from its lowest to its highest value over the turn, at the stress of the running
    links and without rotation terms. Where a point is outside the bands, another harmonic of its
    mode has become the largest.

    Parameters
    ----------
    dataset : Dataset
        Of a ``StabilityMap`` result.
    ax : Axes, optional
        The user's. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If there is an equilibrium at no speed.
    """
    frequency = values_of(dataset["frequency"].isel(engine=0), "crank_speed", "multiplier")[:, ::2]
    if not np.isfinite(frequency).any():
        raise InputError(NOTHING)
    height = NARROW_HEIGHT if style.is_narrow() else HEIGHT
    speed, curves = speeds_of(dataset), list[Curve]()
    for branch, along in enumerate(frequency.T):
        name = "" if branch else "Floquet frequency, in its branch's colour"
        curves.append(Curve(speed, along, _points(branch), name))
    curves += _moving(dataset)
    pane = Pane(
        "Frequency (Hz)",
        curves,
        spans=speed_spans(dataset),
        limits=_limits(dataset, frequency),
        scale="plain log",
    )
    label = f"Crank speed ({speed_unit(dataset)})"
    picture = Picture([pane], label, dataset, "Floquet frequencies", over="speed", places=speed)

    def number(drawn: Sheet) -> None:
        (axes,) = drawn.panels
        axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0), numticks=9))
        _number_branches(axes, dataset)

    return draw(picture, grid(1, 1, height + style.AXES_HEIGHT), ax=ax, finish=number)


def plot_floquet_harmonics(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw which harmonics of the crank the Floquet modes are made of, a panel a branch.

    The darker, the greater a part of the mode's mean square displacement is in the harmonic,
    counted from the largest one: a mode that does not change along the turn has the harmonic 0
    alone. Of the first engine and of the four lowest branches.

    Parameters
    ----------
    dataset : Dataset
        Of a ``StabilityMap`` result.
    ax : Axes or sequence of Axes, optional
        The user's, one a branch. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If there is an equilibrium at no speed.
    """
    share = dataset["harmonic_share"].isel(engine=0)
    if not np.isfinite(share).any():
        raise InputError(NOTHING)
    first = values_of(share, "multiplier", "harmonic", "crank_speed")[::2][:MOST_BRANCHES]
    speed = speeds_of(dataset.sortby("crank_speed"))
    first = first[..., np.argsort(dataset["crank_speed"].values)]
    number, order = len(first), dataset["harmonic"].values.astype(float)
    layout = tiles(number, 2, PANEL_HEIGHT, extra=0.6, sharex=True, sharey=True)
    with sheet(layout, ax=ax) as drawn:
        key = Patch(color=style.MID_GREY, label="the darker, the greater a part of the mode")
        drawn.header([key], "Harmonics of the Floquet modes", of=dataset)
        for branch, axes in enumerate(drawn.panels):
            cells = axes.pcolormesh(
                cell_edges(speed),
                cell_edges(order),
                np.clip(first[branch], LEAST_SHARE, 1.0),
                norm=LogNorm(LEAST_SHARE, 1.0),
                cmap="Greys",
                rasterized=True,
            )
            axes.set_xlim(*cell_edges(speed)[[0, -1]])
            axes.set_yticks(order[:: 2 if len(order) > 3 else 1])
            drawn.title(axes, f"Branch {branch + 1}", loc="left")
        drawn.label_x(f"Crank speed ({speed_unit(dataset)})")
        drawn.label_y("Harmonic of the crank")
        drawn.colour_bar(cells, "Part of the mean square")
    return drawn.figure


def _limits(dataset: xr.Dataset, frequency: FloatArray) -> tuple[float, float]:
    """Of the frequency axis: around the means of the moving frequencies, and their highest.

    Those of a linkage that is statically unstable are zero, and have no place on the axis.
    """
    mean = dataset["mean_frequency"].values
    if not (mean > 0).any():
        oscillating = frequency[frequency > 0] if (frequency > 0).any() else np.ones(1)
        return float(oscillating.min()) / ROOM, float(oscillating.max()) * ROOM
    highest = float(dataset["highest_frequency"].max())
    return LOWEST_PART * float(mean[mean > 0].min()), ROOM * highest


def _moving(dataset: xr.Dataset) -> list[Curve]:
    """Bands of the moving frequencies, and their means."""
    speed, curves = speeds_of(dataset, "moving_speed"), list[Curve]()
    lowest, mean, highest = (
        values_of(dataset[f"{name}_frequency"], "branch", "moving_speed")
        for name in ("lowest", "mean", "highest")
    )
    for branch in range(len(mean)):
        color, dashes = series_style(branch).color, series_style(branch).linestyle
        band = {"color": color, "zorder": 1} | FILL
        curves.append(
            Curve(speed, lowest[branch], band, "moving frequencies", upto=highest[branch])
        )
        curves.append(Curve(speed, mean[branch], {"color": color, "lw": 0.6, "ls": dashes}))
    return curves


def _number_branches(axes: Axes, dataset: xr.Dataset) -> None:
    """Numbers of the branches beside the right edge, at their means, spread to be read."""
    if not dataset.sizes["moving_speed"]:
        return
    mean = values_of(dataset["mean_frequency"], "branch", "moving_speed")[:, -1]
    # Where the linkage is statically unstable there is no frequency.
    upward = np.argsort(mean)[int((mean <= 0).sum()) :]
    bottom, top = np.log(axes.get_ylim())
    heights = np.exp(spread(np.log(mean[upward]), NUMBER_HEIGHT * (top - bottom)))
    look: Look = {"fontsize": style.LABEL_POINTS, "va": "center", "textcoords": "offset points"}
    for number, height in zip(dataset["branch"].values[upward].tolist(), heights, strict=True):
        place, color = (axes.get_xlim()[1], height), series_style(number - 1).color
        axes.annotate(str(number), place, xytext=(3, 0), color=color, **look)


def _points(branch: int) -> Look:
    each = series_style(branch)
    return {
        "color": each.color,
        "ls": "",
        "marker": each.marker,
        "ms": POINT_SIZE,
        "mew": 0.3,
        "zorder": 3,
    }
