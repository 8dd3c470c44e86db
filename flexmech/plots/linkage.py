"""The rigid linkage in a figure of its own, and the names of joints for all figures."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from flexmech.plots import style
from flexmech.plots.labels import mechanism_name
from flexmech.plots.layout import AxesLike, grid, sheet
from flexmech.plots.linkage_parts import SAME_PLACE
from flexmech.plots.linkage_sketch import LinkageSketch, clearance
from flexmech.plots.reading import names_of, values_of
from flexmech.plots.series import Look
from flexmech.plots.to_scale import height_of
from flexmech.types import FloatArray

LEAST_HEIGHT, MOST_HEIGHT = 1.6, 3.6
# Distance of a name from its joint in points; farther from what slides and the shaft.
AWAY, BEYOND_BLOCK, BEYOND_SHAFT = np.array([12.0, 9.0]), 1.5, 1.3
# Room for the names around the joints over the linkage's size.
NAME_ROOM = 0.06
# Directions that are tried for a name where more than links is in the way.
TRIED = np.radians(np.arange(0.0, 360.0, 15.0))


def plot_linkage(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the rigid linkage with the names of its joints, and its supports on the ground.

    Parameters
    ----------
    dataset : Dataset
        With ``rigid_position`` (link, station, component) and ``joint_position`` (joint,
        component) in m, the coordinate ``joint_kind`` (clamp, pivot, pin, weld or slider), the
        name of the mechanism, and the attribute ``drawing``.
    ax : Axes, optional
        The user's. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    joints = values_of(dataset["joint_position"], "joint", "component")
    is_pin = ~np.isin(dataset["joint_kind"].values, ["clamp", "pivot"])
    sketch = LinkageSketch.of(dataset)
    room = NAME_ROOM * sketch.size
    limits = sketch.limits(np.vstack([joints - room, joints + room]))
    height = height_of(limits, style.figure_width(), LEAST_HEIGHT, MOST_HEIGHT)
    with sheet(grid(1, 1, height), ax=ax) as drawn:
        (axes,) = drawn.panels
        sketch.frame(axes, limits)
        sketch.draw(axes, color="0.5", lw=2.0)
        sketch.draw_scale_bar(axes)
        axes.set_title(mechanism_name(dataset), loc="center")
        name_joints(axes, sketch, names_of(dataset, "joint"), joints, is_pin)
    return drawn.figure


def name_joints(
    axes: Axes,
    sketch: LinkageSketch,
    names: list[str],
    places: FloatArray,
    is_pin: NDArray[np.bool_],
) -> None:
    """Write names beside joints, away from links and supports.

    Parameters
    ----------
    axes : Axes
    sketch : LinkageSketch
    names : list of str
    places : ndarray, shape (joint, 2)
        In m.
    is_pin : ndarray of bool, shape (joint,)
        Whether a joint is one between links; the others are held by the ground.
    """
    for number, (name, place, pinned) in enumerate(zip(names, places, is_pin, strict=True)):
        here = np.hypot(*(places - place).T) <= SAME_PLACE * sketch.size
        # Of several joints in one place the one that has the place's own name.
        if min(np.flatnonzero(here), key=lambda other: len(names[other])) != number:
            continue
        offset = AWAY * _away(sketch, place, held=not pinned)
        if sketch.slides(place):
            offset *= BEYOND_BLOCK
        elif (
            np.hypot(*(place - sketch.shaft)) <= SAME_PLACE * sketch.size and not style.is_narrow()
        ):
            # On a narrow page the shaft's disc is within the usual distance.
            offset *= BEYOND_SHAFT
        look: Look = {"textcoords": "offset points", "ha": "center", "va": "center", "zorder": 6}
        look["bbox"] = {"fc": "white", "lw": 0, "alpha": 0.75, "pad": 0.5}
        axes.annotate(name, place, tuple(offset), **look)


def _away(sketch: LinkageSketch, place: FloatArray, *, held: bool) -> FloatArray:
    """Direction away from the links at a joint, from a support below it, and from all else."""
    links = sketch.taken(place, links_alone=True)
    directions = ([np.array([0.0, -1.0])] if held else []) + links
    if len(sketch.occupied(place)) > len(directions):
        tried = np.column_stack([np.cos(TRIED), np.sin(TRIED)])
        room = [round(clearance(each, sketch.occupied(place)), 6) for each in tried]
        return np.asarray(tried[int(np.argmax(room))])
    pull = np.sum(directions, axis=0)
    if np.hypot(*pull) <= SAME_PLACE:
        # Between two in one line there is room on both sides.
        pull = directions[0][::-1] * [1.0, -1.0]
    return np.asarray(-pull / np.hypot(*pull))
