"""Equations of links that are chains of elements, in a narrow band.

Each node of a chain meets its neighbours alone: in a good order of the coordinates all entries of
the unreduced matrices stand near the diagonal.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack
from scipy.sparse import csr_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

from flexmech.types import FloatArray, IntArray


@dataclass(frozen=True)
class BandForm:
    """Where the entries of matrices of one pattern stand in a band.

    Parameters
    ----------
    order : ndarray of int, shape (n,)
        Of the coordinates in the band.
    rows, columns : ndarray of int, shape (k,)
        The entries, by the coordinates in that order.
    width : int
        Diagonals beside the main one, on each side.
    """

    order: IntArray
    rows: IntArray
    columns: IntArray
    width: int

    @classmethod
    def of(cls, *matrices: FloatArray) -> BandForm:
        """Band that holds all matrices (B, n, n), in reverse Cuthill-McKee order."""
        taken = np.any([(matrix != 0).any(axis=0) for matrix in matrices], axis=0)
        taken |= taken.T
        order = reverse_cuthill_mckee(csr_array(taken), symmetric_mode=True)
        rows, columns = np.nonzero(taken[np.ix_(order, order)])
        width = int(np.abs(rows - columns).max(initial=0))
        return cls(np.asarray(order, dtype=np.intp), rows, columns, width)

    def entries(self, matrix: FloatArray) -> FloatArray:
        """Those of matrices (B, n, n), shape (B, k)."""
        return np.asarray(matrix[:, self.order[self.rows], self.order[self.columns]])

    def solve(self, entries: NDArray[Any], right: NDArray[Any]) -> NDArray[np.complex128]:
        """Solve each of m systems, by elimination with row interchanges.

        Parameters
        ----------
        entries : ndarray of complex, shape (m, k)
        right : ndarray of complex, shape (m, n)
            In the order of :attr:`order`, as the solution.

        Returns
        -------
        ndarray of complex, shape (m, n)
            Not a number where a matrix is singular.
        """
        size, width = right.shape[1], self.width
        depth = 3 * width + 1
        band = np.zeros((len(right), size * depth), dtype=complex)
        band[:, self.columns * depth + 2 * width + self.rows - self.columns] = entries
        solution = np.empty(right.shape, dtype=complex)
        for own, one, found in zip(band.reshape(-1, size, depth), right, solution, strict=True):
            *_, found[:], failed = lapack.zgbsv(width, width, own.T, one, overwrite_ab=True)
            if failed:
                found[:] = np.nan
        return solution
