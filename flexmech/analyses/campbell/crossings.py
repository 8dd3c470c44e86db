"""Where the rays of the crank's orders meet the bands of the branches, on a grid of speeds.

The ray of order n is ``n |W| / 2 pi``. At a speed it is below a branch's band, inside, or above.
It passes the band's lowest or highest frequency in a step of the grid over which that changes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray, IntArray, unbroken_runs

# Rows of both ends of a band.
LOWEST, HIGHEST = 0, 2
# A ray that meets no band but comes as near as this, relatively, is told.
NEAR_MISS = 0.1


@dataclass(frozen=True)
class Edge:
    """A step of the grid in which a ray meets an end of a band.

    Parameters
    ----------
    order, branch : int
        Counted from 1.
    end : int
        Row of the band's values: 0 the lowest, 2 the highest frequency.
    place : int
        Number of the speed before the step.
    enters : bool
        Whether the ray comes into the band with rising speed.
    """

    order: int
    branch: int
    end: int
    place: int
    enters: bool


@dataclass(frozen=True)
class CriticalSpeed:
    """Speeds from and to which an order meets a branch.

    Parameters
    ----------
    order, branch : int
        Counted from 1.
    start, end : float
        rad/s. Both are the nearest speed where the order does not meet the branch.
    gap : float
        Least distance of ray and band over the frequency of the band; 0 where they meet.
    starts_inside, ends_inside : bool
        Whether the ray is inside the band already at the first speed, or still at the last one,
        of those with a solution.
    amplification : float
        By how much the running linkage is amplified in the range; infinite without damping, not a
        number where it is not known.
    resonance : float
        Speed in the range in rad/s at which it is amplified most; not a number where that is not
        known, or without damping.
    """

    order: int
    branch: int
    start: float
    end: float
    gap: float = 0.0
    starts_inside: bool = False
    ends_inside: bool = False
    amplification: float = np.nan
    resonance: float = np.nan


def ray(order: int | FloatArray, crank_speed: FloatArray | float) -> FloatArray:
    """Frequency of an order of the crank in Hz, at speeds in rad/s."""
    return np.asarray(order * np.abs(crank_speed) / (2 * np.pi), dtype=float)


def edges_of(crank_speed: FloatArray, values: FloatArray, orders: IntArray) -> list[Edge]:
    """Steps in which rays meet the ends of bands.

    Parameters
    ----------
    crank_speed : ndarray, shape (G,)
        Ascending, rad/s.
    values : ndarray, shape (G, 3, m)
        Lowest, mean and highest frequency; not a number where there is none.
    orders : ndarray of int, shape (o,)

    Returns
    -------
    list of Edge
        Of each order and branch along the speed.
    """
    found = []
    for order in orders.tolist():
        for branch in range(values.shape[2]):
            side = _side(crank_speed, values, order, branch)
            for stretch in unbroken_runs(np.isfinite(side)):
                for place in stretch[:-1]:
                    before, after = side[place], side[place + 1]
                    ends = _ends_between(before, after)
                    found += [
                        Edge(order, branch + 1, end, place, enters=enters) for end, enters in ends
                    ]
    return found


def critical_speeds(
    crank_speed: FloatArray,
    values: FloatArray,
    orders: IntArray,
    edges: dict[Edge, float],
) -> list[CriticalSpeed]:
    """Ranges of speed in which orders meet branches, and near misses.

    Parameters
    ----------
    crank_speed, values, orders
        As of :func:`edges_of`.
    edges : dict of Edge to float
        And the speeds in rad/s at which they are.

    Returns
    -------
    list of CriticalSpeed
        By order, branch and speed.
    """
    found = []
    for order in orders.tolist():
        for branch in range(values.shape[2]):
            side = _side(crank_speed, values, order, branch)
            own = [(e, w) for e, w in edges.items() if (e.order, e.branch) == (order, branch + 1)]
            ranges = []
            for stretch in unbroken_runs(np.isfinite(side)):
                here = [(e, w) for e, w in own if stretch[0] <= e.place < stretch[-1]]
                ends = float(crank_speed[stretch[0]]), float(crank_speed[stretch[-1]])
                ranges += _ranges(order, branch + 1, here, ends, inside=side[stretch[0]] == 0)
            found += ranges or _near_miss(crank_speed, values, order, branch)
    return found


def _side(crank_speed: FloatArray, values: FloatArray, order: int, branch: int) -> FloatArray:
    """Where a ray is at each speed: -1 below the band, 0 inside, 1 above; or not a number."""
    frequency = ray(order, crank_speed)
    lowest, highest = values[:, LOWEST, branch], values[:, HIGHEST, branch]
    side = np.where(frequency < lowest, -1.0, np.where(frequency > highest, 1.0, 0.0))
    return np.where(np.isfinite(lowest), side, np.nan)


def _ends_between(before: float, after: float) -> list[tuple[int, bool]]:
    """Ends of the band that a ray passes in a step, and whether it enters there."""
    if before == after:
        return []
    first = LOWEST if before < after else HIGHEST
    last = HIGHEST if before < after else LOWEST
    enters = [(first, True)] if before != 0 else []
    return enters + ([(last, False)] if after != 0 else [])


def _ranges(
    order: int,
    branch: int,
    edges: list[tuple[Edge, float]],
    ends: tuple[float, float],
    *,
    inside: bool,
) -> list[CriticalSpeed]:
    """Ranges between the edges along one stretch of speeds without a gap."""
    start = ends[0] if inside else None
    cut, found = inside, []
    for edge, speed in edges:
        if edge.enters:
            start, cut = speed, False
        elif start is not None:
            # Of a band without width both ends are the same but for round-off.
            low, high = sorted((start, speed))
            found.append(CriticalSpeed(order, branch, low, high, starts_inside=cut))
            start = None
    if start is not None:
        last = CriticalSpeed(order, branch, start, ends[1], starts_inside=cut, ends_inside=True)
        found.append(last)
    return found


def _near_miss(
    crank_speed: FloatArray, values: FloatArray, order: int, branch: int
) -> list[CriticalSpeed]:
    """The nearest that a ray comes to a band that it does not meet, if that is near."""
    frequency = ray(order, crank_speed)
    lowest, highest = values[:, LOWEST, branch], values[:, HIGHEST, branch]
    gap = np.maximum(1 - frequency / lowest, frequency / highest - 1)
    if not np.isfinite(gap).any():
        return []
    place = int(np.nanargmin(gap))
    if gap[place] > NEAR_MISS:
        return []
    speed = float(crank_speed[place])
    return [CriticalSpeed(order, branch + 1, speed, speed, float(gap[place]))]
