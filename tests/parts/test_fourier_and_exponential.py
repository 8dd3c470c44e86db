"""Fourier series of periodic arrays, and exponentials of stacks of small matrices."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from flexmech.dynamical_systems import FourierSeries, matrix_exponentials

FloatArray = NDArray[np.float64]
HARMONICS = 5


def values(parts: FloatArray, phase: FloatArray, rate: int = 0) -> FloatArray:
    """Values of a trigonometric polynomial by its cosine and sine parts (2, h + 1, 2, 3)."""
    order = 2 * np.pi * np.arange(HARMONICS + 1)
    turn = np.exp(1j * np.outer(phase, order)) * (1j * order) ** rate
    return np.einsum("pk,kij->pij", turn, parts[0] - 1j * parts[1]).real


@given(
    seed=st.integers(0, 1000),
    sampled=st.integers(2 * HARMONICS + 1, 40),
    count=st.integers(1, 40),
    shift=st.floats(-2, 2),
)
@settings(max_examples=15, deadline=None)
def test_a_series_and_its_rate_are_right_at_any_phase(
    seed: int, sampled: int, count: int, shift: float
) -> None:
    """Counts below 2 h + 1 fold the harmonics onto lower ones."""
    parts = np.random.default_rng(seed).normal(size=(2, HARMONICS + 1, 2, 3))
    parts[1, 0] = 0.0
    series = FourierSeries.through(values(parts, np.arange(sampled) / sampled))
    phase = (np.arange(count) + shift) / count
    assert series.samples(count, shift) == pytest.approx(values(parts, phase), abs=1e-12)
    rate = values(parts, phase, rate=1)
    assert series.rate().samples(count, shift) == pytest.approx(rate, abs=1e-10)


def test_the_highest_harmonic_of_an_even_number_of_samples_is_left_out() -> None:
    """Its phase is unknown: of eight samples, that of the fourth."""
    series = FourierSeries.through(np.cos(np.pi * np.arange(8)))
    assert series.harmonics == 3
    assert np.abs(series.coefficients).max() < 1e-15


@pytest.mark.parametrize("count", [21, 61])
def test_the_tail_of_a_series_is_the_error_between_the_samples(count: int) -> None:
    """The harmonics of ``1 / (1 + 0.8 cos)`` fall by a half each."""

    def function(phase: FloatArray) -> FloatArray:
        return np.asarray(1 / (1 + 0.8 * np.cos(2 * np.pi * phase)))

    series = FourierSeries.through(function(np.arange(count) / count))
    error = np.abs(series.samples(200, 0.5) - function((np.arange(200) + 0.5) / 200)).max()
    # The tail begins a quarter of the harmonics below the highest.
    assert error < series.tail * series.coefficients[0].real * 4
    assert series.tail == pytest.approx(0.5 ** (1 + series.harmonics * 3 // 4), rel=1.01)


@pytest.mark.parametrize("size", [1, 5, 24])
@pytest.mark.parametrize("norm", [1e-9, 3.0, 60.0])
def test_exponentials_are_those_by_their_series_in_extended_precision(
    size: int, norm: float
) -> None:
    matrices = np.random.default_rng(size).normal(size=(7, size, size))
    matrices *= norm / np.abs(matrices).sum(axis=1).max()
    halvings = 8
    term = np.broadcast_to(np.eye(size, dtype=np.longdouble), matrices.shape)
    exact = term.copy()
    for order in range(1, 25):
        term = term @ (matrices / np.longdouble(2.0**halvings)) / order
        exact += term
    for _ in range(halvings):
        exact = exact @ exact
    gap = np.abs(matrix_exponentials(matrices) - exact).max(axis=(1, 2))
    assert np.all(gap < 1e-15 * max(10.0, norm) * np.abs(exact).max(axis=(1, 2)))


def test_what_dies_out_in_a_step_is_not_lost_beside_what_stays() -> None:
    found = matrix_exponentials(np.diag([-700.0, -30.0, 0.0])[None])
    assert np.diag(found[0]) == pytest.approx(np.exp([-700.0, -30.0, 0.0]), rel=1e-11)


def test_a_long_stack_of_exponentials_keeps_its_order() -> None:
    angle = np.linspace(0.0, 1.0, 20_000)
    found = matrix_exponentials(angle[:, None, None] * np.array([[0.0, -1.0], [1.0, 0.0]]))
    assert np.abs(found[:, 1, 0] - np.sin(angle)).max() < 1e-15
