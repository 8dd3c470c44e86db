"""Signals that come step by step: a low-pass filter, and values between the steps.

Joint forces and torque ring with the axial modes, which no time step of interest resolves:
their raw peaks depend on the step. What is left below those frequencies does not.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy

from flexmech.arrays import FloatArray, IntArray

# In dB: of frequencies beyond twice the band 1e-3 is left; below it the gain is 1 within 1e-3, as
# near as joint forces of a mesh are known.
ATTENUATION = 60.0
# Lengths of the kernel that are filtered at once, at least: each time one of them is done twice.
KERNELS_AT_ONCE = 4
# Bands that a step must show for weights to count: twice the band is stopped, and weights of two in
# turn mirror a frequency about half of what the step shows.
WEIGHTED = 3.0
# Samples that fall on a step to this part of the step are read off, not interpolated.
ON_A_STEP = 1e-6


def look_ahead(band: float) -> float:
    """Time in s before and after an instant that a filtered value depends on.

    Parameters
    ----------
    band : float
        Band of :class:`LowPass`, in Hz.
    """
    return float((ATTENUATION - 7.95) / (4 * 2.285 * np.pi * band))


class LowPass:
    """Finite impulse response without delay: Kaiser's window (Oppenheim & Schafer, ch. 7).

    Signals up to ``band`` pass, those beyond ``2 * band`` do not. Before its start and after
    its end a history is taken as its own mirror image. That is not how it goes on: what counts
    should end :attr:`half` values before the history does.

    Parameters
    ----------
    band : float
        In Hz.
    step : float
        Between values in s. A step too long to show frequencies beyond the band leaves the
        history as it is.
    weights : sequence of float
        What the values count in an integral over time, in turn from the first one; their mean
        is 1. Where their number is more than one they are left out unless the step shows three
        times the band: at longer steps they would turn what is high into what is low.

    Attributes
    ----------
    half : int
        Values before and after an instant that its filtered value depends on.
    """

    def __init__(self, band: float, step: float, weights: Sequence[float] = (1.0,)) -> None:
        middle, nyquist = 1.5 * band, 0.5 / step
        self.kernel: FloatArray = np.ones(1)
        if middle < nyquist:
            beta = scipy.signal.kaiser_beta(ATTENUATION)
            half = int(np.ceil(look_ahead(band) / step))
            self.kernel = scipy.signal.firwin(
                2 * half + 1, middle, window=("kaiser", beta), fs=1 / step
            )
        self.half = len(self.kernel) // 2
        self._weights = np.array(weights) if WEIGHTED * band < nyquist else np.ones(1)
        self._taken = 0
        self._values: FloatArray | None = None
        self._begun = False

    def add(self, values: FloatArray) -> FloatArray:
        """Take the next values and give those that can be filtered by now.

        Parameters
        ----------
        values : ndarray, shape (m, k)

        Returns
        -------
        ndarray, shape (l, k)
            All calls together, and :meth:`finish`, give as many values as they took.
        """
        if not self.half:
            return values
        turn = np.arange(self._taken, self._taken + len(values)) % len(self._weights)
        self._taken += len(values)
        values = self._weights[turn, None] * values
        self._values = values if self._values is None else np.concatenate([self._values, values])
        if len(self._values) < KERNELS_AT_ONCE * len(self.kernel):
            return values[:0]
        if not self._begun:
            self._values = _mirrored(self._values, self.half, 0)
            self._begun = True
        return self._filtered()

    def finish(self) -> FloatArray:
        """Filtered values that were left when the history ended."""
        if self._values is None:
            return np.zeros((0, 1))
        self._values = _mirrored(self._values, 0 if self._begun else self.half, self.half)
        return self._filtered()

    def _filtered(self) -> FloatArray:
        assert self._values is not None
        result = scipy.signal.oaconvolve(self._values, self.kernel[:, None], mode="valid", axes=0)
        self._values = self._values[len(result) :]
        return np.asarray(result)


def _mirrored(values: FloatArray, before: int, after: int) -> FloatArray:
    return np.pad(values, ((before, after), (0, 0)), mode="reflect" if len(values) > 1 else "edge")


def sample_intervals(time: FloatArray, at: FloatArray) -> tuple[IntArray, FloatArray]:
    """Step before each sample and how far the sample is beyond it, from 0 to 1.

    Parameters
    ----------
    time : ndarray, shape (m,)
        Time of the steps.
    at : ndarray, shape (N,)
        Place of the samples.

    Returns
    -------
    ndarray of int, shape (N,)
    ndarray, shape (N,)
    """
    before = np.clip(np.searchsorted(time, at, side="right") - 1, 0, len(time) - 2)
    fraction = (at - time[before]) / (time[before + 1] - time[before])
    nearest = np.round(fraction)
    return before, np.where(np.abs(fraction - nearest) <= ON_A_STEP, nearest, fraction)


def linear_interpolation(values: FloatArray, before: IntArray, fraction: FloatArray) -> FloatArray:
    """Linear interpolation between steps.

    Parameters
    ----------
    values : ndarray, shape (m, ...)
    before : ndarray of int, shape (N,)
    fraction : ndarray, shape (N,)
        Both of :func:`sample_intervals`.

    Returns
    -------
    ndarray, shape (N, ...)
    """
    s = fraction.reshape(-1, *(1,) * (values.ndim - 1))
    return (1 - s) * values[before] + s * values[before + 1]


def hermite_interpolation(
    time: FloatArray,
    value: FloatArray,
    rate: FloatArray,
    before: IntArray,
    fraction: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Cubic Hermite interpolation between steps.

    Parameters
    ----------
    time : ndarray, shape (m,)
    value, rate : ndarray, shape (m, n)
    before : ndarray of int, shape (N,)
    fraction : ndarray, shape (N,)
        Both of :func:`sample_intervals`.

    Returns
    -------
    tuple of ndarray, shape (N, n)
        Values and rates.
    """
    s, h = fraction[:, None], (time[before + 1] - time[before])[:, None]
    v0, v1, r0, r1 = value[before], value[before + 1], h * rate[before], h * rate[before + 1]
    jump = v1 - v0
    second, third = 3 * jump - 2 * r0 - r1, r0 + r1 - 2 * jump
    interpolated = v0 + s * (r0 + s * (second + s * third))
    slope = (r0 + s * (2 * second + s * 3 * third)) / h
    return interpolated, slope
