"""Coordinates of a link that follow from those of the linkage while the frames turn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.linkages.matrix_with_rates import MatrixWithRates as MovingMatrix
from flexmech.linear_system.rotation_terms import RotationTerms
from flexmech.types import FloatArray, IntArray


@dataclass(frozen=True)
class FollowingRows:
    """Rows of a link's coordinates that follow: ``q[rows] = turn @ z[columns]``.

    A pinned end follows its leader's end, turned from the leader's frame: two rows, two columns.
    An end on a line follows the slide, one on a rigid link that link's three coordinates.

    Parameters
    ----------
    rows : ndarray of int, shape (r,)
        Coordinates of the link.
    columns : ndarray of int, shape (c,)
        Independent coordinates of the linkage, all different.
    turn : ndarray, shape (B, r, c)
    rate : ndarray, shape (B, r, c)
        Time derivative of ``turn``.
    centripetal, tangential : ndarray, shape (B, r, c)
        Second time derivative of ``turn``: the parts in squares and products of velocities of
        the rigid motion, and in its accelerations.
    """

    rows: IntArray
    columns: IntArray
    turn: FloatArray
    rate: FloatArray
    centripetal: FloatArray
    tangential: FloatArray

    @classmethod
    def of(cls, rows: IntArray, columns: IntArray, matrix: MovingMatrix) -> FollowingRows:
        """Rows that follow by a moving matrix.

        Parameters
        ----------
        rows : ndarray of int, shape (r,)
        columns : ndarray of int, shape (c,)
        matrix : MovingMatrix
            Of shape (B, r, c).
        """
        return cls(rows, columns, matrix.value, matrix.rate, matrix.centripetal, matrix.tangential)

    def acceleration(self, terms: RotationTerms) -> FloatArray:
        """Second time derivative of ``turn`` of the terms that count, (B, r, c)."""
        if terms.centripetal and terms.tangential:
            return self.centripetal + self.tangential
        return self.centripetal if terms.centripetal else self.tangential

    def leading(self, forces: FloatArray) -> FloatArray:
        """Forces (B, c) on the columns of forces (B, r) on the rows."""
        return np.asarray(np.einsum("bij,bi->bj", self.turn, forces))
