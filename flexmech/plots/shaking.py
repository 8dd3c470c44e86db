"""Forces of a mechanism on its frame: shaking force, moment, harmonics, and their balance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr

from flexmech.arrays import SAME_PLACE
from flexmech.plots import kinematics, reading, style
from flexmech.plots.drawing import figure
from flexmech.plots.kinematics import MAGNITUDE
from flexmech.plots.layout import grid
from flexmech.plots.picture import ZERO, Curve, Pane, Picture, bars, over_angles, series
from flexmech.plots.response import elastic_and_rigid, over_time

# Room of an axis over the highest bar.
ROOM = 1.05
# Heights of two panels above each other, and of two beside each other, in inches.
_STACKED, _BESIDE = 3.9, 2.3
# Height of two rows of two panels in inches: four of them fit a page in one column.
_HEIGHT = 4.0
_ELASTIC: style.Look = {"alpha": 0.45, "lw": 0.9, "zorder": 1.5}
_MM = 1e3


@figure
def plot_shaking_force(dataset: xr.Dataset) -> Picture:
    """Draw shaking force and shaking moment of the rigid linkage against the crank angle.

    Parameters
    ----------
    dataset : Dataset
        With ``shaking_force`` (crank_angle, component) in N, ``shaking_moment`` (crank_angle) in
        N m and ``moment_point`` (component) in m; the attributes ``crank_speed`` and
        ``mechanism``.
    ax : sequence of Axes, optional
        Two of the user's. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    over, (dataset, angles) = dataset, kinematics.positions(dataset)
    force = reading.values_of(dataset["shaking_force"], "component", "crank_angle")
    names = [f"along {name}" for name in reading.names_of(dataset, "component")]
    curves = series(angles, force, names)
    curves.append(Curve(angles, np.linalg.norm(force, axis=0), MAGNITUDE, "magnitude"))
    about = f"Moment about\n{moment_point(dataset)}"
    moment = Curve(angles, dataset["shaking_moment"].values, style.series_line(0, angles))
    panes = (
        Pane("Force", curves, reading.FORCE_UNITS, spans=(ZERO,)),
        Pane(about, (moment,), reading.TORQUE_UNITS, spans=(ZERO,)),
    )
    title = f"Shaking force and moment {reading.conditions(over)}"
    layout = grid(2, 1, _STACKED, sharex=True)
    return kinematics.over_positions(over, panes, title, layout=layout)


@figure
def plot_running_shaking_force(dataset: xr.Dataset) -> Picture:
    """Draw shaking force and moment of the running mechanism against time.

    The curves are those of each engine, and of rigid links (dark grey). A periodic motion is drawn
    over one turn.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``Response`` result; N, N m, s and rad.
    ax : Axes or sequence of Axes, optional
        The user's, one a panel. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    dataset, panes = reading.a_turn(dataset), []
    for one in reading.names_of(dataset, "component"):
        along = dataset.sel(component=one)
        forces = elastic_and_rigid(dataset, along["shaking_force"], along["rigid_shaking_force"])
        panes.append(Pane(f"Force along {one}", forces, reading.FORCE_UNITS, spans=(ZERO,)))
    moments = dataset["shaking_moment"], dataset["rigid_shaking_moment"]
    about, curves = moment_point(dataset), elastic_and_rigid(dataset, *moments)
    panes.append(Pane(f"Moment about\n{about}", curves, reading.TORQUE_UNITS, spans=(ZERO,)))
    title = f"Shaking force and moment\n{reading.run_title(dataset)}"
    return over_time(dataset, panes, title)


@figure
def plot_shaking_orders(dataset: xr.Dataset) -> Picture:
    """Draw the harmonics of shaking force and moment by the order of the crank angle.

    Parameters
    ----------
    dataset : Dataset
        With ``shaking_force_order`` (order) in N, the greatest size of an order, and
        ``shaking_moment_amplitude`` (order) in N m, and over ``engine`` where engines have run; of
        these those of rigid links too, with names that begin with ``rigid_``.
    ax : sequence of Axes, optional
        Two of the user's. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    of_engines = "engine" in dataset["shaking_force_order"].dims
    engines = dataset.sizes["engine"] if of_engines else 0
    names = [reading.engine_label(dataset, number) for number in range(engines)]
    looks: list[style.Look] = [{"color": style.series_style(n).color} for n in range(engines or 1)]
    if engines:
        names.append("rigid links")
        looks.append({"color": style.MID_GREY})
    orders, panes = dataset["order"].values.astype(float), []
    for variable, units, what in (
        ("shaking_force_order", reading.FORCE_UNITS, "Force"),
        ("shaking_moment_amplitude", reading.TORQUE_UNITS, "Moment"),
    ):
        rows = list(np.atleast_2d(dataset[variable].transpose(..., "order").values))
        if engines:
            rows.append(dataset[f"rigid_{variable}"].values)
        panes.append(
            Pane(
                what,
                bars(orders, rows, looks, names or [""]),
                units,
                limits=(0.0, ROOM * float(np.max(rows))),
                x_ticks=orders,
                along="Order of the crank angle",
            )
        )
    title = f"Harmonics of shaking force and moment at {reading.speed_text(dataset)}"
    return Picture(panes, "", dataset, title, layout=grid(1, 2, _BESIDE))


def moment_point(dataset: xr.Dataset) -> str:
    """The point about which moments are taken, with its coordinates in mm."""
    x, y = (f"{_MM * place + 0.0:.4g}" for place in dataset["moment_point"].values.tolist())
    return f"({x}, {y}) mm"


@figure
def plot_balance(dataset: xr.Dataset) -> Picture:
    """Draw the shaking force's end point, its size, the shaking moment and the driving torque.

    Paler lines are the size with elastic links.

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
    panes = _path_of_force(dataset), *_balanced(dataset)
    title, layout = f"Balance at {reading.drive_text(dataset)}", grid(2, 2, _HEIGHT)
    angles = reading.degrees(dataset["crank_angle"])
    return over_angles(angles, panes, dataset, title, layout=layout)


def _path_of_force(dataset: xr.Dataset) -> Pane:
    """The path of the force's end point, which is not over the crank angle."""
    force = reading.values_of(dataset["shaking_force"], "state", "crank_angle", "component")
    factor, unit = reading.fitting_unit(force, reading.FORCE_UNITS)
    curves = [
        Curve(path[:, 0], path[:, 1], style.series_line(number))
        for number, path in enumerate(factor * force)
    ]
    if np.abs(force[-1]).max() < SAME_PLACE * np.abs(force).max():
        # A balanced force is a point.
        dot: style.Look = {"ls": "", "marker": "o", "ms": 3.0}
        dot["color"] = style.series_style(len(force) - 1).color
        curves.append(Curve(np.zeros(1), np.zeros(1), dot))
    spans = ZERO, replace(ZERO, upright=True)
    along = f"Shaking force along x ({unit})"
    return Pane(f"Along y ({unit})", curves, spans=spans, along=along, apart="plane")


def _balanced(dataset: xr.Dataset) -> list[Pane]:
    """Size of the shaking force, shaking moment and driving torque over the crank angle."""
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
    return panes
