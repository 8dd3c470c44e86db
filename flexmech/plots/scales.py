"""Scales of axes: crank angles along x, and numbers along y."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib import ticker
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from flexmech.plots.series import few_points
from flexmech.types import FloatArray

DEGREE_STEPS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 60.0, 90.0, 180.0, 360.0)
"""Distances of ticks at round angles."""

FREQUENCY_BAND = 4e-3
"""Narrowest axis of frequencies as a part of them: below it one would look at round-off."""

# Half the height of a y axis over the span of the values on it.
HALF_AXIS = 0.58


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


def scale_y(axes: Axes, values: ArrayLike, *, least: float = 1e-9, least_part: float = 0.0) -> None:
    """Fit the y axis to values, in plain numbers, and never so closely that one sees round-off.

    Parameters
    ----------
    axes : Axes
    values : array_like
        All that the axis shall hold; not a number is left out.
    least : float
        Least span of the axis.
    least_part : float
        Least span as a part of the mean of the greatest and the least value.
    """
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    middle = (low + high) / 2
    half = HALF_AXIS * max(high - low, least_part * abs(middle), least)
    axes.set_ylim(middle - half, middle + half)
    plain_numbers(axes)


def log_scale(axes: Axes, low: float, high: float) -> None:
    """Make the y axis logarithmic, ticked at every decade or every few.

    Parameters
    ----------
    axes : Axes
    low, high : float
        Limits of the axis.
    """
    axes.set_yscale("log")
    axes.set_ylim(low, high)
    axes.yaxis.set_major_locator(ticker.LogLocator(base=10, numticks=7))
    axes.yaxis.set_minor_formatter(ticker.NullFormatter())
