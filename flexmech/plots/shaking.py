"""Forces of a mechanism on its frame: shaking force, moment, harmonics, and their balance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexmech.plots import kinematics, reading, style
from flexmech.plots.drawing import drawing, figure
from flexmech.plots.drawn_linkage.sketch import LARGEST_MARK, SMALL, LinkageSketch
from flexmech.plots.drawn_linkage.symbols import drawn_posture
from flexmech.plots.kinematics import MAGNITUDE
from flexmech.plots.layout import AxesLike, grid
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
# Room around the linkage for counterweights and their masses, over its extent.
_MARGIN = 0.15


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


def plot_balance(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the counterweights on the linkage; shaking force, shaking moment and driving torque.

    Paler lines are the force with elastic links. A counterweight's area is as its mass.

    Parameters
    ----------
    dataset : Dataset
        With ``shaking_force`` (state, crank_angle, component) in N, ``shaking_moment`` and
        ``driving_torque`` (state, crank_angle) in N m, ``moment_point`` (component) in m; of
        counterweights ``counterweight_mass`` in kg, ``counterweight_place`` in m and
        ``counterweight_about``; where there are elastic links ``elastic_shaking_force``
        (state, elastic_angle, component). The attributes ``crank_speed``, ``mechanism`` and
        ``drawing``, which is of the linkage as given.
    ax : sequence of Axes, optional
        Four of the user's. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    with drawing(balance_picture(dataset), ax=ax) as drawn:
        _draw_counterweights(drawn.panels[0], dataset)
    return drawn.figure


def balance_picture(dataset: xr.Dataset) -> Picture:
    """Room for the linkage, and shaking force, shaking moment and driving torque.

    Parameters
    ----------
    dataset : Dataset
        As of :func:`plot_balance`.

    Returns
    -------
    Picture
    """
    panes = Pane("", [], title="Counterweights", apart="none"), *_balanced(dataset)
    title, layout = f"Balance at {reading.drive_text(dataset)}", grid(2, 2, _HEIGHT)
    angles = reading.degrees(dataset["crank_angle"])
    return over_angles(angles, panes, dataset, title, layout=layout)


def _draw_counterweights(axes: Axes, dataset: xr.Dataset) -> None:
    """The linkage as given, and the counterweights of the balanced state with their masses."""
    found = drawn_posture(dataset)
    if found is None:
        return
    sketch = LinkageSketch(*found[:2], mark_size=SMALL)
    at = {joint["name"]: joint["at"] for joint in sketch.parts.joints}
    weights = dataset.isel(counterweight=np.flatnonzero(dataset["counterweight_mass"].values))
    arms = []
    for about, place in zip(
        weights["counterweight_about"].values.tolist(),
        reading.values_of(weights["counterweight_place"], "counterweight", "component"),
        strict=True,
    ):
        link = int(at[about][0])
        centre = sketch.links[link, 0] + sketch.turned(link) @ place
        arms.append(np.array([sketch.place(at[about]), centre]))
    axes.set_axis_off()
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(_MARGIN)
    sketch.draw(axes, color=style.MID_GREY, lw=1.4)
    color, masses = style.series_style(1).color, weights["counterweight_mass"].values
    for arm, mass in zip(arms, masses.tolist(), strict=True):
        size = float(np.sqrt(LARGEST_MARK * mass / masses.max()))
        axes.plot(*arm.T, color=color, lw=1.4, zorder=3)
        axes.plot(*arm[1], "o", color=color, ms=size, zorder=4)
        # Supports are below.
        look: style.Look = {"xytext": (0, size / 2 + 1), "ha": "center", "va": "bottom"}
        axes.annotate(f"{1e3 * mass:.4g} g", arm[1], textcoords="offset points", **look)


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
