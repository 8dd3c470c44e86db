"""Least squares with intervals: they hold for white noise, and for noise that is not white."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.signal import lfilter

from flexmech.analyses.comparison.fit import Fit, Parameter, autoregression, fitted
from flexmech.arrays import FloatArray
from flexmech.errors import ComputationError

TIME = np.linspace(0.0, 1.0, 400)
RATE, WAVE = 3.0, 40.0


@dataclass(frozen=True)
class Decay:
    """A decaying vibration of unknown amplitude, which is found by itself."""

    measured: FloatArray
    names: tuple[str, ...] = ("rate",)
    linear_unknowns = 1

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return tuple(Parameter(name, "1/s", 2.0, 1.0) for name in self.names)

    def computed(self, values: Sequence[float]) -> FloatArray:
        shape = np.exp(-sum(values) * TIME) * np.cos(WAVE * TIME)
        return np.asarray(shape * (self.measured[0] @ shape) / (shape @ shape))[None]


# A noise that rings as the vibration does, and of the same size as white noise elsewhere.
RADIUS, TURN = 0.95, WAVE * (TIME[1] - TIME[0])
RINGING = (1.0, -2 * RADIUS * np.cos(TURN), RADIUS**2)
WHITE = (1.0,)


def record(seed: int, size: float, noise: tuple[float, ...] = WHITE) -> FloatArray:
    white = np.random.default_rng(seed).standard_normal(len(TIME) + 200)
    coloured = lfilter([1.0], noise, white)[200:]
    return np.asarray(2 * np.exp(-RATE * TIME) * np.cos(WAVE * TIME) + size * coloured)[None]


def held(fits: list[Fit], widening: float = 1.0) -> float:
    """Part of the intervals, made narrower by a factor, that hold the true rate."""
    return float(
        np.mean(
            [abs(fit.values[0] - RATE) <= (fit.upper[0] - fit.values[0]) / widening for fit in fits]
        )
    )


def test_intervals_hold_for_white_noise():
    """Of 200 intervals of 95 % between 181 and 198 hold with a probability of 0.999."""
    fits = [fitted(Decay(record(seed, 0.1))) for seed in range(200)]
    assert 181 / 200 <= held(fits) <= 198 / 200


def test_intervals_are_widened_for_noise_that_rings_as_the_vibration_does():
    fits = [fitted(Decay(record(seed, 0.003, RINGING))) for seed in range(200)]
    factors = np.array([fit.widened for fit in fits])
    assert min(fit.order for fit in fits) >= 2
    assert np.median(factors) > 2
    assert held(fits) >= 0.9
    # As wide as for white noise they would be wrong more often than right.
    assert held(fits, float(np.median(factors))) < 0.5


def test_the_standard_error_is_the_scatter():
    fits = [fitted(Decay(record(seed, 0.1))) for seed in range(200)]
    scatter = np.std([fit.values[0] for fit in fits])
    assert np.mean([fit.standard_error[0] for fit in fits]) == pytest.approx(scatter, rel=0.15)


def test_the_order_of_a_process_and_that_of_white_noise():
    white = np.random.default_rng(1).standard_normal((1, 4000))
    assert len(autoregression(white)) == 0
    second = lfilter([1.0], [1.0, -1.2, 0.7], white, axis=1)
    found = autoregression(second)
    assert found[:2] == pytest.approx([1.2, -0.7], abs=0.05)
    assert len(found) <= 4


def test_what_remains_is_told():
    fit = fitted(Decay(record(0, 0.1)))
    spread = np.sum((record(0, 0.1) - record(0, 0.1).mean()) ** 2)
    assert fit.unexplained == pytest.approx(np.sum((record(0, 0.1) - fit.computed) ** 2) / spread)


def test_parameters_that_do_the_same_are_refused():
    with pytest.raises(ComputationError, match="does not tell rate, other apart"):
        fitted(Decay(record(0, 0.1), ("rate", "other")))


def test_nothing_to_fit():
    fit = fitted(Decay(record(0, 0.0), ()))
    assert fit.values.size == 0
    assert fit.unexplained > 0.1
