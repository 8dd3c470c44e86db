"""Spectra of signals that are known, and the ridge of a run on its predicted frequency."""

from __future__ import annotations

import numpy as np
import pytest

from flexmech import ExudynEngine, ReferenceEngine, natural_frequencies
from flexmech.analyses.response.measurements import deflections, deflections_of
from flexmech.analyses.response.spectra import (
    WHOLE_PERIODS,
    amplitude_spectrum,
    resolution_note,
    spectrogram,
    window_duration,
)
from flexmech.linkages import ConstantSpeed
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


def test_amplitudes_over_whole_periods_are_those_of_the_fourier_series():
    # An order beside a much greater one: under a window it would drown.
    turn = 2 * np.pi * TIME / 0.5
    signal = 2.0 + np.sin(3 * turn) + 1e-6 * np.cos(4 * turn)
    frequency, amplitude = amplitude_spectrum(signal[None], 1 / RATE, 100.0, WHOLE_PERIODS)
    orders = dict(zip(np.round(frequency * 0.5, 9), amplitude[0], strict=True))
    assert orders[3.0] == pytest.approx(1.0, rel=1e-12)
    assert orders[4.0] == pytest.approx(1e-6, rel=1e-6)
    others = [value for order, value in orders.items() if order not in (3.0, 4.0)]
    assert max(others) < 1e-12


def frequencies_of(first, second):
    return np.stack(np.broadcast_arrays(first, second, np.full_like(TIME, 200.0)), axis=-1)


def test_window_is_long_enough_to_tell_lines_apart_where_these_stand_still():
    close = frequencies_of(40.0, 44.0 + 0.1 * np.sin(TIME))
    duration = window_duration(TIME, close, 40.0)
    assert duration == pytest.approx(2 / 4.0, rel=1e-3)
    signal = np.sin(2 * np.pi * 40.0 * TIME) + np.sin(2 * np.pi * 44.0 * TIME)
    for length, told in ((None, False), (duration, True)):
        picture = spectrogram(signal[None], 1 / RATE, 40.0, 60.0, length)
        level = picture.amplitude[0].mean(axis=1)
        peaks = [
            picture.frequency[n]
            for n in range(1, len(level) - 1)
            if level[n] > max(level[n - 1], level[n + 1], 0.3)
        ]
        assert (len(peaks) == 2) is told
    assert "cannot tell" not in resolution_note(close[:, :2], duration + 0.05)


def test_window_stays_short_where_lines_move_or_the_run_is_too_short():
    moving = frequencies_of(
        40.0 + 8 * np.sin(2 * np.pi * TIME), 44.0 + 8 * np.sin(2 * np.pi * TIME)
    )
    nearly_one = frequencies_of(40.0, 40.5)
    for frequency in (moving, nearly_one, moving[:, :1], frequencies_of(40.0, 90.0)):
        assert window_duration(TIME, frequency, 40.0) == pytest.approx(6 / 40.0)
    note = resolution_note(moving, 0.15)
    assert note == ("window 0.15 s, resolution 13.3 Hz: cannot tell f1 and f2 (nearest 4 Hz) apart")


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
    drive = ConstantSpeed(speed)
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


@pytest.mark.parametrize(
    "kind", [ReferenceEngine, pytest.param(ExudynEngine, marks=pytest.mark.thorough)]
)
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
