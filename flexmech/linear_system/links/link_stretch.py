"""What a link's axial strain owes to the square of its slopes.

A straight link that bends is, to second order, longer than its chord by half the integral of
the squared slope (von Karman 1910; Crisfield, *Non-linear Finite Element Analysis of Solids
and Structures*, vol. 1, 1991, ch. 7). Bending itself stays linear; tension and its work
against the slopes do not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linkages.connection_forces import RANK_TOLERANCE


@dataclass(frozen=True)
class LinkStretch:
    """Second-order axial strains of one link, scaled so that their squares are energies.

    Each of the ``s`` strains ``gradient @ q + weights @ (slopes @ q)**2 / 2`` is a mean over a
    part of the link times the square root of that part's stiffness, ``EA`` times length: the
    strain energy is half the sum of their squares, and a strain is its own tension. Of a link that
    turns far there are strains of bending among them.

    Parameters
    ----------
    gradient : ndarray, shape (s, n)
        Linear part.
    slopes : ndarray, shape (g, n)
        Slopes whose squares count.
    weights : ndarray, shape (s, g)
    damping_time : ndarray, shape (s,)
        Kelvin-Voigt: a tension is its strain plus this time in s its rate.
    """

    gradient: FloatArray
    slopes: FloatArray
    weights: FloatArray
    damping_time: FloatArray

    @classmethod
    def none(cls, size: int) -> LinkStretch:
        """Of a link of ``size`` coordinates that does not stretch."""
        return cls(np.zeros((0, size)), np.zeros((0, size)), np.zeros((0, 0)), np.zeros(0))

    def projected(self, basis: FloatArray) -> LinkStretch:
        """The same with ``q = basis @ p``.

        Only strains that the linear part of some p can show are kept: the squared slopes of
        high modes must not stretch a link that has no axial shape to give way with (membrane
        locking).

        Parameters
        ----------
        basis : ndarray, shape (n, m)

        Returns
        -------
        LinkStretch
        """
        gradient = self.gradient @ basis
        combined, times = [gradient[:, :0]], [self.damping_time[:0]]
        for time in np.unique(self.damping_time):
            own = np.flatnonzero(self.damping_time == time)
            shown, size, _ = np.linalg.svd(gradient[own], full_matrices=False)
            shown = shown[:, size > RANK_TOLERANCE * size.max(initial=0.0)]
            combined.append(np.zeros((len(gradient), shown.shape[1])))
            combined[-1][own] = shown
            times.append(np.full(shown.shape[1], time))
        kept = np.concatenate(combined, axis=1).T
        return LinkStretch(
            kept @ gradient, self.slopes @ basis, kept @ self.weights, np.concatenate(times)
        )

    def remainder(self, displacement: FloatArray, rate: FloatArray) -> tuple[FloatArray, ...]:
        """Forces beyond those of the linear strain, elastic and of damping.

        Parameters
        ----------
        displacement, rate : ndarray, shape (m, n)

        Returns
        -------
        tuple of ndarray, shape (m, n)
        """
        slope, linear, second = self._strain(displacement)
        elastic = self._force(slope, linear, second)
        if not self.damping_time.any():
            return elastic, np.zeros_like(elastic)
        linear_rate = rate @ self.gradient.T
        second_rate = (slope * (rate @ self.slopes.T)) @ self.weights.T
        time = self.damping_time
        return elastic, self._force(slope, time * linear_rate, time * second_rate)

    def energy(self, displacement: FloatArray) -> FloatArray:
        """Strain energy beyond that of the linear strain; (m, n) -> (m,)."""
        _, linear, second = self._strain(displacement)
        return np.asarray(np.sum(second * (linear + second / 2), axis=1))

    def _strain(self, displacement: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        slope = displacement @ self.slopes.T
        return slope, displacement @ self.gradient.T, (slope * slope) @ self.weights.T / 2

    def _force(self, slope: FloatArray, linear: FloatArray, second: FloatArray) -> FloatArray:
        along = second @ self.gradient
        return np.asarray(along + (((linear + second) @ self.weights) * slope) @ self.slopes)
