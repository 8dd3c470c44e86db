"""Dependent coordinates of a link, and where its matrix goes in those of the linkage."""

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
    def of(cls, rows: IntArray, columns: IntArray, matrix: MatrixWithRates) -> DependentRows:
        """Rows that depend by a matrix with rates.

        Parameters
        ----------
        rows : ndarray of int, shape (r,)
        columns : ndarray of int, shape (c,)
        matrix : MatrixWithRates
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


@dataclass(frozen=True)
class LinkPlace:
    """Coordinates of a link and those of the linkage that they are.

    Parameters
    ----------
    runs : list of tuple of slice
        Those that are coordinates of the linkage themselves: runs in the link and in the linkage.
    following : list of tuple of slice or ndarray of int
        Rows that follow, in the link, and what they follow, in the linkage.
    """

    runs: list[tuple[slice, slice]]
    following: list[tuple[Numbers, Numbers]]

    @classmethod
    def of(cls, target: IntArray, following: Sequence[tuple[IntArray, IntArray]]) -> LinkPlace:
        """Place of a link.

        Parameters
        ----------
        target : ndarray of int, shape (n,)
            Coordinate of the linkage of each of the link; -1 where held.
        following : sequence of tuple of ndarray of int
            Rows of the link that follow, and the columns that they follow.
        """
        own = target.copy()
        for rows, _ in following:
            own[rows] = -1
        free = np.flatnonzero(own >= 0)
        places = [(_numbers(rows), _numbers(columns)) for rows, columns in following]
        return cls(_runs(free, own[free]), places)

    def add(
        self, total: FloatArray, matrix: FloatArray, following: Sequence[DependentRows]
    ) -> None:
        """Add ``Q' X Q`` to a matrix of the linkage; only what follows turns.

        Parameters
        ----------
        total : ndarray, shape (B, size, size)
        matrix : ndarray, shape (n, n) or (B, n, n)
        following : sequence of DependentRows
        """
        self.add_resting(total, matrix)
        self.add_turning(total, matrix, following)

    def add_resting(self, total: FloatArray, matrix: FloatArray) -> None:
        """Add the part of ``Q' X Q`` that does not turn, to (size, size) or (B, size, size)."""
        for row, to_row in self.runs:
            for column, to_column in self.runs:
                total[..., to_row, to_column] += matrix[..., row, column]

    def add_turning(
        self, total: FloatArray, matrix: FloatArray, following: Sequence[DependentRows]
    ) -> None:
        """Add the rest of ``Q' X Q``.

        Parameters
        ----------
        total : ndarray, shape (B, size, size)
        matrix : ndarray, shape (n, n) or (B, n, n)
        following : sequence of DependentRows
        """
        for (rows, to_rows), led in zip(self.following, following, strict=True):
            for column, to_column in self.runs:
                block = _turned(led.turn, matrix[..., rows, column])
                total[_where(to_rows, to_column)] += block
        self.add_following(total, matrix, following, [led.turn for led in following])

    def add_following(
        self,
        total: FloatArray,
        matrix: FloatArray,
        following: Sequence[DependentRows],
        right: Sequence[FloatArray],
    ) -> None:
        """Add ``Q' X P``, where P holds what follows alone.

        Parameters
        ----------
        total : ndarray, shape (B, size, size)
        matrix : ndarray, shape (n, n) or (B, n, n)
        following : sequence of DependentRows
        right : sequence of ndarray, shape (B, r, c)
            ``P`` of each.
        """
        for (columns, to_columns), by in zip(self.following, right, strict=True):
            transposed = np.swapaxes(matrix[..., columns], -1, -2)
            turned = np.swapaxes(_turned(by, transposed), 1, 2)
            for row, to_row in self.runs:
                total[_where(to_row, to_columns)] += turned[:, row]
            for (rows, to_rows), led in zip(self.following, following, strict=True):
                total[_where(to_rows, to_columns)] += np.swapaxes(led.turn, 1, 2) @ turned[:, rows]


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
