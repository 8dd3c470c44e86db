"""What a mechanism exerts on its frame: shaking force and moment, and their harmonics."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import MultipleLocator

from flexmech.arrays import FloatArray
from flexmech.plots import angle_panels, motion, reading, scales, style
from flexmech.plots.kinematics import MAGNITUDE
from flexmech.plots.layout import AxesLike, grid, sheet
from flexmech.plots.response import RIGID, draw_engines, engine_lines

# Of two panels above each other, and of two beside each other, in inches.
_STACKED, _BESIDE = 3.9, 2.3
# Of all bars of an order together, in orders.
_BARS = 0.8
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
    over, (dataset, angles) = dataset, motion.positions(dataset)
    components = reading.names_of(dataset, "component")
    with sheet(grid(2, 1, _STACKED, sharex=True), ax=ax) as drawn:
        handles = style.series_handles(f"along {name}" for name in components)
        handles.append(style.line_handle("magnitude", **MAGNITUDE))
        title = f"Shaking force and moment {reading.conditions(dataset)}"
        drawn.header(handles, title, of=dataset)
        of_force, of_moment = drawn.panels
        force = reading.values_of(dataset["shaking_force"], "crank_angle", "component")
        factor, unit = reading.fitting_unit(force, reading.FORCE_UNITS)
        scales.zero_line(of_force)
        of_force.plot(angles, factor * np.linalg.norm(force, axis=-1), **MAGNITUDE, zorder=1.5)
        for number in range(len(components)):
            angle_panels.draw_line(of_force, angles, factor * force[:, number], number)
        of_force.set_ylabel(f"Force ({unit})")
        moment = dataset["shaking_moment"].values
        factor, unit = reading.fitting_unit(moment, reading.TORQUE_UNITS)
        scales.zero_line(of_moment)
        angle_panels.draw_line(of_moment, angles, factor * moment, 0)
        of_moment.set_ylabel(f"Moment about\n{moment_point(dataset)} ({unit})")
        for axes in drawn.panels:
            scales.plain_numbers(axes)
        motion.label_positions(drawn, over)
    return drawn.figure


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
    names = [("shaking_force", one) for one in reading.names_of(dataset, "component")]
    with sheet(scales.time_layout(len(names) + 1), ax=ax) as drawn:
        handles = [*engine_lines(dataset), style.line_handle("rigid links", **RIGID)]
        title = f"Shaking force and moment\n{reading.run_title(dataset)}"
        drawn.header(handles, title, of=dataset)
        scales.label_times(drawn, dataset)
        for axes, (name, component) in zip(drawn.panels, names, strict=False):
            one = dataset.sel(component=component)
            forces = one[name], one[f"rigid_{name}"]
            _draw_history(axes, *forces, reading.FORCE_UNITS, f"Force along {component}")
        what = f"Moment about\n{moment_point(dataset)}"
        moments = dataset["shaking_moment"], dataset["rigid_shaking_moment"]
        _draw_history(drawn.panels[-1], *moments, reading.TORQUE_UNITS, what)
    return drawn.figure


def _draw_history(
    axes: Axes, elastic: xr.DataArray, rigid: xr.DataArray, units: reading.Units, what: str
) -> None:
    factor = draw_engines(axes, elastic, units, what)
    axes.plot(rigid["time"].values, factor * rigid.values, **RIGID, zorder=3)


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
