"""Numbers that users give, refused by name and with the remedy where they are none."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import ROUND_OFF, FloatArray
from flexmech.errors import InputError
from flexmech.units import shown

_Item = TypeVar("_Item")


@dataclass(frozen=True)
class Bounds:
    """Between what a finite number must lie.

    Parameters
    ----------
    above, below : float, optional
        Which the number must not reach.
    least, most : float, optional
        Which the number may reach.
    """

    above: float | None = None
    least: float | None = None
    below: float | None = None
    most: float | None = None

    def hold(self, number: float) -> bool:
        """Whether a number is finite and within the bounds."""
        return (
            math.isfinite(number)
            and (self.above is None or number > self.above)
            and (self.least is None or number >= self.least)
            and (self.below is None or number < self.below)
            and (self.most is None or number <= self.most)
        )

    @property
    def words(self) -> str:
        """Condition on a number."""
        if self.below is None and self.most is None:
            if self.above is None and self.least is None:
                return "be a number"
            return "be zero or positive" if self.above is None else "be positive"
        low = f"at least {self.least:g}" if self.above is None else f"above {self.above:g}"
        if self.most is not None:
            return f"be {low} and at most {self.most:g}"
        if self.above is None:
            return f"be {low} and less than {self.below:g}"
        return f"lie between {self.above:g} and {self.below:g}"


# A full turn, with the rounding of angles that come from degrees.
_FULL_TURN = 2 * np.pi * (1 + ROUND_OFF)

_NUMBERS = (int, float, np.integer, np.floating)
# Which Python and NumPy count among them: a span of time is an integer to NumPy.
_NO_NUMBERS = (bool, np.timedelta64)
_ADDRESS = re.compile(" at 0x[0-9a-f]+")

FINITE = Bounds()
POSITIVE = Bounds(above=0.0)
NOT_NEGATIVE = Bounds(least=0.0)


def check_number(value: object, name: str, unit: str = "", bounds: Bounds = FINITE) -> None:
    """Refuse what is no number or out of bounds.

    Parameters
    ----------
    value : object
    name : str
        What messages call it.
    unit : str
        SI unit in which it is given; empty for a ratio.
    bounds : Bounds

    Raises
    ------
    InputError
    """
    if isinstance(value, _NO_NUMBERS) or not isinstance(value, _NUMBERS):
        raise InputError(_no_number(value, name, unit))
    if not bounds.hold(float(value)):
        raise InputError(f"{name} must {bounds.words}, got {value} {unit}".rstrip())


def checked_number(value: object, name: str, unit: str = "", bounds: Bounds = FINITE) -> float:
    """Take a number; refuse what :func:`check_number` refuses.

    Parameters
    ----------
    value : object
    name : str
        What messages call it.
    unit : str
        SI unit in which it is given; empty for a ratio.
    bounds : Bounds

    Returns
    -------
    float
    """
    check_number(value, name, unit, bounds)
    return float(value)  # type: ignore[arg-type]


def check_fields(
    record: object,
    units: Mapping[str, str],
    bounds: Bounds = FINITE,
    of: str = "",
    *,
    optional: bool = False,
) -> None:
    """Refuse fields of a record that are no numbers or out of bounds.

    Parameters
    ----------
    record : object
    units : mapping of str to str
        SI unit of each field that is looked at, by its name.
    bounds : Bounds
    of : str
        What messages add to the names of the fields, such as ``"of a ply"``.
    optional : bool
        Whether fields may be None.

    Raises
    ------
    InputError
    """
    for name, unit in units.items():
        value = getattr(record, name)
        if not (optional and value is None):
            check_number(value, f"{name} {of}".rstrip(), unit, bounds)


def check_instance(value: object, kind: type, name: str, remedy: str) -> None:
    """Refuse what is of another type.

    Parameters
    ----------
    value : object
    kind : type
    name : str
        What messages call it.
    remedy : str
        What to give instead.

    Raises
    ------
    InputError
    """
    if not isinstance(value, kind):
        raise InputError(f"{name} must be a {kind.__name__}, got {_shown(value)}; {remedy}")


def check_pair(values: object, name: str, unit: str = "") -> None:
    """Refuse what is not two finite numbers.

    Parameters
    ----------
    values : object
    name : str
        What messages call them.
    unit : str
        SI unit in which they are given.

    Raises
    ------
    InputError
    """
    pair = values.shape == (2,) if isinstance(values, np.ndarray) else isinstance(values, Sequence)
    if not pair or len(values) != 2:  # type: ignore[arg-type]
        raise InputError(f"{name} must be two numbers, got {_shown(values)}")
    for value in values:  # type: ignore[attr-defined]
        check_number(value, name, unit)


def check_choice(value: object, known: Collection[str], name: str) -> None:
    """Refuse a word that is none of those known.

    Parameters
    ----------
    value : object
    known : collection of str
    name : str
        Name of the argument.

    Raises
    ------
    InputError
        Names the argument and lists the words.
    """
    if not isinstance(value, str) or value not in known:
        raise InputError(f"{name} must be one of {', '.join(known)}, got {_shown(value)}")


def check_flag(value: object, name: str) -> None:
    """Refuse values that are neither True nor False: arrays, text and numbers."""
    if not isinstance(value, bool | np.bool_):
        raise InputError(f"{name} must be True or False, got {_shown(value)}")


def checked_tuple(
    values: Iterable[_Item], kind: type | tuple[type, ...], name: str, remedy: str
) -> tuple[_Item, ...]:
    """Things of one type as a tuple.

    Parameters
    ----------
    values : iterable
    kind : type or tuple of types
    name : str
        What messages call them.
    remedy : str
        What to give instead.

    Returns
    -------
    tuple

    Raises
    ------
    InputError
        If it is a single thing or text, or something else is among them.
    """
    scalar = getattr(values, "ndim", None) == 0
    if isinstance(values, str | bytes | type) or scalar or not isinstance(values, Iterable):
        raise InputError(f"{name} must be a sequence, got {_shown(values)}; {remedy}")
    items = tuple(values)
    for item in items:
        if not isinstance(item, kind):
            raise InputError(f"{name} holds {_shown(item)}; {remedy}")
    return items


def check_count(
    value: object, name: str, least: int = 1, unit: str = "", most: int | None = None
) -> None:
    """Refuse what is no whole number, too few or too many.

    Parameters
    ----------
    value : object
    name : str
        Name of the argument.
    least : int
    unit : str
        What the count is taken over, such as ``"a revolution"``.
    most : int, optional
        More than these do not fit into memory.

    Raises
    ------
    InputError
        Names the argument and its least number.
    """
    counts = isinstance(value, int | np.integer) and not isinstance(value, _NO_NUMBERS)
    number = int(value) if counts else None  # type: ignore[call-overload]
    if number is not None and number >= least:
        if most is not None and number > most:
            wanted = f"{name} must be at most {most} {unit}".rstrip()
            raise InputError(f"{wanted}, got {_shown(value)}")
        return
    wanted = f"{name} must be {least} or more {unit}".rstrip()
    raise InputError(f"{wanted}, got {_shown(value)}")


def check_angle(value: object, name: str) -> None:
    """Refuse what is no angle of a point or a fibre in rad, degrees above all.

    Parameters
    ----------
    value : object
    name : str
        What messages call it.

    Raises
    ------
    InputError
        If it is no number, or more than a full turn either way.
    """
    check_number(value, name, "rad")
    if abs(float(value)) > _FULL_TURN:  # type: ignore[arg-type]
        raise InputError(
            f"{name} must be at most a full turn either way, got {value} rad; for degrees give "
            f"np.radians({value})"
        )


def checked_array(values: ArrayLike, name: str, unit: str = "") -> FloatArray:
    """Numbers as an array.

    Parameters
    ----------
    values : array_like
    name : str
        What messages call them.
    unit : str
        SI unit in which they are given.

    Returns
    -------
    ndarray

    Raises
    ------
    InputError
        If one is no finite number, or masked.
    """
    try:
        array = values if isinstance(values, np.ndarray) else np.asarray(values)
    except (TypeError, ValueError) as error:
        raise InputError(_no_number(values, name, unit)) from error
    if array.dtype.kind not in "iuf" or np.ma.is_masked(array):
        raise InputError(_no_number(values, name, unit))
    # A number of more digits may be beyond those of double precision.
    with np.errstate(over="ignore"):
        numbers = np.asarray(array, dtype=float)
    if not np.isfinite(numbers).all():
        wrong = array[~np.isfinite(numbers)].flat[0]
        raise InputError(f"{name} must be finite numbers, got {wrong} {unit}".rstrip())
    return numbers


def _no_number(value: object, name: str, unit: str) -> str:
    wanted = f"number of {unit}" if unit else "number"
    remedy = "give it without quotes; units are for model files"
    if not isinstance(value, str):
        remedy = "give int, float or an array of them, without missing values"
    return f"{name} must be a {wanted}, got {_shown(value)}; {remedy}"


def _shown(value: object) -> str:
    """Write a value in one line."""
    return _ADDRESS.sub("", " ".join(shown(value).split()))
