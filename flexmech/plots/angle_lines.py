"""Series over the crank angle: lines of the first engine, marks of the others."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes

from flexmech.plots.labels import engine_label
from flexmech.plots.series import (
    MARK_SIZE,
    Look,
    few_points,
    line_handle,
    series_line,
    series_style,
)
from flexmech.plots.style import MID_GREY
from flexmech.types import FloatArray

__all__ = ["draw_line", "draw_marks", "engine_handles", "marked_handles", "staggered"]

# Marks along a line: enough to judge by, few enough to see the lines through.
MARKS_ALONG_ANGLE = 12


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
    look = _mark(style.marker, style.color, engine)
    if few_points(angles):
        # The first engine has marks too: ring them.
        look["markersize"] *= 1.5
    axes.plot(angles[places], values[places], **look, clip_on=False, zorder=2.4)


def _mark(marker: str, color: str, engine: int) -> Look:
    """Mark of an engine: open for the second one, filled for further ones."""
    fill = "white" if engine == 1 else color
    look = {"linestyle": "", "color": color, "marker": marker, "markersize": MARK_SIZE}
    return look | {"markerfacecolor": fill, "markeredgewidth": 0.9}


def marked_handles(dataset: xr.Dataset, labels: Sequence[str]) -> list[Artist]:
    """Legend entries of series: the marks are those of the second engine, or of few angles."""
    engines, handles = dataset.sizes["engine"], list[Artist]()
    for number, label in enumerate(labels):
        style, look = series_style(number), series_line(number)
        if engines > 1 or few_points(dataset["crank_angle"].values):
            look = _mark(style.marker, style.color, engines - 1) | {"linestyle": style.linestyle}
        handles.append(line_handle(label, **look))
    return handles


def engine_handles(dataset: xr.Dataset) -> list[Artist]:
    """Legend entries of the engines: the first is drawn as lines, the others as marks."""
    dot = "o" if few_points(dataset["crank_angle"].values) else ""
    first = line_handle(engine_label(dataset), color=MID_GREY, marker=dot, markersize=3.0)
    others = range(1, dataset.sizes["engine"])
    return [
        first,
        *(line_handle(engine_label(dataset, n), **_mark("o", MID_GREY, n)) for n in others),
    ]
