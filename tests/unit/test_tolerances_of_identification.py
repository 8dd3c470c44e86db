"""Numbers that decide what is identified: each test fails where one is changed grossly."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech.errors import InputError
from flexmech.modal_testing.circle_fit import circle_fit_poles, peaks
from flexmech.modal_testing.harmonic_orders import estimate_harmonics
from flexmech.modal_testing.identified import fit_residues, modal_sum
from flexmech.modal_testing.refine import refined_poles, significant_poles

LINES = np.arange(1, 401) * 0.25
S = 2j * np.pi * LINES


def pole_at(frequency: float, ratio: float) -> complex:
    return complex(2 * np.pi * frequency * (-ratio + 1j))


def modes_of(*poles: complex, points: int = 1) -> np.ndarray:
    """Receptance of modes of unit modal mass."""
    each = np.array(poles)
    return modal_sum(S, each, np.ones((points, 1)) / (2j * each.imag))


def noise(seed: int, *shape: int) -> np.ndarray:
    """White noise with unit variance of its real and of its imaginary part."""
    real, imaginary = np.random.default_rng(seed).standard_normal((2, *shape))
    return np.asarray(real + 1j * imaginary)


@pytest.mark.parametrize(("height", "found"), [(1.8, 0), (2.2, 1)])
def test_peaks_rise_to_twice_the_valleys_beside_them(height, found):
    bump = 1 + (height - 1) * np.exp(-(((LINES - 50) / 2) ** 2))
    assert peaks(LINES, (bump / LINES)[None]).size == found


def test_noise_is_no_circle_and_a_noisy_mode_is_one():
    at = np.array([200])
    found = [circle_fit_poles(LINES, noise(seed, 6, 400), at, 0.0)[0] for seed in range(20)]
    assert np.isnan(found).all()
    exact = modes_of(pole_at(LINES[200], 0.01), points=6)
    noisy = exact + 0.05 * abs(exact).max() * noise(1, 6, 400)
    assert np.isfinite(circle_fit_poles(LINES, noisy, at, 0.0)).all()


def test_refined_poles_stay_within_a_twentieth_of_their_first_place():
    pole = pole_at(50.0, 0.03)
    exact = modes_of(pole)
    [near] = refined_poles(S, exact, np.array([pole * 1.04]))
    assert near == pytest.approx(pole, rel=1e-6)
    assert np.isnan(refined_poles(S, exact, np.array([pole * 1.06]))).all()


@pytest.mark.parametrize(("energy", "kept"), [(23.0, False), (37.0, True)])
def test_noise_looks_like_a_mode_once_in_a_thousand_bands(energy, kept):
    """Of a mode's energy over the variance of the noise, which adds four: the limit is 31."""
    pole = pole_at(50.0, 0.005)
    exact = modes_of(pole)
    exact *= np.sqrt(energy / np.sum(abs(exact) ** 2))
    counts = [
        significant_poles(S, exact + noise(seed, 1, 400), np.array([pole])).size
        for seed in range(30)
    ]
    assert (sum(counts) > 15) == kept


def test_modes_above_the_band_do_not_change_residues_below():
    """With one term less the second residue is 1.7e-4 off, with the constant alone 1.1e-3."""
    inside = np.array([pole_at(40.0, 0.005), pole_at(85.0, 0.005)])
    residue, _ = fit_residues(S, modes_of(*inside, pole_at(150.0, 0.005)), inside)
    np.testing.assert_allclose(residue[0], 1 / (2j * inside.imag), rtol=5e-5)


@pytest.mark.parametrize(("spread", "refused"), [(0.15, False), (0.05, True)])
def test_impacts_close_together_do_not_tell_the_orders_apart(spread, refused):
    """Of three impacts that part of a radian of the period apart."""
    number, period = np.arange(16), 4
    force = np.exp(-1j * spread * np.arange(3)[:, None] * number / period)
    asked = {"highest_order": 1, "shift": period, "bins": 8}
    if refused:
        with pytest.raises(InputError, match=r"do not tell the orders apart .*spread them"):
            estimate_harmonics(force, force, **asked)
    else:
        assert 100 < estimate_harmonics(force, force, **asked).condition < 1000
