"""Measured quantities in SI units over time, frequency or crank angle."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.errors import InputError, suggestion
from flexmech.validation import check_choice, checked_array, checked_tuple

Abscissa = Literal["time", "frequency", "crank_angle"]
# SI unit of what a record is written over.
ABSCISSA_UNITS: dict[Abscissa, str] = {"time": "s", "frequency": "Hz", "crank_angle": "rad"}
# Fewer have no usual step, beside which another could be called uneven.
LEAST_SAMPLES = 3
# No measured number is greater in SI units; of much greater ones squares overflow.
GREATEST = 1e60

# Part of the step by which one step may differ from the others, besides the rounding of the file:
# 3.6 deg of the phase at half the sampling rate.
JITTER = 0.02
# A step of so many others is a gap if it is a whole number of them within this part of a step: five
# times what a step may differ by, since each of the missing ones may.
WHOLE = 0.1


@dataclass(frozen=True)
class MeasuredQuantity:
    """One curve of a record.

    Parameters
    ----------
    name : str
        Without its unit, such as ``"coupler_mid_strain"``.
    unit : str
        SI unit of the values; empty for a ratio such as a strain.
    values : ndarray, shape (N,)
        Real, or complex for a frequency-response function. Finite.
    header : str
        The name as it stands in the file, with its unit.

    Raises
    ------
    InputError
        If a value is no finite number, or greater than any that is measured.

    Examples
    --------
    >>> flexmech.MeasuredQuantity("strain", "", np.array([1e-6, 3e-6, 2e-6])).unit
    ''
    """

    name: str
    unit: str
    values: FloatArray | ComplexArray
    header: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", _samples(self.values, str(self.name), self.unit))


@dataclass(frozen=True)
class MeasuredRecord:
    """Quantities that were measured together.

    Parameters
    ----------
    abscissa : {"time", "frequency", "crank_angle"}
        What the quantities are written over.
    position : ndarray, shape (N,)
        Values of the abscissa in s, Hz or rad, in the order of the file.
    quantities : tuple of MeasuredQuantity
    source : str
        File that messages name.
    unreadable : mapping of str to str
        Columns of the file that are no quantity, by name, and what is wrong with each.
    rounding : float
        What the last digit of the file's abscissa stands for, in SI units.

    Raises
    ------
    InputError
        If a value of the abscissa is no finite number, a quantity has not as many values as the
        abscissa, or there are fewer than three.

    Examples
    --------
    >>> strain = flexmech.MeasuredQuantity("strain", "", np.array([1e-6, 3e-6, 2e-6]))
    >>> record = flexmech.MeasuredRecord("time", np.array([0.0, 0.1, 0.2]), (strain,))
    >>> record.names
    ('strain',)
    """

    abscissa: Abscissa
    position: FloatArray
    quantities: tuple[MeasuredQuantity, ...]
    source: str = "record"
    unreadable: Mapping[str, str] = field(default_factory=dict)
    rounding: float = 0.0

    def __post_init__(self) -> None:
        check_choice(self.abscissa, tuple(ABSCISSA_UNITS), "abscissa")
        position = _samples(self.position, self.abscissa, ABSCISSA_UNITS[self.abscissa])
        object.__setattr__(self, "position", position)
        remedy = "give MeasuredQuantity(name, unit, values) in a tuple"
        quantities = checked_tuple(self.quantities, MeasuredQuantity, "quantities", remedy)
        object.__setattr__(self, "quantities", quantities)
        if len(self.position) < LEAST_SAMPLES:
            raise InputError(
                f"{self.source}: holds {len(self.position)} samples, too few for a record; give at "
                f"least {LEAST_SAMPLES}"
            )
        for quantity in self.quantities:
            if quantity.values.shape != self.position.shape:
                raise InputError(
                    f"{self.source}: {quantity.name} has {len(quantity.values)} values over "
                    f"{len(self.position)} of the {self.abscissa}; give one for each"
                )

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the quantities, in the order of the file."""
        return tuple(quantity.name for quantity in self.quantities)

    def has(self, name: str) -> bool:
        """Whether there is a quantity of this name."""
        return name in self.names

    def quantity(self, name: str) -> MeasuredQuantity:
        """The quantity of a name, with or without its unit.

        Parameters
        ----------
        name : str

        Returns
        -------
        MeasuredQuantity

        Raises
        ------
        InputError
            If there is none, or its column has no unit, has gaps or is no numbers.
        """
        for quantity in self.quantities:
            if name in (quantity.name, quantity.header):
                return quantity
        if name in self.unreadable:
            raise InputError(self.unreadable[name])
        known = [*self.names, *self.unreadable]
        raise InputError(f"{self.source}: has no column {name!r}; {suggestion(name, known)}")


def _samples(values: Any, name: str, unit: str) -> FloatArray | NDArray[np.complex128]:
    """Numbers of a record, of one dimension, real or complex."""
    try:
        complex_ = np.iscomplexobj(values)
    except (TypeError, ValueError):  # lists of different lengths, or a dataset
        complex_ = False
    samples: FloatArray | NDArray[np.complex128]
    if complex_:
        real, imaginary = np.real(values), np.imag(values)
        samples = checked_array(real, name, unit) + 1j * checked_array(imaginary, name, unit)
    else:
        samples = checked_array(values, name, unit)
    if samples.ndim != 1:
        raise InputError(f"{name} must be a row of numbers, got an array of shape {samples.shape}")
    if float(np.abs(samples).max(initial=0.0)) > GREATEST:
        raise InputError(
            f"{name} reaches {np.abs(samples).max():.3g} {unit}".rstrip()
            + ", more than anything that is measured; correct the values or their unit"
        )
    return samples


def sampling_interval(time: FloatArray, source: str = "record", rounding: float = 0.0) -> float:
    """Step of an evenly sampled record.

    Parameters
    ----------
    time : ndarray, shape (N,)
        In s.
    source : str
        File that messages name.
    rounding : float
        Value in s of the last digit that the file writes.

    Returns
    -------
    float
        In s: the length of the record over the number of its steps.

    Raises
    ------
    InputError
        If the time does not increase, samples are missing, or steps are unequal.
    """
    steps = np.diff(time)
    wrong = np.flatnonzero(steps <= 0)
    if len(wrong):
        raise InputError(
            f"{source}: time goes from {time[wrong[0]]:.9g} s to {time[wrong[0] + 1]:.9g} s, and "
            "must increase; if the file holds several runs, such as those of two engines, keep one"
        )
    usual = float(np.median(steps))
    allowed = JITTER * usual + 1.01 * rounding
    uneven = np.flatnonzero(np.abs(steps - usual) > allowed)
    if len(uneven):
        first = int(uneven[0])
        times = steps[first] / usual
        place = f"from {time[first]:.9g} s to {time[first + 1]:.9g} s"
        missing = round(float(times)) - 1
        if missing >= 1 and abs(times - missing - 1) < WHOLE:
            raise InputError(
                f"{source}: has a gap: {missing} samples of every {usual:.6g} s are missing "
                f"{place}; give a part of the record without gaps"
            )
        raise InputError(
            f"{source}: steps are unequal: one is {steps[first]:.6g} s, {place}, the others "
            f"{usual:.6g} s; resample the record to equal steps, with the filter that this needs"
        )
    return float(time[-1] - time[0]) / (len(time) - 1)
