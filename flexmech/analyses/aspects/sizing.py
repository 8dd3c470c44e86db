"""Sizes of a motor and bearings: mean and greatest torque, power, speed and joint forces.

A motor heats up by the square of its torque, so that its root mean square counts; the life of a
rolling bearing goes with the third power of its load, so that the cubic mean is the equivalent one
(ISO 281; Harris and Kotzalas, *Essential Concepts of Bearing Technology*, 5th ed., ch. 8).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

import numpy as np
import xarray as xr

from flexmech.analyses.digits import Quantity
from flexmech.analyses.extremes import peaks_between
from flexmech.analyses.schema import Values
from flexmech.analyses.summary import Aspect, Table
from flexmech.arrays import FloatArray
from flexmech.linkages import Drive, MotorRun

GREATEST = np.inf
"""Exponent of a mean that is the greatest size."""


class Driven(NamedTuple):
    """A shaft that is driven, at N positions.

    Parameters
    ----------
    of : str
        ``"shaft"`` of the crank, or ``"motor"`` on its own shaft.
    torque, speed : ndarray, shape (N,)
        In N m and rad/s.
    """

    of: str
    torque: FloatArray
    speed: FloatArray

    @property
    def histories(self) -> Iterator[tuple[str, str, str, FloatArray, float]]:
        """Quantities, what they are of, units, values (N,) and the exponents of their means."""
        yield "rms_torque", self.of, "N m", self.torque, 2.0
        yield "peak_torque", self.of, "N m", self.torque, GREATEST
        yield "peak_power", self.of, "W", self.torque * self.speed, GREATEST
        yield "peak_speed", self.of, "rad/s", self.speed, GREATEST


def mean_size(values: FloatArray, place: FloatArray, exponent: float) -> float:
    """Mean of the size of a history: the root of the mean of a power, or the greatest size.

    By the trapezoidal rule, which converges faster than any power of the step over a whole turn of
    what is smooth and periodic. The greatest size is sought between the positions too.

    Parameters
    ----------
    values : ndarray, shape (N,)
    place : ndarray, shape (N,)
        Even steps of crank angle at constant speed, or of time.
    exponent : float
        2 of a root mean square, 3 of a cubic mean, infinite of the greatest size.

    Returns
    -------
    float

    Examples
    --------
    >>> angle = np.linspace(0.0, 2 * np.pi, 37)
    >>> [round(mean_size(np.cos(angle - 1.0), angle, n), 4) for n in (2.0, np.inf)]
    [0.7071, 1.0]
    """
    if exponent == GREATEST or len(place) < 2:
        return float(peaks_between(values[:, None], place)[0][0])
    mean = np.trapezoid(np.abs(values) ** exponent, place) / (place[-1] - place[0])
    return float(mean ** (1 / exponent))


def sizing_values(
    place: FloatArray,
    driven: Iterable[Driven],
    force: Mapping[str, FloatArray],
    drive: Drive | None = None,
) -> Values:
    """All that sizes motor and bearings, over a whole turn or a run.

    Parameters
    ----------
    place : ndarray, shape (N,)
        As of :func:`mean_size`, both ends of the turn included.
    driven : iterable of Driven
    force : mapping of str to ndarray, shape (N, 2)
        Forces of joints in N.
    drive : Drive, optional
        Drive of a motor, whose rotor is compared with what it drives.

    Returns
    -------
    dict
        Variables over ``sizing``.
    """
    histories = [history for one in driven for history in one.histories]
    for joint, vectors in force.items():
        size = np.hypot(vectors[:, 0], vectors[:, 1])
        histories.append(("cubic_mean_force", joint, "N", size, 3.0))
        histories.append(("peak_force", joint, "N", size, GREATEST))
    rows = []
    for name, of, unit, values, exponent in histories:
        value = mean_size(values, place, exponent)
        coarse = mean_size(values[::2], place[::2], exponent)
        rows.append((name, of, unit, value, abs(value - coarse)))
    if isinstance(drive, MotorRun) and drive.drive.motor.inertia:
        rows.append(("inertia_ratio", "motor", "", *_inertia_ratio(drive)))
    columns = zip(*rows, strict=True)
    names = ("sizing_quantity", "sizing_of", "sizing_unit", "sizing_value", "sizing_error")
    return {name: np.array(column) for name, column in zip(names, columns, strict=True)}


def _inertia_ratio(run: MotorRun) -> tuple[float, float]:
    """Mean inertia over a turn of linkage and shaft, at the motor, over its rotor's; its error."""
    angle = np.linspace(0.0, 2 * np.pi, 721)
    load = run.equation.load.inertia(angle) + run.equation.shaft_inertia
    fine, coarse = (
        np.trapezoid(load[::step], angle[::step]) / (2 * np.pi) / run.drive.motor.inertia_at_crank
        for step in (1, 2)
    )
    return float(fine), float(abs(fine - coarse))


def sizing_aspect(data: xr.Dataset, errors: xr.DataArray | None = None) -> Aspect:
    """Sizes of motor and bearings, as a table and as numbers.

    Parameters
    ----------
    data : xarray.Dataset
        Variables of a result, for one engine where engines have run.
    errors : xarray.DataArray, optional
        Over (sizing), besides those by the number of positions.

    Returns
    -------
    Aspect
        Nothing where nothing is known between the crank angles.
    """
    if "sizing_value" not in data:
        return Aspect()
    error = data["sizing_error"] if errors is None else data["sizing_error"] + errors
    columns = (data[f"sizing_{name}"].values for name in ("quantity", "value", "unit", "of"))
    numbers = tuple(
        Quantity(str(name), float(value), str(unit), float(own), str(of))
        for name, value, unit, of, own in zip(*columns, error.values, strict=True)
    )
    rows = tuple((one.name.replace("_", " "), one.of, *str(one).split(" ", 1)) for one in numbers)
    title = f"sizes of motor and bearings, over {data.attrs['sizing_over']}"
    headings = ("quantity", "of", "value", "unit")
    table = Table(title, headings, (tuple((*row, "")[:4] for row in rows),), text_columns=2)
    # Peaks are among the numbers of the answer.
    means = tuple(one for one in numbers if not one.name.startswith("peak_"))
    return Aspect(details=(table,), numbers=means)
