"""Parabolas over elements along a line: factors of the matrices of rectangles and bricks."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

from flexmech.types import FloatArray

__all__ = ["Parabolas"]

MASS = np.array([[4.0, 2.0, -1.0], [2.0, 16.0, 2.0], [-1.0, 2.0, 4.0]]) / 30
STIFFNESS = np.array([[7.0, -8.0, 1.0], [-8.0, 16.0, -8.0], [1.0, -8.0, 7.0]]) / 3
COUPLING = np.array([[-3.0, 4.0, -1.0], [-4.0, 0.0, 4.0], [1.0, -4.0, 3.0]]) / 6


class Parabolas:
    """Functions that are parabolas in each element, with a node in its middle.

    Parameters
    ----------
    ends : ndarray, shape (n + 1,)
        Of the elements, ascending.

    Attributes
    ----------
    places : ndarray, shape (2 n + 1,)
        Of the nodes.
    size : int
        Number of nodes.
    """

    def __init__(self, ends: FloatArray) -> None:
        self._lengths = np.diff(ends)
        self.places = np.sort(np.concatenate([ends, (ends[1:] + ends[:-1]) / 2]))
        self.size = len(self.places)

    def mass(self, weight: FloatArray | None = None) -> Any:
        """Integral of a weight (n,) times two functions, sparse."""
        return self._summed(MASS, weight, self._lengths)

    def stiffness(self, weight: FloatArray | None = None) -> Any:
        """Integral of a weight (n,) times two slopes, sparse."""
        return self._summed(STIFFNESS, weight, 1 / self._lengths)

    def coupling(self, weight: FloatArray | None = None) -> Any:
        """Integral of a weight (n,) times a function (row) and a slope (column), sparse."""
        return self._summed(COUPLING, weight, np.ones(len(self._lengths)))

    def integral(
        self, slope_of_row: bool, slope_of_column: bool, weight: FloatArray | None = None
    ) -> Any:
        """Any of the three.

        Parameters
        ----------
        slope_of_row, slope_of_column : bool
            Whether rows and columns stand for slopes.
        weight : ndarray, shape (n,), optional
            Of each element; one where it is left out.

        Returns
        -------
        sparse matrix, shape (2 n + 1, 2 n + 1)
        """
        if slope_of_row and slope_of_column:
            return self.stiffness(weight)
        if slope_of_row:
            return self.coupling(weight).T
        return self.coupling(weight) if slope_of_column else self.mass(weight)

    def _summed(self, own: FloatArray, weight: FloatArray | None, factor: FloatArray) -> Any:
        if weight is not None:
            factor = factor * weight
        nodes = 2 * np.arange(len(factor))[:, None] + np.arange(3)
        rows, columns = np.repeat(nodes, 3, axis=1), np.tile(nodes, (1, 3))
        values = factor[:, None] * own.ravel()
        shape = (self.size, self.size)
        return sp.csr_matrix((values.ravel(), (rows.ravel(), columns.ravel())), shape=shape)
