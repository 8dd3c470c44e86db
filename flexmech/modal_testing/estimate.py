"""Frequency-response functions from windowed records of force and response, averaged over impacts.

The exponential window ``exp(-a t)`` lets the record of a lightly damped structure end small. It
moves every pole by ``a`` to the left, so that each mode seems to be damped more than it is. Taken
over force *and* response it does nothing else: the transforms are those at ``s = a + i omega``,
and so is their ratio, the frequency-response function. The poles found in it are moved back by
``a``, exactly. Source: W. A. Fladung and R. W. Rost, Mechanical Systems and Signal Processing 11
(1997), 23-36, "Application and correction of the exponential window for frequency response
functions".

Source of the estimates: J. S. Bendat and A. G. Piersol, Random Data, 4th edition (2010), sections
6.1 and 11.1.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.fft
from numpy.typing import NDArray
from scipy import signal

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.errors import InputError
from flexmech.modal_testing.noise import FrfNoise


@dataclass(frozen=True)
class ForceWindow:
    """One over the impact, zero after it: noise of the force channel after the impact is cut off.

    Parameters
    ----------
    length : float
        Time in s, from the record's begin, that is kept in full.
    taper : float
        Time in s after it over which the window falls to zero as half a cosine.

    Raises
    ------
    InputError
        The length is not above zero, or the taper is below zero.
    """

    length: float
    taper: float = 0.0

    def __post_init__(self) -> None:
        if not self.length > 0.0:
            raise InputError(f"a force window of {self.length:g} s: give a length above 0 s")
        if not self.taper >= 0.0:
            raise InputError(f"a force window with a taper of {self.taper:g} s: give 0 s or more")

    def values(self, time: FloatArray) -> FloatArray:
        """The window over time.

        Parameters
        ----------
        time : ndarray, shape (N,)
            In s, from the record's begin.

        Returns
        -------
        ndarray, shape (N,)
            From 1 to 0.
        """
        if self.taper == 0.0:
            return (np.asarray(time) <= self.length).astype(float)
        fraction = np.clip((np.asarray(time) - self.length) / self.taper, 0.0, 1.0)
        window: FloatArray = 0.5 * (1.0 + np.cos(np.pi * fraction))
        return window


@dataclass(frozen=True)
class ExponentialWindow:
    """A window ``exp(-a t)`` over force and response.

    Parameters
    ----------
    decay_rate : float
        The a in 1/s: by so much every pole moves to the left.

    Raises
    ------
    InputError
        The rate is below zero or not a number.
    """

    decay_rate: float

    def __post_init__(self) -> None:
        if not (np.isfinite(self.decay_rate) and self.decay_rate >= 0.0):
            raise InputError(
                f"an exponential window that decays by {self.decay_rate:g} 1/s: give 0 or more"
            )

    @classmethod
    def ending_at(cls, duration: float, value: float = 0.01) -> ExponentialWindow:
        """The window that has come down to a value at the end of a record.

        Parameters
        ----------
        duration : float
            Duration of the record in s.
        value : float
            Between 0 and 1; laboratories take 0.01 to 0.05.

        Returns
        -------
        ExponentialWindow

        Raises
        ------
        InputError
            The duration is not above zero, or the value is not in (0, 1].

        Examples
        --------
        >>> round(ExponentialWindow.ending_at(2.0).decay_rate, 4)
        2.3026
        """
        if not duration > 0.0:
            raise InputError(f"a record of {duration:g} s: give a duration above 0 s")
        if not 0.0 < value <= 1.0:
            raise InputError(
                f"an exponential window that ends at {value:g}: give a value above 0 and up to 1"
            )
        return cls(float(-np.log(value) / duration))

    def values(self, time: FloatArray) -> FloatArray:
        """The window over time.

        Parameters
        ----------
        time : ndarray, shape (N,)
            In s, from the record's begin.

        Returns
        -------
        ndarray, shape (N,)
        """
        return np.exp(-self.decay_rate * np.asarray(time))

    def added_damping_ratio(self, frequency: FloatArray | float) -> FloatArray:
        """Damping ratio that the window adds to a lightly damped mode.

        Parameters
        ----------
        frequency : float or ndarray
            Natural frequency in Hz.

        Returns
        -------
        ndarray
            ``a / (2 pi f)``, of the frequency's shape.
        """
        return np.asarray(self.decay_rate / (2 * np.pi * np.asarray(frequency, dtype=float)))


@dataclass(frozen=True, eq=False)
class FrfEstimate:
    """Frequency-response function of one impact point and one response point.

    Parameters
    ----------
    frequency : ndarray, shape (F,)
        In Hz, from 0 to half the sampling rate.
    h1 : ndarray of complex, shape (F,)
        Response over force: cross spectrum over the force's own. Noise of the response averages
        out, noise of the force makes it too small.
    h2 : ndarray of complex, shape (F,)
        The response's own spectrum over the cross spectrum. Noise of the force averages out, noise
        of the response makes it too great.
    coherence : ndarray, shape (F,)
        H1 over H2, from 0 to 1; one record alone gives 1 everywhere.
    noise : FrfNoise
        How noise of the records stands in ``h1``.
    added_damping : float
        Decay rate of the exponential window in 1/s. The functions are those at
        ``s = added_damping + 2 pi i frequency``: poles that are identified in them are moved back
        by it.
    """

    frequency: FloatArray
    h1: ComplexArray
    h2: ComplexArray
    coherence: FloatArray
    noise: FrfNoise
    added_damping: float = 0.0

    def at(self, kept: NDArray[np.bool_]) -> FrfEstimate:
        """The estimate at some of its frequencies.

        Parameters
        ----------
        kept : ndarray of bool, shape (F,)

        Returns
        -------
        FrfEstimate
        """
        return replace(
            self,
            frequency=self.frequency[kept],
            h1=self.h1[kept],
            h2=self.h2[kept],
            coherence=self.coherence[kept],
            noise=self.noise.at(kept),
        )


def estimate_frf(
    force: FloatArray,
    response: FloatArray,
    sampling_rate: float,
    *,
    force_window: ForceWindow | None = None,
    exponential_window: ExponentialWindow | None = None,
) -> FrfEstimate:
    """Estimate a frequency-response function from records, one a row.

    The exponential window is laid over both signals: the estimate is then the exact function at a
    shifted ``s``. A force window keeps noise after the impact out of it. Spectra are those of
    :func:`scipy.signal.csd` with one record a segment, no overlap and no further window.

    Parameters
    ----------
    force : ndarray, shape (A, N)
        Force of A impacts in N; one record may be of shape (N,).
    response : ndarray, shape (A, N)
        Displacement, velocity or acceleration, in SI units.
    sampling_rate : float
        In Hz.
    force_window : ForceWindow, optional
    exponential_window : ExponentialWindow, optional

    Returns
    -------
    FrfEstimate
        Response over force.

    Raises
    ------
    InputError
        Records of other shapes or with values that are not finite, a sampling rate that is not
        above zero, a force that is zero all along.
    """
    forces, responses = _records(force, response, sampling_rate)
    length = forces.shape[1]
    time = np.arange(length) / sampling_rate
    decay = exponential_window.values(time) if exponential_window else np.ones(length)
    cut = force_window.values(time) if force_window else np.ones(length)
    pushed = (forces * (decay * cut)).ravel()
    if not np.any(pushed):
        raise InputError(
            "the force is zero all along its window: let the record begin with the impact"
        )
    answered = (responses * decay).ravel()
    how = {
        "fs": sampling_rate,
        "window": "boxcar",
        "nperseg": length,
        "noverlap": 0,
        "detrend": False,
    }
    frequency, own_force = signal.welch(pushed, **how)
    _, own_response = signal.welch(answered, **how)
    _, cross = signal.csd(pushed, answered, **how)
    # Where nothing answers, both ratios have no value and there is no coherence.
    with np.errstate(divide="ignore", invalid="ignore"):
        h2 = np.where(own_response > 0.0, own_response / np.conj(cross), 0.0)
        coherence = np.where(own_response > 0.0, abs(cross) ** 2 / (own_force * own_response), 0.0)
    return FrfEstimate(
        np.asarray(frequency),
        np.asarray(cross / own_force),
        h2,
        np.clip(coherence, 0.0, 1.0),
        _noise(forces, decay, cut),
        exponential_window.decay_rate if exponential_window else 0.0,
    )


def _noise(forces: FloatArray, decay: FloatArray, cut: FloatArray) -> FrfNoise:
    """How noise stands in H1 of hits with forces (A, N); after the hit the force is noise alone."""
    spectra = scipy.fft.rfft(forces * (decay * cut), axis=1)
    size, together = np.sqrt(np.sum(abs(spectra) ** 2, axis=0)), np.sum(spectra, axis=0)
    after = forces[:, cut == 0.0]
    return FrfNoise(
        np.arange(size.size),
        # Where nothing is excited the estimate is noise without bound.
        np.maximum(size, np.finfo(float).tiny) * np.exp(1j * np.angle(together)),
        decay,
        decay * cut,
        float(np.sqrt(np.mean(after**2))) if after.size else 0.0,
    )


def with_noise(
    records: FloatArray, rms_fraction: float, generator: np.random.Generator
) -> FloatArray:
    """Add white Gaussian noise to records.

    Parameters
    ----------
    records : ndarray, shape (..., N)
    rms_fraction : float
        Root mean square of the noise over that of each record.
    generator : numpy.random.Generator
        Made from a fixed seed, it gives the same noise again.

    Returns
    -------
    ndarray, shape (..., N)

    Raises
    ------
    InputError
        The fraction is below zero or not finite.
    """
    if not (np.isfinite(rms_fraction) and rms_fraction >= 0.0):
        raise InputError(f"noise of {rms_fraction:g} of the signal: give 0 or more")
    size = np.sqrt(np.mean(np.square(records), axis=-1, keepdims=True))
    noisy: FloatArray = records + rms_fraction * size * generator.standard_normal(records.shape)
    return noisy


def _records(
    force: FloatArray, response: FloatArray, sampling_rate: float
) -> tuple[FloatArray, FloatArray]:
    """Both records as rows, checked."""
    if not (np.isfinite(sampling_rate) and sampling_rate > 0.0):
        raise InputError(f"a sampling rate of {sampling_rate:g} Hz: give one above 0 Hz")
    forces = np.atleast_2d(np.asarray(force, dtype=float))
    responses = np.atleast_2d(np.asarray(response, dtype=float))
    if forces.shape != responses.shape or forces.ndim != 2 or forces.shape[1] < 2:
        raise InputError(
            f"records of force {np.shape(force)} and of response {np.shape(response)}: give both "
            "as (averages, samples), with as many of each"
        )
    for name, values in (("force", forces), ("response", responses)):
        if not np.all(np.isfinite(values)):
            raise InputError(f"the {name} holds values that are not finite: leave such records out")
    return forces, responses
