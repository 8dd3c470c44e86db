"""The crank speed at which a part fails first, where loads follow no power of the speed."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.errors import ComputationError

Least = Callable[[float], Mapping[str, float]]
"""From a factor of the crank speed to the least load factor of each part."""

# Speeds up to which loads of inertia alone would break a part, and somewhat beyond; a resonance
# narrower than a step may lie between two of them, which the result says.
STEPS, BEYOND = 24, 1.1
# Each halves the step in which a part fails: then the speed is known to a thousandth of the range.
HALVINGS = 6


@dataclass(frozen=True)
class SpeedSearch:
    """What was found over the crank speed.

    Parameters
    ----------
    factor : ndarray, shape (S,)
        Of the crank speed, ascending.
    load_factor : ndarray, shape (S,)
        Least of all parts.
    part : list of str
        Whose it is.
    speed_factor : float
        At which the first part fails; not a number where none does up to the last speed.
    note : str
        Why the search ended before a part failed; empty where one did.
    """

    factor: FloatArray
    load_factor: FloatArray
    part: list[str]
    speed_factor: float
    note: str

    @property
    def first(self) -> str:
        """Part that fails first; empty where none does."""
        if math.isnan(self.speed_factor):
            return ""
        return self.part[int(np.flatnonzero(self.load_factor <= 1)[0])]


def search_speed(least: Least, start: float) -> SpeedSearch:
    """Raise the crank speed until a part fails.

    Parameters
    ----------
    least : callable
    start : float
        Least load factor at the speed itself: with the square of the speed, loads would reach it at
        its root.

    Returns
    -------
    SpeedSearch
        The speed factor is 1 where a part fails at the speed itself already, which is searched
        upwards alone.
    """
    found: dict[float, tuple[float, str]] = {}

    def weakest(factor: float) -> float:
        parts = least(factor)
        name = min(parts, key=lambda part: parts[part])
        found[factor] = parts[name], name
        return parts[name]

    note, low, high = "", 1.0, math.nan
    last = max(BEYOND * math.sqrt(start), BEYOND) if math.isfinite(start) else BEYOND
    for factor in np.linspace(1.0, last, STEPS).tolist():
        try:
            reached = weakest(factor)
        except ComputationError as error:
            note = f"ended at {factor:.4g} times the speed: {error.message}"
            break
        if reached <= 1:
            high = factor
            break
        low = factor
    else:
        note = f"no part fails up to {last:.4g} times the speed"
    if math.isfinite(high):
        low, high = _halved(weakest, low, high)
    factors = sorted(found)
    return SpeedSearch(
        np.array(factors),
        np.array([found[factor][0] for factor in factors]),
        [found[factor][1] for factor in factors],
        high,
        note,
    )


def _halved(weakest: Callable[[float], float], low: float, high: float) -> tuple[float, float]:
    """Narrow down where the least load factor passes 1."""
    for _ in range(HALVINGS if high > low else 0):
        middle = (low + high) / 2
        if weakest(middle) <= 1:
            high = middle
        else:
            low = middle
    return low, high
