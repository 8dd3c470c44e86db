"""Spectra of a response: over the whole run, and over a window that moves along it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import ShortTimeFFT, get_window, periodogram

from flexmech.arrays import FloatArray

_WINDOW = "hann"
# Window of signals that repeat: over whole periods none is needed.
WHOLE_PERIODS = "boxcar"
# Distance of two frequencies that a Hann window tells apart, over one by its length: half the
# width of its main lobe.
_RESOLVED = 2.0
# Length of the moving window in periods of the lowest natural frequency: shorter, and
# neighbouring frequencies merge; longer, and they have moved on meanwhile.
_PERIODS_IN_WINDOW = 6.0
# As many columns as a picture shows, and samples of which a spectrum can be made.
_MOST_WINDOWS = 160
_LEAST_WINDOW = 16


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
    signals: FloatArray, interval: float, up_to: float, window: str = _WINDOW
) -> tuple[FloatArray, FloatArray]:
    """Single-sided amplitude spectrum of whole signals under a window.

    Parameters
    ----------
    signals : ndarray, shape (k, N)
    interval : float
        Between samples in s.
    up_to : float
        Highest frequency wanted in Hz.
    window : str
        Hann's; ``"boxcar"`` is none, for whole periods without their last sample, whose
        amplitudes are then those of the Fourier series.

    Returns
    -------
    ndarray, shape (F,)
        Frequencies in Hz.
    ndarray, shape (k, F)
        Amplitudes in the signals' unit; the mean is taken off.
    """
    frequency, power = periodogram(
        signals, 1 / interval, window=window, detrend="constant", scaling="spectrum"
    )
    wanted = frequency <= up_to
    return frequency[wanted], np.sqrt(2 * power[:, wanted])


def spectrogram(
    signals: FloatArray,
    interval: float,
    lowest: float,
    up_to: float,
    duration: float | None = None,
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
    duration : float, optional
        Length of the window in s instead.

    Returns
    -------
    Spectrogram or None
        None where the signals are shorter than the window.
    """
    duration = duration or _PERIODS_IN_WINDOW / lowest
    length = max(_LEAST_WINDOW, round(duration / interval))
    count = signals.shape[1]
    if count < length:
        return None
    hop = max(1, -(-(count - length) // _MOST_WINDOWS))
    transform = ShortTimeFFT(
        get_window(_WINDOW, length), hop, 1 / interval, fft_mode="onesided2X", scale_to="magnitude"
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


def window_duration(time: FloatArray, frequency: FloatArray, lowest: float) -> float:
    """Length of a window that tells the first two natural frequencies apart, if one can.

    It must be long enough for their distance, and so short that they move by less than half of
    it meanwhile, and that the run holds two of it.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Evenly spaced, in s.
    frequency : ndarray, shape (n, m)
        Predicted natural frequencies in Hz, ascending.
    lowest : float
        Lowest natural frequency in Hz.

    Returns
    -------
    float
        In s; six periods of the lowest frequency where none can, or where these suffice.
    """
    shortest = _PERIODS_IN_WINDOW / lowest
    if frequency.shape[1] < 2 or len(time) < 2:
        return shortest
    apart = frequency[:, 1] - frequency[:, 0]
    # Apart all the time, or else for half of it.
    for gap in (float(apart.min()), float(np.median(apart))):
        wanted = _RESOLVED / gap if gap > 0 else np.inf
        if wanted <= shortest:
            return shortest
        if wanted <= float(time[-1] - time[0]) / 2:
            points = min(len(time), int(np.ceil(wanted / (time[1] - time[0]))) + 1)
            passed = np.lib.stride_tricks.sliding_window_view(frequency[:, :2], points, axis=0)
            if float(np.ptp(passed, axis=-1).max()) <= gap / 2:
                return wanted
    return shortest


def resolution_note(frequency: FloatArray, duration: float) -> str:
    """Say which neighbouring natural frequencies a window tells apart.

    Parameters
    ----------
    frequency : ndarray, shape (n, m)
        Predicted, in Hz, ascending.
    duration : float
        Length of the window in s.

    Returns
    -------
    str
    """
    resolved = _RESOLVED / duration
    note = f"window {duration:.3g} s, resolution {resolved:.3g} Hz"
    nearest = np.diff(frequency, axis=1).min(axis=0)
    merged = [
        f"f{n} and f{n + 1} (nearest {gap:.3g} Hz)"
        for n, gap in enumerate(nearest.tolist(), start=1)
        if gap < resolved
    ]
    return f"{note}: cannot tell {', '.join(merged)} apart" if merged else note
