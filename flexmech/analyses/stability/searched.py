"""Which crank speeds a stability map has looked at, and which bands it may miss between them."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.analyses.remarks import speed_text
from flexmech.analyses.stability.dataset import NO, YES
from flexmech.arrays import unbroken_runs
from flexmech.plots.reading import speed_unit
from flexmech.units import from_si


def known_ranges(dataset: xr.Dataset) -> list[tuple[float, float]]:
    """Ranges of speeds at which the first engine knows whether a vibration grows.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a stability map.

    Returns
    -------
    list of tuple of float
        In rad/s, from slow to fast, as far as speeds were solved for, those between the speeds
        asked for too; parted by speeds without equilibrium.
    """
    asked, states = dataset["crank_speed"].values, dataset["unstable"].values[0]
    known = np.isin(states, (YES, NO))
    first = dataset["curve_engine"].values == dataset["engine"].values[0]
    solved = np.setdiff1d(dataset["curve_speed"].values[first], asked)
    speeds = np.concatenate([asked, solved])
    order = np.argsort(np.abs(speeds))
    speeds, known = speeds[order], np.append(known, np.ones(len(solved), dtype=bool))[order]
    return [(float(speeds[run[0]]), float(speeds[run[-1]])) for run in unbroken_runs(known)]


def within(dataset: xr.Dataset) -> str:
    """Ranges of the crank speeds that a map knows, with a blank before them.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a stability map.

    Returns
    -------
    str
        Such as ``" from 100 to 500 rpm"``; all speeds asked for where none is known.
    """
    unit, speeds = speed_unit(dataset), dataset["crank_speed"].values
    ranges = known_ranges(dataset) or [(float(speeds[0]), float(speeds[-1]))]
    said = [
        f"at {speed_text(first, unit)}"
        if first == last
        else f"from {speed_text(first, unit)} to {speed_text(last, unit)}"
        for first, last in ranges
    ]
    return f" {' and '.join(said)} {unit}"


def is_known(dataset: xr.Dataset, speed: float) -> bool:
    """Whether a speed in rad/s lies in one of :func:`known_ranges`.

    What went through another unit may be off by its last digits.
    """
    slack = 1e-9 * float(np.abs(dataset["crank_speed"].values).max())
    ranges = [sorted(ends) for ends in known_ranges(dataset)]
    return any(low - slack <= speed <= high + slack for low, high in ranges)


def greatest_step(dataset: xr.Dataset, engine: str) -> str:
    """Greatest distance of two speeds at which an engine was solved for.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a stability map.
    engine : str

    Returns
    -------
    str
        Such as ``"63 rpm"``; empty where there are no two speeds.
    """
    every = np.unique(dataset["curve_speed"].values[dataset["curve_engine"].values == engine])
    if len(every) < 2:
        return ""
    unit = speed_unit(dataset)
    return f"{abs(from_si(float(np.diff(every).max()), unit)):.2g} {unit}"
