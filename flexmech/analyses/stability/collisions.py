"""Where two Floquet modes meet between the crank speeds of a map, and whether they grow there.

Modes a and b of opposite sense meet where ``f_a + f_b = n f_crank``. Near that speed w_0::

    ((lambda_a - conj(lambda_b)) / 2)^2 = kappa^2 - slope^2 (w - w_0)^2

without damping; kappa is the growth rate where they meet, and the slope is known from the
frequencies. Two speeds tell both. Damping closes the band at about the damping ratio
``kappa w_1 / (w_a w_b)``, with w_1 the lowest frequency: that of a mode is in proportion to its
frequency. The bands of a pair shrink as the order n grows.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy.optimize

from flexmech.analyses.stability.growth import Sample, SignedGrowth, TrackedSpeed
from flexmech.arrays import FloatArray
from flexmech.errors import ComputationError
from flexmech.solvers.floquet_modes import SelectedModes, wrapped
from flexmech.solvers.stability import LinkageSolver

# After so many orders one after the other that are far from growing, a pair is left: bands shrink
# as the order grows, but orders that symmetry closes stand between others.
HOPELESS = 3
# Below this part of the growth that would count: a factor of three is beyond the error of the
# guess.
FAR = 1 / 3
# Kappa goes with the distance of the links from straight ones, or its square: away from resonances
# a periodic motion is at most three times as far as the equilibrium.
NEAR_MOTION = 1 / 10
# Growth is looked at beside a band at this multiple of its half width without damping, so that the
# edges lie between.
ASIDE = 1.5
# Speeds about a meeting are at least this part of the step from it: nearer, the bow of the squares
# drowns in their round-off. It is refined so often: the first three speeds tell the bow, the next
# stand where it holds.
LEAST_ASIDE = 0.02
REFINED = 2
# Part of the slope of free modes: where the slope is less, the modes are together in half of the
# step or more.
LEAST_SLOPE = 0.5
# In a band the sum of the frequencies is this near to its order times that of the crank, which is
# far less than the next order and more than a band's edge is off: the edge beyond is found without
# looking for a meeting.
LOCKED = 0.05
# With damping two modes may stay together at a speed without growing there: then the sum is the
# order but for round-off of the exponents, and no farther, for it goes on at the next speed.
TOUCHES = 1e-6
# Modes are distinguished by their angle, which interpolation between the speeds of a map
# gives within some tenths of a radian, and, where angles are alike, by frequency, within a tenth.
ANGLE_SCALE, FREQUENCY_SCALE = 0.3, 0.1


@dataclass(frozen=True)
class Meeting:
    """A pair of modes that meets between two speeds of a map.

    Parameters
    ----------
    lower, upper : float
        The speeds in rad/s.
    lower_frequency, upper_frequency : tuple of float
        Frequencies of modes a and b at these speeds, in Hz.
    order : int
    decay : float
        Geometric mean of the rates in 1/s at which a and b die out by their damping: they grow
        where kappa exceeds it.
    """

    lower: float
    upper: float
    lower_frequency: tuple[float, float]
    upper_frequency: tuple[float, float]
    order: int
    decay: float

    def frequencies(self, crank_speed: float) -> FloatArray:
        """Frequencies of a and b in Hz, interpolated."""
        fraction = (crank_speed - self.lower) / (self.upper - self.lower)
        first, last = np.array(self.lower_frequency), np.array(self.upper_frequency)
        return np.asarray(first + fraction * (last - first))

    def mismatch(self, crank_speed: float) -> float:
        """Half of ``f_a + f_b - n f_crank`` as an angular velocity in rad/s."""
        total = float(self.frequencies(crank_speed).sum())
        return np.pi * total - self.order * abs(crank_speed) / 2

    @property
    def crank_speed(self) -> float:
        """Where the modes meet by interpolation, rad/s."""
        speed = self.lower - self.mismatch(self.lower) / self.slope
        low, high = sorted((self.lower, self.upper))
        return min(max(speed, low), high)

    @property
    def slope(self) -> float:
        """Change of :meth:`mismatch` by the crank speed.

        Modes that damping keeps together are taken to pass each other as free ones do, whose
        frequencies hardly change.
        """
        return self._free_slope if self.is_locked else self._mean_slope

    @property
    def is_locked(self) -> bool:
        """Whether damping keeps the modes together in a part of the step between the speeds."""
        return self._mean_slope / self._free_slope <= LEAST_SLOPE

    @property
    def _mean_slope(self) -> float:
        return (self.mismatch(self.upper) - self.mismatch(self.lower)) / (self.upper - self.lower)

    @property
    def _free_slope(self) -> float:
        return float(-np.sign(self.upper) * self.order / 2)


@dataclass(frozen=True)
class MeetingPair:
    """All meetings of two branches a and b (from zero), the fastest first."""

    branches: tuple[int, int]
    meetings: Sequence[Meeting]


@dataclass(frozen=True)
class MetModes:
    """A meeting that may be the middle of an unstable band.

    Parameters
    ----------
    crank_speed : float
        rad/s.
    samples : list of Sample
        Growth with the solver's damping: there and beside the band.
    """

    crank_speed: float
    samples: list[Sample]


def meetings(speeds: Sequence[TrackedSpeed], branches: int) -> list[MeetingPair]:
    """Meetings of all pairs of branches between neighbouring speeds.

    Parameters
    ----------
    speeds : sequence of TrackedSpeed
        By increasing size of the speed.
    branches : int

    Returns
    -------
    list of MeetingPair
    """
    pairs = [(a, b) for a in range(branches) for b in range(a, branches)]
    found: dict[tuple[int, int], list[Meeting]] = {pair: [] for pair in pairs}
    for lower, upper in pairwise(speeds):
        first, last = lower.frequency[::2], _continued(lower, upper)
        rates = np.minimum(*(np.maximum(-f.exponent.real[::2], 0.0) for f in (lower, upper)))
        for a, b in pairs:
            crank = abs(lower.crank_speed) / (2 * np.pi), abs(upper.crank_speed) / (2 * np.pi)
            ends = (first[a] + first[b]) / crank[0], (last[a] + last[b]) / crank[1]
            low, high = sorted(ends)
            found[a, b] += [
                Meeting(
                    lower.crank_speed,
                    upper.crank_speed,
                    (float(first[a]), float(first[b])),
                    (float(last[a]), float(last[b])),
                    order,
                    float(np.sqrt(rates[a] * rates[b])),
                )
                # Two modes that creep have no frequency, and meet at no multiple of the crank's.
                for order in range(max(1, math.ceil(low - TOUCHES)), math.floor(high + TOUCHES) + 1)
                if not (lower.is_unstable and abs(ends[0] - order) < LOCKED)
                if not (upper.is_unstable and abs(ends[1] - order) < LOCKED)
            ]
    return [
        MeetingPair(pair, sorted(every, key=lambda meeting: (-abs(meeting.upper), meeting.order)))
        for pair, every in found.items()
        if every
    ]


@dataclass(frozen=True)
class _Strength:
    """A meeting with its middle in rad/s, kappa in 1/s, and kappa over the damping ratio.

    Kappa is infinite beyond the last equilibrium.
    """

    meeting: Meeting
    centre: float
    kappa: float
    for_ratio: float


def _strengths(
    solver: LinkageSolver,
    pair: MeetingPair,
    lowest: float,
    least_ratio: float,
    share: float,
    negligible: float,
) -> Iterator[tuple[_Strength, bool]]:
    """Meetings of a pair, and whether each has a part of the kappa that grows.

    After several without, one after the other, the pair is left. Kappa is rough where it is below
    ``negligible`` times that.
    """
    hopeless = 0
    for meeting in pair.meetings:
        frequency = meeting.frequencies(meeting.crank_speed)
        # A mode that creeps does not vibrate, and meets no other one.
        if hopeless == HOPELESS or not frequency.all():
            continue
        for_ratio = float(np.prod(2 * np.pi * frequency)) / lowest
        least = share * max(least_ratio * for_ratio, meeting.decay)
        try:
            centre, kappa = _middle(solver, meeting, negligible * least)
        except ComputationError:
            centre, kappa = meeting.crank_speed, np.inf
        hopeless = 0 if kappa > least else hopeless + 1
        yield _Strength(meeting, centre, kappa, for_ratio), kappa > least


def met(
    solver: LinkageSolver,
    pair: MeetingPair,
    lowest: float,
    least_ratio: float,
    ends: tuple[float, float],
) -> tuple[list[MetModes], int]:
    """Meetings of a pair that damping does not close.

    Parameters
    ----------
    solver : LinkageSolver
    pair : MeetingPair
    lowest : float
        Lowest natural frequency in rad/s.
    least_ratio : float
        Damping ratio at which a band must be open to be kept.
    ends : tuple of float
        Ends of the map in rad/s, the lower first: nothing is looked at beyond.

    Returns
    -------
    list of MetModes
    int
        Number of those whose modes meet, but whose bands are narrower than that.
    """
    meetings, narrower = [], 0
    kept = least_ratio * (1.0 if solver.is_hamiltonian else FAR)
    for one, _ in _strengths(solver, pair, lowest, least_ratio, FAR, FAR):
        if one.kappa < kept * one.for_ratio:
            narrower += one.kappa > 0
        elif FAR * one.meeting.decay <= one.kappa < np.inf:
            # Beyond the last equilibrium there is nothing; the map says so at its own speeds.
            with suppress(ComputationError):
                half_width = one.kappa / abs(one.meeting.slope)
                meetings.append(_sampled(solver, one.centre, half_width, ends))
    return meetings, narrower


def promising(
    quasi_static: LinkageSolver, pair: MeetingPair, lowest: float, least_ratio: float
) -> MeetingPair:
    """Meetings of a pair that may grow about a motion near the quasi-static equilibrium.

    Parameters
    ----------
    quasi_static : LinkageSolver
        About the equilibrium, where kappa costs little.
    pair, lowest, least_ratio
        As of :func:`met`.

    Returns
    -------
    MeetingPair
        Those whose kappa about the equilibrium is a tenth of what grows, or more; and those beyond
        the last equilibrium, where the motion alone tells.
    """
    every = _strengths(quasi_static, pair, lowest, least_ratio, NEAR_MOTION, np.inf)
    return MeetingPair(pair.branches, [one.meeting for one, grows in every if grows])


def _sampled(
    solver: LinkageSolver, centre: float, half_width: float, ends: tuple[float, float]
) -> MetModes:
    """Growth in the middle of a band and, where it grows, beside it and inside the map."""
    growth = SignedGrowth(solver)
    samples = [growth.sample(centre)]
    if samples[0].signed_growth > 0:
        beside = (centre + side * ASIDE * half_width for side in (-1.0, 1.0))
        samples += [growth.sample(speed) for speed in beside if ends[0] <= speed <= ends[1]]
    return MetModes(centre, samples)


def _middle(solver: LinkageSolver, meeting: Meeting, negligible: float) -> tuple[float, float]:
    """Where two modes meet in rad/s, and kappa in 1/s; rough, where it is negligible."""
    slope, (low, high) = meeting.slope, sorted((meeting.lower, meeting.upper))
    if meeting.is_locked:
        # The slope of free modes is not known well enough for two speeds.
        centre, strength, _ = _by_three_speeds(solver, meeting, (low + high) / 2, (high - low) / 2)
    else:
        first = meeting.crank_speed
        square = _square(solver, meeting, first)
        second = first - np.sqrt(abs(square)) / abs(slope) if square else meeting.lower
        if second * first <= 0:
            # Modes that meet so strongly do so down to standstill.
            second = meeting.lower if first != meeting.lower else meeting.upper
        other = _square(solver, meeting, second)
        centre = (second + first) / 2 + (square - other) / (2 * slope**2 * (first - second))
        strength = square + slope**2 * (first - centre) ** 2
    centre = float(np.clip(centre, low, high))
    if strength <= negligible**2:
        return centre, float(np.sqrt(max(0.0, strength)))
    # Beside a narrow band damped modes stay together, and their slope is not that of free ones:
    # three speeds about the middle tell all.
    for _ in range(REFINED):
        aside = max(np.sqrt(strength) / (2 * abs(slope)), LEAST_ASIDE * (high - low))
        aside = min(aside, (high - low) / 2)
        centre = float(np.clip(centre, low + aside, high - aside))
        centre, strength, has_top = _by_three_speeds(solver, meeting, centre, aside)
        centre = float(np.clip(centre, low, high))
        if not has_top or strength <= 0:
            break
    return centre, float(np.sqrt(max(0.0, strength)))


def _by_three_speeds(
    solver: LinkageSolver, meeting: Meeting, middle: float, aside: float
) -> tuple[float, float, bool]:
    """Top of the parabola through the squares about a speed, its height, and whether it has one."""
    below, here, above = (_square(solver, meeting, middle + step) for step in (-aside, 0.0, aside))
    bow = 2 * here - below - above
    if bow <= 0:
        return middle, here, False
    return (
        middle + aside * (above - below) / (2 * bow),
        here + (above - below) ** 2 / (8 * bow),
        True,
    )


def _square(solver: LinkageSolver, meeting: Meeting, crank_speed: float) -> float:
    """``((lambda_a - conj(lambda_b)) / 2)^2`` at a crank speed, by forces with a potential."""
    modes = solver.solve(solver.moving(crank_speed).with_potential_alone(), damping=0.0)
    a, b = _places(modes, meeting.frequencies(crank_speed))
    apart = (modes.exponent[a].real - modes.exponent[b].real) / 2
    turn = modes.angle[a] - modes.angle[b]
    passing = wrapped(turn) / (2 * modes.period)
    return float(apart**2 - passing**2)


def _places(modes: SelectedModes, frequency: FloatArray) -> tuple[int, int]:
    """Places of mode a, which turns forward, and of the conjugate of b."""
    wanted = 2 * np.pi * modes.period * frequency * np.array([1.0, -1.0])
    gap = modes.angle - wanted[:, None]
    apart = np.abs(wrapped(gap)) / ANGLE_SCALE
    size = np.abs(modes.exponent.imag) / (2 * np.pi)
    other = np.abs(size - frequency[:, None]) / (FREQUENCY_SCALE * frequency[:, None])
    places = scipy.optimize.linear_sum_assignment(apart + np.minimum(other, 1.0))[1]
    return int(places[0]), int(places[1])


def _continued(lower: TrackedSpeed, upper: TrackedSpeed) -> FloatArray:
    """Frequencies of the branches at the upper speed that continue those at the lower one, (m,).

    Two modes of opposite sense that have met share their family of frequencies.
    """
    crank, before = abs(upper.crank_speed) / (2 * np.pi), lower.frequency[::2]
    both = upper.frequency[::2] * np.array([[1.0], [-1.0]])
    near = before + wrapped(both - before, crank)
    return np.asarray(near[np.abs(near - before).argmin(axis=0), np.arange(len(before))])
