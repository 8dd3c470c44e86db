"""Fourier series of periodic arrays: at any number of samples, any shift, with rates."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flexmech.arrays import FloatArray
from flexmech.dynamical_systems import FourierSeries

HARMONICS = 5


def wave(seed: int) -> tuple[FloatArray, FloatArray]:
    """Cosine and sine parts (h + 1, 2, 3) of a random trigonometric polynomial."""
    parts = np.random.default_rng(seed).normal(size=(2, HARMONICS + 1, 2, 3))
    parts[1, 0] = 0.0
    return parts[0], parts[1]


def values(parts: tuple[FloatArray, FloatArray], phase: FloatArray, rate: int = 0) -> FloatArray:
    order = 2 * np.pi * np.arange(HARMONICS + 1)
    turn = np.exp(1j * np.outer(phase, order)) * (1j * order) ** rate
    return np.einsum("pk,kij->pij", turn, parts[0] - 1j * parts[1]).real


@given(
    seed=st.integers(0, 1000),
    sampled=st.integers(2 * HARMONICS + 1, 40),
    count=st.integers(1, 40),
    shift=st.floats(-2, 2),
)
def test_values_at_any_phases(seed: int, sampled: int, count: int, shift: float) -> None:
    # Counts below 2 h + 1 fold the harmonics onto lower ones.
    parts = wave(seed)
    series = FourierSeries.through(values(parts, np.arange(sampled) / sampled))
    phase = (np.arange(count) + shift) / count
    assert series.samples(count, shift) == pytest.approx(values(parts, phase), abs=1e-12)
    rate = values(parts, phase, rate=1)
    assert series.rate().samples(count, shift) == pytest.approx(rate, abs=1e-10)


@pytest.mark.parametrize("count", [8, 9])
def test_number_of_harmonics(count: int) -> None:
    # Of eight samples the phase of the fourth harmonic is unknown; it is left out.
    samples = np.cos(np.pi * np.arange(count))
    series = FourierSeries.through(samples)
    assert series.harmonics == (count - 1) // 2
    if count == 8:
        assert np.abs(series.coefficients).max() < 1e-15


def test_tail_follows_the_error_between_the_samples() -> None:
    # 1 / (1 + 0.8 cos) has harmonics that fall by a half each.
    def function(phase: FloatArray) -> FloatArray:
        return np.asarray(1 / (1 + 0.8 * np.cos(2 * np.pi * phase)))

    for count in (21, 41, 61):
        series = FourierSeries.through(function(np.arange(count) / count))
        between = (np.arange(200) + 0.5) / 200
        error = np.abs(series.samples(200, 0.5) - function(between)).max()
        # The tail begins a quarter of the harmonics below the highest.
        assert error < series.tail * series.coefficients[0].real * 4
        assert series.tail == pytest.approx(0.5 ** (1 + series.harmonics * 3 // 4), rel=1.01)


def test_tail_of_a_constant() -> None:
    assert FourierSeries.through(np.zeros((7, 2))).tail == 0.0
    assert FourierSeries.through(np.ones((7, 2))).tail < 1e-15


@pytest.mark.parametrize("count", [1, 2, 7])
def test_constant_series(count: int) -> None:
    value = np.array([[1.0, 0.1], [3.0, -1e-9]])
    series = FourierSeries.constant(value)
    assert np.array_equal(series.samples(count, 0.3), np.stack(count * [value]))
    assert not series.rate().samples(count).any()
    assert series.harmonics == 0
    assert series.tail == 0.0
