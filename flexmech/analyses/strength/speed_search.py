"""Crank speeds at which parts fail, where loads follow no power of the speed."""

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
# For links at rest in their frames. The secant through a load factor so near to 1 has its root
# to some 1e-4.
CLOSE = 0.01
# Speeds for each part, the least and the greatest of them over that asked for, how much a step may
# go beyond those known, and how near to where no equilibrium is found.
MOST, SLOWEST, FASTEST, STRIDE, NEAR_END = 25, 1e-3, 64.0, 3.0, 0.05


@dataclass(frozen=True)
class SpeedSearch:
    """Result of a search over the crank speed.

    Parameters
    ----------
    factor : ndarray, shape (S,)
        Factor of the crank speed, ascending.
    load_factor : ndarray, shape (S,)
        Least of all parts.
    part : list of str
        Whose it is.
    speed_factor : mapping of str to float
        At which a part fails, of those of which it was found.
    note : str
        Why the search ended before a part failed; empty where one did.
    """

    factor: FloatArray
    load_factor: FloatArray
    part: list[str]
    speed_factor: Mapping[str, float]
    note: str

    @classmethod
    def of(
        cls, weakest: Mapping[float, tuple[str, float]], found: Mapping[str, float], note: str
    ) -> SpeedSearch:
        """Result with the weakest part and its load factor at each factor of the speed.

        Parameters
        ----------
        weakest : mapping of float to tuple of str and float
        found : mapping of str to float
        note : str

        Returns
        -------
        SpeedSearch
        """
        factors = sorted(weakest)
        parts, least = zip(*(weakest[factor] for factor in factors), strict=True)
        return cls(np.array(factors), np.array(least), list(parts), found, note)


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
        Speed factor of the part that fails first, searched upwards alone: 1 where it fails at the
        speed itself already.
    """
    found: dict[float, tuple[str, float]] = {}

    def weakest(factor: float) -> float:
        found[factor] = _weakest(least(factor))
        return found[factor][1]

    note, low, high = "", 1.0, math.nan
    last = max(BEYOND * math.sqrt(start), BEYOND) if math.isfinite(start) else BEYOND
    for factor in np.linspace(1.0, last, STEPS).tolist():
        try:
            reached = weakest(factor)
        except ComputationError as error:
            note = _ended(factor, error)
            break
        if reached <= 1:
            high = factor
            break
        low = factor
    else:
        note = f"no part fails up to {last:.4g} times the speed"
    if math.isfinite(high):
        low, high = _halved(weakest, low, high)
    first = {} if math.isnan(high) else {found[high][0]: high}
    return SpeedSearch.of(found, first, note)


def search_roots(least: Least, now: Mapping[str, float]) -> SpeedSearch:
    """Find the crank speed at which each part fails, its load factor falling with the speed.

    The secant method in logarithms, in which the load factor of inertia alone is a straight line
    as long as links stay straight.

    Parameters
    ----------
    least : callable
    now : mapping of str to float
        Least load factor of each part at the speed itself.

    Returns
    -------
    SpeedSearch
        Speed factor of each part: zero where it fails at rest, none where it does not fail at any
        speed at which an equilibrium exists.
    """
    samples, end, note = {1.0: dict(now)}, FASTEST, ""
    found = {}
    for part in sorted(now, key=lambda each: now[each]):
        if now[part] == 0 or math.isinf(now[part]):
            found[part] = now[part]
            continue
        for _ in range(MOST):
            known = {factor: own[part] for factor, own in samples.items()}
            root, guess = _next_speed(known, end)
            if not math.isnan(root):
                found[part] = root
            if math.isnan(guess):
                break
            try:
                samples[guess] = dict(least(guess))
            except ComputationError as error:
                end, note = guess, _ended(guess, error)
    if unknown := [part for part in now if part not in found]:
        ended = note or f"ended at {FASTEST:.4g} times the speed"
        note = f"{ended}; up to there these do not fail: {', '.join(unknown)}"
    return SpeedSearch.of({f: _weakest(own) for f, own in samples.items()}, found, note)


def _next_speed(known: Mapping[float, float], end: float) -> tuple[float, float]:
    """Speed at which a load factor is 1, and the next one to try; each may be not a number.

    Both follow from load factors by the speed, and the speed from which on there are none.
    """
    high = min((factor for factor, value in known.items() if value <= 1), default=math.inf)
    low = max((factor for factor, value in known.items() if value > 1 and factor < high), default=0)
    # Nearest to the root first.
    points = sorted((abs(math.log(value)), factor) for factor, value in known.items() if value)
    near = points[0][1] if points else high
    if high < SLOWEST:
        return 0.0, math.nan
    if math.isinf(high) and low >= end / (1 + NEAR_END):
        return math.nan, math.nan
    power = -2.0
    if len(points) > 1:
        other = points[1][1]
        power = math.log(known[other] / known[near]) / math.log(other / near)
    guess = math.inf if low else 0.0
    if points and power < 0:
        guess = near * known[near] ** (-1 / power)
    if len(points) > 1 and points[0][0] < CLOSE:
        return guess if power < 0 else near, math.nan
    if math.isinf(high):
        # Not much farther than is known, and not where there is no equilibrium.
        guess = min(guess, STRIDE * low)
        return math.nan, guess if low < guess < end else (low + end) / 2
    if not low < guess < high:
        guess = math.sqrt(low * high) if low else high / 4
    return math.nan, guess


def _weakest(parts: Mapping[str, float]) -> tuple[str, float]:
    name = min(parts, key=lambda part: parts[part])
    return name, parts[name]


def _ended(factor: float, error: ComputationError) -> str:
    # What follows the colon is a remedy for the speed itself.
    reason = str(error).partition(": ")[0]
    return f"ended at {factor:.4g} times the speed: {reason}"


def _halved(weakest: Callable[[float], float], low: float, high: float) -> tuple[float, float]:
    """Narrow down where the least load factor passes 1."""
    for _ in range(HALVINGS if high > low else 0):
        middle = (low + high) / 2
        if weakest(middle) <= 1:
            high = middle
        else:
            low = middle
    return low, high
