"""Spectra of signals that are known, and the ridge of a run on its predicted frequency."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech import ExudynEngine, ReferenceEngine, natural_frequencies
from flexmech.analyses.response.measurements import deflections, deflections_of
from flexmech.analyses.response.spectra import amplitude_spectrum, spectrogram
from flexmech.linkages import CrankDrive
from flexmech.time_domain import DrivenLinkage, LinkState, linear_run, periodic_turn

RATE = 2000.0
TIME = np.arange(0, 2, 1 / RATE)


def ridge(picture, low, high):
    """Frequency of the greatest amplitude between two frequencies, window by window, (k, W)."""
    frequency = picture.frequency[:, None]
    band = (frequency >= low) & (frequency <= high)
    level = np.where(band, picture.amplitude, -1.0)
    best = picture.frequency[np.argmax(level, axis=1)]
    return np.where(band.any(axis=0), best, np.nan)


def test_amplitude_of_a_sine():
    signal = 3.0 + 0.5 * np.sin(2 * np.pi * 50 * TIME)
    frequency, amplitude = amplitude_spectrum(signal[None], 1 / RATE, up_to=200.0)
    assert amplitude.max() == pytest.approx(0.5, rel=1e-6)
    assert frequency[amplitude[0].argmax()] == pytest.approx(50.0)
    assert frequency.max() <= 200.0


def test_ridge_of_a_chirp():
    signal = np.sin(2 * np.pi * (60 * TIME + 10 * TIME**2))
    picture = spectrogram(signal[None], 1 / RATE, lowest=60.0, up_to=200.0)
    exact = 60 + 20 * picture.time
    bin_width = picture.frequency[1]
    found = ridge(picture, np.full_like(exact, 40.0), np.full_like(exact, 150.0))
    assert np.abs(found[0] - exact).max() <= bin_width / 2 + 0.5
    level = picture.amplitude[0].max(axis=0)
    assert np.all((level > 0.7) & (level < 1.05))


def test_short_signals_have_no_spectrogram():
    assert spectrogram(np.zeros((1, 50)), 1 / RATE, lowest=10.0, up_to=100.0) is None


def free_vibration(engine, speed, steps):
    """Deflection of an undamped run less that of the periodic motion: what vibrates freely."""
    drive = CrankDrive(speed)
    time = drive.revolution_time / 2880 * np.arange(2881)
    step = drive.revolution_time / steps
    reference = ReferenceEngine(engine.mechanism)
    forced = DrivenLinkage(reference, drive, "equilibrium")
    periodic = deflections_of(reference, periodic_turn(forced, steps))[:: steps // 2880]
    if isinstance(engine, ExudynEngine):
        run = engine.simulate(drive, LinkState.rigid(engine.links), time, step)
    else:
        run = linear_run(forced, forced.unstressed(), np.zeros(forced.size), time, step)
    return time, deflections(engine, run)[:-1] - periodic


@pytest.mark.parametrize("kind", [ReferenceEngine, ExudynEngine])
def test_ridge_of_an_undamped_run_is_the_first_moving_frequency(steel, kind):
    """From 58 to 110 Hz and back within a turn of 3.1 s; every window within one bin."""
    engine, speed = kind(steel), 2.0
    time, free = free_vibration(engine, speed, 5760)
    lowest = 62.0
    picture = spectrogram(free[:, 1][None], time[1], lowest, up_to=300.0)
    first, second = natural_frequencies(
        ReferenceEngine(steel), speed * picture.time, speed, modes=2
    ).T
    bin_width = picture.frequency[1]
    found = ridge(picture, first - 3 * bin_width, (first + second) / 2)[0]
    assert np.ptp(first) > 2.5 * bin_width
    assert np.abs(found - first).max() <= bin_width
