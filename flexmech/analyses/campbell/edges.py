"""The speeds at which rays meet ends of bands, by real solutions.

A band's end is a lowest or highest frequency over the crank angle. Near a crossing both speed and
angle are unknown: three crank angles around each extreme that may be the band's end give a
parabola, its vertex the frequency there, and that a better speed by the secant method.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from flexmech.analyses.campbell.bands import Bands, BandSolver
from flexmech.analyses.campbell.crossings import LOWEST, Edge, ray
from flexmech.analyses.campbell.sampling import SampledBands
from flexmech.analyses.frequencies.formulation import Systems
from flexmech.analyses.frequencies.frequency_map import frequencies_along
from flexmech.arrays import FloatArray, IntArray

logger = logging.getLogger(__name__)

# Relative change of the speed in the last round, and relative distance of ray and band then.
CONVERGED = 1e-8
# The secant doubles the digits in less than two rounds; what has not converged is sought anew.
MOST_ROUNDS = 20
# Of the crank angles around an extreme, in steps of the grid: at first, and at last, where the
# parabola through three of them is the curve to nine digits.
FIRST_ASIDE, LAST_ASIDE = 0.5, 0.04
# Relative differences of frequencies below this are their round-off.
ROUND_OFF = 1e-10
# Extremes on the grid at a solved speed that may be the band's end a little further on: as near to
# it as this many times what the end moves by until the next solved speed, and relatively. A grid
# misses the peak of a sharp one by one or two per cent.
MAY_BE_END, NEAR_END = 2.0, 0.02
# A band seldom has more that are nearly as low; those missed are found by whole turns. Speed alone
# beyond three.
MOST_EXTREMES = 3
# By this part of its step's width a speed may be outside it on the way: the secant comes back from
# there, and beyond there may be no solution.
OUTSIDE = 0.5


@dataclass
class _Search:
    """Speeds and crank angles of c extremes that are tracked to where they meet a ray.

    Parameters
    ----------
    owner : ndarray of int, shape (c,)
        Number of the edge.
    sign : ndarray, shape (c,)
        1 for the lowest frequency of a band, -1 for the highest.
    mode : ndarray of int, shape (c,)
    order, low, high : ndarray, shape (c,)
        Of the ray, and the ends of the step in speed.
    speed, slope : ndarray, shape (c,)
        Where the extreme meets the ray, and how it changes with speed.
    angle, aside : ndarray, shape (c,)
        Of the extreme, and of the angles on both sides of it; 0 at an end of the crank angles.
    last : ndarray, shape (2, c)
        Speed and frequency of the round before; not a number before the first.
    off : ndarray, shape (c,)
        Relative distance of ray and extreme.
    converged : ndarray of bool, shape (c,)
    """

    owner: IntArray
    sign: FloatArray
    mode: IntArray
    order: FloatArray
    low: FloatArray
    high: FloatArray
    speed: FloatArray
    slope: FloatArray
    angle: FloatArray
    aside: FloatArray
    last: FloatArray
    off: FloatArray
    converged: NDArray[np.bool_]

    def advance(self, systems: Systems, least_aside: float) -> None:
        """One round of those that have not converged."""
        these = np.flatnonzero(~self.converged)
        extreme, certain = self._narrowed(systems, these, least_aside)
        speed, ray_slope = self.speed[these], self.order[these] / (2 * np.pi)
        target = ray_slope * np.abs(speed)
        moved = speed - self.last[0, these]
        use = certain & (np.abs(moved) > 1e-5 * np.abs(speed))
        secant = (extreme - self.last[1, these]) / np.where(use, moved, 1.0)
        self.slope[these] = np.where(use, secant, self.slope[these])
        self.last[:, these] = np.where(certain, [speed, extreme], self.last[:, these])
        change = (extreme - target) / (ray_slope * np.sign(speed) - self.slope[these])
        width = OUTSIDE * (self.high - self.low)[these]
        new = np.clip(speed + change, self.low[these] - width, self.high[these] + width)
        self.speed[these] = np.where(certain, new, speed)
        self.off[these] = np.abs(extreme / target - 1)
        small = np.abs(new - speed) <= CONVERGED * np.abs(new)
        narrow = self.aside[these] <= least_aside
        # One that would meet the ray far from this step only is left.
        left = (new == speed) & (np.abs(change) > width)
        self.converged[these] = left | (certain & small & narrow & (self.off[these] <= CONVERGED))

    def _narrowed(
        self, systems: Systems, these: IntArray, least_aside: float
    ) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Extremes (k,) of some, and whether they are known; their angles come nearer."""
        sign, aside = self.sign[these], self.aside[these]
        angle = self.angle[these] + np.array([[-1.0], [0.0], [1.0]]) * aside
        speed = np.broadcast_to(self.speed[these], angle.shape)
        found = frequencies_along(systems, angle.ravel(), speed.ravel())
        found = found.reshape(*angle.shape, -1)[:, np.arange(len(these)), self.mode[these]]
        before, here, behind = sign * found
        slope, bend = (behind - before) / 2, before - 2 * here + behind
        level = np.maximum(np.abs(slope), np.abs(bend)) <= ROUND_OFF * np.abs(here)
        vertex = ~level & (bend > 0) & (np.abs(slope) <= bend)
        bend = np.where(vertex, bend, 1.0)
        move = np.where(vertex, -slope / bend, np.where(level, 0.0, -np.sign(slope)))
        self.angle[these] += move * aside
        certain = vertex | level
        self.aside[these] = np.where(
            certain, np.maximum(aside / 4, np.minimum(least_aside, aside)), aside
        )
        lowest = np.where(vertex, here - slope**2 / (2 * bend), np.minimum(before, behind))
        return sign * np.where(level, here, lowest), certain


def exact_edges(
    solver: BandSolver, sampled: SampledBands, edges: list[Edge]
) -> tuple[dict[Edge, float], float]:
    """Speeds of edges, and how far the rays are off there.

    Parameters
    ----------
    solver : BandSolver
    sampled : SampledBands
    edges : list of Edge
        On its grid.

    Returns
    -------
    dict of Edge to float
        rad/s.
    float
        Greatest relative distance of ray and band.
    """
    if not edges:
        return {}, 0.0
    step = float(np.max(np.diff(solver.crank_angles), initial=np.radians(1.0)))
    search = _begin(solver, sampled, edges, FIRST_ASIDE * step)
    for _ in range(MOST_ROUNDS):
        if search.converged.all():
            break
        search.advance(solver.systems, LAST_ASIDE * step)
    margin = CONVERGED * np.abs(search.high)
    inside = (search.speed >= search.low - margin) & (search.speed <= search.high + margin)
    found, off = {}, 0.0
    for number, edge in enumerate(edges):
        own = np.flatnonzero((search.owner == number) & search.converged & inside)
        if not len(own):
            logger.info("%s is searched for over all crank angles", edge)
            found[edge] = _by_whole_turns(solver, sampled.crank_speed, edge)
            continue
        # A ray enters a band at the first of its extremes, and has left it behind the last.
        chosen = own[(np.argmin if edge.enters else np.argmax)(search.speed[own])]
        found[edge] = float(search.speed[chosen])
        off = max(off, float(search.off[chosen]))
    return found, off


def _begin(solver: BandSolver, sampled: SampledBands, edges: list[Edge], aside: float) -> _Search:
    """Extremes that may be the ends of bands, and first guesses of the speeds."""
    rows: list[tuple[float, ...]] = []
    for number, edge in enumerate(edges):
        step = slice(edge.place, edge.place + 2)
        speed, ends = sampled.crank_speed[step], sampled.values[step, edge.end, edge.branch - 1]
        off = ends - ray(edge.order, speed)
        part = float(np.clip(off[0] / (off[0] - off[1]), 0.0, 1.0))
        guess, slope = speed[0] + part * (speed[1] - speed[0]), np.diff(ends) / np.diff(speed)
        for angle, inside in _extremes_near(solver, sampled.solved, edge, speed):
            rows.append((number, edge.order, *speed, guess, slope[0], angle, aside * inside))
    owner, order, low, high, guess, slope, angle, asides = np.array(rows, dtype=float).T.copy()
    number = owner.astype(np.intp)
    return _Search(
        owner=number,
        sign=np.array([1.0 if edge.end == LOWEST else -1.0 for edge in edges])[number],
        mode=np.array([edge.branch - 1 for edge in edges])[number],
        order=order,
        low=low,
        high=high,
        speed=guess,
        slope=slope,
        angle=angle,
        aside=asides,
        last=np.full((2, len(owner)), np.nan),
        off=np.full(len(owner), np.inf),
        converged=np.zeros(len(owner), dtype=bool),
    )


def _extremes_near(
    solver: BandSolver, solved: Bands, edge: Edge, step: FloatArray
) -> list[tuple[float, bool]]:
    """Crank angles of extremes around a step, and whether each is inside the crank angles."""
    grid, full_turn = solver.crank_angles, solver.full_turn
    sign = 1.0 if edge.end == LOWEST else -1.0
    below = int(np.searchsorted(solved.crank_speed, step[0], side="right")) - 1
    above = min(int(np.searchsorted(solved.crank_speed, step[1])), len(solved.crank_speed) - 1)
    rows = sorted({below, above})
    ends = solved.values[rows, edge.end, edge.branch - 1]
    near = MAY_BE_END * float(np.ptp(ends)) + NEAR_END * float(ends.max())
    angles = solved.angle[rows, 0 if edge.end == LOWEST else 1, edge.branch - 1].tolist()
    for row in rows:
        value = sign * solved.frequency[row, :, edge.branch - 1]
        around = np.pad(value, 1, mode="wrap" if full_turn else "edge")
        lowest = (value <= around[:-2]) & (value <= around[2:]) & (value <= value.min() + near)
        places = np.flatnonzero(lowest)
        angles += grid[places[np.argsort(value[places])][:MOST_EXTREMES]].tolist()
    width = float(np.max(np.diff(grid), initial=0.0))
    found: list[float] = []
    for angle in angles:
        apart = np.abs(np.array(found) - angle)
        if full_turn:
            apart = np.minimum(apart, 2 * np.pi - apart)
        # The same extreme moves by a step at most from one solved speed to the next, mostly.
        if not np.any(apart <= width):
            found.append(angle)
    return [(angle, full_turn or grid[0] < angle < grid[-1]) for angle in found]


def _by_whole_turns(solver: BandSolver, grid: FloatArray, edge: Edge) -> float:
    """Speed of an edge by solutions over all crank angles (Brent's method)."""

    def distance(crank_speed: float) -> float:
        bands = solver.solve(np.array([crank_speed]))
        if not len(bands.crank_speed):
            raise solver.reason(crank_speed)
        end = float(bands.values[0, edge.end, edge.branch - 1])
        return end - float(ray(edge.order, crank_speed))

    low, high = grid[edge.place : edge.place + 2].tolist()
    at_low, at_high = distance(low), distance(high)
    if at_low * at_high > 0:
        # The fit put it into this step, and the solution has it at one of the ends.
        return float(low if abs(at_low) < abs(at_high) else high)
    return float(brentq(distance, low, high, xtol=CONVERGED * high))
