"""Unstable bands: their edges with errors, the damping ratio that closes them, and their names.

An edge is wrong by steps, reduction and mesh, and so are exponents. A name says which frequencies
add up to a multiple of the crank's.

A name holds whatever speeds a map was asked for: modes are followed from standstill in the same
steps in every map (:func:`following_speeds`), and nothing else than the mode that grows fastest in
the band decides. A real multiplier has met its own conjugate, so that both modes are the same, and
is positive for an even order and negative for an odd one; any other multiplier is that of two
different modes.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import scipy.optimize

from flexmech.analyses.damping_ratios import TURN, with_damping_time
from flexmech.analyses.frequencies.positions import frequencies_at
from flexmech.analyses.stability.growth import (
    BandEdge,
    ExponentErrors,
    Kind,
    SignedGrowth,
    TrackedSpeed,
)
from flexmech.arrays import FloatArray
from flexmech.errors import ComputationError
from flexmech.solvers.floquet_modes import GROWS, SelectedModes, VibratingLinkage, wrapped
from flexmech.solvers.formulation import Formulation
from flexmech.solvers.stability import BY_REFINEMENT, LinkageSolver, likeness, track_modes

# A branch that is a smaller part of the mode that grows has no part in the band: two that meet
# have about 0.7 each, and what others are like by chance is a twentieth.
LEAST_PART = 0.15
# Farther from a whole multiple, relative to the crank's frequency, there is no name: half-way to
# the next one chance would name it as well.
FARTHEST_FROM_ORDER = 0.25
# In a band frequencies are pulled to its order: by no more than its growth tells, or by this, which
# interpolation between speeds a fortieth of the lowest frequency apart leaves in a narrow band.
PULLED = 0.01
# In turns: the angle of a multiplier that is real but for round-off.
REAL = 1e-6
# A smaller Krein signature is that of a multiplier beside the unit circle, or about to leave it:
# round-off tells its sign.
LEAST_SIGNATURE = 0.01


@dataclass(frozen=True)
class BandName:
    """Name of a band by the modes that meet in it.

    Parameters
    ----------
    kind : Kind
    branches : tuple of int
        From 1; empty without a name, and where a mode diverges.
    order : int
        0 without branches.
    mismatch : float
        How far ``(f_a + f_b) / f_crank`` or ``(f_a - f_b) / f_crank`` is from the order.
    frequencies : tuple of float
        ``f_a`` and ``f_b`` in Hz beside the band; empty without branches.
    """

    kind: Kind
    branches: tuple[int, ...]
    order: int
    mismatch: float
    frequencies: tuple[float, ...] = ()


UNNAMED = BandName("unnamed", (), 0, float("nan"))
DIVERGENCE = BandName("divergence", (), 0, float("nan"))
# Damping that closes a band lies within this factor of what the two modes of its name need: within
# 1.2 in bands whose modes were followed to them from far below; of wrong names it is 4 to 17.
CLOSING_WITHIN = 2.0


def closing_fits(
    name: BandName, growth_rate: float, start: float, closing: float, lowest: float
) -> bool:
    """Whether the damping that closes a band is what the modes of its name need.

    Two modes that meet grow with ``(s + d_a) (s + d_b) = g^2``, in which ``d`` are their rates of
    decay and ``g`` is the growth without damping (Nayfeh and Mook, combination resonances); the
    band is closed where ``d_a d_b = g^2``. A damping ratio Z of all links has
    ``d_k = Z omega_k^2 / omega_1``.

    Parameters
    ----------
    name : BandName
    growth_rate : float
        Greatest in the band, in 1/s.
    start : float
        Damping ratio at which it grows so.
    closing : float
        Damping ratio that closes the band.
    lowest : float
        ``omega_1`` in rad/s.

    Returns
    -------
    bool
        True where nothing can be compared: without a name, for a difference of frequencies, or
        where no damping closes the band.
    """
    comparable = name.kind in ("principal", "sum") and np.isfinite(closing) and closing > start
    if not comparable or min(name.frequencies) <= 0:
        return True
    decay = (2 * np.pi * np.array(name.frequencies)) ** 2 / lowest
    needed = float(np.sqrt(np.prod(growth_rate + start * decay) / np.prod(decay)))
    return bool(1 / CLOSING_WITHIN < closing / needed < CLOSING_WITHIN)


def band_name(
    frequency: FloatArray,
    participation: FloatArray,
    usual: FloatArray,
    crank_frequency: float,
    pull: float,
    *,
    differences: bool,
    is_refused: Callable[[BandName], bool] = lambda name: False,
) -> BandName:
    """Name of a band.

    Parameters
    ----------
    frequency : ndarray, shape (m,)
        Floquet frequencies of the branches in Hz where none of them grows, at the band's speed.
    participation : ndarray, shape (m,)
        How alike the mode that grows is to the shape of each branch.
    usual : ndarray, shape (m,)
        Median of each branch's frequency over the speeds. Modes that were mixtures may have
        changed their branches; a name goes by the nearest frequency.
    crank_frequency : float
        In Hz.
    pull : float
        How far growth may pull the sum of the frequencies, over the crank's frequency.
    differences : bool
        Whether differences of frequencies can be unstable.
    is_refused : callable, optional
        Tells names that cannot be, whatever the frequencies.

    Returns
    -------
    BandName
    """
    scored_names: list[tuple[float, BandName]] = []
    # With too few steps a mode may not turn at all: its frequency is zero.
    height, usual_height = (
        np.log(np.maximum(of, np.finfo(float).tiny)) for of in (frequency, usual)
    )
    label = np.abs(height[:, None] - usual_height).argmin(axis=1) + 1
    count = len(frequency)
    for a in range(count):
        for b in range(a, count):
            common = min(participation[a], participation[b])
            if common < LEAST_PART:
                continue
            kinds: list[tuple[Kind, float]] = [("sum", frequency[a] + frequency[b])]
            if label[a] == label[b]:
                kinds = [("principal", frequency[a] + frequency[b])]
            elif differences:
                kinds.append(("difference", abs(frequency[b] - frequency[a])))
            for kind, meeting in kinds:
                ratio = float(meeting) / crank_frequency
                order = round(ratio)
                if order == 0 or abs(ratio - order) > FARTHEST_FROM_ORDER:
                    continue
                both = sorted((int(label[branch]), float(frequency[branch])) for branch in (a, b))
                branches, frequencies = zip(*both, strict=True)
                name = BandName(kind, branches, order, abs(ratio - order), frequencies)
                if is_refused(name):
                    continue
                pulled = max(PULLED, pull)
                scored_names.append((common / (1 + ((ratio - order) / pulled) ** 2), name))
    if not scored_names:
        return UNNAMED
    return max(scored_names, key=lambda scored: scored[0])[1]


def signatures_of(
    name: BandName, ends: tuple[float, float], tracked: Sequence[TrackedSpeed]
) -> tuple[float, float]:
    """Krein signatures of the two multipliers that meet in a band.

    Parameters
    ----------
    name : BandName
    ends : tuple of float
        Ends of the band in rad/s.
    tracked : sequence of TrackedSpeed

    Returns
    -------
    tuple of float
        At the nearest speed beside the band at which both are clear: those of the multipliers of
        ``f_a`` and of ``-f_b``, or of ``f_b`` for a difference. Not a number without a name, or
        where there is no such speed.
    """
    if not name.branches:
        return float("nan"), float("nan")
    first, last = name.frequencies
    sense = 1 if name.kind == "difference" else -1
    low, high = sorted(ends)
    beside = [f for f in tracked if not low <= f.crank_speed <= high]
    for modes in sorted(beside, key=lambda f: max(low - f.crank_speed, f.crank_speed - high)):
        signatures = modes.signature_of(first, 1), modes.signature_of(last, sense)
        if min(map(abs, signatures)) > LEAST_SIGNATURE:
            return signatures
    return float("nan"), float("nan")


def following_speeds(fastest: float, step: float) -> FloatArray:
    """Crank speeds at which modes are followed for names, the same in every map.

    Parameters
    ----------
    fastest : float
        Crank speed that the map reaches, rad/s.
    step : float
        rad/s.

    Returns
    -------
    ndarray, shape (n,)
        Multiples of the step, from the second to the first beyond the fastest speed.
    """
    last = max(2, int(np.floor(abs(fastest) / step)) + 1)
    return np.asarray(np.sign(fastest) * step * np.arange(2, last + 1))


def passes_through(
    name: BandName, ends: tuple[float, float], tracked: Sequence[TrackedSpeed]
) -> bool:
    """Whether the two multipliers of a difference have one Krein signature beside the band.

    Such multipliers meet on the unit circle and stay on it. Those of sums have opposite ones
    unless the Hamilton function is far from definite.

    Parameters
    ----------
    name : BandName
    ends : tuple of float
        Ends of the band in rad/s.
    tracked : sequence of TrackedSpeed
        By increasing size of the speed.

    Returns
    -------
    bool
    """
    first, second = signatures_of(name, ends, tracked)
    return name.kind == "difference" and first * second > 0


def name_of_growth(
    modes: SelectedModes, followed: Sequence[SelectedModes], *, differences: bool
) -> BandName:
    """Name of the band that grows fastest at these modes.

    Parameters
    ----------
    modes : SelectedModes
        Where it grows fastest.
    followed : sequence of SelectedModes
        At some of :func:`following_speeds`, by increasing size of the speed.
    differences : bool
        Whether differences of frequencies can be unstable.

    Returns
    -------
    BandName
        :data:`DIVERGENCE` where the mode grows without oscillating.
    """
    number = int(modes.exponent.real.argmax())
    if not modes.exponent.imag[number]:
        return DIVERGENCE
    size = abs(modes.crank_speed)
    before = [each for each in followed if abs(each.crank_speed) <= size]
    if not before:
        return UNNAMED
    # What comes later than the next speed tells nothing, lest a name depends on how far a map goes.
    branches = track_modes([*before, *followed[len(before) :][:1]])
    last, crank = branches.shapes[len(before) - 1], 1 / modes.period
    participation = (
        likeness(last.shape, modes.shape[..., number, None])[:, 0].reshape(-1, 2).max(axis=1)
    )
    frequency = np.abs(last.frequency[::2])
    after = branches.modes[len(before) :]
    if after and after[0].growth_rate * after[0].period < GROWS:
        below = abs(before[-1].crank_speed)
        share = (size - below) / (abs(after[0].crank_speed) - below)
        ahead = np.abs(branches.shapes[-1].frequency[::2])
        frequency = frequency + share * wrapped(ahead - frequency, crank)
    return band_name(
        frequency,
        participation,
        branches.usual_frequency,
        crank,
        2 * modes.growth_rate / size,
        differences=differences,
        is_refused=lambda name: not multiplier_fits(name, modes),
    )


def multiplier_fits(name: BandName, modes: SelectedModes) -> bool:
    """Whether the multiplier that grows fastest is one of two modes that meet as a name says.

    Parameters
    ----------
    name : BandName
    modes : SelectedModes
        Where the band grows fastest.

    Returns
    -------
    bool
    """
    parity = parity_of(modes)
    if parity is None:
        return name.kind != "principal"
    return name.kind == "principal" and parity == name.order % 2


def parity_of(modes: SelectedModes) -> int | None:
    """Whether the order of a band whose multiplier is real is even or odd.

    Parameters
    ----------
    modes : SelectedModes

    Returns
    -------
    int or None
        0 or 1 of the multiplier that grows fastest; None where it is not real.
    """
    angle = float(modes.angle[modes.exponent.real.argmax()]) / np.pi
    return round(angle) % 2 if abs(angle - round(angle)) < 2 * REAL else None


def order_is_nearest(name: BandName, solver: LinkageSolver, modes: SelectedModes) -> bool:
    """Whether the order of a name is the nearest that natural frequencies allow.

    Where the crank is slow beside a vibration, it oscillates at its natural frequency averaged over
    the turn; modes that are counted by their order at every crank angle need no following.

    Parameters
    ----------
    name : BandName
    solver : LinkageSolver
    modes : SelectedModes
        Where the band grows fastest.

    Returns
    -------
    bool
        Only every second order is possible for a principal band. False where a frozen mode does not
        oscillate, and so decides nothing.
    """
    if not name.branches:
        return True
    undamped = with_damping_time(solver.engine, 0.0)
    formulation = Formulation(solver.quasi_static, modes=max(name.branches))
    try:
        frequencies = frequencies_at(undamped, TURN, modes.crank_speed, formulation)
    except ComputationError:
        return False
    first, second = frequencies.mean(axis=0)[[name.branches[0] - 1, name.branches[-1] - 1]]
    meeting = abs(first - second) if name.kind == "difference" else first + second
    farthest = 1.0 if name.kind == "principal" else 0.5
    return bool(abs(meeting * modes.period - name.order) < farthest)


def without_repetition(names: Sequence[BandName]) -> list[BandName]:
    """Names of the bands of a map, in which no two have the same.

    Two modes meet at a multiple of the crank's frequency once: of equal names at most one is true.
    """
    meetings = [(name.kind, name.branches, name.order) for name in names]
    return [
        UNNAMED if name.branches and meetings.count(meeting) > 1 else name
        for name, meeting in zip(names, meetings, strict=True)
    ]


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
        """Width of the bracket in rad/s."""
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
        Width of the bracket in rad/s; zero where the band is open.
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


def edge_errors(solver: LinkageSolver, sought: FoundEdge) -> BandEdge:
    """Find out how wrong steps, reduction and mesh make an edge.

    Parameters
    ----------
    solver : LinkageSolver
        With which it was found.
    sought : FoundEdge

    Returns
    -------
    BandEdge
    """
    edge, width = sought.crank_speed, sought.width
    if not width:
        # The speeds asked for end there: the band's own edge, and its error, are not known.
        return BandEdge(edge, np.nan, np.nan, np.nan, is_open=True)
    growth, apart = SignedGrowth(solver), SLOPE_OVER * width
    slope = abs((growth(edge + apart) - growth(edge - apart)) / (2 * apart))
    place = _Place(edge, slope, width)
    moving, coarse = solver.moving(edge), solver.sampled_coarsely()
    try:
        same, more_modes = coarse.both_reductions(edge)
        coarse_growth = SignedGrowth(coarse).at(same)
        by_reduction = place.moved(coarse.with_more_modes(), coarse_growth, more_modes)
        by_mesh = place.moved(coarse.refined(), coarse_growth)
    except ComputationError:
        by_reduction = by_mesh = width
    return BandEdge(
        crank_speed=edge,
        step_error=place.moved(solver.with_half_the_steps(moving), sought.growth, moving),
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
            moved_growth = growth.at(moving or solver.moving(self.edge))
            # Beside an edge of next to no width growth may be level.
            by_slope = abs(moved_growth - here) / self.slope if self.slope else np.inf
            return (
                by_slope if by_slope <= LINEAR * self.width else self._sought(growth, moved_growth)
            )
        except ComputationError:
            # There it has no equilibrium: the edge may be anywhere in the bracket.
            return self.width

    def _sought(self, growth: SignedGrowth, moved_growth: float) -> float:
        """Distance of the measure's own sign change, where the slope at the edge tells nothing."""
        distances = [2 * self.width]
        for end in (self.edge - 2 * self.width, self.edge + 2 * self.width):
            # Beyond standstill the linkage turns the other way.
            if end * self.edge > 0 and growth(end) * moved_growth < 0:
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
        minimum = scipy.optimize.minimize_scalar(
            lambda speed: -solver.growth_rate(speed),
            bounds=(lower, upper),
            method="bounded",
            options={"xatol": TOP_TOLERANCE * (upper - lower)},
        )
        other = solver.solve(solver.moving(float(minimum.x)))
        best = max(best, other, key=lambda modes: modes.growth_rate)
    inside = SIDE * (upper - lower)
    sides = [solver.solve(solver.moving(speed)) for speed in (lower + inside, upper - inside)]
    growing = [side for side in sides if side.growth_rate > 0]
    return best, all(parity_of(side) == parity_of(best) for side in growing)


# Relative: ratios are written with three digits, which two more keep right.
RATIO_TOLERANCE = 1e-5
# Damping ratio beyond which nothing is called a vibration; and one far below what any material has,
# 1e-6, while growth by round-off ends at 1e-10.
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
        Not a number where nothing can be compared: beams that are softer buckle earlier, and modes
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
