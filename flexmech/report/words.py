"""Words and numbers that panels share: speeds, states, engines, errors."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from flexmech.report.results import Results
from flexmech.units import from_si

# More decimals are below the solver's own tolerance.
MOST_DECIMALS = 6
DRY = "dry"


def speed_unit_of(results: Results) -> str:
    """Unit in which a report speaks of crank speeds: that of its first result with speeds."""
    return results.attribute("speed_unit") or "rad/s"


def speed_name(speed: float, unit: str) -> str:
    """A crank speed in rad/s as the reader chooses it."""
    return f"{from_si(speed, unit):.6g} {unit}"


def state_of(attributes: Mapping[str, object]) -> str:
    """State in which a result was computed, in the words of results with two states.

    Parameters
    ----------
    attributes : mapping
        Of a dataset.

    Returns
    -------
    str
    """
    first = str(attributes.get("environment_lines", "")).partition("\n")[0]
    _, told, state = first.partition("state: ")
    return state if told else DRY


def decimals_of(error: float) -> int:
    """Decimal places of a number that an error of it, rounded to one digit, leaves known."""
    if not (math.isfinite(error) and error > 0):
        return MOST_DECIMALS
    one_digit = float(f"{error:.0e}")
    return int(np.clip(-math.floor(math.log10(one_digit)), 0, MOST_DECIMALS))


def with_error(value: float, error: float) -> str:
    """A number with its error, each to the last place that is known.

    Parameters
    ----------
    value, error : float
        Both in one unit; an error that is not a number is not known, and not told.

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
