"""Shaking force, shaking moment and driving torque of a linkage before and after its balance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from flexmech.arrays import SAME_PLACE
from flexmech.plots import reading, scales, style
from flexmech.plots.drawing import draw
from flexmech.plots.layout import AxesLike, Sheet, grid
from flexmech.plots.picture import ZERO, Pane, Picture, over_angles, series
from flexmech.plots.shaking import moment_point

# Of two rows of two panels in inches: four of them fit a page in one column.
_HEIGHT = 4.0
_ELASTIC: style.Look = {"alpha": 0.45, "lw": 0.9, "zorder": 1.5}


def plot_balance(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the shaking force's end point, its size, the shaking moment and the driving torque.

    Of elastic links the size is drawn too, in paler lines.

    Parameters
    ----------
    dataset : Dataset
        With ``shaking_force`` (state, crank_angle, component) in N, ``shaking_moment`` and
        ``driving_torque`` (state, crank_angle) in N m, ``moment_point`` (component) in m; where
        there are elastic links ``elastic_shaking_force`` (state, elastic_angle, component). The
        attributes ``crank_speed`` and ``mechanism``.
    ax : sequence of Axes, optional
        Four of the user's. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    picture = balance_picture(dataset)
    force = reading.values_of(dataset["shaking_force"], "state", "crank_angle", "component")
    factor, unit = reading.fitting_unit(force, reading.FORCE_UNITS)

    def draw_plane(drawn: Sheet) -> None:
        """The path of the force's end point, which is not over the crank angle."""
        plane = drawn.panels[0]
        plane.set_aspect("equal", adjustable="datalim")
        for line in (plane.axhline, plane.axvline):
            line(0.0, **ZERO.look)
        for number, path in enumerate(factor * force):
            plane.plot(path[:, 0], path[:, 1], **style.series_line(number))
        if np.abs(force[-1]).max() < SAME_PLACE * np.abs(force).max():
            # A balanced force is a point.
            plane.plot(0.0, 0.0, "o", ms=3.0, color=style.series_style(1).color)
        plane.set(xlabel=f"Shaking force along x ({unit})", ylabel=f"Along y ({unit})")
        scales.plain_numbers(plane)

    return draw(picture, grid(2, 2, _HEIGHT), ax=ax, by_hand=1, finish=draw_plane)


def balance_picture(dataset: xr.Dataset) -> Picture:
    """Size of the shaking force, shaking moment and driving torque, as of plot_balance."""
    angles = reading.degrees(dataset["crank_angle"])
    states = style.distinct_names(reading.names_of(dataset, "state"))
    force = np.linalg.norm(
        reading.values_of(dataset["shaking_force"], "state", "crank_angle", "component"), axis=-1
    )
    sizes = series(angles, force, states)
    if "elastic_shaking_force" in dataset:
        turned = np.degrees(dataset["elastic_angle"].values)
        running = dataset["elastic_shaking_force"]
        of_elastic = np.linalg.norm(
            reading.values_of(running, "state", "elastic_angle", "component"), axis=-1
        )
        sizes += [
            replace(one, name=f"{one.name}, elastic links", look=one.look | _ELASTIC)
            for one in series(turned, of_elastic, states)
        ]
    panes = [Pane("Shaking force", sizes, reading.FORCE_UNITS, spans=(ZERO,))]
    for name, what in (
        ("shaking_moment", f"Shaking moment about\n{moment_point(dataset)}"),
        ("driving_torque", "Driving torque"),
    ):
        values = reading.values_of(dataset[name], "state", "crank_angle")
        curves = series(angles, values, states)
        panes.append(Pane(what, curves, reading.TORQUE_UNITS, spans=(ZERO,)))
    title = f"Balance at {reading.drive_text(dataset)}"
    return over_angles(angles, panes, dataset, title)
