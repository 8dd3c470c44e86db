"""What rings after a crank has stopped: the envelope of each link's deflection."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexmech.analyses.response.request import ResponseRequest
from flexmech.arrays import FloatArray

# A rest of fewer samples shows no vibration.
LEAST_SAMPLES = 8
# Places in a period of the highest mode at which an envelope is sought: the greatest of so many
# values of a wave is at most 0.2 % below its amplitude.
_PLACES = 48


def rests(request: ResponseRequest) -> bool:
    """Whether the run goes on for a while after the crank has stopped."""
    drive = request.drive
    after = request.duration - drive.law_time
    return not drive.speed and after >= LEAST_SAMPLES * request.sample_interval


def edges(
    at: FloatArray,
    time: FloatArray,
    values: FloatArray,
    waves: NDArray[np.complex128],
    decay: FloatArray,
    angular_frequency: FloatArray,
    period: float,
) -> tuple[FloatArray, FloatArray]:
    """Least and greatest value of a history within a period that follows, were it not to decay.

    What is known of a history is the sum of its decaying waves, each of which keeps the amplitude
    that it has at the time; what else the history holds is taken as it is. A decaying wave about a
    state of rest thus stays between the state plus and minus its amplitude, and touches both. Where
    less than a period follows, the last period counts.

    Parameters
    ----------
    at : ndarray, shape (n,)
        Where the edges are wanted, in s; between the first and the last time.
    time : ndarray, shape (N,)
        Of the history in s, from zero on.
    values : ndarray, shape (N,)
    waves : ndarray of complex, shape (m,)
        Amplitudes at time zero; not a number of a wave that is not known.
    decay, angular_frequency : ndarray, shape (m,)
        In 1/s and rad/s.
    period : float
        Of the slowest wave, in s; of a shorter history all counts.

    Returns
    -------
    lower, upper : ndarray, shape (n,)

    Examples
    --------
    >>> time = np.linspace(0.0, 1.0, 1001)
    >>> history = 5.0 + np.exp((2j * np.pi * 50 - 2.0) * time).real
    >>> wave = np.array([1.0 + 0j]), np.array([2.0]), np.array([2 * np.pi * 50])
    >>> lower, upper = edges(time[[0, 500]], time, history, *wave, 0.02)
    >>> ((upper - lower) / 2).round(3), ((upper + lower) / 2).round(3)
    (array([1.   , 0.368]), array([5., 5.]))
    """
    known = np.isfinite(waves)
    amplitude = np.where(known, waves, 0.0)
    turning = np.exp(np.multiply.outer(time, 1j * angular_frequency - decay))
    besides = values - (turning @ amplitude).real
    period = min(period, float(time[-1]))
    begin = np.minimum(at, time[-1] - period)
    rates = np.multiply.outer(begin, 1j * angular_frequency) - np.multiply.outer(at, decay)
    kept = amplitude * np.exp(rates)
    cycles = period * float(angular_frequency[known].max(initial=0.0)) / (2 * np.pi)
    lower = upper = np.interp(at, time, values)
    for shift in np.linspace(0.0, period, max(_PLACES, int(np.ceil(_PLACES * cycles))) + 1):
        wave = (kept @ np.exp(1j * angular_frequency * shift)).real
        value = np.interp(begin + shift, time, besides) + wave
        lower, upper = np.minimum(lower, value), np.maximum(upper, value)
    return lower, upper
