"""What a mechanism exerts on its frame: shaking force, moment and harmonics, and its balance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import MultipleLocator

from flexmech.arrays import SAME_PLACE, FloatArray
from flexmech.plots import kinematics, reading, scales, style
from flexmech.plots.drawing import draw
from flexmech.plots.kinematics import MAGNITUDE
from flexmech.plots.layout import AxesLike, Sheet, grid, sheet
from flexmech.plots.picture import ZERO, Curve, Pane, Picture, over_angles, series
from flexmech.plots.response import elastic_and_rigid, over_time

# Of two panels above each other, and of two beside each other, in inches.
_STACKED, _BESIDE = 3.9, 2.3
# Of all bars of an order together, in orders.
_BARS = 0.8
# Height of two rows of two panels in inches: four of them fit a page in one column.
_HEIGHT = 4.0
_ELASTIC: style.Look = {"alpha": 0.45, "lw": 0.9, "zorder": 1.5}
_SHADE = "0.45"
_MM = 1e3


def plot_shaking_force(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
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
    return draw(shaking_picture(dataset), grid(2, 1, _STACKED, sharex=True), ax=ax)


def shaking_picture(dataset: xr.Dataset) -> Picture:
    """Shaking force and moment of the rigid linkage, as of plot_shaking_force."""
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
    return kinematics.over_positions(over, panes, title)


def plot_running_shaking_force(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw shaking force and moment of the running mechanism against time.

    Of each engine, and of rigid links (dark grey).

    Parameters
    ----------
    dataset : Dataset
        Of a ``Response`` result; N, N m, s and rad.
    ax : Axes or sequence of Axes, optional
        The user's, one a panel. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    panes = []
    for one in reading.names_of(dataset, "component"):
        along = dataset.sel(component=one)
        forces = elastic_and_rigid(dataset, along["shaking_force"], along["rigid_shaking_force"])
        panes.append(Pane(f"Force along {one}", forces, reading.FORCE_UNITS, spans=(ZERO,)))
    moments = dataset["shaking_moment"], dataset["rigid_shaking_moment"]
    about, curves = moment_point(dataset), elastic_and_rigid(dataset, *moments)
    panes.append(Pane(f"Moment about\n{about}", curves, reading.TORQUE_UNITS, spans=(ZERO,)))
    title = f"Shaking force and moment\n{reading.run_title(dataset)}"
    return draw(over_time(dataset, panes, title), scales.time_layout(len(panes)), ax=ax)


def plot_shaking_orders(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
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
    engines = dataset.sizes["engine"] if "engine" in dataset["shaking_force_order"].dims else 0
    labels = [reading.engine_label(dataset, number) for number in range(engines)]
    looks: list[style.Look] = [{"color": style.series_style(n).color} for n in range(engines or 1)]
    if engines:
        labels.append("rigid links")
        looks.append({"color": _SHADE})
    with sheet(grid(1, 2, _BESIDE), ax=ax) as drawn:
        speed = reading.speed_text(dataset)
        title = f"Harmonics of shaking force and moment at {speed}"
        handles: list[Artist] = [
            Patch(label=label, **look) for label, look in zip(labels, looks, strict=False)
        ]
        drawn.header(handles, title, of=dataset)
        shown = (
            ("shaking_force_order", reading.FORCE_UNITS, "Force"),
            ("shaking_moment_amplitude", reading.TORQUE_UNITS, "Moment"),
        )
        for axes, (name, units, what) in zip(drawn.panels, shown, strict=True):
            rows = list(np.atleast_2d(dataset[name].transpose(..., "order").values))
            if engines:
                rows.append(dataset[f"rigid_{name}"].values)
            draw_orders(axes, dataset["order"].values, rows, looks, units, what)
    return drawn.figure


def draw_orders(
    axes: Axes,
    orders: FloatArray,
    rows: Sequence[FloatArray],
    looks: Sequence[style.Look],
    units: reading.Units,
    what: str,
) -> None:
    """Draw bars of several series beside each other at each order.

    Parameters
    ----------
    axes : Axes
    orders : ndarray, shape (n,)
    rows : sequence of ndarray, shape (n,)
        Of each series, in the SI unit.
    looks : sequence of dict
        Of each series, for ``Axes.bar``.
    units : tuple of (float, str)
        Factors and names of units that the axis may have.
    what : str
        Label of the axis, without the unit.
    """
    factor, unit = reading.fitting_unit(np.array(rows), units)
    width = _BARS / len(rows)
    for number, (row, look) in enumerate(zip(rows, looks, strict=True)):
        places = orders - _BARS / 2 + (number + 0.5) * width
        axes.bar(places, factor * row, width, **look)
    scales.plain_numbers(axes)
    axes.xaxis.set_major_locator(MultipleLocator(1.0))
    axes.set_xlabel("Order of the crank angle")
    axes.set_ylabel(f"{what} ({unit})")


def moment_point(dataset: xr.Dataset) -> str:
    """The point about which moments are taken, with its coordinates in mm."""
    x, y = (f"{_MM * place + 0.0:.4g}" for place in dataset["moment_point"].values.tolist())
    return f"({x}, {y}) mm"


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
