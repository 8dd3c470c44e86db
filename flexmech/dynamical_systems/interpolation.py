"""Values at samples between the time steps of a run."""

from __future__ import annotations

import numpy as np

from flexmech.types import FloatArray, IntArray

# Samples that fall on a step to this part of the step are read off, not interpolated.
ON_A_STEP = 1e-6


def sample_intervals(time: FloatArray, at: FloatArray) -> tuple[IntArray, FloatArray]:
    """Step before each sample and how far the sample is beyond it, from 0 to 1.

    Parameters
    ----------
    time : ndarray, shape (m,)
        Of the steps.
    at : ndarray, shape (N,)
        Of the samples.

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
