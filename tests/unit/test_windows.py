"""Windows over the records of a hammer test, by their definitions."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech.modal_testing import ExponentialWindow, ForceWindow, estimate_frf


def test_a_force_window_is_full_over_its_length_and_falls_over_its_taper() -> None:
    window = ForceWindow(0.02, taper=0.008)
    time = np.array([0.0, 0.012, 0.02, 0.022, 0.024, 0.026, 0.028, 0.1])
    quarter = 0.5 * (1 + np.sqrt(0.5))
    expected = [1.0, 1.0, 1.0, quarter, 0.5, 1 - quarter, 0.0, 0.0]
    np.testing.assert_allclose(window.values(time), expected, rtol=0, atol=1e-12)


def test_a_taper_leaves_a_force_that_ends_within_the_length_as_it_is() -> None:
    """The last sample of the force is at the end of the length."""
    rate = 1000.0
    force, response = np.zeros((2, 256))
    force[:21] = np.sin(np.pi * np.arange(21) / 42)
    response[5:105] = 1.0
    plain = estimate_frf(force, response, rate)
    tapered = estimate_frf(force, response, rate, force_window=ForceWindow(0.02, taper=0.01))
    np.testing.assert_allclose(tapered.h1, plain.h1, rtol=1e-9)


@pytest.mark.parametrize("frequency", [20.0, 150.0])
def test_the_damping_that_a_window_adds_is_that_of_a_pole_moved_by_its_rate(
    frequency: float,
) -> None:
    """Of lightly damped modes, whose damping ratio is the decay rate over the frequency."""
    window = ExponentialWindow.ending_at(2.0, 0.05)
    assert window.values(np.array([2.0]))[0] == pytest.approx(0.05)
    pole = 2 * np.pi * frequency * (-1e-3 + 1j)
    moved = pole - window.decay_rate
    added = -moved.real / abs(moved) + pole.real / abs(pole)
    assert window.added_damping_ratio(frequency) == pytest.approx(added, rel=1e-3)
