"""Kernels of the identification: stabilisation chart, circles and refinement."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech.modal_testing import FrfNoise
from flexmech.modal_testing.identified import fit_residues, modal_sum
from flexmech.modal_testing.identify import circle_fit_poles, peaks
from flexmech.modal_testing.lscf import stabilisation_chart
from flexmech.modal_testing.refine import refined_poles, significant_poles

LINES = np.arange(1, 401) * 0.25
S = 2j * np.pi * LINES
EVEN = FrfNoise.of_lines(LINES, 0.0)


def pole_at(frequency: float, ratio: float) -> complex:
    omega = 2 * np.pi * frequency
    return complex(-ratio * omega, omega * np.sqrt(1 - ratio**2))


def modes_of(*poles: complex, points: int = 1) -> np.ndarray:
    """Receptance of modes of unit modal mass."""
    known = np.array(poles)
    return modal_sum(S, known, np.ones((points, 1)) / (2j * known.imag))


def noise(seed: int, *shape: int) -> np.ndarray:
    real, imaginary = np.random.default_rng(seed).standard_normal((2, *shape))
    return real + 1j * imaginary


# --- the stabilisation chart --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("frequency", "ratio", "same_frequency", "same_pole"),
    [(1.004, 1.04, True, True), (1.006, 1.0, False, False), (1.0, 1.06, True, False)],
)
def test_a_pole_is_stable_within_half_a_percent_of_frequency_and_5_of_damping(
    frequency, ratio, same_frequency, same_pole
):
    orders = [np.array([pole_at(10, 0.01)]), np.array([pole_at(10 * frequency, 0.01 * ratio)])]
    chart = stabilisation_chart(orders, 0.0)
    assert chart.stable_frequency.tolist() == [False, same_frequency]
    assert chart.stable.tolist() == [False, same_pole]


@pytest.mark.parametrize(
    ("orders", "filled", "chosen"), [(20, 5, 1), (20, 4, 0), (10, 4, 1), (10, 3, 0)]
)
def test_a_column_of_stable_poles_is_a_mode_in_a_fifth_of_the_orders(orders, filled, chosen):
    """Three orders at least; the first of a column is not stable, and a growing pole is no mode."""
    nothing = np.zeros(0, dtype=complex)
    column = [np.array([pole_at(10, 0.01)])] * filled + [nothing] * (orders - filled)
    assert stabilisation_chart(column, 0.0).chosen.size == chosen
    growing = stabilisation_chart([-poles.conj() for poles in column], 0.0)
    assert not growing.stable.any()
    assert growing.chosen.size == 0


# --- circles, residues and refinement -----------------------------------------------------------


@pytest.mark.parametrize(("height", "count"), [(1.8, 0), (2.2, 1)])
def test_peaks_rise_to_twice_the_valleys_beside_them(height, count):
    bump = 1 + (height - 1) * np.exp(-(((LINES - 50) / 2) ** 2))
    assert peaks(LINES, (bump / LINES)[None]).size == count


def test_noise_is_no_circle_and_a_noisy_mode_is_one():
    at = np.array([200])
    drawn = [circle_fit_poles(LINES, noise(seed, 6, 400), at, 0.0)[0] for seed in range(20)]
    assert np.isnan(drawn).all()
    exact = modes_of(pole_at(LINES[200], 0.01), points=6)
    noisy = exact + 0.05 * abs(exact).max() * noise(1, 6, 400)
    assert np.isfinite(circle_fit_poles(LINES, noisy, at, 0.0)).all()


def test_refined_poles_stay_within_a_twentieth_of_their_first_place():
    pole = pole_at(50.0, 0.03)
    [near] = refined_poles(S, modes_of(pole), np.array([pole * 1.04]))
    assert near == pytest.approx(pole, rel=1e-6)
    assert np.isnan(refined_poles(S, modes_of(pole), np.array([pole * 1.06]))).all()


@pytest.mark.parametrize(("energy", "kept"), [(23.0, False), (37.0, True)])
def test_noise_looks_like_a_mode_once_in_a_thousand_bands(energy, kept):
    """Energy of a mode over the variance of the noise, which adds four: the limit is 31."""
    pole = pole_at(50.0, 0.005)
    exact = modes_of(pole)
    exact *= np.sqrt(energy / np.sum(abs(exact) ** 2))
    counts = [
        significant_poles(S, exact + noise(seed, 1, 400), np.array([pole]), EVEN).size
        for seed in range(30)
    ]
    assert (sum(counts) > 15) == kept


def test_noise_under_an_exponential_window_is_no_mode():
    """Lines are alike to 2a/|2a + i k dw|: the pole of the highest one is never significant.

    Were they independent, it would be in most of the records.
    """
    rate, samples = 2.0, 2048
    time = np.arange(samples) / 200.0
    window, lines = np.exp(-rate * time), np.arange(1, 401) / time[-1] * (1 - 1 / samples)
    s, found = rate + 2j * np.pi * lines, {"known": 0, "independent": 0}
    for seed in range(20):
        white = np.random.default_rng(seed).standard_normal(samples)
        spectrum = np.fft.rfft(white * window)[1:401]
        apart = spectrum[1:] * spectrum[:-1].conj()
        assert abs(apart.mean()) > 0.4 * np.mean(abs(spectrum) ** 2)
        pole = np.array([2j * np.pi * lines[abs(spectrum).argmax()] - 1e-3])
        for name, decay in (("known", rate), ("independent", 0.0)):
            kind = FrfNoise.of_lines(lines, decay)
            found[name] += significant_poles(s, spectrum[None], pole, kind).size
    assert found["known"] == 0 < 10 < found["independent"]


def test_modes_above_the_band_leave_residues_below_right_to_5e_5():
    """Without the last term of their series the second residue is 1.7e-4 off."""
    inside = np.array([pole_at(40.0, 0.005), pole_at(85.0, 0.005)])
    residue, _ = fit_residues(S, modes_of(*inside, pole_at(150.0, 0.005)), inside)
    np.testing.assert_allclose(residue[0], 1 / (2j * inside.imag), rtol=5e-5)
