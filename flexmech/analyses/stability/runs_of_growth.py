"""Runs of neighbouring crank speeds at which a vibration grows."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise


@dataclass(frozen=True)
class Sample:
    """Growth at a crank speed.

    Parameters
    ----------
    crank_speed : float
        rad/s.
    signed_growth : float
        Positive where a vibration grows; see
        :class:`flexmech.analyses.stability.signed_growth.SignedGrowth`.
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
