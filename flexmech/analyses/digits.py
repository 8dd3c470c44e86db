"""Numbers as text: with the digits that their errors leave known, and no more."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

# Significant digits of an answer: no catalogue of bearings, motors or profiles has more.
MOST_DIGITS = 4
# Decimal places of a number with its error: more are below the solvers' own tolerance.
MOST_DECIMALS = 6

# Units of the last printed digit: it is known to half of what the digit before it counts.
_UNITS = 5.0
# Below it zeros behind the point are hard to count.
_PLAIN = 1e-3


def rounded(value: float, error: float, most: int = MOST_DIGITS) -> str:
    """A number to the last decimal place in which its error is at most five units.

    Parameters
    ----------
    value, error : float
        Both in one unit. An error that is not a number is not known, and not considered.
    most : int
        Significant digits at most.

    Returns
    -------
    str

    Examples
    --------
    >>> rounded(146.38, 0.6), rounded(1034.2, 20), rounded(0.030689, 4e-4), rounded(1.33e-5, 2e-7)
    ('146', '1030', '0.0307', '1.33e-05')
    """
    if not value or not math.isfinite(value):
        return f"{value + 0.0:g}"
    places = most - 1 - math.floor(math.log10(abs(value)))
    if math.isfinite(error) and error > 0:
        places = min(places, math.floor(math.log10(_UNITS / error)))
    if abs(value) < _PLAIN:
        return f"{value:.{max(places + math.floor(math.log10(abs(value))), 0)}e}"
    return f"{round(value, places) + 0.0:.{max(places, 0)}f}"


def plain(value: float) -> str:
    """A number that is known exactly: four digits, and whole numbers as they are.

    Parameters
    ----------
    value : float

    Returns
    -------
    str

    Examples
    --------
    >>> plain(10000.0), plain(271.426), plain(8.0)
    ('10000', '271.4', '8')
    """
    digits = f".{MOST_DIGITS}g"
    large = 10.0**MOST_DIGITS <= abs(value) < 10.0 ** (2 * MOST_DIGITS)
    return f"{value + 0.0:.0f}" if large else f"{value + 0.0:{digits}}"


def decimals_of(error: float) -> int:
    """Decimal places of a number that an error of it, rounded to one digit, leaves known."""
    if not (math.isfinite(error) and error > 0):
        return MOST_DECIMALS
    one_digit = float(f"{error:.0e}")
    return min(max(-math.floor(math.log10(one_digit)), 0), MOST_DECIMALS)


def with_error(value: float, error: float) -> str:
    """A number with its error, each to the last place that is known.

    Parameters
    ----------
    value, error : float
        Both in one unit; an error that is not a number is unknown, and not printed.

    Returns
    -------
    str

    Examples
    --------
    >>> with_error(43.6131, 0.011)
    '43.61 ± 0.01'
    """
    if not math.isfinite(error):
        return f"{value:.4g}"
    places = decimals_of(error)
    if error < 10.0**-MOST_DECIMALS:
        return f"{value:.{MOST_DECIMALS}g}"
    return f"{value:.{places}f} ± {float(f'{error:.0e}'):.{places}f}"


def percent(relative: float) -> str:
    """A relative error in percent, to two digits and rounded up.

    Parameters
    ----------
    relative : float

    Returns
    -------
    str

    Examples
    --------
    >>> percent(2.31e-4), percent(0.05), percent(0.0)
    ('0.024 %', '5 %', '0 %')
    """
    if not relative or not math.isfinite(relative):
        return f"{relative:g} %"
    value = 100 * relative
    place = 10.0 ** (math.floor(math.log10(value)) - 1)
    # A number that has two digits already is not rounded up by its last bit.
    return f"{math.ceil(round(value / place, 6)) * place:.6g} %"


@dataclass(frozen=True)
class Quantity:
    """A number of an answer, in its printed unit.

    Parameters
    ----------
    name : str
        What it is, such as ``"peak_deflection"``.
    value : float
    unit : str
        Empty for a pure number.
    error : float
        In the same unit; not a number where none is known.
    of : str
        Link, joint, mode or engine that it is of; may be empty.
    """

    name: str
    value: float
    unit: str
    error: float = math.nan
    of: str = ""

    def __str__(self) -> str:
        return f"{rounded(self.value, self.error)} {self.unit}".rstrip()

    def as_data(self) -> dict[str, Any]:
        """The same for JSON; what is not known is None."""
        known = math.isfinite(self.error)
        return {
            "name": self.name,
            "of": self.of or None,
            "value": self.value if math.isfinite(self.value) else None,
            "unit": self.unit,
            "error": self.error if known else None,
        }
