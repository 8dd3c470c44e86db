"""What was measured: quantities in SI units over time, frequency or crank angle."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flexmech.errors import InputError, suggestion
from flexmech.types import FloatArray

__all__ = ["ABSCISSA_UNITS", "Abscissa", "MeasuredQuantity", "MeasuredRecord"]

Abscissa = Literal["time", "frequency", "crank_angle"]
ABSCISSA_UNITS: dict[Abscissa, str] = {"time": "s", "frequency": "Hz", "crank_angle": "rad"}
"""SI unit of what a record is written over."""
LEAST_SAMPLES = 3


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

    Examples
    --------
    >>> flexmech.MeasuredQuantity("strain", "", np.array([1e-6, 3e-6, 2e-6])).unit
    ''
    """

    name: str
    unit: str
    values: FloatArray | NDArray[np.complex128]
    header: str = ""


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
        If a quantity has not as many values as the abscissa, or there are fewer than three.

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
