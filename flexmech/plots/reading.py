"""Arrays out of datasets, and the units in which they can be read."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.plots.labels import speed_text
from flexmech.types import FloatArray

Units = tuple[tuple[float, str], ...]
"""Factors from the SI unit and names: the usual unit first, smaller ones after it."""
LENGTH_UNITS: Units = ((1e3, "mm"), (1e6, "µm"), (1e9, "nm"))
"""Deflections are read in mm; an arm at constant speed hardly bends, and needs less."""
LEAST_NUMBER = 0.01
MAP = ("engine", "crank_speed", "crank_angle", "mode")
"""Dimensions of what is known of each mode, in the order in which it is drawn."""


def values_of(array: xr.DataArray, *order: str) -> FloatArray:
    """Numbers of an array with its dimensions in an order."""
    return np.asarray(array.transpose(*order).values, dtype=float)


def names_of(dataset: xr.Dataset | xr.DataArray, coordinate: str) -> list[str]:
    """Names along a coordinate such as ``link``."""
    return [str(name) for name in dataset[coordinate].values]


def bending_links(dataset: xr.Dataset) -> list[str]:
    """Links of a response that deflect at all, which rigid ones do not; all where none does."""
    deflected = abs(dataset["deflection"]).max(
        [d for d in dataset["deflection"].dims if d != "link"]
    )
    names = names_of(dataset, "link")
    return [n for n in names if float(deflected.sel(link=n)) > 0] or names


def degrees(angle: xr.DataArray) -> FloatArray:
    """Angles of a coordinate in degrees, free of the conversion's round-off."""
    return np.asarray(np.round(np.degrees(angle.values.astype(float)), 9))


def cell_edges(centres: FloatArray) -> FloatArray:
    """Edges of cells around ascending centres; one alone gets a width of its own value."""
    if centres.size == 1:
        half = abs(float(centres[0])) / 2 or 0.5
        return np.array([centres[0] - half, centres[0] + half])
    middle = (centres[1:] + centres[:-1]) / 2
    ends = 2 * centres[[0, -1]] - middle[[0, -1]]
    return np.concatenate([ends[:1], middle, ends[1:]])


def at_highest_speed(dataset: xr.Dataset) -> tuple[xr.Dataset, str]:
    """The dataset at the greatest crank speed in either sense, and that speed as text."""
    place, text = highest_speed(dataset)
    return dataset.isel(crank_speed=place), text


def highest_speed(dataset: xr.Dataset) -> tuple[int, str]:
    """Place of the greatest crank speed in either sense, and that speed as text."""
    speeds = dataset["crank_speed"].values.astype(float)
    place = int(np.argmax(np.abs(speeds)))
    return place, speed_text(dataset, float(speeds[place]))


def fitting_unit(values: FloatArray, units: Units) -> tuple[float, str]:
    """Unit in which values can be read: the first in which the largest is not too small.

    Parameters
    ----------
    values : ndarray
        In the SI unit.
    units : tuple of (float, str)
        Factors from the SI unit and names, the usual one first, smaller ones after it.

    Returns
    -------
    float, str
        Factor and name.
    """
    largest = float(np.nanmax(np.abs(values), initial=0.0))
    fitting = (unit for unit in units if largest * unit[0] >= LEAST_NUMBER)
    return next(fitting, units[0 if largest == 0 else -1])
