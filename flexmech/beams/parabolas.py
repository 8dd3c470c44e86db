"""One-dimensional quadratic elements: factors of the matrices of rectangles and bricks."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

from flexmech.arrays import FloatArray, IntArray

# Integrals over an element of length one of two parabolas, of two slopes, and of a parabola (row)
# and a slope (column); nodes at its start, middle and end.
MASS = np.array([[4.0, 2.0, -1.0], [2.0, 16.0, 2.0], [-1.0, 2.0, 4.0]]) / 30
STIFFNESS = np.array([[7.0, -8.0, 1.0], [-8.0, 16.0, -8.0], [1.0, -8.0, 7.0]]) / 3
COUPLING = np.array([[-3.0, 4.0, -1.0], [-4.0, 0.0, 4.0], [1.0, -4.0, 3.0]]) / 6


def graded(count: int, share: float) -> FloatArray:
    """Ends of elements between 0 and 1, graded towards both ends.

    Parameters
    ----------
    count : int
        Of the elements.
    share : float
        Of spacing by a cosine; the rest is even.

    Returns
    -------
    ndarray, shape (count + 1,)
    """
    s = np.linspace(0, 1, count + 1)
    return np.asarray(share * (1 - np.cos(np.pi * s)) / 2 + (1 - share) * s)


def rows_of_runs(faces: FloatArray, total: int) -> tuple[FloatArray, IntArray]:
    """Share rows of elements among runs of layers by their thickness, one at least to each.

    Parameters
    ----------
    faces : ndarray, shape (n + 1,)
        Of the runs, ascending.
    total : int
        About how many rows.

    Returns
    -------
    ends : ndarray, shape (m + 1,)
        Of all rows.
    count : ndarray of int, shape (n,)
        Rows of each run.
    """
    shares = total * np.diff(faces) / (faces[-1] - faces[0])
    count = np.maximum(1, np.round(shares)).astype(int)
    pairs = zip(faces[:-1], faces[1:], count, strict=True)
    heights = [np.linspace(low, high, rows + 1)[1:] for low, high, rows in pairs]
    return np.concatenate([faces[:1], *heights]), count


class Parabolas:
    """Quadratic shape functions in each element, with a node in its middle.

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
        """Mass matrix: integral of a weight (n,) times two functions, sparse."""
        return self._summed(MASS, weight, self._lengths)

    def stiffness(self, weight: FloatArray | None = None) -> Any:
        """Stiffness matrix: integral of a weight (n,) times two slopes, sparse."""
        return self._summed(STIFFNESS, weight, 1 / self._lengths)

    def coupling(self, weight: FloatArray | None = None) -> Any:
        """Integral of a weight (n,) times a function (row) and a slope (column), sparse."""
        return self._summed(COUPLING, weight, np.ones(len(self._lengths)))

    def integral(
        self, slope_of_row: bool, slope_of_column: bool, weight: FloatArray | None = None
    ) -> Any:
        """Integral of a weight times two functions or slopes.

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
