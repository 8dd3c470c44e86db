"""The damping ratio that closes an unstable band."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.optimize

from flexmech.analyses.stability.solver import LinkageSolver
from flexmech.analyses.stability.vibrating_linkage import VibratingLinkage

__all__ = ["ClosingSearch", "closing_damping_ratio"]

# Relative.
RATIO_TOLERANCE = 1e-5
LARGEST_RATIO = 1.0
# Speeds to either side of the last one, relative to the width, and how often they are moved.
ASIDE, LEAST_ASIDE, PASSES = 0.2, 0.005, 4


@dataclass(frozen=True)
class ClosingSearch:
    """A band whose closing is sought.

    Parameters
    ----------
    solver : LinkageSolver
        With damping such that its factor is the damping ratio.
    crank_speed : float
        Where the vibration grows most, rad/s.
    lower, upper : float
        Ends of the band in rad/s.
    start : float
        Damping ratio at which it grows.
    """

    solver: LinkageSolver
    crank_speed: float
    lower: float
    upper: float
    start: float


def closing_damping_ratio(search: ClosingSearch) -> float:
    """Smallest damping ratio above which nothing grows at the speeds about a band.

    The speed at which the last growth ends is followed: damping moves it.

    Parameters
    ----------
    search : ClosingSearch

    Returns
    -------
    float
        NaN if a damping ratio of 1 does not close the band.
    """
    speed, ratio, width = search.crank_speed, search.start, search.upper - search.lower
    for _ in range(PASSES):
        ratio = _ratio_at(search.solver, speed, ratio)
        if np.isnan(ratio):
            return ratio
        # Not beyond the band: there may be no equilibrium.
        aside = min(ASIDE * width, speed - search.lower, search.upper - speed)
        if aside <= LEAST_ASIDE * width:
            return ratio
        here, below, above = (
            search.solver.growth_at(search.solver.moving(w), ratio)
            for w in (speed, speed - aside, speed + aside)
        )
        if max(below, above) > here:
            speed += aside if above > below else -aside
            ratio = search.start
            continue
        bow = 2 * here - below - above
        top = speed + aside * (above - below) / (2 * bow) if bow > 0 else speed
        return _ratio_at(search.solver, top, ratio * 0.9)
    return _ratio_at(search.solver, speed, ratio)


def _ratio_at(solver: LinkageSolver, crank_speed: float, start: float) -> float:
    """Largest damping ratio from a start at which a vibration grows at one speed."""
    moving: VibratingLinkage = solver.moving(crank_speed)

    def growth(ratio: float) -> float:
        return solver.growth_at(moving, ratio)

    low, step = start, max(0.5 * start, 1e-4)
    if growth(low) <= 0:
        low = 0.0
    high = low + step
    while growth(high) > 0:
        low, step = high, 2 * step
        high = low + step
        if low > LARGEST_RATIO:
            return float("nan")
    if low == 0.0 and growth(1e-9) <= 0:
        return 0.0
    return float(scipy.optimize.brentq(growth, max(low, 1e-9), high, rtol=RATIO_TOLERANCE))
