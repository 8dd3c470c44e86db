"""The damping ratio that closes an unstable band."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
import scipy.optimize

from flexmech.analyses.stability.solver import LinkageSolver
from flexmech.analyses.stability.vibrating_linkage import VibratingLinkage

# Relative.
RATIO_TOLERANCE = 1e-5
LARGEST_RATIO, LEAST_RATIO = 1.0, 1e-9
# The first step from the start relative to it, and its least size; a next one at most this many
# times the last, and this much farther than a straight line through the last two asks for.
FIRST_STEP, LEAST_STEP = 0.1, 1e-4
FARTHEST, BEYOND = 16.0, 1.05
# Speeds to either side of the last one, relative to the width, and how often they are moved.
ASIDE, LEAST_ASIDE, PASSES = 0.2, 0.005, 4


@dataclass(frozen=True)
class ClosingSearch:
    """A band whose closing is sought.

    Parameters
    ----------
    crank_speed : float
        Where the vibration grows most, rad/s.
    lower, upper : float
        Ends of the band in rad/s.
    start : float
        Damping ratio at which it grows.
    """

    crank_speed: float
    lower: float
    upper: float
    start: float


def closing_damping_ratio(solver: LinkageSolver, search: ClosingSearch) -> float:
    """Smallest damping ratio above which nothing grows at the speeds about a band.

    The speed at which the last growth ends is followed: damping moves it.

    Parameters
    ----------
    solver : LinkageSolver
        With damping such that its factor is the damping ratio.
    search : ClosingSearch

    Returns
    -------
    float
        NaN if a damping ratio of 1 does not close the band.
    """
    speed, ratio, width = search.crank_speed, search.start, search.upper - search.lower
    for _ in range(PASSES):
        ratio = _ratio_at(solver, speed, ratio)
        if np.isnan(ratio):
            return ratio
        # Not beyond the band: there may be no equilibrium.
        aside = min(ASIDE * width, speed - search.lower, search.upper - speed)
        if aside <= LEAST_ASIDE * width:
            return ratio
        here, below, above = (
            solver.growth_at(solver.moving(w), ratio) for w in (speed, speed - aside, speed + aside)
        )
        if max(below, above) > here:
            speed += aside if above > below else -aside
            ratio = search.start
            continue
        bow = 2 * here - below - above
        top = speed + aside * (above - below) / (2 * bow) if bow > 0 else speed
        return _ratio_at(solver, top, ratio * 0.9)
    return _ratio_at(solver, speed, ratio)


def _ratio_at(solver: LinkageSolver, crank_speed: float, start: float) -> float:
    """Largest damping ratio from a start at which a vibration grows at one speed."""
    moving: VibratingLinkage = solver.moving(crank_speed)

    @cache
    def growth(ratio: float) -> float:
        return solver.growth_at(moving, ratio)

    low, high = start, start + max(FIRST_STEP * start, LEAST_STEP)
    if growth(low) <= 0:
        low = 0.0
    while growth(high) > 0:
        if high > LARGEST_RATIO:
            return float("nan")
        low, high = high, _beyond(growth, low, high)
    if low < LEAST_RATIO:
        # Also a start that is less than it, at which a vibration still grows.
        if growth(LEAST_RATIO) <= 0:
            return 0.0
        low = LEAST_RATIO
    return float(scipy.optimize.brentq(growth, low, high, rtol=RATIO_TOLERANCE))


def _beyond(growth: Callable[[float], float], low: float, high: float) -> float:
    """A damping ratio above ``high`` at which it seems that nothing grows.

    Damping takes growth off nearly in proportion: a straight line tells where none is left.
    """
    slope = (growth(high) - growth(low)) / (high - low)
    least = high + (high - low)
    most = high + FARTHEST * (high - low)
    if slope >= 0:
        return most
    return min(max(high - BEYOND * growth(high) / slope, least), most)
