"""Fourier series of arrays that repeat themselves once a period, from evenly spaced samples."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray

# The highest harmonics, this part of them, tell how large those are that the samples miss: enough
# of them that some are not zero by symmetry.
TAIL = 4


@dataclass(frozen=True)
class FourierSeries:
    """A real periodic function of the phase, which counts periods.

    Parameters
    ----------
    coefficients : ndarray, shape (h + 1, ...)
        ``c_k`` of ``Re(c_0 + 2 sum_k c_k exp(2 pi i k phase))``, as of :func:`numpy.fft.rfft`
        divided by the number of samples.
    """

    coefficients: NDArray[np.complex128]

    @classmethod
    def through(cls, samples: FloatArray, *, with_last_cosine: bool = False) -> FourierSeries:
        """Series through values (N, ...) at the phases k / N.

        Parameters
        ----------
        samples : ndarray, shape (N, ...)
            An odd number N leaves no harmonic whose phase is unknown.
        with_last_cosine : bool
            Whether the highest harmonic of an even number, of which samples show the cosine alone,
            is kept as this cosine; it is left out by default.
        """
        count = len(samples)
        coefficients = np.fft.rfft(samples, axis=0) / count
        if count % 2:
            return cls(coefficients)
        # The transform has the last cosine's whole amplitude, the others' half.
        coefficients[-1] /= 2
        return cls(coefficients if with_last_cosine else coefficients[:-1])

    @classmethod
    def constant(cls, value: FloatArray) -> FourierSeries:
        """Series of one value (...) at all phases."""
        return cls(np.asarray(value, dtype=complex)[None])

    @property
    def harmonics(self) -> int:
        """Number of harmonics besides the mean."""
        return len(self.coefficients) - 1

    @property
    def tail(self) -> float:
        """Greatest of the highest harmonics relative to the greatest value of all.

        An estimate of the relative error of the series between the samples.
        """
        if not self.harmonics:
            return 0.0
        size = np.abs(self.coefficients)
        highest = size[-max(1, self.harmonics // TAIL) :]
        return float(highest.max() / size.max()) if size.any() else 0.0

    def plus(self, other: FourierSeries, factor: float) -> FourierSeries:
        """Sum of this series and a multiple of another one with as many harmonics."""
        return FourierSeries(self.coefficients + factor * other.coefficients)

    def rate(self) -> FourierSeries:
        """Derivative by the phase."""
        order = 2j * np.pi * np.arange(len(self.coefficients))
        return FourierSeries(
            self.coefficients * order.reshape(-1, *[1] * (self.coefficients.ndim - 1))
        )

    def at(self, phase: FloatArray) -> FloatArray:
        """Values at phases (A,) or at one phase; shape (A, ...) or (...)."""
        order = np.arange(len(self.coefficients))
        waves = np.where(order, 2.0, 1.0) * np.exp(2j * np.pi * np.multiply.outer(phase, order))
        return np.asarray(np.tensordot(waves, self.coefficients, 1).real)

    def samples(self, count: int, shift: float = 0.0, which: slice = slice(None)) -> FloatArray:
        """Values at the phases ``(k + shift) / count``, shape (count, ...).

        Parameters
        ----------
        count : int
        shift : float
            In spacings.
        which : slice
            Part of the numbers k; all by default.
        """
        flat = self.coefficients.reshape(len(self.coefficients), -1)
        order = np.arange(len(flat))
        turn = np.where(order, 2.0, 1.0) * np.exp(2j * np.pi * order * shift / count)
        turned = turn[:, None] * flat
        # One product with all waves is faster than Fourier transforms of so many short columns.
        values = _waves(count, len(flat), which.indices(count)) @ np.concatenate(
            [turned.real, turned.imag]
        )
        return np.asarray(values.reshape(-1, *self.coefficients.shape[1:]))


def differentiation_matrices(
    samples: int, angular_frequency: float
) -> tuple[FloatArray, FloatArray]:
    """First and second time derivative of a periodic function by its samples.

    They differentiate its Fourier series (Trefethen, *Spectral Methods in MATLAB*, 2000, ch. 3).

    Parameters
    ----------
    samples : int
        Even number N of evenly spaced times of a period.
    angular_frequency : float
        Angular frequency of the period, in rad/s.

    Returns
    -------
    ndarray, shape (N, N)
        First derivative; the highest harmonic, of which samples show the cosine alone, has none.
    ndarray, shape (N, N)
        Second derivative.
    """
    harmonic = np.arange(samples // 2 + 1)
    unit = np.fft.rfft(np.eye(samples), axis=0)
    once = 1j * harmonic[:, None] * unit
    once[-1] = 0.0
    first = np.fft.irfft(once, samples, axis=0)
    second = np.fft.irfft(-(harmonic[:, None] ** 2) * unit, samples, axis=0)
    return angular_frequency * first, angular_frequency**2 * second


@lru_cache(maxsize=2)
def _waves(count: int, orders: int, which: tuple[int, int, int]) -> FloatArray:
    """Cosines, then minus sines, of the first orders at some of evenly spaced phases.

    Parameters
    ----------
    count, orders : int
    which : tuple of int
        Start, stop and step of the m numbers of the phases.

    Returns
    -------
    ndarray, shape (m, 2 orders)
    """
    steps = np.outer(np.arange(*which), np.arange(orders)) % count
    wave = np.exp(-2j * np.pi * np.arange(count) / count)[steps]
    waves = np.concatenate([wave.real, wave.imag], axis=1)
    waves.flags.writeable = False
    return waves
