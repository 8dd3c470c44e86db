"""What the running linkage does against time: deflections, strains, torque and forces."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import xarray as xr
from matplotlib import rcParamsDefault
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

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
# Of a line with more turning points in a panel of that width the waves run together into a blot:
# its envelope is drawn, by the least and greatest value in each of so many stretches.
MOST_TURNING_POINTS, STRETCHES = 700, 300
ENVELOPE: Look = {"alpha": 0.25, "lw": 0.0}
# Panels of forces that fit a page: with more of them magnitudes stand alone, without components.
MOST_FORCE_PANELS = 7
# Between turning points a line goes up or down by this part of its panel, less is hardly seen.
RIPPLE = 0.03
# Width of a panel over that of the figure, of one that has a row for itself.
ALONE = float(rcParamsDefault["figure.subplot.right"] - rcParamsDefault["figure.subplot.left"])
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
        handles = engine_lines(dataset)
        handles += _envelope_handles(drawn.panels[0], (quantity for quantity, *_ in shown))
        drawn.header(handles, reading.run_title(dataset), of=dataset)
        scales.label_times(drawn, dataset)
        for axes, (quantity, units, what) in zip(drawn.panels, shown, strict=True):
            draw_engines(axes, quantity, units, what)
    return drawn.figure


def plot_forces(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the driving torque and the pin forces against time, with those of rigid links.

    Forces are those of the pins between links, or of the clamped joint where there is no
    pin, as far as the run's band lets them through: what the links vibrate along themselves
    is too fast to be told apart. Of each the magnitude and both components are drawn, of more
    than two joints the magnitudes alone, so that a page holds them. Beside them those of rigid
    links (dark grey).

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
    joints = pins if pins.size else dataset["joint"].values
    components = reading.names_of(dataset, "component")
    if 1 + len(joints) * (1 + len(components)) > MOST_FORCE_PANELS:
        components = []
    for joint in joints:
        forces = [dataset[name].sel(joint=joint) for name in ("joint_force", "rigid_joint_force")]
        drawn_parts = {"magnitude": [_magnitude(force) for force in forces]}
        drawn_parts |= {one: [force.sel(component=one) for force in forces] for one in components}
        for part, (elastic, rigid) in drawn_parts.items():
            shown.append((elastic, rigid, reading.FORCE_UNITS, f"Force at {joint},\n{part}"))
            titles.append(reading.joint_title(dataset, joint) if part == "magnitude" else "")
    with sheet(scales.time_layout(len(shown)), ax=ax) as drawn:
        handles = [*engine_lines(dataset), line_handle("rigid links", **RIGID)]
        handles += _envelope_handles(drawn.panels[0], (elastic for elastic, *_ in shown))
        band = dataset.attrs.get("force_band")
        up_to = "" if band is None else f", forces up to {band:.4g} Hz"
        drawn.header(handles, reading.run_title(dataset) + up_to, of=dataset)
        scales.label_times(drawn, dataset)
        panels = zip(drawn.panels, shown, titles, strict=True)
        for axes, (elastic, rigid, units, what), title in panels:
            if title:
                axes.set_title(title)
            factor = draw_engines(axes, elastic, units, what)
            axes.plot(rigid["time"].values, factor * rigid.values, **RIGID, zorder=3)
    return drawn.figure


def _magnitude(force: xr.DataArray) -> xr.DataArray:
    """Of a force with dim component, at each sample."""
    size: xr.DataArray = xr.apply_ufunc(
        lambda parts: np.linalg.norm(parts, axis=-1), force, input_core_dims=[["component"]]
    )
    return size


def engine_lines(dataset: xr.Dataset) -> list[Artist]:
    """Legend entries of engines that are all drawn as lines."""
    return series_handles(reading.engine_label(dataset, n) for n in range(dataset.sizes["engine"]))


def draw_engines(axes: Axes, quantity: xr.DataArray, units: reading.Units, what: str) -> float:
    """Draw a quantity of all engines against time, and scale the y axis to all of it.

    Lines become thinner the more vibrations stand side by side, and translucent where they
    are faster than the samples tell apart: a band through which other lines can be seen. Of
    more vibrations than a panel can show the envelope is drawn.

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
    time, room = quantity["time"].values, _room(axes)
    for number, line in enumerate(lines):
        if _turning_points(line) > room * MOST_TURNING_POINTS:
            _draw_envelope(axes, *_envelope(time, line), number)
            continue
        width, opacity = _line_look(line, room)
        # What lies under a line must be seen between its dashes and beside them.
        wider = 1.4 if number < len(lines) - 1 and opacity == 1.0 else 1.0
        look = series_line(number)
        axes.plot(time, line, **look, lw=wider * width, alpha=opacity)
    scales.plain_numbers(axes)
    axes.set_ylabel(f"{what} ({unit})")
    return factor


def _room(axes: Axes) -> float:
    """Width of a panel over that of one that has a row for itself, at most 1."""
    return min(1.0, axes.get_position(original=True).width / ALONE)


def _turning_points(line: FloatArray) -> int:
    """How often a line turns from rising to falling or back, but for ripples."""
    turns = line[np.flatnonzero(np.diff(np.sign(np.diff(line)))) + 1]
    return int(np.count_nonzero(np.abs(np.diff(turns)) > RIPPLE * np.ptp(line)))


def _envelope(time: FloatArray, line: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Times, and the least and greatest value of a line about each of them."""
    starts = np.linspace(0, line.size, STRETCHES, endpoint=False).astype(int)
    low, high = (one.reduceat(line, starts) for one in (np.minimum, np.maximum))
    middle = (starts + np.append(starts[1:], line.size) - 1) // 2
    # From the first to the last sample.
    return np.r_[time[0], time[middle[1:-1]], time[-1]], low, high


def _draw_envelope(
    axes: Axes, time: FloatArray, low: FloatArray, high: FloatArray, number: int
) -> None:
    """Envelope of an engine: two lines, and filled between them for the first one."""
    look = series_line(number) | {"lw": LINE_WIDTHS[1][1]}
    if number == 0:
        axes.fill_between(time, low, high, color=look["color"], **ENVELOPE)
    for edge in (low, high):
        axes.plot(time, edge, **look)


def _envelope_handles(axes: Axes, quantities: Iterable[xr.DataArray]) -> list[Artist]:
    """Legend entry of envelopes, where one of the quantities with dim engine is drawn by one."""
    lines = (line for one in quantities for line in reading.values_of(one, "engine", "time"))
    most = _room(axes) * MOST_TURNING_POINTS
    if all(_turning_points(line) <= most for line in lines):
        return []
    return [Patch(color="0.35", label="envelope of the vibration", **ENVELOPE)]


def _line_look(line: FloatArray, room: float) -> tuple[float, float]:
    """Width and opacity of a line, by how often it turns and the room for it."""
    turning_points = _turning_points(line)
    width = next(width for most, width in LINE_WIDTHS if turning_points <= room * most)
    return width, VEIL if turning_points > max(MOST_TURNING * line.size, LEAST_VEILED) else 1.0
