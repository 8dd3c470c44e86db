"""What the running linkage does against time: deflections, strains, torque and forces."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexmech.arrays import FloatArray
from flexmech.plots import reading, scales
from flexmech.plots.layout import AxesLike, sheet
from flexmech.plots.style import Look, line_handle, series_handles, series_line

ROTATION_UNITS: reading.Units = ((np.degrees(1.0), "deg"),)
SPEED_UNITS: reading.Units = ((1.0, "rad/s"), (1e3, "mrad/s"), (1e6, "µrad/s"))

# Thinner than the engines' lines, which it covers where the links are as good as rigid.
RIGID: Look = {"color": "0.25", "lw": 0.6}

# Width in points of a line with at most so many turning points in a panel of 450 points' width, so
# that waves stay apart.
LINE_WIDTHS = ((80, 1.1), (350, 0.7), (np.inf, 0.5))
# Opacity of a line that turns at more than a third of its samples, so that each wave has less than
# six, and at more than so many places: it is a band, through which others are seen.
VEIL = 0.6
MOST_TURNING, LEAST_VEILED = 0.33, 100


def plot_response(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the deflection of each link, and bending strains in the middle, against time.

    One panel for the deflection of each link that is not rigid: of its middle from the line
    between its pins, or of a clamped link's tip. Under them the bending strain of those links
    whose middle is watched, and the rotation and speed of a shaft that is free, against what is
    prescribed. The axis on top gives the crank angle.

    Parameters
    ----------
    dataset : Dataset
        Of a ``Response`` result; m, s and rad.
    ax : Axes or sequence of Axes, optional
        The user's, one a panel. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    links = reading.bending_links(dataset)
    strained = [name for name in links if dataset["probe"].sel(link=name) == "middle"]
    watched = [("deflection", name, reading.LENGTH_UNITS) for name in links]
    watched += [("strain", name, reading.STRAIN_UNITS) for name in strained]
    shown = [
        (
            dataset[quantity].sel(link=name),
            units,
            f"{reading.link_label(dataset, name)}\n{quantity}",
        )
        for quantity, name, units in watched
    ]
    if "shaft_rotation" in dataset:
        shown += [
            (dataset["shaft_rotation"], ROTATION_UNITS, "Shaft\nrotation"),
            (dataset["crank_speed_fluctuation"], SPEED_UNITS, "Shaft speed\nfluctuation"),
        ]
    fewer = "choose one link that is watched at its tip (links=...)"
    with sheet(scales.time_layout(len(shown)), ax=ax, fewer=fewer) as drawn:
        drawn.header(engine_lines(dataset), reading.run_title(dataset), of=dataset)
        scales.label_times(drawn, dataset)
        for axes, (quantity, units, what) in zip(drawn.panels, shown, strict=True):
            draw_engines(axes, quantity, units, what)
    return drawn.figure


def plot_forces(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the driving torque and the pin forces against time, with those of rigid links.

    Forces are those of the pins between links, or of the clamped joint where there is no
    pin, as far as the run's band lets them through: what the links vibrate along themselves
    is too fast to be told apart. Beside them those of rigid links (dark grey).

    Parameters
    ----------
    dataset : Dataset
        Of a ``Response`` result; N m, N, s and rad.
    ax : Axes or sequence of Axes, optional
        The user's, one a panel. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    torque = dataset["driving_torque"], dataset["rigid_driving_torque"]
    shown, titles = [(*torque, reading.TORQUE_UNITS, "Driving\ntorque")], [""]
    pins = dataset["joint"].values[dataset["joint_kind"].values == "pin"]
    for joint in pins if pins.size else dataset["joint"].values:
        for component in reading.names_of(dataset, "component"):
            there = dataset.sel(joint=joint, component=component)
            forces = there["joint_force"], there["rigid_joint_force"]
            shown.append((*forces, reading.FORCE_UNITS, f"Force at {joint},\n{component}"))
            titles.append(reading.joint_title(dataset, joint))
    with sheet(scales.time_layout(len(shown)), ax=ax) as drawn:
        handles = [*engine_lines(dataset), line_handle("rigid links", **RIGID)]
        band = dataset.attrs.get("force_band")
        up_to = "" if band is None else f", forces up to {band:.4g} Hz"
        drawn.header(handles, reading.run_title(dataset) + up_to, of=dataset)
        scales.label_times(drawn, dataset)
        panels = zip(drawn.panels, shown, titles, strict=True)
        for axes, (elastic, rigid, units, what), title in panels:
            axes.set_title(title)
            factor = draw_engines(axes, elastic, units, what)
            axes.plot(rigid["time"].values, factor * rigid.values, **RIGID, zorder=3)
    return drawn.figure


def engine_lines(dataset: xr.Dataset) -> list[Artist]:
    """Legend entries of engines that are all drawn as lines."""
    return series_handles(reading.engine_label(dataset, n) for n in range(dataset.sizes["engine"]))


def draw_engines(axes: Axes, quantity: xr.DataArray, units: reading.Units, what: str) -> float:
    """Draw a quantity of all engines against time, and scale the y axis to all of it.

    Lines become thinner the more vibrations stand side by side, and translucent where they
    are faster than the samples tell apart: a band through which other lines can be seen.

    Parameters
    ----------
    axes : Axes
    quantity : DataArray
        With dims engine and time, in its SI unit.
    units : tuple of (float, str)
        Factors and names of units that the axis may have.
    what : str
        Label of the axis, without the unit.

    Returns
    -------
    float
        Factor from the SI unit to that of the axis.
    """
    factor, unit = reading.fitting_unit(quantity.values, units)
    lines = factor * reading.values_of(quantity, "engine", "time")
    scales.zero_line(axes)
    for number, line in enumerate(lines):
        width, opacity = _line_look(line)
        # What lies under a line must be seen between its dashes and beside them.
        wider = 1.4 if number < len(lines) - 1 and opacity == 1.0 else 1.0
        look = series_line(number)
        axes.plot(quantity["time"].values, line, **look, lw=wider * width, alpha=opacity)
    scales.plain_numbers(axes)
    axes.set_ylabel(f"{what} ({unit})")
    return factor


def _line_look(line: FloatArray) -> tuple[float, float]:
    """Width and opacity of a line, by how often it turns."""
    turning_points = np.count_nonzero(np.diff(np.sign(np.diff(line))))
    width = next(width for most, width in LINE_WIDTHS if turning_points <= most)
    return width, VEIL if turning_points > max(MOST_TURNING * line.size, LEAST_VEILED) else 1.0
