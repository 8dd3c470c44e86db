"""Arrays, names, units and headings that figures read out of datasets, and the part shown."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.errors import InputError
from flexmech.units import ANGULAR_SPEED, from_si

STARTS = {
    "rigid": "from undeformed links",
    "equilibrium": "from the quasi-static equilibrium",
    "periodic": "on the periodic motion",
}

Units = tuple[tuple[float, str], ...]
"""Factors from the SI unit and names: the usual unit first, smaller ones after it."""
LENGTH_UNITS: Units = ((1e3, "mm"), (1e6, "µm"), (1e9, "nm"))
"""Deflections are read in mm; an arm at constant speed hardly bends, and needs less."""
FORCE_UNITS: Units = ((1.0, "N"), (1e3, "mN"), (1e6, "µN"))
TORQUE_UNITS: Units = ((1.0, "N m"), (1e3, "mN m"), (1e6, "µN m"))
POWER_UNITS: Units = ((1.0, "W"), (1e3, "mW"), (1e6, "µW"))
STRAIN_UNITS: Units = ((1e6, "µm/m"),)
A_TURN = 2 * np.pi * (1 + 1e-9)
"""A turn in rad: round-off does not lose the sample that closes it."""
# Least number of the largest value in a unit that can be read: axes write two decimals.
LEAST_NUMBER = 0.01
MAP = ("engine", "crank_speed", "crank_angle", "mode")
"""Dimensions of what is known of each mode, in the order in which it is drawn."""

_DIMENSIONS = {
    "engine": "engine",
    "modes": "mode",
    "speeds": "crank_speed",
    "links": "link",
    "branches": "branch",
    "orders": "order",
}
# Relative difference up to which two speeds are the same: that by units that are typed with ten
# digits, as in 31.41592654 rad/s.
_SAME_SPEED = 1e-9
_SUBSCRIPTS = str.maketrans("0123456789+-", "₀₁₂₃₄₅₆₇₈₉₊₋")


def mechanism_name(dataset: xr.Dataset) -> str:
    """Name of the mechanism with a capital letter; empty where a dataset has none.

    Dollar signs stay what they are, where matplotlib would see a formula.
    """
    name = str(dataset.attrs.get("mechanism", ""))
    return (name[:1].upper() + name[1:]).replace("$", r"\$")


def terms_text(dataset: xr.Dataset) -> str:
    """Counted terms of the turning link frames; empty where all of them are."""
    counted = str(dataset.attrs.get("rotation_terms", "on"))
    if counted == "on":
        return ""
    names = "none" if counted == "off" else counted.replace(",", ", ")
    return f"rotation terms counted: {names.replace('coriolis', 'Coriolis')}"


def mode_label(numbers: Sequence[int]) -> str:
    """Heading of a panel for one mode or several neighbours."""
    if len(numbers) == 1:
        return f"Mode {numbers[0]}"
    return f"Modes {numbers[0]} {'and' if len(numbers) == 2 else 'to'} {numbers[-1]}"


def speed_label(speed: float, unit: str = ANGULAR_SPEED.unit) -> str:
    """Crank speed, given in rad/s, as text in a unit such as rpm, with a true minus sign."""
    return f"{from_si(speed, unit):.4g} {unit}".replace("-", "\N{MINUS SIGN}")


def speed_unit(dataset: xr.Dataset) -> str:
    """Unit in which a result speaks of crank speeds."""
    return str(dataset.attrs.get("speed_unit", ANGULAR_SPEED.unit))


def crank_speed_units(dataset: xr.Dataset) -> Units:
    """The one unit, for crank speeds over time."""
    unit = speed_unit(dataset)
    return ((from_si(1.0, unit), unit),)


def speed_text(dataset: xr.Dataset, speed: float | None = None) -> str:
    """A crank speed in rad/s, by default that of the whole dataset, in the user's unit."""
    value = dataset.attrs["crank_speed"] if speed is None else speed
    return speed_label(float(value), speed_unit(dataset))


def drive_text(dataset: xr.Dataset) -> str:
    """Crank speed of the whole dataset, and the crank's acceleration where it has one."""
    acceleration = dataset.attrs.get("crank_acceleration")
    if acceleration is None:
        return speed_text(dataset)
    size = f"{float(acceleration):.4g} rad/s²".replace("-", "\N{MINUS SIGN}")
    return f"{speed_text(dataset)}, crank acceleration {size}"


def conditions(dataset: xr.Dataset) -> str:
    """At which crank speed and acceleration a dataset is, or under which law of motion."""
    law = dataset.attrs.get("drive")
    return f"at {drive_text(dataset)}" if law is None else f"under {law}"


def operating_speeds(dataset: xr.Dataset) -> list[float]:
    """Operating speeds of the model file between the ends of a map over crank speeds, in rad/s."""
    named = [float(speed) for speed in str(dataset.attrs.get("operating_speeds", "")).split()]
    low, high = dataset["crank_speed"].values[[0, -1]].tolist()
    return [speed for speed in named if lies_in(dataset, [(low, high)], speed)]


def lies_in(dataset: xr.Dataset, ranges: Sequence[tuple[float, float]], speed: float) -> bool:
    """Whether a crank speed in rad/s lies in ranges of a map over crank speeds.

    A speed that went through another unit may be off by its last digits.

    Parameters
    ----------
    dataset : Dataset
    ranges : sequence of tuple of float
    speed : float
    """
    slack = 1e-9 * float(np.abs(dataset["crank_speed"].values).max())
    return any(min(ends) - slack <= speed <= max(ends) + slack for ends in ranges)


def speed_texts(dataset: xr.Dataset) -> list[str]:
    """Crank speeds of a dataset in the user's unit."""
    return [speed_text(dataset, float(speed)) for speed in dataset["crank_speed"].values]


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
    if "drive" in dataset.attrs:
        return f"Response to {dataset.attrs['drive']}"
    title = f"Response at {speed_text(dataset)}"
    run_up = float(dataset.attrs.get("run_up_time", 0.0))
    if run_up > 0:
        title += f" after a run-up of {run_up:.3g} s"
    start = STARTS.get(str(dataset.attrs.get("start", "")))
    return f"{title}, {start}" if start else title


def merged(ranges: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
    """Ranges in ascending order, those that overlap as one."""
    whole: list[tuple[float, float]] = []
    for low, high in sorted(ranges):
        if whole and low <= whole[-1][1]:
            whole[-1] = (whole[-1][0], max(high, whole[-1][1]))
        else:
            whole.append((low, high))
    return whole


def spread(places: FloatArray, least: float) -> FloatArray:
    """Move places apart to a least distance, so that labels at them do not touch.

    Parameters
    ----------
    places : ndarray
        Ascending.
    least : float
        Distance that neighbours keep at least.

    Returns
    -------
    ndarray
        In the same order; places that had to move are centred on where they were.
    """
    rows: list[tuple[float, int]] = []  # centre and number of places that stand in a row
    for place in places.tolist():
        centre, count = place, 1
        while rows and centre - rows[-1][0] < (count + rows[-1][1]) * least / 2:
            before, many = rows.pop()
            centre = (centre * count + before * many) / (count + many)
            count += many
        rows.append((centre, count))
    return np.array(
        [centre + (n - (count - 1) / 2) * least for centre, count in rows for n in range(count)]
    )


def values_of(array: xr.DataArray, *order: str) -> FloatArray:
    """Numbers of an array with its dimensions in an order."""
    return np.asarray(array.transpose(*order).values, dtype=float)


def sizing(dataset: xr.Dataset, quantity: str, of: str) -> FloatArray:
    """Numbers that size motor or bearings, by one engine after the other.

    Parameters
    ----------
    dataset : Dataset
    quantity, of : str
        Such as ``rms_torque`` of ``shaft``.

    Returns
    -------
    ndarray, shape (1,) or (engines, 1)
    """
    wanted = (dataset["sizing_quantity"] == quantity) & (dataset["sizing_of"] == of)
    return np.asarray(dataset["sizing_value"].values[..., wanted.values], dtype=float)


def names_of(dataset: xr.Dataset | xr.DataArray, coordinate: str) -> list[str]:
    """Names along a coordinate such as ``link``."""
    return [str(name) for name in dataset[coordinate].values]


def joint_title(dataset: xr.Dataset, joint: str) -> str:
    """A joint, and which link exerts the force on which, where a dataset has that."""
    there = dataset.sel(joint=joint)
    if "force_by" not in there.coords:
        return joint
    return f"{joint}: force of the {there['force_by'].item()} on the {there['force_on'].item()}"


def complex_values(dataset: xr.Dataset, name: str, *order: str) -> ComplexArray:
    """Values that are stored as real and imaginary part, with their dimensions in an order."""
    parts = (dataset[f"{name}_{part}"] for part in ("real", "imag"))
    real, imaginary = (values_of(part, *(order or map(str, part.dims))) for part in parts)
    return np.asarray(real + 1j * imaginary)


def amplitudes_of(values: ComplexArray) -> FloatArray:
    """Amplitudes for a logarithmic axis: not a number where nothing answers."""
    size = np.abs(values)
    return np.where(size > 0, size, np.nan)


def speeds_of(dataset: xr.Dataset, name: str = "crank_speed") -> FloatArray:
    """Crank speeds along a coordinate, in the unit in which the user reads them."""
    return np.asarray(from_si(1.0, speed_unit(dataset)) * dataset[name].values)


def subscripts(number: int | str) -> str:
    """An integer, or one with its sign, in lowered figures."""
    return str(number).translate(_SUBSCRIPTS)


def signed(order: int) -> str:
    """An order with its sign, 0 without one."""
    return f"{order:+d}" if order else "0"


def a_turn(dataset: xr.Dataset) -> xr.Dataset:
    """The first turn of a periodic motion, which all others repeat; any other run whole."""
    if "drive" in dataset.attrs or dataset.attrs.get("start") != "periodic":
        return dataset
    turned = np.abs(dataset["crank_angle"].values - dataset["crank_angle"].values[0])
    return dataset.isel(time=turned <= A_TURN)


def bending_links(dataset: xr.Dataset) -> list[str]:
    """Links of a response that deflect at all, which rigid ones do not; all where none does."""
    deflected = abs(dataset["deflection"]).max(
        [d for d in dataset["deflection"].dims if d != "link"]
    )
    names = names_of(dataset, "link")
    return [n for n in names if float(deflected.sel(link=n)) > 0] or names


def degrees(angle: ArrayLike) -> FloatArray:
    """Angles such as those of a coordinate in degrees, free of the conversion's round-off."""
    return np.asarray(np.round(np.degrees(np.asarray(angle, dtype=float)), 9))


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


def chosen(
    dataset: xr.Dataset,
    *,
    engine: ArrayLike | None = None,
    modes: ArrayLike | None = None,
    speeds: ArrayLike | None = None,
    links: ArrayLike | None = None,
    branches: ArrayLike | None = None,
    orders: ArrayLike | None = None,
) -> xr.Dataset:
    """Part of a dataset that a figure shall show, in the order asked for.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a result.
    engine : str or sequence of str, optional
        Names, such as ``"exudyn"``.
    modes : int or sequence of int, optional
        Numbers from 1.
    speeds : float or sequence of float, optional
        Crank speeds in rad/s.
    links : str or sequence of str, optional
        Names, such as ``"coupler"``.
    branches, orders : int or sequence of int, optional
        Numbers from 1.

    Returns
    -------
    Dataset
        With all its dimensions; what is not chosen by is whole.

    Raises
    ------
    InputError
        If the dataset has no such engine, mode, speed or link.
    """
    asked = {"engine": engine, "modes": modes, "speeds": speeds, "links": links}
    asked |= {"branches": branches, "orders": orders}
    places = {}
    for argument, wanted in asked.items():
        if wanted is not None:
            places[_DIMENSIONS[argument]] = _places(dataset, argument, wanted)
    return dataset.isel(places)


def _places(dataset: xr.Dataset, argument: str, wanted: ArrayLike) -> list[int]:
    """Positions along a dimension of the values asked for."""
    dimension = _DIMENSIONS[argument]
    if dimension not in dataset.dims:
        raise InputError(f"{argument}: this result has none to choose from")
    known = dataset[dimension].values.tolist()
    values = np.atleast_1d(np.asarray(wanted)).tolist()
    there = ", ".join(map(_text, known)) + (" rad/s" if dimension == "crank_speed" else "")
    if not values:
        raise InputError(f"{argument}: nothing is chosen; choose from {there}")
    places = []
    for value in values:
        found = [place for place, each in enumerate(known) if _same(each, value)]
        if not found:
            raise InputError(f"{argument}: this result has no {value!r}; choose from {there}")
        places += found
    return places


def _text(value: object) -> str:
    return f"{value:.10g}" if isinstance(value, float) else str(value)


def _same(one: object, other: object) -> bool:
    if isinstance(one, float) and isinstance(other, int | float):
        return math.isclose(one, other, rel_tol=_SAME_SPEED)
    return one == other
