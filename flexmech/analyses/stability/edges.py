"""Edges of unstable bands, with what steps, reduction and mesh make them wrong by."""

from __future__ import annotations

from dataclasses import dataclass

import scipy.optimize

from flexmech.analyses.stability.band import BandEdge
from flexmech.analyses.stability.kept_modes import KeptModes
from flexmech.analyses.stability.signed_growth import SignedGrowth
from flexmech.analyses.stability.solver import BY_REFINEMENT, LinkageSolver
from flexmech.analyses.stability.vibrating_linkage import VibratingLinkage
from flexmech.errors import ComputationError

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
    inside, outside : float
        Crank speeds in rad/s with and without growth; the same where the band is open.
    growth_inside, growth_outside : float
        Measure of growth there; see
        :class:`flexmech.analyses.stability.signed_growth.SignedGrowth`.
    """

    inside: float
    outside: float
    growth_inside: float
    growth_outside: float

    @property
    def width(self) -> float:
        """Of the bracket in rad/s."""
        return abs(self.outside - self.inside)


@dataclass(frozen=True)
class FoundEdge:
    """An edge whose errors are not yet known.

    Parameters
    ----------
    crank_speed : float
        rad/s.
    growth : float
        Measure of growth there: next to nothing.
    width : float
        Of the bracket in rad/s; zero where the band is open.
    """

    crank_speed: float
    growth: float
    width: float


def find_edge(solver: LinkageSolver, search: EdgeSearch) -> FoundEdge:
    """Find the edge in a bracket.

    Parameters
    ----------
    solver : LinkageSolver
    search : EdgeSearch

    Returns
    -------
    FoundEdge
    """
    if not search.width:
        return FoundEdge(search.inside, search.growth_inside, 0.0)
    growth = SignedGrowth(solver)
    seen = {search.inside: search.growth_inside, search.outside: search.growth_outside}

    def measure(crank_speed: float) -> float:
        if crank_speed not in seen:
            seen[crank_speed] = growth(crank_speed)
        return seen[crank_speed]

    low, high = sorted((search.inside, search.outside))
    edge = float(
        scipy.optimize.brentq(
            measure, low, high, xtol=EDGE_TOLERANCE * abs(high), rtol=1e-14, maxiter=MOST_STEPS
        )
    )
    return FoundEdge(edge, measure(edge), search.width)


def edge_errors(solver: LinkageSolver, found: FoundEdge) -> BandEdge:
    """Find out how wrong steps, reduction and mesh make an edge.

    Parameters
    ----------
    solver : LinkageSolver
        With which it was found.
    found : FoundEdge

    Returns
    -------
    BandEdge
    """
    edge, width = found.crank_speed, found.width
    if not width:
        return BandEdge(edge, 0.0, 0.0, 0.0, is_open=True)
    growth, apart = SignedGrowth(solver), SLOPE_OVER * width
    slope = abs((growth(edge + apart) - growth(edge - apart)) / (2 * apart))
    place = _Place(edge, slope, width)
    moving, coarse = solver.moving(edge), solver.sampled_coarsely()
    try:
        same, more_modes = coarse.both_reductions(edge)
        there = SignedGrowth(coarse).at(same)
        by_reduction = place.moved(coarse.with_more_modes(), there, more_modes)
        by_mesh = place.moved(coarse.refined(), there)
    except ComputationError:
        by_reduction = by_mesh = width
    return BandEdge(
        crank_speed=edge,
        step_error=place.moved(solver.with_half_the_steps(moving), found.growth, moving),
        reduction_error=by_reduction,
        mesh_error=by_mesh * BY_REFINEMENT,
        is_open=False,
    )


@dataclass(frozen=True)
class _Place:
    """An edge, the slope of the growth's measure there, and the width of its bracket."""

    edge: float
    slope: float
    width: float

    def moved(
        self, solver: LinkageSolver, here: float, moving: VibratingLinkage | None = None
    ) -> float:
        """How far away another solver, instead of the one with growth ``here``, puts the edge."""
        growth = SignedGrowth(solver)
        try:
            there = growth.at(moving or solver.moving(self.edge))
            by_slope = abs(there - here) / self.slope
            return by_slope if by_slope <= LINEAR * self.width else self._sought(growth, there)
        except ComputationError:
            # There it has no equilibrium: the edge may be anywhere in the bracket.
            return self.width

    def _sought(self, growth: SignedGrowth, there: float) -> float:
        """Distance of the measure's own sign change, where the slope at the edge tells nothing."""
        distances = [2 * self.width]
        for end in (self.edge - 2 * self.width, self.edge + 2 * self.width):
            if growth(end) * there < 0:
                ends = sorted((self.edge, end))
                root = scipy.optimize.brentq(growth, *ends, xtol=1e-3 * self.width)
                distances.append(abs(float(root) - self.edge))
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
