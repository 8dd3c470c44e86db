"""What speed, heat and moisture change of frequencies, in percent with the errors of the change."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from flexmech.analyses.digits import MOST_DIGITS, decimals_of
from flexmech.analyses.frequencies.extremes import known_error


def percent_range(values: xr.DataArray, error: float) -> str:
    """Least and greatest of relative changes in percent, to the place that their error leaves.

    Parameters
    ----------
    values : xarray.DataArray
        Relative changes.
    error : float
        Of each of them, relative too; not a number where none is known.

    Returns
    -------
    str

    Examples
    --------
    >>> percent_range(xr.DataArray([-0.0123456, 0.02]), 3e-4)
    '-1.23 to +2.00 % ± 0.03 %'
    >>> percent_range(xr.DataArray([0.02]), math.nan)
    '+2.000 %'
    """
    ends = 100 * float(values.min()), 100 * float(values.max())
    size = max(map(abs, ends))
    places = MOST_DIGITS - 1 - math.floor(math.log10(size)) if size else 0
    known = math.isfinite(error) and error > 0
    places = max(min(places, decimals_of(100 * error)) if known else places, 0)
    told = " to ".join(dict.fromkeys(f"{end:+.{places}f}" for end in ends))
    uncertain = f"{100 * error:.{places}f}"
    # What is below the last place is no error of what is told.
    return f"{told} % ± {uncertain} %" if known and float(uncertain) else f"{told} %"


def speed_change(dataset: xr.Dataset, slow: int, fast: int) -> str:
    """How far the lowest mode is moved from one crank speed to another, by the first engine.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of the map in one state.
    slow, fast : int
        Numbers of the crank speeds.

    Returns
    -------
    str
    """
    first = dataset["frequency"].isel(mode=0)
    change = first.isel(crank_speed=fast) / first.isel(crank_speed=slow) - 1
    errors = known_error(dataset).isel(engine=0, mode=0)
    known = float(errors.isel(crank_speed=fast) + errors.isel(crank_speed=slow))
    return percent_range(change.isel(engine=0), max(known, _apart(change)))


def change_by_state(change: xr.DataArray, error: xr.DataArray, mode: int) -> str:
    """How far heat and moisture move a mode over the crank angles and speeds, by the first engine.

    Parameters
    ----------
    change : xarray.DataArray
        Relative, over (engine, crank_speed, crank_angle, mode).
    error : xarray.DataArray
        Relative, of frequencies in both states together, over (engine, crank_speed, mode).
    mode : int
        Its place, from 0.

    Returns
    -------
    str
    """
    own = change.isel(mode=mode)
    known = float(error.isel(engine=0, mode=mode).max())
    return percent_range(own.isel(engine=0), max(known, _apart(own)))


def change_lines(change: xr.DataArray | None, error: xr.DataArray | None) -> list[str]:
    """How far heat and moisture move each frequency over the crank angles and speeds.

    Parameters
    ----------
    change, error : xarray.DataArray or None
        As in :func:`change_by_state`; None where there are no states.

    Returns
    -------
    list of str
    """
    if change is None or error is None:
        return []
    ranges = [
        f"{change_by_state(change, error, place)} (mode {mode})"
        for place, mode in enumerate(change["mode"].values)
    ]
    lines = [f"against dry: {', '.join(ranges)}"]
    if change.sizes["engine"] > 1:
        lines.append(
            f"against dry: engines differ by at most {_apart(change):.1e} of the frequency"
        )
    return lines


def _apart(change: xr.DataArray) -> float:
    """Greatest difference of any engine from the first."""
    return float(np.abs(change - change.isel(engine=0, drop=True)).max())
