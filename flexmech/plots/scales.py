"""Scales of axes: crank angles, times and crank speeds along x, and numbers along y."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib import ticker
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.plots.layout import Layout, Sheet, grid
from flexmech.plots.reading import speed_unit, speeds_of
from flexmech.plots.style import LIGHT_GREY, few_points, is_narrow
from flexmech.units import from_si

DEGREE_STEPS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 60.0, 90.0, 180.0, 360.0)
"""Distances of ticks at round angles."""

FREQUENCY_BAND = 4e-3
"""Narrowest axis of frequencies as a part of them, four times the error by the mesh that is
allowed: below it one would look at that."""

# In inches: narrower panels have ticks every 90 deg, whose numbers would touch at 60.
WIDE = 4.0

# Half the height of a y axis over the span of the values on it: some 7 % of the panel are free
# below them, and as much above.
HALF_AXIS = 0.58

# Heights of panels over time in inches: four of them and their axes fit half a page, seven a page.
# The last height is that in two columns, whose last row may stand between those above, with numbers
# on either side.
TIME_PANEL_HEIGHT, MOST_OF_A_PAGE, TIME_ROW_HEIGHT = 1.11, 7, 1.25
# What the axes of time and of crank angle take, in inches: letters of their numbers and words.
TIME_AXES_HEIGHT = 0.85

# Up to this many turns the angle is read in degrees, beyond it turns are counted: two turns have
# ticks every 90 deg, and round-off does not make them more.
MOST_TURNS_IN_DEGREES = 2.05
TURN_STEPS = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
# Parts of the axis between ticks, at most: numbers of degrees are longer than those of turns.
MOST_INTERVALS, MOST_TURNS = 8, 12


def crank_angle_axis(axes: Axes, angles: FloatArray, *, narrow: bool = False) -> None:
    """Scale the x axis to crank angles given in degrees, with ticks at round angles.

    Parameters
    ----------
    axes : Axes
        Its x axis is set, without a label.
    angles : ndarray, shape (n,)
        Crank angles in degrees, ascending.
    narrow : bool
        Whether the panel has room for few ticks only (90 deg on a full turn, else 60).
    """
    first, last = float(angles[0]), float(angles[-1])
    span = last - first
    if span == 0:
        axes.set_xlim(first - 1.0, last + 1.0)
        axes.set_xticks([first])
    else:
        # The points of a coarse map are marked, and a mark must not hang over the edge.
        room = 0.03 * span if few_points(angles) else 0.0
        axes.set_xlim(first - room, last + room)
        most = 4 if narrow else 6
        if angles.size <= most + 1 and np.diff(angles).min() >= span / (most + 1):
            axes.set_xticks(angles)
        else:
            axes.xaxis.set_major_locator(
                ticker.MultipleLocator(round_step(span, most, DEGREE_STEPS))
            )
    axes.xaxis.set_major_formatter(ticker.ScalarFormatter(useOffset=False))


def label_angles(drawn: Sheet, angles: FloatArray) -> None:
    """Scale and label the axes along x of panels over the crank angle.

    Parameters
    ----------
    drawn : Sheet
    angles : ndarray
        Crank angles in degrees, ascending.
    """
    width = drawn.figure.get_figwidth()
    for axes in drawn.panels:
        crank_angle_axis(axes, angles, narrow=axes.get_position().width * width < WIDE)
    drawn.label_x("Crank angle (deg)")


def round_step(span: float, most: int, steps: Sequence[float]) -> float:
    """Smallest round step, or multiple of the last one, that cuts a span into so many parts.

    Parameters
    ----------
    span : float
        In the unit of the steps.
    most : int
        Greatest number of parts.
    steps : sequence of float
        Round steps, increasing.

    Returns
    -------
    float
    """
    parts = most * (1 + 1e-6)
    fitting = (step for step in steps if span <= step * parts)
    return next(fitting, steps[-1] * float(np.ceil(span / (steps[-1] * parts))))


def plain_numbers(axes: Axes) -> None:
    """Write the y ticks in full: no offset and no power of ten apart from the axis."""
    formatter = ticker.ScalarFormatter(useOffset=False)
    formatter.set_scientific(False)
    axes.yaxis.set_major_formatter(formatter)
    axes.yaxis.set_major_locator(
        ticker.MaxNLocator(nbins=5, steps=[1, 2, 2.5, 5, 10], min_n_ticks=3)
    )


def ticks_within(low: float, high: float, most: int) -> FloatArray:
    """Round numbers between two values.

    Parameters
    ----------
    low, high : float
    most : int
        Greatest number of intervals.

    Returns
    -------
    ndarray
    """
    locator = ticker.MaxNLocator(most, steps=[1, 2, 2.5, 5, 10])
    places = np.asarray(locator.tick_values(low, high))
    return places[(places >= low) & (places <= high)]


def limits_around(
    values: ArrayLike, *, least: float = 1e-9, least_part: float = 0.0
) -> tuple[float, float]:
    """Limits of a y axis around values, never so near that one sees round-off.

    Parameters
    ----------
    values : array_like
        All that the axis shall hold; not a number is left out.
    least : float
        Least span of the axis.
    least_part : float
        Least span as a part of the mean of the greatest and the least value.

    Returns
    -------
    float, float
    """
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    middle = (low + high) / 2
    half = HALF_AXIS * max(high - low, least_part * abs(middle), least)
    return middle - half, middle + half


def log_scale(axes: Axes, low: float, high: float, *, plain: bool = False) -> None:
    """Make the y axis logarithmic, ticked at every decade or every few.

    Parameters
    ----------
    axes : Axes
    low, high : float
        Limits of the axis.
    plain : bool
        Whether numbers are written in full, with those of 1, 2 and 5 between powers of ten.
    """
    axes.set_yscale("log")
    axes.set_ylim(low, high)
    axes.yaxis.set_minor_formatter(ticker.NullFormatter())
    steps = (1.0, 2.0, 5.0) if plain else (1.0,)
    axes.yaxis.set_major_locator(ticker.LogLocator(subs=steps, numticks=9 if plain else 7))
    if plain:
        axes.yaxis.set_major_formatter(ticker.FuncFormatter(lambda value, _: f"{value:g}"))


def log_limits(values: ArrayLike, decades: float) -> tuple[float, float]:
    """Limits of a logarithmic axis for amplitudes, at most so many decades below the greatest.

    Parameters
    ----------
    values : array_like
        Not a number is left out.
    decades : float

    Returns
    -------
    float, float
        The least value or the last decade that is drawn, and twice the greatest value.
    """
    highest = float(np.nanmax(values)) or 1.0
    return max(float(np.nanmin(values)), highest * 10.0**-decades), 2.0 * highest


def phase_of(values: ComplexArray) -> FloatArray:
    """Phases in degrees from -180 to 180, broken where they leave one end for the other."""
    phase = np.asarray(np.degrees(np.angle(values)), dtype=float)
    phase[1:][np.abs(np.diff(phase)) > 180.0] = np.nan
    return phase


def speed_limits(dataset: xr.Dataset, room: float = 0.0) -> tuple[float, float]:
    """Limits of an axis of crank speed in the user's unit.

    Parameters
    ----------
    dataset : Dataset
    room : float
        Beyond either end, as a part of the range.

    Returns
    -------
    float, float
    """
    speeds = speeds_of(dataset)
    low, high = float(speeds.min()), float(speeds.max())
    beyond = room * (high - low) if high > low else 1.0
    return low - beyond, high + beyond


def second_speed_axis(axes: Axes, dataset: xr.Dataset) -> None:
    """Crank speed in turns a minute above a panel, or in rad/s where turns a minute are below."""
    unit = speed_unit(dataset)
    factor = from_si(1.0, unit)
    other, ratio = ("rad/s", 1.0 / factor) if unit == "rpm" else ("rpm", 30 / np.pi / factor)
    there_and_back = (lambda speed: ratio * speed, lambda speed: speed / ratio)
    upper = axes.secondary_xaxis("top", functions=there_and_back)
    upper.set_xlabel(f"Crank speed ({other})")


def time_layout(count: int) -> Layout:
    """A stack of panels over time, or two where a page does not hold it, with axes at both ends."""
    columns = _time_columns(count)
    rows = -(-count // columns)
    panel = TIME_PANEL_HEIGHT if columns == 1 else TIME_ROW_HEIGHT
    height = max(rows * panel, 2.2) + TIME_AXES_HEIGHT
    return grid(rows, columns, height, count=count, sharex=True)


def _time_columns(count: int) -> int:
    return 2 if count > MOST_OF_A_PAGE and not is_narrow() else 1


def label_times(drawn: Sheet, dataset: xr.Dataset) -> None:
    """Scale and label panels over the whole time of a response, with the crank angle on top.

    Parameters
    ----------
    drawn : Sheet
    dataset : Dataset
        With ``time`` and ``crank_angle``.
    """
    time = dataset["time"].values.astype(float)
    for axes in drawn.panels:
        axes.set_xlim(float(time[0]), float(time[-1]))
    columns = _time_columns(len(drawn.panels)) if drawn.is_new else 1
    turns = [angle_axis(axes, dataset) for axes in drawn.panels[:columns]]
    for axes in drawn.panels:
        for place in turns[0]:
            axes.axvline(place, color=LIGHT_GREY, lw=0.6, zorder=0)
    drawn.label_x("Time (s)")


def angle_axis(axes: Axes, dataset: xr.Dataset) -> list[float]:
    """Put an axis of crank angle on top of a panel over time, within the panel's limits.

    Ticks stand at the times at which the crank passes round angles, so that the axis is
    right for a crank that runs up to its speed and for one that turns backwards. Under a law of
    motion a crank stands still and may turn back: there is no axis then, and ``plot_law`` shows
    the angle.

    Parameters
    ----------
    axes : Axes
        Its limits along time are set.
    dataset : Dataset
        With ``time`` and ``crank_angle``.

    Returns
    -------
    list of float
        Times within the limits at which a turn is completed.
    """
    if "drive" in dataset.attrs:
        return []
    time = dataset["time"].values.astype(float)
    angle = dataset["crank_angle"].values.astype(float)
    low, high = (float(np.interp(limit, time, angle)) for limit in axes.get_xlim())
    whole = abs(high - low) > MOST_TURNS_IN_DEGREES * 2 * np.pi
    unit = 2 * np.pi if whole else np.pi / 180
    span = abs(high - low) / unit
    most, steps = (MOST_TURNS, TURN_STEPS) if whole else (MOST_INTERVALS, DEGREE_STEPS)
    ticks = _multiples(low / unit, high / unit, round_step(span, most, steps))
    top = axes.secondary_xaxis("top")
    labels = [f"{tick:g}".replace("-", "\N{MINUS SIGN}") for tick in ticks]
    top.set_xticks(_times(ticks * unit, time, angle).tolist(), labels)
    top.set_xlabel("Crank angle (revolutions)" if whole else "Crank angle (deg)")
    turns = _multiples(low / (2 * np.pi), high / (2 * np.pi), 1.0)
    return [float(place) for place in _times(turns * 2 * np.pi, time, angle)]


def _multiples(first: float, last: float, step: float) -> FloatArray:
    """Multiples of a step between two values in either order."""
    low, high = min(first, last), max(first, last)
    room = 1e-6 * max(high - low, step)
    count = np.arange(np.ceil((low - room) / step), np.floor((high + room) / step) + 1)
    # Adding zero makes a zero of a negative one, which would be written with its sign.
    return np.asarray(count * step + 0.0, dtype=float)


def _times(wanted: FloatArray, time: FloatArray, angle: FloatArray) -> FloatArray:
    """Times at which a crank that never turns back has turned by certain angles."""
    sense = 1.0 if angle[-1] >= angle[0] else -1.0
    return np.asarray(np.interp(sense * wanted, sense * angle, time), dtype=float)
