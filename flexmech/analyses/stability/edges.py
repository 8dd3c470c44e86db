"""Edges of unstable bands, with what steps, reduction and mesh make them wrong by."""

from __future__ import annotations

from dataclasses import dataclass

import scipy.optimize

from flexmech.analyses.stability.band import BandEdge
from flexmech.analyses.stability.kept_modes import KeptModes
from flexmech.analyses.stability.signed_growth import SignedGrowth
from flexmech.analyses.stability.solver import BY_REFINEMENT, LinkageSolver
from flexmech.errors import ComputationError

__all__ = ["EdgeSearch", "find_edge", "find_top"]

# Relative to the crank speed.
EDGE_TOLERANCE = 1e-8
MOST_STEPS = 60
# The fastest speed of a band, relative to its width.
TOP_TOLERANCE, MOST_TRIES = 0.02, 12
# The slope is taken over this part of the bracket.
SLOPE_OVER = 1e-3
# An edge that moves by less than this part of its bracket moves as the slope says.
LINEAR = 0.25


@dataclass(frozen=True)
class EdgeSearch:
    """A bracket about an edge.

    Parameters
    ----------
    solver : LinkageSolver
    inside, outside : float
        Crank speeds in rad/s with and without growth; the same where the band is open.
    """

    solver: LinkageSolver
    inside: float
    outside: float


def find_edge(search: EdgeSearch) -> BandEdge:
    """Find the edge in a bracket.

    Parameters
    ----------
    search : EdgeSearch

    Returns
    -------
    BandEdge
    """
    if search.inside == search.outside:
        return BandEdge(search.inside, 0.0, 0.0, 0.0, is_open=True)
    growth = SignedGrowth(search.solver)
    low, high = sorted((search.inside, search.outside))
    edge = float(
        scipy.optimize.brentq(
            growth, low, high, xtol=EDGE_TOLERANCE * abs(high), rtol=1e-14, maxiter=MOST_STEPS
        )
    )
    apart = SLOPE_OVER * (high - low)
    moving = search.solver.moving(edge)
    here = growth.of(search.solver.solve(moving))
    slope = abs((growth(edge + apart) - growth(edge - apart)) / (2 * apart))
    fewer = search.solver.with_half_the_steps(moving)

    coarse = search.solver.sampled_coarsely()

    def moved(other: LinkageSolver, one: LinkageSolver = coarse) -> float:
        try:
            same = here if one is search.solver else SignedGrowth(one)(edge)
            return _moved(SignedGrowth(other), edge, same, slope, high - low)
        except ComputationError:
            # There it has no equilibrium: the edge may be anywhere in the bracket.
            return high - low

    return BandEdge(
        crank_speed=edge,
        step_error=moved(fewer, search.solver),
        reduction_error=moved(coarse.with_more_modes()),
        mesh_error=moved(coarse.refined()) * BY_REFINEMENT,
        is_open=False,
    )


def _moved(other: SignedGrowth, edge: float, here: float, slope: float, width: float) -> float:
    """How far an edge is from where another measure of growth puts it."""
    change = other(edge) - here
    by_slope = abs(change) / slope
    if by_slope <= LINEAR * width:
        return by_slope
    # Too far for the slope at the edge: the measure's own sign change is sought.
    ends = [edge - 2 * width, edge + 2 * width]
    values = [other(end) for end in ends]
    distances = [2 * width]
    for end, value in zip(ends, values, strict=True):
        if value * (here + change) < 0:
            root = scipy.optimize.brentq(other, *sorted((edge, end)), xtol=1e-3 * width)
            distances.append(abs(float(root) - edge))
    return min(distances)


def find_top(solver: LinkageSolver, place: tuple[float, float, float]) -> KeptModes:
    """Find the speed between two edges at which a vibration grows most.

    Parameters
    ----------
    solver : LinkageSolver
    place : tuple of float
        Fastest growing speed known, lower and upper edge, in rad/s.

    Returns
    -------
    KeptModes
        At that speed.
    """
    known, lower, upper = place
    best = solver.solve(solver.moving(known))
    if upper > lower:
        found = scipy.optimize.minimize_scalar(
            lambda speed: -solver.growth_rate(speed),
            bounds=(lower, upper),
            method="bounded",
            options={"xatol": TOP_TOLERANCE * (upper - lower), "maxiter": MOST_TRIES},
        )
        other = solver.solve(solver.moving(float(found.x)))
        best = max(best, other, key=lambda modes: modes.growth_rate)
    return best
