"""Steps of the integrator of linkages that stretch, its quadrature and the filter of forces."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flexmech.analyses.extremes import peaks_between
from flexmech.analyses.response.measurements import (
    WHOLE_PERIODS,
    amplitude_spectrum,
    spectrogram,
)
from flexmech.dynamical_systems import (
    FourierSeries,
    LowPass,
    differentiation_matrices,
    parabolic_work,
)
from flexmech.dynamical_systems.lobatto import MARCH_ON, WEIGHTS
from flexmech.solvers import step_lag

FloatArray = NDArray[np.float64]
RATE = 2000.0
TIME = np.arange(0, 2, 1 / RATE)


def test_a_free_vibration_takes_a_step_of_the_diagonal_pade_approximation() -> None:
    """(2, 2) of the exponential function: it keeps its size, and lags in fourth order."""
    for angle in (0.2, 0.4, 3.0, 300.0):
        # H^2 z'' = -angle^2 z at both stages of a double step, from both states at its start.
        start = np.array([[1.0, 0.0], [0.0, angle], [-(angle**2), 0.0]])
        by_start, by_stages = MARCH_ON[:, 2, :3], MARCH_ON[:, 2, 3:]
        stages = np.linalg.solve(by_stages + angle**2 * np.eye(2), -by_start @ start)
        end = MARCH_ON[-1] @ np.concatenate([start, stages])
        turned = np.linalg.eigvals(end[:2] / [[1.0], [angle]])
        pade = np.roots([1 / 12, 1 / 2, 1.0]), np.roots([1 / 12, -1 / 2, 1.0])
        expected = np.prod(1j * angle - pade[0]) / np.prod(1j * angle - pade[1])
        assert np.abs(turned) == pytest.approx([1.0, 1.0], abs=1e-9)
        assert np.abs(turned - expected).min() < 1e-9
        if angle < 1:
            lag = 1 - np.abs(np.angle(turned[0])) / angle
            assert lag == pytest.approx(step_lag(angle / 2, stretches=True), rel=0.02)


def test_powers_are_integrated_as_the_stages_are() -> None:
    """Cubics are exact up to each end, parabolas also up to each middle."""
    step, time = 0.1, 0.1 * np.arange(7)
    work = parabolic_work(step, np.stack([time**2, time**3]))
    assert work[0] == pytest.approx(time**3 / 3, abs=1e-12)
    assert work[1, ::2] == pytest.approx(time[::2] ** 4 / 4, abs=1e-12)


def filtered(
    values: FloatArray, band: float, piece: int, weights: tuple[float, ...] = (1.0,)
) -> FloatArray:
    low_pass = LowPass(band, 1e-4, weights)
    parts = [low_pass.add(values[i : i + piece]) for i in range(0, len(values), piece)]
    return np.concatenate([*parts, low_pass.finish()])


def test_the_filter_of_forces_passes_its_band_and_stops_twice_of_it() -> None:
    time = 1e-4 * np.arange(4000)
    for frequency, gain in ((20.0, 1.0), (400.0, 1.0), (800.0, 0.0), (3000.0, 0.0)):
        signal = np.cos(2 * np.pi * frequency * time)
        passed = filtered(signal[:, None], 400.0, 4000)[:, 0]
        assert np.abs(passed - gain * signal)[100:-100].max() < 2.5e-3


def test_what_no_double_step_resolves_does_not_pass_for_slow() -> None:
    """A stiff vibration is 1 at the ends and -1/2 in the middles: on the mean of both, 1/4."""
    values = np.where(np.arange(4000) % 2, -0.5, 1.0)[:, None]
    slow = np.cos(2 * np.pi * 150.0 * 1e-4 * np.arange(4000))[:, None]
    inside = slice(100, -100)
    weights = tuple(WEIGHTS)
    assert np.abs(filtered(values, 400.0, 4000)[inside] - 0.25).max() < 1e-3
    assert np.abs(filtered(values, 400.0, 999, weights)[inside]).max() < 1e-3
    assert np.abs(filtered(slow, 400.0, 999, weights) - slow)[inside].max() < 2.5e-3


def test_a_history_may_be_filtered_in_pieces() -> None:
    values = np.random.default_rng(0).normal(size=(997, 3))
    whole = filtered(values, 300.0, 997)
    assert len(whole) == 997
    assert filtered(values, 300.0, 50) == pytest.approx(whole, abs=1e-12)


def test_derivatives_of_harmonics_along_a_turn_are_exact() -> None:
    first, second = differentiation_matrices(32, -3.0)
    angle = 2 * np.pi / 32 * np.arange(32)
    z = 0.3 + np.cos(5 * angle) - 2 * np.sin(15 * angle)
    exact = -5 * np.sin(5 * angle) - 30 * np.cos(15 * angle)
    assert first @ z == pytest.approx(-3.0 * exact, abs=1e-10)
    exact = -25 * np.cos(5 * angle) + 450 * np.sin(15 * angle)
    assert second @ z == pytest.approx(9.0 * exact, abs=1e-10)
    elsewhere = np.array([0.1, 2.0])
    exact = 0.3 + np.cos(5 * elsewhere) - 2 * np.sin(15 * elsewhere)
    series = FourierSeries.through(z, with_last_cosine=True)
    assert series.at(elsewhere / (2 * np.pi)) == pytest.approx(exact, abs=1e-12)


def test_a_peak_of_a_cosine_between_its_samples_is_found_to_fourth_order() -> None:
    errors = []
    for spacing in (0.4, 0.2):
        place = spacing * np.arange(int(4 / spacing))
        peaks = 2.0 + spacing * np.linspace(0, 1, 20)
        size, where = peaks_between(-np.cos(place[:, None] - peaks), place)
        np.testing.assert_allclose(where, peaks, atol=0.1 * spacing)
        errors.append(np.abs(size - 1).max())
    assert errors[1] == pytest.approx(errors[0] / 16, rel=0.2)
    # The peak of a growing history is its end.
    assert peaks_between(np.arange(5.0)[:, None] ** 2, np.arange(5.0)) == ([16.0], [4.0])


def test_a_spectrum_has_the_amplitude_and_the_frequency_of_a_sine() -> None:
    signal = 3.0 + 0.5 * np.sin(2 * np.pi * 50 * TIME)
    frequency, amplitude = amplitude_spectrum(signal[None], 1 / RATE, up_to=200.0)
    assert amplitude.max() == pytest.approx(0.5, rel=1e-6)
    assert frequency[amplitude[0].argmax()] == pytest.approx(50.0)


def test_amplitudes_over_whole_periods_are_those_of_the_fourier_series() -> None:
    """An order beside a much greater one: under a window it would drown."""
    turn = 2 * np.pi * TIME / 0.5
    signal = 2.0 + np.sin(3 * turn) + 1e-6 * np.cos(4 * turn)
    frequency, amplitude = amplitude_spectrum(signal[None], 1 / RATE, 100.0, WHOLE_PERIODS)
    orders = dict(zip(np.round(frequency * 0.5, 9), amplitude[0], strict=True))
    assert orders[3.0] == pytest.approx(1.0, rel=1e-12)
    assert orders[4.0] == pytest.approx(1e-6, rel=1e-6)
    assert max(value for order, value in orders.items() if order not in (3.0, 4.0)) < 1e-12


def test_the_ridge_of_a_chirp_follows_its_frequency() -> None:
    signal = np.sin(2 * np.pi * (60 * TIME + 10 * TIME**2))
    picture: Any = spectrogram(signal[None], 1 / RATE, lowest=60.0, up_to=200.0)
    exact = 60 + 20 * picture.time
    ridge = picture.frequency[picture.amplitude[0].argmax(axis=0)]
    assert np.abs(ridge - exact).max() <= picture.frequency[1] / 2 + 0.5
    level = picture.amplitude[0].max(axis=0)
    assert np.all((level > 0.7) & (level < 1.05))
