"""Edges of unstable bands, with what steps, reduction and mesh make them wrong by.

Besides, the damping ratio that closes a band, and the errors of exponents.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import scipy.optimize

from flexmech.analyses.stability.engine_stability import BandEdge, ExponentErrors
from flexmech.analyses.stability.growth import SignedGrowth
from flexmech.analyses.stability.naming import parity_of
from flexmech.analyses.stability.selected_modes import SelectedModes, wrapped
from flexmech.analyses.stability.solver import BY_REFINEMENT, LinkageSolver
from flexmech.analyses.stability.vibrating_linkage import VibratingLinkage
from flexmech.errors import ComputationError

logger = logging.getLogger(__name__)

# Relative to the crank speed: far below what steps, modes and mesh make an edge wrong by.
EDGE_TOLERANCE = 1e-8
# The fastest speed of a band, relative to its width: growth is level there, so that an error of a
# fiftieth lowers it by a thousandth or so. A hundredth of that costs twice the tries.
TOP_TOLERANCE = 0.02
# The slope is taken over this part of the bracket: its error is of second order in it, 1e-6, and
# the growth, known to seven digits or more, leaves 1e-4 of the difference.
SLOPE_OVER = 1e-3
# An edge that moves by less than this part of its bracket moves as the slope says; beyond, a band's
# growth is bent like a parabola.
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
        :class:`flexmech.analyses.stability.growth.SignedGrowth`.
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
        scipy.optimize.brentq(measure, low, high, xtol=EDGE_TOLERANCE * abs(high), rtol=1e-14)
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
        # The speeds asked for end there: the band's own edge, and its error, are not known.
        return BandEdge(edge, np.nan, np.nan, np.nan, is_open=True)
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
            # Beside an edge of next to no width growth may be level.
            by_slope = abs(there - here) / self.slope if self.slope else np.inf
            return by_slope if by_slope <= LINEAR * self.width else self._sought(growth, there)
        except ComputationError:
            # There it has no equilibrium: the edge may be anywhere in the bracket.
            return self.width

    def _sought(self, growth: SignedGrowth, there: float) -> float:
        """Distance of the measure's own sign change, where the slope at the edge tells nothing."""
        distances = [2 * self.width]
        for end in (self.edge - 2 * self.width, self.edge + 2 * self.width):
            # Beyond standstill the linkage turns the other way.
            if end * self.edge > 0 and growth(end) * there < 0:
                ends = sorted((self.edge, end))
                root = scipy.optimize.brentq(growth, *ends, xtol=1e-3 * self.width)
                distances.append(abs(float(root) - self.edge))
        return min(distances)


# Distance of the speeds near the edges from them, over the width of the band.
SIDE = 0.1


def find_top(
    solver: LinkageSolver, place: tuple[float, float, float]
) -> tuple[SelectedModes, bool]:
    """Find the speed between two edges at which a vibration grows most.

    Resonances may overlap without a gap, as one of two different modes and one of twice the same
    mode: then the band has no single name.

    Parameters
    ----------
    solver : LinkageSolver
    place : tuple of float
        Fastest growing speed known, lower and upper edge, in rad/s.

    Returns
    -------
    SelectedModes
        At that speed.
    bool
        Whether the multipliers near both edges are of one kind with it: real and of one sign, or
        not real.
    """
    known, lower, upper = place
    best = solver.solve(solver.moving(known))
    if upper > lower:
        found = scipy.optimize.minimize_scalar(
            lambda speed: -solver.growth_rate(speed),
            bounds=(lower, upper),
            method="bounded",
            options={"xatol": TOP_TOLERANCE * (upper - lower)},
        )
        other = solver.solve(solver.moving(float(found.x)))
        best = max(best, other, key=lambda modes: modes.growth_rate)
    inside = SIDE * (upper - lower)
    sides = [solver.solve(solver.moving(speed)) for speed in (lower + inside, upper - inside)]
    growing = [side for side in sides if side.growth_rate > 0]
    return best, all(parity_of(side) == parity_of(best) for side in growing)


# Relative: ratios are written with three digits, which two more keep right.
RATIO_TOLERANCE = 1e-5
# Of critical damping, beyond which nothing is called a vibration; and far below what any material
# has, 1e-6, while growth by round-off ends at 1e-10.
LARGEST_RATIO, LEAST_RATIO = 1.0, 1e-9
# The first step from the start relative to it, and its least size, of ratios that close narrow
# bands: shorter ones take more steps, and longer ones bracket the ratio less closely. A next one is
# at most this many times the last, lest a line that is hardly inclined leads far beyond, and this
# much farther than a straight line through the last two asks for, to come out on the other side.
FIRST_STEP, LEAST_STEP = 0.1, 1e-4
FARTHEST, BEYOND = 16.0, 1.05
# Speeds to either side of the last one, relative to the width, and how often they are moved: the
# last growth is in the band, so that five moves of a fifth reach it, and the parabola through three
# speeds does the rest. Nearer to the end of the band than the least there is nothing to move to.
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

    The speed at which the last growth ends is tracked: damping moves it.

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


def exponent_errors(solver: LinkageSolver, crank_speed: float) -> ExponentErrors:
    """Compare with more moving modes, half the element length, and beams of a finer theory.

    Parameters
    ----------
    solver : LinkageSolver
    crank_speed : float
        rad/s.

    Returns
    -------
    ExponentErrors
        Not a number for what cannot be compared: beams that are softer buckle earlier, and modes
        that die out too fast within a turn have no multipliers.
    """
    coarse = solver.sampled_coarsely()
    moving, with_more_modes = coarse.both_reductions(crank_speed)
    # In as many steps: what more modes change is far more than the steps of these leave.
    stepped = replace(coarse, steps=coarse.steps_for(moving))
    modes, theory = coarse.solve(moving), coarse.with_finer_beams()

    def solved_by(other: LinkageSolver) -> SelectedModes | None:
        return _solved(lambda: other.solve(other.moving(crank_speed)))

    others = {
        "reduction": (_solved(lambda: stepped.solve(with_more_modes)), 1.0),
        "mesh": (solved_by(coarse.refined()), BY_REFINEMENT),
        "theory": (solved_by(theory) if theory else modes, 1.0),
    }
    apart, growth = {}, 0.0
    for name, (other, factor) in others.items():
        apart[name] = factor * _apart(modes, other) if other else np.nan
        grows = other.growth_rate if other else np.nan
        growth += factor * abs(grows - modes.growth_rate)
    return ExponentErrors(crank_speed, **apart, growth=growth * modes.period)


def _solved(modes: Callable[[], SelectedModes]) -> SelectedModes | None:
    """Floquet modes; None where there are none."""
    try:
        return modes()
    except ComputationError as refusal:
        logger.info("an error is not known: %s", refusal)
        return None


def _apart(modes: SelectedModes, others: SelectedModes) -> float:
    """Greatest relative difference of exponents, whatever members of their families they are."""
    ours, theirs = modes.exponent, others.exponent
    size = np.abs(ours.imag)[:, None]
    cost = np.abs(size - np.abs(theirs.imag)) / (size + 1 / modes.period)
    cost = cost + (np.sign(ours.imag)[:, None] != np.sign(theirs.imag))
    gap = ours - theirs[scipy.optimize.linear_sum_assignment(cost)[1]]
    turned = wrapped(gap.imag, 2 * np.pi / modes.period)
    return float((np.hypot(gap.real, turned) / np.abs(ours)).max())
