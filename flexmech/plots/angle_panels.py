"""Panels over the crank angle, and the series in them: lines of one engine, marks of others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize

from flexmech.arrays import FloatArray
from flexmech.plots.layout import Layout, grid
from flexmech.plots.picture import Curve
from flexmech.plots.reading import engine_label, speed_unit
from flexmech.plots.style import (
    MID_GREY,
    Look,
    few_points,
    is_narrow,
    series_line,
    series_style,
)
from flexmech.units import from_si

# In points, of the marks of further engines: they stand out from lines of 1.2 points.
MARK_SIZE = 4.2
# Marks along a line: enough to judge by, few enough to see the lines through.
MARKS_ALONG_ANGLE = 12
ONE_MODE = "choose one mode (modes=1)"
# From this number of panels on, two columns read better than one tall stack.
TWO_COLUMNS_FROM = 4
# Height of a panel with its heading at least, in inches: three ticks and their numbers. More panels
# on top of each other than these are flatter: eight of them fit a page of 240 mm.
PANEL_HEIGHT, MOST_TALL, FLAT_PANEL = 1.4, 5, 1.1
FEW_SPEEDS = 5
"""More crank speeds than these are distinguished by a colour map rather than by styles."""
# Lightest part of viridis, which is perceptually uniform and grows lighter throughout; its yellow
# end cannot be seen on white.
LIGHTEST = 0.9
COLOURS = LinearSegmentedColormap.from_list(
    "speeds", mpl.colormaps["viridis"](np.linspace(0.0, LIGHTEST, 256))
)
# Thinner than a line alone, since many lie side by side.
SPEED_LINE: Look = {"linestyle": "-", "linewidth": 0.9}


def angle_layout(sizes: Sequence[int], *, share_y: bool = False) -> Layout:
    """Panels over a shared crank-angle axis, in two columns from four panels on.

    Parameters
    ----------
    sizes : sequence of int
        Height of each panel in units, in order; panels of a row have that of the tallest.
    share_y : bool
        Whether all panels have the same y axis.

    Returns
    -------
    Layout
    """
    count = len(sizes)
    columns = 2 if count > 1 and sum(sizes) >= TWO_COLUMNS_FROM and not is_narrow() else 1
    rows = [max(sizes[first : first + columns]) for first in range(0, count, columns)]
    units = sum(rows)
    least = PANEL_HEIGHT if units <= MOST_TALL else FLAT_PANEL
    height = units * max(least, 1.9 - 0.3 * units) + 0.5
    options: Look = {"sharex": True, "sharey": share_y, "height_ratios": rows}
    return grid(len(rows), columns, height, count=count, **options)


def staggered(angles: FloatArray, number: int, total: int) -> slice:
    """Every so many points for the marks of a line, apart from those of the other lines.

    Parameters
    ----------
    angles : ndarray
    number, total : int
        Which line of how many.

    Returns
    -------
    slice
        All points where they are few.
    """
    step = 1 if few_points(angles) else -(-angles.size // MARKS_ALONG_ANGLE)
    # In the middle of its share, so that no mark is cut off by the axis.
    return slice(((2 * number + 1) * step) // (2 * total), None, step)


def branch_lines(values: FloatArray, branch: FloatArray) -> dict[int, FloatArray]:
    """Values along each branch over the angles; not a number where the branch is elsewhere.

    Parameters
    ----------
    values, branch : ndarray, shape (crank_angle, mode)
        Values of some modes, and the numbers of their branches.

    Returns
    -------
    dict of int to ndarray, shape (crank_angle,)
    """
    lines = {}
    for number in np.unique(branch):
        here = branch == number
        along = np.where(here, values, 0.0).sum(axis=1)
        lines[int(number)] = np.where(here.any(axis=1), along, np.nan)
    return lines


@dataclass(frozen=True)
class Between:
    """Points of a line between the crank angles of a map.

    Parameters
    ----------
    angles : ndarray, shape (n,)
        In degrees.
    values, branch : ndarray, shape (n, mode)
        In the panel's unit, and branches as those of the map; 0 where none is known.
    """

    angles: FloatArray
    values: FloatArray
    branch: FloatArray

    def among(
        self, angles: FloatArray, line: FloatArray, branch: int
    ) -> tuple[FloatArray, FloatArray]:
        """A line with the points of its branch among those of the map.

        Parameters
        ----------
        angles, line : ndarray, shape (A,)
        branch : int

        Returns
        -------
        ndarray, ndarray
        """
        here = self.branch == branch
        points = here.any(axis=1)
        added = np.where(here, self.values, 0.0).sum(axis=1)[points]
        along = np.concatenate([angles, self.angles[points]])
        order = np.argsort(along, kind="stable")
        return along[order], np.concatenate([line, added])[order]


def series_curves(
    along: FloatArray,
    values: FloatArray,
    branch: FloatArray,
    series: tuple[int, int, str],
    between: Between | None = None,
) -> list[Curve]:
    """A series of modes: lines of the first engine, marks of the others at some places.

    Parameters
    ----------
    along : ndarray, shape (n,)
        Crank angles in degrees, or speeds.
    values : ndarray, shape (engine, n, mode)
        In the pane's unit.
    branch : ndarray, shape (n, mode)
        Branch of each mode of the first engine; a line follows a branch. Lines of the first series
        are numbered by them where there are several modes.
    series : (int, int, str)
        Which series of how many, and its name.
    between : Between, optional
        Further points of the first engine's lines.

    Returns
    -------
    list of Curve
    """
    number, total, name = series
    numbered = number == 0 and values.shape[-1] > 1
    curves = []
    for of_branch, line in branch_lines(values[0], branch).items():
        x, y = (along, line) if between is None else between.among(along, line, of_branch)
        look = series_line(number, x) | {"zorder": 2.5}
        label = f"branch {of_branch}" if numbered else ""
        curves.append(Curve(x, y, look, name, label=label))
    style, places = series_style(number), staggered(along, number, total)
    for engine in range(1, len(values)):
        look = _mark(style.marker, style.color, engine) | {"clip_on": False, "zorder": 2.4}
        if few_points(along):
            # The first engine has marks too: ring them.
            look["markersize"] *= 1.5
        curves += [Curve(along[places], one, look) for one in values[engine, places].T]
    return curves


def _mark(marker: str, color: str, engine: int) -> Look:
    """Mark of an engine: open for the second one, filled for further ones."""
    fill = "white" if engine == 1 else color
    look = {"linestyle": "", "color": color, "marker": marker, "markersize": MARK_SIZE}
    return look | {"markerfacecolor": fill, "markeredgewidth": 0.9}


def series_and_engines(
    dataset: xr.Dataset, names: Sequence[str], along: str = "crank_angle"
) -> dict[str, Look]:
    """Legend of series by name, then of the engines: lines of one, marks of others.

    The marks of the series are those of the second engine, or of few points along the coordinate.

    Parameters
    ----------
    dataset : Dataset
    names : sequence of str
        Names of the series.
    along : str
        Coordinate of the x axis.

    Returns
    -------
    dict of str to dict
    """
    engines, few = dataset.sizes["engine"], few_points(dataset[along].values)
    legend = dict[str, Look]()
    for number, name in enumerate(names):
        style, legend[name] = series_style(number), series_line(number)
        if engines > 1 or few:
            look = _mark(style.marker, style.color, engines - 1)
            legend[name] = look | {"linestyle": style.linestyle}
    first: Look = {"color": MID_GREY, "marker": "o" if few else "", "markersize": 3.0}
    for engine in range(engines):
        look = _mark("o", MID_GREY, engine) if engine else first
        legend[engine_label(dataset, engine)] = look
    return legend


def has_many_speeds(dataset: xr.Dataset) -> bool:
    """Whether a dataset has too many crank speeds for each to have a style of its own."""
    return bool(dataset.sizes["crank_speed"] > FEW_SPEEDS)


def speed_lines(dataset: xr.Dataset) -> list[Look]:
    """Properties of the line of each of many crank speeds, without marks.

    Parameters
    ----------
    dataset : Dataset

    Returns
    -------
    list of dict
        For ``Axes.plot``; a single crank angle is a dot.
    """
    mark = {"marker": "." if dataset.sizes["crank_angle"] == 1 else ""}
    mapped = _mappable(dataset)
    return [
        {**SPEED_LINE, **mark, "color": mapped.to_rgba(speed)}
        for speed in dataset["crank_speed"].values.astype(float).tolist()
    ]


def speed_colours(dataset: xr.Dataset) -> tuple[ScalarMappable, str] | None:
    """Scale of the crank speeds' colours and its label, where there are many speeds."""
    if not has_many_speeds(dataset):
        return None
    factor, mapped = from_si(1.0, speed_unit(dataset)), _mappable(dataset)
    mapped.set_clim(*(factor * end for end in mapped.get_clim()))
    return mapped, f"Crank speed ({speed_unit(dataset)})"


def _mappable(dataset: xr.Dataset) -> ScalarMappable:
    speeds = dataset["crank_speed"].values.astype(float)
    return ScalarMappable(Normalize(float(speeds.min()), float(speeds.max())), COLOURS)
