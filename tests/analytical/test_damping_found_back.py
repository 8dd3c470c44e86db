"""Of noisy records of a damped linkage, at least 90 in 100 give their damping back.

The records are runs of the reference engine from undeformed links, whose links stretch by the
square of their slopes: the fitted equations, linear ones in moving modes, know nothing of that.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from flexmech.analyses.comparison.fit import Fit, fitted
from flexmech.analyses.comparison.over_time import TimeProblem
from flexmech.analyses.comparison.parameters import fitted_names
from flexmech.analyses.comparison.quantities import gauges
from tests.support.comparison_data import SPEED, damping_time, history, undamped

LINKS = ("crank", "coupler", "rocker")
# A part of the signal, and how the noise of one sample lives on in the next.
NOISE, MEMORY = 0.03, 0.8
# Of the thorough form records begin anywhere in the first turn, and do not tell where.
SAMPLES_A_TURN = 180


def fits(seeds: range, memory: float = 0.0, *, anywhere: bool = False) -> Iterator[Fit]:
    """Damping fitted to records with noise of fixed seeds."""
    time, angle, strain = history()
    gauge = next(g for g in gauges(undamped()) if g.name == "coupler_mid_strain")
    known = TimeProblem(
        engine=undamped(),
        record=strain,
        names=fitted_names(("damping",), LINKS),
        crank_speed=SPEED,
        gauge=gauge,
        time=time,
        angle=angle,
    )
    for seed in seeds:
        random = np.random.default_rng(seed)
        white = random.standard_normal(len(strain))
        noise = lfilter([np.sqrt(1 - memory**2)], [1.0, -memory], white)
        first = int(random.integers(SAMPLES_A_TURN)) if anywhere else 0
        record = (strain + NOISE * strain.std() * noise)[first:]
        shorter = time[first:] - time[first]
        own = None if anywhere else angle
        # The linkages that are kept for one record serve all of them.
        yield fitted(replace(known, time=shorter, record=record, angle=own))


def held(found: Iterator[Fit]) -> int:
    """How many of the intervals hold the true damping time."""
    return sum(bool(fit.lower[0] <= damping_time() <= fit.upper[0]) for fit in found)


@pytest.mark.thorough
def test_a_few_records_give_their_damping_back():
    """Of six intervals of 95 % fewer than four hold with a probability of 0.002.

    They are narrow: a tenth more damping is in none of them.
    """
    found = list(fits(range(6)))
    assert held(iter(found)) >= 4
    assert all(fit.upper[0] < 1.1 * damping_time() for fit in found)


@pytest.mark.thorough
def test_of_100_records_90_give_their_damping_back():
    """Of 100 intervals of 95 % fewer than 90 hold with a probability of 0.011."""
    assert held(fits(range(100))) >= 90


@pytest.mark.thorough
def test_of_40_records_without_crank_angle_36_give_their_damping_back():
    """Of 40 intervals of 95 % fewer than 36 hold with a probability of 0.014."""
    assert held(fits(range(1000, 1040), anywhere=True)) >= 36


@pytest.mark.thorough
def test_of_40_records_with_coloured_noise_36_give_their_damping_back():
    assert held(fits(range(2000, 2040), MEMORY)) >= 36
