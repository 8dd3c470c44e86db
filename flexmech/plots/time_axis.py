"""Axes of all figures over time: panels, with the crank angle on top."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from flexmech.plots.layout import Layout, Sheet, grid
from flexmech.plots.scales import DEGREE_STEPS, round_step
from flexmech.plots.style import LIGHT_GREY
from flexmech.types import FloatArray

PANEL_HEIGHT = 1.12
# What the axes of time and of crank angle take, in inches.
AXES_HEIGHT = 0.85

# Up to this many turns the angle is read in degrees, beyond it turns are counted.
MOST_TURNS_IN_DEGREES = 2.05
TURN_STEPS = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
MOST_INTERVALS = 8
MOST_TURNS = 12


def time_layout(count: int) -> Layout:
    """A stack of panels over time, with the axes below and on top."""
    return grid(count, 1, max(count * PANEL_HEIGHT, 2.2) + AXES_HEIGHT, sharex=True)


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
    turns = angle_axis(drawn.panels[0], dataset)
    for axes in drawn.panels:
        for place in turns:
            axes.axvline(place, color=LIGHT_GREY, lw=0.6, zorder=0)
    drawn.label_x("Time (s)")


def angle_axis(axes: Axes, dataset: xr.Dataset) -> list[float]:
    """Put an axis of crank angle on top of a panel over time, within the panel's limits.

    Ticks stand at the times at which the crank passes round angles, so that the axis is
    right for a crank that runs up to its speed and for one that turns backwards.

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
