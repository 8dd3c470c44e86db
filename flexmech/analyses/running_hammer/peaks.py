"""The greatest amplitude of each order, predicted and identified."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.types import ComplexArray, FloatArray, IntArray

# How far from the predicted peak the identified one is sought: in bins, and of its frequency.
BINS, NEAR = 5, 0.05


@dataclass(frozen=True)
class OrderPeaks:
    """Of each order, (O,).

    Parameters
    ----------
    predicted_bin, identified_bin : ndarray of int, shape (O,)
    predicted, identified : ndarray, shape (O,)
        Amplitudes in m/N.
    """

    predicted_bin: IntArray
    identified_bin: IntArray
    predicted: FloatArray
    identified: FloatArray


def order_peaks(predicted: ComplexArray, identified: ComplexArray) -> OrderPeaks:
    """The greatest amplitude predicted of each order, and the greatest one identified near it.

    Parameters
    ----------
    predicted, identified : ndarray of complex, shape (O, B)

    Returns
    -------
    OrderPeaks
    """
    amplitude, other = np.abs(predicted), np.abs(identified)
    own = amplitude.argmax(axis=1)
    place = np.arange(amplitude.shape[1])
    reach = np.maximum(BINS, NEAR * own)
    near = np.where(np.abs(place - own[:, None]) <= reach[:, None], other, -1.0)
    found = near.argmax(axis=1)
    rows = np.arange(len(own))
    return OrderPeaks(own, found, amplitude[rows, own], other[rows, found])
