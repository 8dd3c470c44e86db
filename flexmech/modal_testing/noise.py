r"""Noise of the records in a frequency-response function, and in all that is linear in it.

White noise ``n`` of the response and ``m`` of the force stand in H1 as

.. math:: e_k = \frac{N_k - H_k M_k}{F_k},\qquad
          N_k = \sum_j w_j\,n_j\,\mathrm e^{-2\pi\mathrm i k j/N},\qquad
          M_k = \sum_j c_j\,w_j\,m_j\,\mathrm e^{-2\pi\mathrm i k j/N}

with the exponential window w, the force window c, and the spectrum F of the hits. Under an
exponential window of rate a the noise of lines that lie k steps apart is correlated by
``2 a / |2 a + i k dw|``, and where the pulse excites little its variance is greater. A number that
is linear in the receptances is a sum over the samples of the records: its variance is the sum of
squares of what multiplies them, and no matrix of lines by lines is made. Source: the covariance of
linear estimates, J. S. Bendat and A. G. Piersol, Random Data, 4th edition (2010), section 8.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from flexmech.arrays import ComplexArray, FloatArray, IntArray

# At least this part of what a fit leaves is noise of the response, whatever that of the
# force is.
_LEAST_PART = 0.1
# Part of a receptance that rounding leaves.
_ROUND_OFF = np.finfo(float).eps


@dataclass(frozen=True, eq=False)
class FrfNoise:
    """How noise of the records stands in frequency-response functions of hits that are alike.

    Parameters
    ----------
    line : ndarray of int, shape (F,)
        Numbers of the frequencies in the spectrum of a record.
    force : ndarray of complex, shape (F,)
        Sum of the samples of the windowed force at each frequency; of several hits the root of the
        sum of their squares, with their common phase.
    response_window, force_window : ndarray, shape (N,)
        Factors of the samples of the response, and of those of the force.
    force_level : float
        Root mean square of the noise of the force; 0 where it is not known.
    """

    line: IntArray
    force: ComplexArray
    response_window: FloatArray
    force_window: FloatArray
    force_level: float = 0.0

    @classmethod
    def of_lines(cls, frequency: FloatArray, added_damping: float) -> FrfNoise:
        """Noise of the response alone, under a force that excites all frequencies alike.

        Parameters
        ----------
        frequency : ndarray, shape (F,)
            In Hz, evenly spaced multiples of their step.
        added_damping : float
            Decay rate in 1/s of the exponential window.

        Returns
        -------
        FrfNoise
        """
        step = (frequency[-1] - frequency[0]) / (frequency.size - 1)
        line = np.round(frequency / step).astype(np.intp)
        samples = 2 * int(line[-1]) + 2
        window = np.exp(-added_damping / step * np.arange(samples) / samples)
        return cls(line, np.ones(line.size, dtype=complex), window, np.zeros(samples))

    def at(self, kept: NDArray[np.bool_]) -> FrfNoise:
        """The noise at some of the frequencies.

        Parameters
        ----------
        kept : ndarray of bool, shape (F,)

        Returns
        -------
        FrfNoise
        """
        windows = self.response_window, self.force_window
        return FrfNoise(self.line[kept], self.force[kept], *windows, self.force_level)

    def of_response(self, rows: FloatArray) -> FloatArray:
        """Factors of the samples of the response in numbers linear in a receptance.

        Parameters
        ----------
        rows : ndarray, shape (R, 2 F)
            Factors of the real parts of the receptance, then of the imaginary ones.

        Returns
        -------
        ndarray, shape (R, N)
        """
        spectrum = np.zeros((len(rows), self.response_window.size), dtype=complex)
        spectrum[:, self.line] = _coefficients(rows) / self.force
        return np.asarray(scipy.fft.fft(spectrum, axis=1).real * self.response_window)

    def of_force(self, rows: FloatArray, receptance: ComplexArray) -> FloatArray:
        """Factors of the samples of the force that its window keeps.

        Parameters
        ----------
        rows : ndarray, shape (R, 2 F)
            As for :meth:`of_response`.
        receptance : ndarray of complex, shape (F,)

        Returns
        -------
        ndarray, shape (R, n)
            For noise of a root mean square of one; nothing where the level is not known.
        """
        if self.force_level == 0.0:
            return np.zeros((len(rows), 0))
        kept = np.flatnonzero(self.force_window)
        turn = np.exp(-2j * np.pi / self.force_window.size * np.outer(self.line, kept))
        noise = (_coefficients(rows) * receptance / self.force) @ turn
        return np.asarray(noise.real * self.force_window[kept])

    def covariance(
        self, rows: FloatArray, receptance: ComplexArray, response_level: float
    ) -> FloatArray:
        """Covariance of numbers that are linear in a receptance.

        Parameters
        ----------
        rows : ndarray, shape (R, 2 F)
            As for :meth:`of_response`.
        receptance : ndarray of complex, shape (F,)
        response_level : float
            Root mean square of the noise of the response.

        Returns
        -------
        ndarray, shape (R, R)
        """
        seen, hit = response_level * self.of_response(rows), self.of_force(rows, receptance)
        return np.asarray(seen @ seen.T + self.force_level**2 * (hit @ hit.T))

    def response_level(
        self, left: FloatArray, basis: FloatArray, receptance: ComplexArray, free: float
    ) -> float:
        """Root mean square of the noise of the response, from what a fit leaves.

        Parameters
        ----------
        left : ndarray, shape (2 F,)
            Remainder of the receptance, real parts and then imaginary ones.
        basis : ndarray, shape (2 F, m)
            Orthonormal columns that were fitted.
        receptance : ndarray of complex, shape (F,)
        free : float
            Part of the remaining numbers that poles have not used up.

        Returns
        -------
        float
        """
        spread = float(np.sum(1 / abs(self.force) ** 2) * np.sum(self.response_window**2))
        # Where a few lines that nothing excites hold all of the noise, rounding is left.
        seen = spread - float(np.sum(self.of_response(basis.T) ** 2))
        seen = max(seen, _ROUND_OFF * spread)
        hit = np.sum(abs(receptance / self.force) ** 2) * np.sum(self.force_window**2)
        hit -= np.sum(self.of_force(basis.T, receptance) ** 2)
        whole = float(np.sum(left**2)) / free
        least = max(_LEAST_PART * whole, (_ROUND_OFF * float(np.linalg.norm(receptance))) ** 2)
        power = whole - self.force_level**2 * float(hit)
        return float(np.sqrt(max(power, least) / seen))


def _coefficients(rows: FloatArray) -> ComplexArray:
    """Factors of a complex receptance that make its real part the number, (R, F)."""
    real, imaginary = np.split(rows, 2, axis=1)
    return np.asarray(real - 1j * imaginary)
