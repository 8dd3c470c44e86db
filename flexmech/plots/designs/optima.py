"""The best designs of a study: what one goal costs of the others, and the search."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.plots.designs.reading import LARGE_PANEL, PANEL, goals_of, label, shown
from flexmech.plots.drawing import draw
from flexmech.plots.drawn_linkage.sketch import LinkageSketch
from flexmech.plots.layout import AxesLike, Sheet, tiles
from flexmech.plots.picture import Curve, Pane, Picture
from flexmech.plots.style import (
    MID_GREY,
    Look,
    series_line,
    series_style,
)

# Linkages of a front that are drawn, what of a panel's height they take, and the size of their
# pins over that in a picture of one linkage.
MOST_LINKAGES, STRIP, PIN = 5, 0.36, 1.4


def plot_pareto(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw what one goal costs of the others: the designs that no other is better than.

    Some of them are drawn above it, to one scale, where the dataset has their ``rigid_position``
    (design, link, station, component).

    Parameters
    ----------
    dataset : Dataset
        Of an ``Optimum``.
    ax : Axes or sequence of Axes, optional
        The user's, one for each goal but the first. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If there are fewer than two goals.
    """
    goals = goals_of(dataset)
    if len(goals) < 2:
        raise InputError("one goal has one best design, and no front; plot_search draws its search")
    picture = pareto_picture(dataset)

    def add_linkages(drawn: Sheet) -> None:
        if "rigid_position" in dataset:
            best = dataset.sortby(goals[0][1])
            for axes, pane in zip(drawn.panels, picture.panes, strict=True):
                _draw_linkages(axes, best, pane.curves[0].x, pane.curves[0].y)

    return draw(picture, tiles(len(goals) - 1, 2, LARGE_PANEL), ax=ax, finish=add_linkages)


def pareto_picture(dataset: xr.Dataset) -> Picture:
    """Best designs of the first goal and of each further one, as of plot_pareto."""
    (sense, first), *others = goals_of(dataset)
    best = dataset.sortby(first)
    # The front of three goals and more is a surface, which no line follows.
    line = "" if others[1:] else "-"
    look: Look = {"marker": "o", "ms": 4, "lw": 0.8, "ls": line, "color": series_style(0).color}
    along = f"{label(best[first])}, {sense}"
    panes = [
        Pane(
            f"{label(best[output])}, {other}",
            (Curve(shown(best[first]), shown(best[output]), look, "design"),),
            along=along,
        )
        for other, output in others
    ]
    title = "Designs that no other is better than in every goal"
    return Picture(panes, "", dataset, title)


def _draw_linkages(axes: Axes, best: xr.Dataset, x: FloatArray, y: FloatArray) -> None:
    """Designs along a front as small linkages in a strip above it, each joined to its point."""
    wanted = np.linspace(x[0], x[-1], min(MOST_LINKAGES, x.size))
    chosen = np.unique(np.abs(x - wanted[:, None]).argmin(axis=1))
    sketches = [
        replace(LinkageSketch.of(best.isel(design=int(number))), joint_size=PIN)
        for number in chosen
    ]
    around = Bbox.union([sketch.limits(sketch.links, 0.0) for sketch in sketches])
    limits = around.expanded(1.1, 1.1)
    # The front below the strip, with some room around it.
    room = 0.05 * (float(np.ptp(y)) or abs(float(y[0])) or 1.0)
    low, high = float(y.min()) - room, float(y.max()) + room
    axes.set_ylim(low, low + (high - low) / (1 - STRIP))
    wide = 1 / len(sketches)
    for place, (number, sketch) in enumerate(zip(chosen.tolist(), sketches, strict=True)):
        inside = axes.inset_axes((place * wide, 1 - STRIP + 0.03, 0.95 * wide, STRIP - 0.03))
        sketch.frame(inside, limits)
        sketch.draw(inside, color=series_style(0).color, lw=1.0)
        axes.annotate(
            "",
            (x[number], y[number]),
            ((place + 0.475) * wide, 1 - STRIP + 0.03),
            textcoords="axes fraction",
            arrowprops={"arrowstyle": "-", "color": MID_GREY, "lw": 0.5},
        )


def plot_search(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the best goal so far over the number of designs that were computed.

    Parameters
    ----------
    dataset : Dataset
        Of an ``Optimum``.
    ax : Axes or sequence of Axes, optional
        The user's, one for each goal. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    picture = search_picture(dataset)
    return draw(picture, tiles(len(picture.panes), 2, PANEL), ax=ax)


def search_picture(dataset: xr.Dataset) -> Picture:
    """The best of each goal so far over the designs computed, as of plot_search."""
    at, panes = dataset["evaluations"].values.astype(float), []
    look = series_line(0) | {"drawstyle": "steps-post"}
    for sense, output in goals_of(dataset):
        own = dataset["history"].sel(goal=output).assign_attrs(dataset[output].attrs)
        curve = Curve(at, shown(own), look, "best so far that keeps every limit")
        panes.append(Pane(f"{label(dataset[output])}, {sense}", (curve,)))
    title = "Search for the best design"
    return Picture(panes, "Designs computed", dataset, title)
