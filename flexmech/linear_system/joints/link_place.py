"""Dependent coordinates of a link, and assembly of its matrix into that of the linkage."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system.links.rotation_terms import RotationTerms
from flexmech.linkages.matrix_with_rates import MatrixWithRates

Numbers = slice | IntArray


@dataclass(frozen=True)
class DependentRows:
    """Dependent coordinates of a link: ``q[rows] = turn @ z[columns]``.

    A pinned end depends on its leader's end, rotated from that frame: two rows, two columns.
    An end on a line depends on the slide, one on a rigid link on that link's three coordinates.

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
    def of(cls, rows: IntArray, columns: IntArray, matrix: MatrixWithRates) -> DependentRows:
        """Dependent rows of a matrix with rates.

        Parameters
        ----------
        rows : ndarray of int, shape (r,)
        columns : ndarray of int, shape (c,)
        matrix : MatrixWithRates
            Of shape (B, r, c).
        """
        return cls(rows, columns, matrix.value, matrix.rate, matrix.centripetal, matrix.tangential)

    def acceleration(self, terms: RotationTerms) -> FloatArray:
        """Second time derivative of ``turn``: the terms that are included, (B, r, c)."""
        if terms.centripetal and terms.tangential:
            return self.centripetal + self.tangential
        return self.centripetal if terms.centripetal else self.tangential

    def leading(self, forces: FloatArray) -> FloatArray:
        """Generalized forces (B, c, ...) on the columns by forces (B, r, ...) on the rows."""
        return np.asarray(np.einsum("bij,bi...->bj...", self.turn, forces))


@dataclass(frozen=True)
class LinkPlace:
    """Assembly of a link: the coordinates of the linkage for each coordinate of the link.

    Parameters
    ----------
    runs : list of tuple of slice
        Independent coordinates: runs of consecutive numbers in the link and in the linkage.
    dependencies : list of tuple of slice or ndarray of int
        Dependent rows of the link, and the columns of the linkage that determine them.
    """

    runs: list[tuple[slice, slice]]
    dependencies: list[tuple[Numbers, Numbers]]

    @classmethod
    def of(cls, target: IntArray, dependencies: Sequence[tuple[IntArray, IntArray]]) -> LinkPlace:
        """Assembly of one link.

        Parameters
        ----------
        target : ndarray of int, shape (n,)
            Coordinate of the linkage for each of the link; -1 where fixed.
        dependencies : sequence of tuple of ndarray of int
            Dependent rows of the link, and the columns that determine them.
        """
        own = target.copy()
        for rows, _ in dependencies:
            own[rows] = -1
        free = np.flatnonzero(own >= 0)
        places = [(_numbers(rows), _numbers(columns)) for rows, columns in dependencies]
        return cls(_runs(free, own[free]), places)

    def add(
        self, total: FloatArray, matrix: FloatArray, dependencies: Sequence[DependentRows]
    ) -> None:
        """Add ``Q' X Q`` to a matrix of the linkage.

        Parameters
        ----------
        total : ndarray, shape (B, size, size)
        matrix : ndarray, shape (n, n) or (B, n, n)
        dependencies : sequence of DependentRows
        """
        for row, to_row in self.runs:
            for column, to_column in self.runs:
                total[:, to_row, to_column] += matrix[..., row, column]
        for (rows, to_rows), tie in zip(self.dependencies, dependencies, strict=True):
            for column, to_column in self.runs:
                block = _turned(tie.turn, matrix[..., rows, column])
                total[_where(to_rows, to_column)] += block
        self.add_dependent_columns(total, matrix, dependencies, [tie.turn for tie in dependencies])

    def add_dependent_columns(
        self,
        total: FloatArray,
        matrix: FloatArray,
        dependencies: Sequence[DependentRows],
        right: Sequence[FloatArray],
    ) -> None:
        """Add ``Q' X P``, where P has the rows of dependent coordinates alone.

        Parameters
        ----------
        total : ndarray, shape (B, size, size)
        matrix : ndarray, shape (n, n) or (B, n, n)
        dependencies : sequence of DependentRows
        right : sequence of ndarray, shape (B, r, c)
            ``P`` of each.
        """
        for (columns, to_columns), by in zip(self.dependencies, right, strict=True):
            transposed = np.swapaxes(matrix[..., columns], -1, -2)
            turned = np.swapaxes(_turned(by, transposed), 1, 2)
            for row, to_row in self.runs:
                total[_where(to_row, to_columns)] += turned[:, row]
            for (rows, to_rows), tie in zip(self.dependencies, dependencies, strict=True):
                total[_where(to_rows, to_columns)] += np.swapaxes(tie.turn, 1, 2) @ turned[:, rows]


def _turned(turn: FloatArray, rows: FloatArray) -> FloatArray:
    """``P' X`` for rows (r, n) or (B, r, n) of a link matrix; (B, c, n)."""
    transposed = np.swapaxes(turn, 1, 2)
    if rows.ndim == 3:
        return transposed @ rows
    batch, columns, count = transposed.shape
    return (transposed.reshape(-1, count) @ rows).reshape(batch, columns, -1)


def _where(rows: Numbers, columns: Numbers) -> tuple[Numbers, ...]:
    """Index of a block of matrices (B, size, size)."""
    if isinstance(rows, slice) or isinstance(columns, slice):
        return slice(None), rows, columns
    return slice(None), rows[:, None], columns


def _numbers(numbers: IntArray) -> Numbers:
    """Slice of numbers that are evenly spaced, in their order; else the numbers."""
    values = numbers.tolist()
    if len(values) < 2:
        return slice(values[0], values[0] + 1) if values else slice(0, 0)
    step = values[1] - values[0]
    if step == 0 or any(b - a != step for a, b in pairwise(values)):
        return numbers
    stop = values[-1] + step
    return slice(values[0], stop if stop >= 0 else None, step)


def _runs(source: IntArray, target: IntArray) -> list[tuple[slice, slice]]:
    """Runs of consecutive numbers in both."""
    ends: list[list[int]] = []
    for s, t in zip(source.tolist(), target.tolist(), strict=True):
        if ends and (s, t) == (ends[-1][1], ends[-1][3]):
            ends[-1][1], ends[-1][3] = s + 1, t + 1
        else:
            ends.append([s, s + 1, t, t + 1])
    return [(slice(a, b), slice(c, d)) for a, b, c, d in ends]
