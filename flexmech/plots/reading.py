"""Arrays, names and units out of datasets, for all figures."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.plots.style import speed_label
from flexmech.types import FloatArray
from flexmech.units import ANGULAR_SPEED

__all__ = [
    "LENGTH_UNITS",
    "Units",
    "at_highest_speed",
    "cell_edges",
    "degrees",
    "engine_label",
    "fitting_unit",
    "link_label",
    "names_of",
    "run_title",
    "speed_text",
    "speed_unit",
    "values_of",
]

Units = tuple[tuple[float, str], ...]
"""Factors from the SI unit and names: the usual unit first, smaller ones after it."""

LENGTH_UNITS: Units = ((1e3, "mm"), (1e6, "µm"), (1e9, "nm"))
"""Deflections are read in mm; an arm at constant speed hardly bends, and needs less."""
LEAST_NUMBER = 0.01

STARTS = {
    "rigid": "from undeformed links",
    "equilibrium": "from the quasi-static equilibrium",
    "periodic": "on the periodic motion",
}


def values_of(array: xr.DataArray, *order: str) -> FloatArray:
    """Numbers of an array with its dimensions in an order."""
    return np.asarray(array.transpose(*order).values, dtype=float)


def names_of(dataset: xr.Dataset, coordinate: str) -> list[str]:
    """Names along a coordinate such as ``link``."""
    return [str(name) for name in dataset[coordinate].values]


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


def speed_unit(dataset: xr.Dataset) -> str:
    """Unit in which the user reads crank speeds."""
    return str(dataset.attrs.get("speed_unit", ANGULAR_SPEED.unit))


def speed_text(dataset: xr.Dataset, speed: float | None = None) -> str:
    """A crank speed in rad/s, by default that of the whole dataset, in the user's unit."""
    value = dataset.attrs["crank_speed"] if speed is None else speed
    return speed_label(float(value), speed_unit(dataset))


def at_highest_speed(dataset: xr.Dataset) -> tuple[xr.Dataset, str]:
    """The dataset at the greatest crank speed in either sense, and that speed as text."""
    fastest = dataset.isel(crank_speed=int(np.argmax(np.abs(dataset["crank_speed"].values))))
    return fastest, speed_text(dataset, float(fastest["crank_speed"]))


def engine_label(dataset: xr.Dataset, engine: int = 0) -> str:
    """Name of an engine with its element, for legends."""
    name = str(dataset["engine"].values[engine])
    if "element" in dataset.coords and dataset["element"].dims == ("engine",):
        return f"{name} ({dataset['element'].values[engine]})"
    return name


def link_label(dataset: xr.Dataset, link: str) -> str:
    """Where on a link its deflection is watched, as in "Coupler middle"."""
    return f"{link.capitalize()} {dataset['probe'].sel(link=link).item()}"


def run_title(dataset: xr.Dataset) -> str:
    """Heading line that says what run is drawn: crank speed and start."""
    title = f"Response at {speed_text(dataset)}"
    run_up = float(dataset.attrs.get("run_up_time", 0.0))
    if run_up > 0:
        title += f" after a run-up of {run_up:.3g} s"
    start = STARTS.get(str(dataset.attrs.get("start", "")))
    return f"{title}, {start}" if start else title


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
