"""Ranges of speed that a Campbell diagram has results for: no other speed is called clear."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from flexmech.analyses.remarks import speed_text
from flexmech.arrays import unbroken_runs
from flexmech.plots.reading import speed_unit

# From one speed to another in rad/s.
Range = tuple[float, float]


def computed_ranges(dataset: xr.Dataset) -> list[Range]:
    """Ranges of speed in which the first engine has results, ascending.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of the diagram.

    Returns
    -------
    list of tuple of float
        In rad/s; a single speed between gaps is a range without width.
    """
    speeds = dataset["band_speed"].values.tolist()
    known = np.isfinite(dataset["band_frequency"].values[0]).all(axis=(1, 2))
    return [(speeds[run[0]], speeds[run[-1]]) for run in unbroken_runs(known)]


def is_computed(dataset: xr.Dataset, speed: float) -> bool:
    """Whether the first engine has results at a speed in rad/s.

    What went through another unit may be off by its last digits.
    """
    slack = 1e-9 * float(np.abs(dataset["crank_speed"].values).max())
    return any(low - slack <= speed <= high + slack for low, high in computed_ranges(dataset))


def not_computed(dataset: xr.Dataset) -> str:
    """The ranges of the diagram without results, in words; empty where there are none.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of the diagram.

    Returns
    -------
    str
        Such as ``"from 139.5 to 900 rad/s nothing was computed"``.
    """
    low, high = np.sort(dataset["crank_speed"].values[[0, -1]]).tolist()
    unit = speed_unit(dataset)
    between = without([(low, high)], computed_ranges(dataset))
    listed = [
        f"from {speed_text(first, unit)} to {speed_text(last, unit)}" for first, last in between
    ]
    return f"{' and '.join(listed)} {unit} nothing was computed" if listed else ""


def without(ranges: Sequence[Range], left_out: Sequence[Range]) -> list[Range]:
    """What is left of ranges when others are taken out, ascending.

    Parameters
    ----------
    ranges, left_out : sequence of tuple of float

    Returns
    -------
    list of tuple of float

    Examples
    --------
    >>> without([(0.0, 5.0), (7.0, 9.0)], [(1.0, 2.0), (4.0, 8.0)])
    [(0.0, 1.0), (2.0, 4.0), (8.0, 9.0)]
    """
    rest = sorted(ranges)
    for start, end in left_out:
        rest = [
            part
            for low, high in rest
            for part in ((low, min(high, start)), (max(low, end), high))
            if part[0] < part[1]
        ]
    return rest
