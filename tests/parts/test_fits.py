"""Least squares with intervals: of a decaying vibration under white noise and noise that rings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.signal import lfilter

from flexmech.analyses.comparison.fit import Fit, Parameter, autoregression, fitted

TIME = np.linspace(0.0, 1.0, 400)
RATE, WAVE = 3.0, 40.0


@dataclass(frozen=True)
class Decay:
    """A decaying vibration of unknown amplitude, which is found by itself."""

    measured: np.ndarray
    names: tuple[str, ...] = ("rate",)
    linear_unknowns = 1

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return tuple(Parameter(name, "1/s", 2.0, 1.0) for name in self.names)

    def computed(self, values: Sequence[float]) -> np.ndarray:
        shape = np.exp(-sum(values) * TIME) * np.cos(WAVE * TIME)
        return (shape * (self.measured[0] @ shape) / (shape @ shape))[None]


RADIUS, TURN = 0.95, WAVE * (TIME[1] - TIME[0])
RINGING = (1.0, -2 * RADIUS * np.cos(TURN), RADIUS**2)
"""Filter of a noise that rings as the vibration does."""


def record(seed: int, size: float, noise: tuple[float, ...] = (1.0,)) -> np.ndarray:
    white = np.random.default_rng(seed).standard_normal(len(TIME) + 200)
    coloured = lfilter([1.0], noise, white)[200:]
    return (2 * np.exp(-RATE * TIME) * np.cos(WAVE * TIME) + size * coloured)[None]


def held(fits: list[Fit], widening: float = 1.0) -> float:
    """Part of the intervals, made narrower by a factor, that hold the true rate."""
    halves = [(fit.upper[0] - fit.values[0]) / widening for fit in fits]
    pairs = zip(fits, halves, strict=True)
    return float(np.mean([abs(fit.values[0] - RATE) <= half for fit, half in pairs]))


def test_intervals_of_95_percent_hold_for_white_noise():
    """Between 181 and 198 of 200 intervals hold with a probability of 0.999.

    Their standard error is the noise over the slope by the rate that no amplitude makes up for.
    """
    fits = [fitted(Decay(record(seed, 0.1))) for seed in range(200)]
    assert 181 / 200 <= held(fits) <= 198 / 200
    shape = np.exp(-RATE * TIME) * np.cos(WAVE * TIME)
    slope = -2 * TIME * shape
    slope -= shape * (shape @ slope) / (shape @ shape)
    error = np.mean([fit.standard_error[0] for fit in fits])
    assert error == pytest.approx(0.1 / np.linalg.norm(slope), rel=0.03)
    first = record(0, 0.1)
    left = np.sum((first - fits[0].computed) ** 2) / np.sum((first - first.mean()) ** 2)
    assert fits[0].unexplained == pytest.approx(left)


def test_intervals_are_widened_for_noise_that_rings_as_the_vibration_does():
    """As wide as for white noise they would be wrong more often than right."""
    fits = [fitted(Decay(record(seed, 0.003, RINGING))) for seed in range(200)]
    factor = float(np.median([fit.widened for fit in fits]))
    assert min(fit.order for fit in fits) >= 2
    assert factor > 2
    assert held(fits) >= 0.9
    assert held(fits, factor) < 0.5


def test_the_order_of_a_process_and_that_of_white_noise_are_found():
    white = np.random.default_rng(1).standard_normal((1, 4000))
    assert len(autoregression(white)) == 0
    process = autoregression(lfilter([1.0], [1.0, -1.2, 0.7], white, axis=1))
    assert process[:2] == pytest.approx([1.2, -0.7], abs=0.05)
    assert len(process) <= 4
