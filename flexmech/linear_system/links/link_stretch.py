"""Second-order axial strain of a link by the square of its slopes.

A straight link that bends is, to second order, longer than its chord by half the integral of
the squared slope (von Karman 1910; Crisfield, *Non-linear Finite Element Analysis of Solids
and Structures*, vol. 1, 1991, ch. 7). Bending itself stays linear; tension and its work
against the slopes do not.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linkages.connection_forces import RANK_TOLERANCE


@dataclass(frozen=True)
class LinkStretch:
    """Second-order axial strains of one link, scaled so that their squares are energies.

    Each of the ``s`` strains ``gradient @ q + weights @ (slopes @ q)**2 / 2`` is a mean over a
    part of the link times the square root of that part's stiffness, ``EA`` times length: the
    strain energy is half the sum of their squares, and each strain equals its tension. A link with
    large rotations has bending strains among them.

    Parameters
    ----------
    gradient : ndarray, shape (s, n)
        Linear part.
    slopes : ndarray, shape (g, n)
        Slopes whose squares count.
    weights : ndarray, shape (s, g)
    damping_time : ndarray, shape (s,)
        Kelvin-Voigt: a tension is its strain plus this time in s its rate.
    neutral_axis : float
        Distance of the axis whose strains they are from that of the link in m.
    """

    gradient: FloatArray
    slopes: FloatArray
    weights: FloatArray
    damping_time: FloatArray
    neutral_axis: float = 0.0

    @classmethod
    def none(cls, size: int) -> LinkStretch:
        """No strains, for a link of ``size`` coordinates that does not stretch."""
        return cls(np.zeros((0, size)), np.zeros((0, size)), np.zeros((0, 0)), np.zeros(0))

    def in_coordinates(self, basis: FloatArray) -> LinkStretch:
        """The same strains in other coordinates: ``q = basis @ p``, with basis (n, m)."""
        return replace(self, gradient=self.gradient @ basis, slopes=self.slopes @ basis)

    def projected(self, basis: FloatArray) -> LinkStretch:
        """The same strains with ``q = basis @ p``, where p are fewer.

        Only strains in the range of the linear part are kept: squared slopes of high modes must
        not stretch a link without axial shapes that could relax them (membrane locking).

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
            directions, size, _ = np.linalg.svd(gradient[own], full_matrices=False)
            directions = directions[:, size > RANK_TOLERANCE * size.max(initial=0.0)]
            combined.append(np.zeros((len(gradient), directions.shape[1])))
            combined[-1][own] = directions
            times.append(np.full(directions.shape[1], time))
        kept = np.concatenate(combined, axis=1).T
        return replace(
            self,
            gradient=kept @ gradient,
            slopes=self.slopes @ basis,
            weights=kept @ self.weights,
            damping_time=np.concatenate(times),
        )

    def nonlinear_forces(
        self, displacement: FloatArray, rate: FloatArray
    ) -> tuple[FloatArray, ...]:
        """Elastic and damping forces beyond those of the linear strain.

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
