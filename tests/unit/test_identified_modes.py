"""What is fitted of receptances, what counts as a mode, and how well it fits."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech.modal_testing import circle_fit, identify
from flexmech.modal_testing.lscf import stabilisation_chart
from tests.unit.test_modal_testing import FREQUENCY, RATIO, pole_of, receptance


def test_the_misfit_is_what_the_model_leaves_of_the_receptances() -> None:
    """Of white noise a fit of so many lines leaves nearly all."""
    lines, noise = np.arange(10.0, 391.0), 0.05
    exact = receptance(lines)
    real, imaginary = np.random.default_rng(5).standard_normal((2, *exact.shape))
    size = np.sqrt(np.mean(abs(exact) ** 2) / 2)
    measured = exact + noise * size * (real + 1j * imaginary)
    modes = identify(lines, measured, expected=FREQUENCY[:3], method="circle-fit")
    misfit = np.linalg.norm(measured - modes.receptance(lines)) / np.linalg.norm(measured)
    np.testing.assert_allclose(modes.misfit, misfit, rtol=1e-9)
    assert 0.9 * noise < modes.misfit < 1.1 * noise


def test_a_window_widens_the_circle_that_is_fitted(monkeypatch: pytest.MonkeyPatch) -> None:
    """A peak is as wide as damping and window together make it."""
    lines, window, spans = np.arange(1, 1000) * 0.1, 6.0, []
    fitted = circle_fit._circle

    def watched(s: np.ndarray, *rest: object) -> tuple[complex, float]:
        spans.append(abs(s[-1] - s[0]) / (2 * np.pi))
        return fitted(s, *rest)

    monkeypatch.setattr(circle_fit, "_circle", watched)
    peak = np.array([np.argmin(abs(lines - FREQUENCY[0]))])
    pole = circle_fit.circle_fit_poles(lines, receptance(lines, window), peak, window)
    assert abs(pole[0]) == pytest.approx(2 * np.pi * FREQUENCY[0], rel=1e-3)
    half_power = 2 * (window - pole[0].real) / (2 * np.pi)
    assert -pole[0].real == pytest.approx(2 * np.pi * FREQUENCY[0] * RATIO[0], rel=0.05)
    assert spans[-1] == pytest.approx(2 * circle_fit.WIDTH * half_power, abs=0.3)


def test_what_grows_is_no_mode_however_often_it_comes_back() -> None:
    growing = np.array([-pole_of(10.0, 0.01).conjugate()])
    chart = stabilisation_chart([growing] * 20, 0.0)
    assert chart.stable_frequency[1:].all()
    assert not chart.stable.any()
    assert chart.chosen.size == 0
