"""Variables of a study: over a range, a list or a distribution."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy

from flexmech.analyses.parameters import Parameters
from flexmech.arrays import FloatArray
from flexmech.errors import AssemblyError, InputError, LockingError
from flexmech.model_text import quantity
from flexmech.units import Dimension, from_si

Distribution = Literal["range", "values", "uniform", "normal", "lognormal"]
CRANK_SPEED = "crank-speed"
"""Variable that is a crank speed, of which a model file has none or several."""

# Probability beyond the range of a distribution without ends: one design of a million.
_EXTREME = 1e-6


@dataclass(frozen=True)
class Variable:
    """A number or text of the model that varies, in one place of the model file or in several.

    Parameters
    ----------
    name : str
    keys : tuple of str
        Keys of the model file or of :mod:`flexmech.analyses.parameters`: all of them get the value.
    dimension : Dimension or None
        None of a text.
    distribution : {"range", "values", "uniform", "normal", "lognormal"}
    numbers : tuple of float or str
        Ends of a range or of a uniform distribution, the listed values, or mean and standard
        deviation of the quantity itself, in SI units.
    steps : int
        Steps of a range, how many values every combination takes.
    shown_unit : str
        In which results speak of it; the SI unit if empty.

    Raises
    ------
    InputError
        If the numbers are none for that distribution.
    """

    name: str
    keys: tuple[str, ...]
    dimension: Dimension | None
    distribution: Distribution
    numbers: tuple[float, ...] | tuple[str, ...]
    steps: int = 5
    shown_unit: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "shown_unit", self.shown_unit or self.unit)
        if self.distribution == "values":
            if not self.numbers or len(set(self.numbers)) != len(self.numbers):
                raise InputError(f"{self.name}: list one value or more, each one once")
            return
        if len(self.numbers) != 2 or self.dimension is None:
            raise InputError(
                f"{self.name}: {self.distribution} needs two quantities; texts have values = [...]"
            )
        first, second = self._pair
        if self.distribution in ("range", "uniform") and not second > first:
            raise InputError(
                f"{self.name}: {self.distribution} = {self.shown} is empty; the second number "
                "must be greater than the first"
            )
        if self.distribution in ("normal", "lognormal") and not second > 0:
            raise InputError(
                f"{self.name}: {self.distribution} = {self.shown}; the second number is the "
                "standard deviation and must be positive"
            )
        if self.distribution == "lognormal" and not first > 0:
            raise InputError(f"{self.name}: the mean of a lognormal distribution must be positive")

    @property
    def _pair(self) -> tuple[float, float]:
        first, second = self.numbers
        return float(first), float(second)

    @property
    def is_text(self) -> bool:
        """Whether its values are texts."""
        return self.dimension is None

    @property
    def is_random(self) -> bool:
        """Whether it has a distribution, and is not chosen."""
        return self.distribution in ("uniform", "normal", "lognormal")

    @property
    def is_fixed(self) -> bool:
        """Whether it has one value in all designs."""
        return self.distribution == "values" and len(self.numbers) == 1

    @property
    def shown(self) -> list[str | float]:
        """Its numbers as a study file writes them."""
        if self.dimension is None:
            return list(self.numbers)
        dimension = self.dimension
        return [quantity(float(each), dimension) for each in self.numbers]

    def text(self, number: float) -> str:
        """A value in words: with its unit, or the text at a place in the list."""
        value = self.value(number)
        if isinstance(value, str):
            return value
        return f"{from_si(value, self.shown_unit):.4g} {self.shown_unit}".rstrip()

    @property
    def unit(self) -> str:
        """SI unit; empty of ratios and texts."""
        return "" if self.dimension is None else self.dimension.unit

    @property
    def count(self) -> int:
        """How many values combinations take."""
        return len(self.numbers) if self.distribution == "values" else self.steps

    def every(self) -> FloatArray:
        """Values that combinations take; of texts their places in the list."""
        if self.is_text:
            return np.arange(len(self.numbers), dtype=float)
        if self.distribution == "values":
            return np.array(self.numbers, dtype=float)
        if self.distribution in ("range", "uniform"):
            return np.linspace(*self._pair, self.steps)
        raise InputError(
            f"{self.name}: a {self.distribution} distribution has no combinations; give a number "
            "of samples"
        )

    def at(self, probability: FloatArray) -> FloatArray:
        """Values that are not exceeded with a probability, of the same shape.

        Parameters
        ----------
        probability : ndarray
            Between 0 and 1.

        Returns
        -------
        ndarray
            Values in SI units; texts by their places in the list.
        """
        if self.distribution == "values":
            place = np.minimum(probability * len(self.numbers), len(self.numbers) - 1).astype(int)
            return place.astype(float) if self.is_text else np.array(self.numbers)[place]
        first, second = self._pair
        if self.distribution in ("range", "uniform"):
            return first + (second - first) * probability
        standard = scipy.special.ndtri(probability)
        if self.distribution == "normal":
            return np.asarray(first + second * standard)
        spread = math.sqrt(math.log1p((second / first) ** 2))
        return np.asarray(first * np.exp(spread * standard - spread**2 / 2))

    def value(self, number: float) -> float | str:
        """Value for the model: a quantity in SI units, or the text at a place in the list."""
        return self.numbers[int(number)] if self.is_text else float(number)

    def check(self, parameters: Parameters) -> None:
        """Refuse a variable whose least or greatest value the model cannot have.

        Parameters
        ----------
        parameters : Parameters
            Parameters of the mechanism.

        Raises
        ------
        InputError
            Names the variable, the value, what is wrong and the remedy. Lengths that cannot be
            assembled are a finding of the study, and are not refused.
        """
        if CRANK_SPEED in self.keys:
            return
        if self.distribution == "values":
            tried = self.every()
        else:
            ends = [0.0, 1.0] if self.distribution in ("range", "uniform") else [_EXTREME]
            tried = self.at(np.array([*ends, 1 - _EXTREME][:2]))
        for number in tried.tolist():
            value = self.value(number)
            try:
                parameters.mechanism_with(dict.fromkeys(self.keys, value))
            except (AssemblyError, LockingError):
                continue
            except InputError as error:
                shown = value
                if self.dimension is not None:
                    shown = quantity(float(f"{number:.4g}"), self.dimension)
                remedy = ""
                if self.distribution == "normal":
                    remedy = (
                        "; one of a million designs is there: take a smaller standard deviation, "
                        "uniform or lognormal"
                    )
                raise InputError(f"{self.name} at {shown}: {error.message}{remedy}") from error


def known_variable(
    parameters: Parameters,
    name: str,
    keys: Sequence[str],
    speed: Dimension,
) -> Dimension | None:
    """Kind of the keys of a variable: all of one kind.

    Parameters
    ----------
    parameters : Parameters
        Parameters of the mechanism.
    name : str
    keys : sequence of str
    speed : Dimension
        Dimension of the crank speed.

    Returns
    -------
    Dimension or None
        None of texts.

    Raises
    ------
    InputError
        If there is no such key, or they are of several kinds.
    """
    kinds: set[Dimension | None] = set()
    for key in keys:
        if key == CRANK_SPEED:
            kinds.add(speed)
        elif key in parameters.texts:
            kinds.add(None)
        else:
            kinds.add(parameters.dimension(key))
    if len(kinds) != 1:
        raise InputError(f"{name}: its paths are of several kinds: {', '.join(keys)}")
    (kind,) = kinds
    return kind


def as_values(variables: Sequence[Variable], row: FloatArray) -> Mapping[str, float | str]:
    """Values of the model's keys in one design.

    Parameters
    ----------
    variables : sequence of Variable
    row : ndarray, shape (k,)

    Returns
    -------
    mapping of str to float or str
    """
    return {
        key: variable.value(number)
        for variable, number in zip(variables, row.tolist(), strict=True)
        for key in variable.keys
    }
