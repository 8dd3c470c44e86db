"""Link matrices that are the same in all positions, in frames that turn.

A link's coordinates are ``q = N z``, and N is linear in the cosines and sines of the angles by
which the link's following ends turn: ``N = sum_i f_i N_i`` with constant ``N_i`` and ``f_0 = 1``.
A symmetric matrix X gives ``N'XN = sum_ij f_i f_j N_i' X N_j``. The products are made once, and
their sums in all positions are one product of two matrices.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from flexmech.types import FloatArray, IntArray

__all__ = ["LinkMap", "SteadySum"]


@dataclass(frozen=True)
class LinkMap:
    """``N_i``: a link's coordinates from those of the linkage, term by term.

    Parameters
    ----------
    parts : ndarray, shape (m, n, size)
        Factors of 1, and of the cosine and the sine of each following end's angle.
    """

    parts: FloatArray

    @classmethod
    def of(cls, target: IntArray, pairs: Sequence[IntArray], size: int) -> LinkMap:
        """Map of a link.

        Parameters
        ----------
        target : ndarray of int, shape (n,)
            Coordinate of the linkage of each of the link; -1 where held.
        pairs : sequence of ndarray of int, shape (2,)
            Coordinates of the link's ends that follow.
        size : int
            Number of coordinates of the linkage.
        """
        parts = np.zeros((1 + 2 * len(pairs), len(target), size))
        free = np.flatnonzero(target >= 0)
        parts[0, free, target[free]] = 1.0
        for pair, cosine, sine in zip(pairs, parts[1::2], parts[2::2], strict=True):
            parts[0, pair] = 0.0
            cosine[pair, target[pair]] = 1.0
            sine[pair, target[pair[::-1]]] = [-1.0, 1.0]
        return cls(parts)

    def turning_terms(self, matrix: FloatArray, rows: int) -> FloatArray:
        """What multiplies the factors of :meth:`turning_factors` in rows of ``N'XN``.

        Parameters
        ----------
        matrix : ndarray, shape (n, n)
            Symmetric.
        rows : int
            How many, the first ones.

        Returns
        -------
        ndarray, shape (m (m + 1) / 2 - 1, rows, size)
        """
        first, second = self._turning
        if not len(first):
            return np.zeros((0, rows, self.parts.shape[2]))
        left = np.swapaxes(self.parts[:, None, :, :rows], 2, 3) @ matrix
        products = left @ self.parts
        mirrored = np.where(first == second, 0.0, 1.0)[:, None, None]
        return np.asarray(products[first, second] + mirrored * products[second, first])

    def turning_factors(self, angles: FloatArray) -> FloatArray:
        """``f_i f_j`` for i <= j, without the first, which is 1.

        Parameters
        ----------
        angles : ndarray, shape (k, B)
            By which each following end turns, in rad.

        Returns
        -------
        ndarray, shape (m (m + 1) / 2 - 1, B)
        """
        factors = np.ones((len(self.parts), angles.shape[1]))
        np.cos(angles, out=factors[1::2])
        np.sin(angles, out=factors[2::2])
        first, second = self._turning
        return np.asarray(factors[first] * factors[second])

    @cached_property
    def _turning(self) -> tuple[IntArray, IntArray]:
        """Numbers i <= j of two terms that do not both rest."""
        first, second = np.triu_indices(len(self.parts))
        return first[1:], second[1:]


@dataclass(frozen=True)
class SteadySum:
    """Sum of ``N'XN`` over links whose matrices are the same in all positions.

    Parameters
    ----------
    links : tuple of int
        Their numbers.
    resting : ndarray, shape (size, size)
        The part that does not turn.
    terms : ndarray, shape (1 + r, e, size)
        First rows of that part and of what multiplies the factors, link by link. No others turn
        but, by symmetry, the first columns.
    """

    links: tuple[int, ...]
    resting: FloatArray
    terms: FloatArray

    def write(self, total: FloatArray, factors: Sequence[FloatArray]) -> None:
        """Write the sum in all positions.

        Parameters
        ----------
        total : ndarray, shape (B, size, size)
        factors : sequence of ndarray, shape (r, B)
            See :meth:`LinkMap.turning_factors`, of all links.
        """
        ends = self.terms.shape[1]
        weights = np.concatenate([np.ones((1, len(total))), *(factors[n] for n in self.links)])
        total[:, :ends] = np.tensordot(weights, self.terms, axes=(0, 0))
        total[:, ends:, :ends] = np.swapaxes(total[:, :ends, ends:], 1, 2)
        total[:, ends:, ends:] = self.resting[ends:, ends:]
