"""Panels over the crank angle: where they stand, what is on their axes, lines and marks in them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import accumulate

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexmech.plots.reading import degrees, engine_label, speed_text
from flexmech.plots.sheet import AxesLike, Layout, Sheet, sheet
from flexmech.plots.style import (
    MARK_SIZE,
    MID_GREY,
    crank_angle_axis,
    few_points,
    line_handle,
    mode_label,
    series_handle,
    series_line,
    series_style,
)
from flexmech.types import FloatArray

__all__ = [
    "ONE_MODE",
    "angle_layout",
    "draw_line",
    "draw_marks",
    "engine_handles",
    "grid_height",
    "label_angles",
    "marked_handles",
    "mode_panels",
    "panel_grid",
    "speed_texts",
    "staggered",
]

ONE_MODE = "choose one mode (modes=1)"

# From this number of panels on, two columns read better than one tall stack.
TWO_COLUMNS_FROM = 4
# Least height of a panel with its heading, and least width for many ticks, in inches.
PANEL_HEIGHT = 1.4
WIDE = 4.0
# Marks along a line: enough to judge by, few enough to see the lines through.
MARKS_ALONG_ANGLE = 12


def angle_layout(sizes: Sequence[int], *, share_y: bool = False) -> Layout:
    """Panels over a shared crank-angle axis, in two columns from four panels on.

    Parameters
    ----------
    sizes : sequence of int
        Height of each panel in units, in order.
    share_y : bool
        Whether all panels have the same y axis.

    Returns
    -------
    Layout
    """
    columns = _columns(sizes)
    rows = max(sum(sizes[panel] for panel in column) for column in columns)

    def make(figure: Figure) -> list[Axes]:
        cells = figure.add_gridspec(rows, len(columns))
        panels: list[Axes] = []
        for place, column in enumerate(columns):
            ends = accumulate(sizes[panel] for panel in column)
            for panel, end in zip(column, ends, strict=True):
                first = panels[0] if panels else None
                cell = cells[end - sizes[panel] : end, place]
                axes = figure.add_subplot(cell, sharex=first, sharey=first if share_y else None)
                axes.tick_params(labelbottom=panel == column[-1])
                panels.append(axes)
        return panels

    return Layout(len(sizes), rows * max(PANEL_HEIGHT, 1.9 - 0.3 * rows) + 0.5, make)


def _columns(sizes: Sequence[int]) -> list[range]:
    """Panel numbers of each column; the first column is the taller one."""
    whole = range(len(sizes))
    if len(sizes) == 1 or sum(sizes) < TWO_COLUMNS_FROM:
        return [whole]
    half = (sum(sizes) + 1) // 2
    cut = next(n for n, filled in enumerate(accumulate(sizes), start=1) if filled >= half)
    return [part for part in (whole[:cut], whole[cut:]) if part]


def label_angles(drawn: Sheet, angles: FloatArray, y_label: str) -> None:
    """Scale and label the axes of panels over the crank angle.

    Parameters
    ----------
    drawn : Sheet
    angles : ndarray
        Crank angles in degrees, ascending.
    y_label : str
        Label of all y axes, with its unit.
    """
    width = drawn.figure.get_figwidth()
    for axes in drawn.panels:
        crank_angle_axis(axes, angles, narrow=axes.get_position().width * width < WIDE)
    drawn.label_x("Crank angle (deg)")
    drawn.label_y(y_label)


@contextmanager
def mode_panels(
    dataset: xr.Dataset, y_label: str, *, ax: AxesLike | None = None, share_y: bool = False
) -> Iterator[Sheet]:
    """One panel a mode over the crank angle, with its heading.

    Parameters
    ----------
    dataset : Dataset
        Sorted by crank angle.
    y_label : str
        Label of all y axes, with its unit.
    ax : Axes or sequence of Axes, optional
        The user's, one a mode.
    share_y : bool
        Whether all panels have the same y axis.

    Yields
    ------
    Sheet
    """
    layout = angle_layout([1] * dataset.sizes["mode"], share_y=share_y)
    with sheet(layout, ax=ax, fewer=ONE_MODE) as drawn:
        label_angles(drawn, degrees(dataset["crank_angle"]), y_label)
        for axes, mode in zip(drawn.panels, dataset["mode"].values, strict=True):
            axes.set_title(mode_label([mode]))
        yield drawn


def grid_height(sizes: Sequence[int]) -> float:
    """Height in inches of a panel grid, its crank-angle axis included."""
    return angle_layout(sizes).height


def panel_grid(
    figure: Figure,
    sizes: Sequence[int],
    angles: FloatArray,
    y_label: str,
    *,
    share_y: bool = False,
) -> list[Axes]:
    """Stack panels over a shared crank-angle axis, in two columns from four panels on.

    Parameters
    ----------
    figure : Figure
        Where to put them.
    sizes : sequence of int
        Height of each panel in units, in order.
    angles : ndarray
        Crank angles in degrees, ascending.
    y_label : str
        Label of all y axes, with its unit.
    share_y : bool
        Whether all panels have the same y axis.

    Returns
    -------
    list of Axes
        One a panel, in order.
    """
    drawn = Sheet(figure, angle_layout(sizes, share_y=share_y).make(figure))
    label_angles(drawn, angles, y_label)
    return drawn.panels


def draw_line(axes: Axes, angles: FloatArray, values: FloatArray, number: int) -> None:
    """Draw a series over the crank angle, with a point where a value stands alone.

    Parameters
    ----------
    axes : Axes
    angles, values : ndarray, shape (n,)
        Degrees, and numbers in the panel's unit; not a number is a gap.
    number : int
        Of the series' style.
    """
    line = series_line(number, angles)
    axes.plot(angles, values, **line, zorder=2.5)
    present = np.concatenate([[False], np.isfinite(values), [False]])
    alone = present[1:-1] & ~present[:-2] & ~present[2:]
    if alone.any() and not line["marker"]:
        axes.plot(angles[alone], values[alone], ".", color=line["color"], ms=3)


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


def draw_marks(
    axes: Axes, angles: FloatArray, values: FloatArray, number: int, total: int, engine: int
) -> None:
    """Draw a series of a further engine as marks at some angles.

    Parameters
    ----------
    axes : Axes
    angles : ndarray, shape (n,)
        In degrees.
    values : ndarray, shape (n,) or (n, k)
        In the panel's unit.
    number, total : int
        Which series of how many.
    engine : int
        From 1; the first engine is drawn as lines.
    """
    style, places = series_style(number), staggered(angles, number, total)
    axes.plot(
        angles[places],
        values[places],
        linestyle="",
        marker=style.marker,
        # On a coarse map the first engine has marks too: ring them.
        markersize=(1.5 if few_points(angles) else 1.0) * MARK_SIZE,
        markerfacecolor=_fill(engine, style.color),
        markeredgecolor=style.color,
        markeredgewidth=0.9,
        clip_on=False,
        zorder=2.4,
    )


def _fill(engine: int, color: str | None) -> str | None:
    return "white" if engine == 1 else color


def marked_handles(dataset: xr.Dataset, labels: Sequence[str]) -> list[Artist]:
    """Legend entries of series: the marks are those of the second engine, or of few angles."""
    several = dataset.sizes["engine"] > 1
    marked = several or few_points(dataset["crank_angle"].values)
    return [
        series_handle(
            number,
            label,
            marker=series_style(number).marker if marked else "",
            markersize=MARK_SIZE,
            markerfacecolor="white" if several else None,
            markeredgewidth=0.9,
        )
        for number, label in enumerate(labels)
    ]


def engine_handles(dataset: xr.Dataset) -> list[Artist]:
    """Legend entries of the engines: the first is drawn as lines, the others as marks."""
    dot = "o" if few_points(dataset["crank_angle"].values) else ""
    handles: list[Artist] = [
        line_handle(engine_label(dataset), color=MID_GREY, marker=dot, markersize=3.0)
    ]
    for engine in range(1, dataset.sizes["engine"]):
        mark = {"linestyle": "", "marker": "o", "markersize": MARK_SIZE}
        fill = _fill(engine, MID_GREY)
        label = engine_label(dataset, engine)
        handles.append(line_handle(label, color=MID_GREY, markerfacecolor=fill, **mark))
    return handles


def speed_texts(dataset: xr.Dataset) -> list[str]:
    """Crank speeds of a dataset in the user's unit."""
    return [speed_text(dataset, float(speed)) for speed in dataset["crank_speed"].values]
