"""Shaking force, shaking moment and driving torque of a linkage before and after its balance."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from flexmech.arrays import SAME_PLACE
from flexmech.plots import angle_panels, reading, scales, style
from flexmech.plots.layout import AxesLike, grid, sheet
from flexmech.plots.shaking import moment_point

# Of two rows of two panels in inches: four of them fit a page in one column.
_HEIGHT = 4.0
_ELASTIC: style.Look = {"alpha": 0.45, "lw": 0.9}


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
    angles, states = (
        reading.degrees(dataset["crank_angle"]),
        style.distinct_names(reading.names_of(dataset, "state")),
    )
    elastic = "elastic_shaking_force" in dataset
    with sheet(grid(2, 2, _HEIGHT), ax=ax) as drawn:
        handles = style.series_handles(states)
        if elastic:
            handles += [
                style.series_handle(number, f"{state}, elastic links", **_ELASTIC)
                for number, state in enumerate(states)
            ]
        drawn.header(handles, f"Balance at {reading.drive_text(dataset)}", of=dataset)
        plane, size, moment, torque = drawn.panels
        force = reading.values_of(dataset["shaking_force"], "state", "crank_angle", "component")
        factor, unit = reading.fitting_unit(force, reading.FORCE_UNITS)
        plane.set_aspect("equal", adjustable="datalim")
        plane.axhline(0.0, color=style.LIGHT_GREY, lw=0.6, zorder=0)
        plane.axvline(0.0, color=style.LIGHT_GREY, lw=0.6, zorder=0)
        scales.zero_line(size)
        for number, path in enumerate(factor * force):
            plane.plot(path[:, 0], path[:, 1], **style.series_line(number))
            angle_panels.draw_line(size, angles, np.linalg.norm(path, axis=-1), number)
        if np.abs(force[-1]).max() < SAME_PLACE * np.abs(force).max():
            # A balanced force is a point.
            plane.plot(0.0, 0.0, "o", ms=3.0, color=style.series_style(1).color)
        plane.set(xlabel=f"Shaking force along x ({unit})", ylabel=f"Along y ({unit})")
        size.set_ylabel(f"Shaking force ({unit})")
        if elastic:
            running = reading.values_of(
                dataset["elastic_shaking_force"], "state", "elastic_angle", "component"
            )
            turned = np.degrees(dataset["elastic_angle"].values)
            for number, path in enumerate(factor * running):
                look = style.series_line(number) | _ELASTIC
                size.plot(turned, np.linalg.norm(path, axis=-1), **look, zorder=1.5)
        for axes, name, what in (
            (moment, "shaking_moment", f"Shaking moment about\n{moment_point(dataset)}"),
            (torque, "driving_torque", "Driving torque"),
        ):
            values = reading.values_of(dataset[name], "state", "crank_angle")
            factor, unit = reading.fitting_unit(values, reading.TORQUE_UNITS)
            scales.zero_line(axes)
            for number, line in enumerate(factor * values):
                angle_panels.draw_line(axes, angles, line, number)
            axes.set_ylabel(f"{what} ({unit})")
        for axes in (size, moment, torque):
            scales.crank_angle_axis(axes, angles, narrow=True)
            axes.set_xlabel("Crank angle (deg)")
        for axes in drawn.panels:
            scales.plain_numbers(axes)
    return drawn.figure
