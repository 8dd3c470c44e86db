"""Spectra of a response: over the whole run, and over a window that moves along it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import ShortTimeFFT, get_window, periodogram

from flexmech.types import FloatArray

__all__ = ["Spectrogram", "amplitude_spectrum", "spectrogram"]


WINDOW = "hann"
# Length of the moving window in periods of the lowest natural frequency: shorter, and
# neighbouring frequencies merge; longer, and they have moved on meanwhile.
PERIODS_IN_WINDOW = 6.0
MOST_WINDOWS = 160
LEAST_WINDOW = 16


@dataclass(frozen=True)
class Spectrogram:
    """Amplitude over frequency and time.

    Parameters
    ----------
    time : ndarray, shape (W,)
        Middle of each window in s.
    frequency : ndarray, shape (F,)
        Hz; evenly spaced by one over the window's length.
    amplitude : ndarray, shape (k, F, W)
        Single-sided, of k signals, in their unit.
    """

    time: FloatArray
    frequency: FloatArray
    amplitude: FloatArray


def amplitude_spectrum(
    signals: FloatArray, interval: float, up_to: float
) -> tuple[FloatArray, FloatArray]:
    """Single-sided amplitude spectrum of whole signals under a Hann window.

    Parameters
    ----------
    signals : ndarray, shape (k, N)
    interval : float
        Between samples in s.
    up_to : float
        Highest frequency wanted in Hz.

    Returns
    -------
    ndarray, shape (F,)
        Frequencies in Hz.
    ndarray, shape (k, F)
        Amplitudes in the signals' unit; the mean is taken off.
    """
    frequency, power = periodogram(
        signals, 1 / interval, window=WINDOW, detrend="constant", scaling="spectrum"
    )
    wanted = frequency <= up_to
    return frequency[wanted], np.sqrt(2 * power[:, wanted])


def spectrogram(
    signals: FloatArray, interval: float, lowest: float, up_to: float
) -> Spectrogram | None:
    """Spectra under a Hann window that moves along the signals.

    Parameters
    ----------
    signals : ndarray, shape (k, N)
    interval : float
        Between samples in s.
    lowest : float
        Lowest natural frequency in Hz, which sets the window's length.
    up_to : float
        Highest frequency wanted in Hz.

    Returns
    -------
    Spectrogram or None
        None where the signals are shorter than the window.
    """
    length = max(LEAST_WINDOW, round(PERIODS_IN_WINDOW / (lowest * interval)))
    count = signals.shape[1]
    if count < length:
        return None
    hop = max(1, -(-(count - length) // MOST_WINDOWS))
    transform = ShortTimeFFT(
        get_window(WINDOW, length), hop, 1 / interval, fft_mode="onesided2X", scale_to="magnitude"
    )
    inside = slice(transform.lower_border_end[1], transform.upper_border_begin(count)[1])
    middle = signals - signals.mean(axis=1, keepdims=True)
    amplitude = np.abs(transform.stft(middle, p0=inside.start, p1=inside.stop))
    wanted = transform.f <= up_to
    return Spectrogram(
        time=transform.t(count, p0=inside.start, p1=inside.stop),
        frequency=transform.f[wanted],
        amplitude=amplitude[:, wanted],
    )
