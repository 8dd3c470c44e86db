"""One-dimensional quadratic elements: factors of the matrices of rectangles and bricks."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp

from flexmech.arrays import FloatArray, IntArray

# Integrals over an element of length one of two parabolas, of two slopes, and of a parabola (row)
# and a slope (column); nodes at its start, middle and end.
_MASS = np.array([[4.0, 2.0, -1.0], [2.0, 16.0, 2.0], [-1.0, 2.0, 4.0]]) / 30
_STIFFNESS = np.array([[7.0, -8.0, 1.0], [-8.0, 16.0, -8.0], [1.0, -8.0, 7.0]]) / 3
_COUPLING = np.array([[-3.0, 4.0, -1.0], [-4.0, 0.0, 4.0], [1.0, -4.0, 3.0]]) / 6
# By what rows and columns stand for, with the power of the length with which it goes.
VALUES, SLOPES = (False, False), (True, True)
_INTEGRALS = {
    VALUES: (_MASS, 1),
    SLOPES: (_STIFFNESS, -1),
    (False, True): (_COUPLING, 0),
    (True, False): (_COUPLING.T, 0),
}


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
    rows, columns : ndarray of int, shape (9 n,)
        Of the matrices' entries, one element after the other.
    """

    def __init__(self, ends: FloatArray) -> None:
        self._lengths = np.diff(ends)
        self.places = np.sort(np.concatenate([ends, (ends[1:] + ends[:-1]) / 2]))
        self.size = len(self.places)
        nodes = 2 * np.arange(len(self._lengths))[:, None] + np.arange(3)
        self.rows, self.columns = np.repeat(nodes, 3, axis=1).ravel(), np.tile(nodes, 3).ravel()

    def entries(self, slopes: tuple[bool, bool], weight: FloatArray | None = None) -> FloatArray:
        """Integrals of a weight times two functions or slopes in each element.

        Parameters
        ----------
        slopes : tuple of bool
            Whether rows and columns stand for slopes: :data:`VALUES`, :data:`SLOPES`, or a function
            and a slope.
        weight : ndarray, shape (n,), optional
            Of each element; one where it is left out.

        Returns
        -------
        ndarray, shape (9 n,)
        """
        element, power = _INTEGRALS[slopes]
        factor = self._lengths**power if weight is None else weight * self._lengths**power
        return np.outer(factor, element).ravel()

    def integral(self, slopes: tuple[bool, bool], weight: FloatArray | None = None) -> Any:
        """Sparse matrix of :meth:`entries`, (2 n + 1, 2 n + 1)."""
        places, shape = (self.rows, self.columns), (self.size, self.size)
        return sp.csr_matrix((self.entries(slopes, weight), places), shape=shape)
