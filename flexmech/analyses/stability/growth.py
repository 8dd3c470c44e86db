"""A measure of growth that changes its sign at the edge of an unstable band; runs of growth."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import scipy.optimize
from numpy.typing import NDArray

from flexmech.analyses.stability.selected_modes import GROWS, SelectedModes, wrapped
from flexmech.analyses.stability.solver import LinkageSolver
from flexmech.analyses.stability.vibrating_linkage import VibratingLinkage


@dataclass(frozen=True)
class Sample:
    """Growth at a crank speed.

    Parameters
    ----------
    crank_speed : float
        rad/s.
    signed_growth : float
        Positive where a vibration grows; see
        :class:`flexmech.analyses.stability.growth.SignedGrowth`.
    growth_rate : float
        1/s.
    """

    crank_speed: float
    signed_growth: float
    growth_rate: float


@dataclass(frozen=True)
class RunOfGrowth:
    """Samples without one between them at which nothing grows.

    Parameters
    ----------
    samples : list of Sample
        By increasing speed.
    before, after : float or None
        Nearest speeds at which nothing grows; None where the samples end, or a speed without
        equilibrium comes first.
    """

    samples: list[Sample]
    before: float | None
    after: float | None

    @property
    def brackets(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Speeds inside and outside of the lower and of the upper edge; the same where open."""
        first, last = self.samples[0].crank_speed, self.samples[-1].crank_speed
        lower = first if self.before is None else self.before
        upper = last if self.after is None else self.after
        return (first, lower), (last, upper)

    @property
    def fastest(self) -> float:
        """Speed of the sample that grows most."""
        return max(self.samples, key=lambda sample: sample.growth_rate).crank_speed


def runs_of_growth(samples: Sequence[Sample], refused: Sequence[float]) -> list[RunOfGrowth]:
    """Find the runs.

    Parameters
    ----------
    samples : sequence of Sample
        In any order.
    refused : sequence of float
        Crank speeds without equilibrium.

    Returns
    -------
    list of RunOfGrowth
        By increasing speed.
    """
    ordered = sorted(samples, key=lambda sample: sample.crank_speed)
    runs: list[RunOfGrowth] = []
    here: list[Sample] = []
    before: float | None = None
    last: float | None = None

    def end(after: float | None) -> None:
        if here:
            runs.append(RunOfGrowth(here.copy(), before, after))
            here.clear()

    for sample in ordered:
        gap = last is not None and any(last < speed < sample.crank_speed for speed in refused)
        if gap:
            end(None)
        if sample.signed_growth > 0:
            if not here:
                before = None if gap else last
            here.append(sample)
        else:
            end(sample.crank_speed)
        last = sample.crank_speed
    end(None)
    return runs


def speeds_between(samples: Sequence[Sample], step: float, refused: Sequence[float]) -> list[float]:
    """Speeds between neighbouring samples that grow, no farther apart than a step.

    Parameters
    ----------
    samples : sequence of Sample
        In any order.
    step : float
        rad/s.
    refused : sequence of float
        Crank speeds without equilibrium; nothing is asked for across them.

    Returns
    -------
    list of float
    """
    found: list[float] = []
    ordered = sorted(samples, key=lambda sample: sample.crank_speed)
    for first, last in pairwise(ordered):
        low, high = first.crank_speed, last.crank_speed
        grows = first.signed_growth > 0 and last.signed_growth > 0
        if grows and not any(low < speed < high for speed in refused):
            count = math.ceil((high - low) / step)
            found += [low + (high - low) * number / count for number in range(1, count)]
    return found


# Of the distance of the neighbours of a dip: two bands whose gap is narrower stay one.
NARROWEST_GAP = 0.02


@dataclass(frozen=True)
class Dip:
    """A sample that grows less than both its neighbours: a band may end there, and another begin.

    Parameters
    ----------
    before, lowest, after : Sample
    """

    before: Sample
    lowest: Sample
    after: Sample


def dips(samples: Sequence[Sample], refused: Sequence[float]) -> list[Dip]:
    """Dips of the growth inside runs.

    Parameters
    ----------
    samples : sequence of Sample
        In any order.
    refused : sequence of float
        Crank speeds without equilibrium.

    Returns
    -------
    list of Dip
    """
    return [
        Dip(before, here, after)
        for run in runs_of_growth(samples, refused)
        for before, here, after in zip(run.samples, run.samples[1:], run.samples[2:], strict=False)
        if here.signed_growth < min(before.signed_growth, after.signed_growth)
    ]


def speeds_inside(runs: Sequence[RunOfGrowth], parts: int, least_width: float) -> list[float]:
    """Speeds inside runs, closer together towards their ends, where growth is steep.

    Parameters
    ----------
    runs : sequence of RunOfGrowth
    parts : int
        Into which the range between the nearest speeds without growth is divided.
    least_width : float
        Narrower ranges have none, rad/s.

    Returns
    -------
    list of float
    """
    share = (1 - np.cos(np.pi * np.arange(1, parts) / parts)) / 2
    ranges = [(lower[1], upper[1]) for lower, upper in (run.brackets for run in runs)]
    return [
        float(speed)
        for low, high in ranges
        if high - low >= least_width
        for speed in low + (high - low) * share
    ]


@dataclass(frozen=True)
class SignedGrowth:
    """Positive where a vibration grows, negative where none does, zero at the edge of a band.

    With damping or follower forces it is the greatest growth rate in 1/s. Without, that is
    zero outside of bands; but where modes a and b meet, ``((lambda_a - conj(lambda_b)) / 2)^2``
    is the square of the growth rate in the band, negative beside it, and smooth.

    Parameters
    ----------
    solver : LinkageSolver
    """

    solver: LinkageSolver

    def __call__(self, crank_speed: float) -> float:
        """Measure at a crank speed in rad/s."""
        return self.at(self.solver.moving(crank_speed))

    def sample(self, crank_speed: float) -> Sample:
        """Measure and growth rate at a crank speed in rad/s."""
        moving = self.solver.moving(crank_speed)
        if not self.solver.is_hamiltonian:
            growth = self.solver.growth_at(moving)
            return Sample(crank_speed, growth, growth)
        modes = self.solver.solve(moving)
        return Sample(crank_speed, self._of(modes), modes.growth_rate)

    def into(self, dip: Dip) -> list[Sample]:
        """Samples towards the bottom of a dip, up to one at which nothing grows."""
        found: list[Sample] = []

        def measure(crank_speed: float) -> float:
            found.append(self.sample(crank_speed))
            if found[-1].signed_growth <= 0:
                raise StopIteration
            return found[-1].signed_growth

        ends = dip.before.crank_speed, dip.after.crank_speed
        options = {"xatol": NARROWEST_GAP * (ends[1] - ends[0])}
        with suppress(StopIteration):
            scipy.optimize.minimize_scalar(measure, bounds=ends, method="bounded", options=options)
        return found

    def at(self, moving: VibratingLinkage) -> float:
        """Measure of a linkage in its moving modes."""
        if not self.solver.is_hamiltonian:
            return self.solver.growth_at(moving)
        return self._of(self.solver.solve(moving))

    def _of(self, modes: SelectedModes) -> float:
        return self.of_exponents(modes.exponent, modes.period)

    def of_exponents(self, exponent: NDArray[np.complex128], period: float) -> float:
        """Measure of exponents (k,) in 1/s that are known, of a turn's time in s."""
        growth = float(exponent.real.max())
        if not self.solver.is_hamiltonian:
            return growth
        if growth * period > GROWS:
            return growth**2
        return -(nearest_meeting(exponent, period) ** 2)


def nearest_meeting(exponent: NDArray[np.complex128], period: float) -> float:
    """Half of the least angular velocity by which two modes of opposite sense pass, in rad/s.

    Of two modes that mix with higher ones those that turn back may be kept: the others, their
    conjugates, turn forward as fast.
    """
    kept = exponent.imag[exponent.imag > 0]
    forward = (kept if kept.size else np.abs(exponent.imag)) * period
    total = forward[:, None] + forward
    return float(np.abs(wrapped(total)).min() / (2 * period))
