"""Where the matrix of one link goes in those of the linkage."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexmech.types import FloatArray, IntArray

__all__ = ["LinkPlace", "TurningPair"]


@dataclass(frozen=True)
class TurningPair:
    """A follower's end displacement, turned from the leader's frame.

    Parameters
    ----------
    pair : ndarray of int, shape (2,)
        The end's coordinates in the following link.
    turn : ndarray, shape (B, 2, 2)
        ``R``, from the leader's frame to the follower's.
    rate : ndarray, shape (B, 2, 2)
        Time derivative of ``R``.
    centripetal, tangential : ndarray, shape (B, 2, 2)
        Second time derivative of ``R``: the parts in the square of the relative angular
        velocity and in the relative angular acceleration.
    """

    pair: IntArray
    turn: FloatArray
    rate: FloatArray
    centripetal: FloatArray
    tangential: FloatArray


@dataclass(frozen=True)
class LinkPlace:
    """Coordinates of a link and those of the linkage that they are.

    Parameters
    ----------
    runs : list of tuple of slice
        Those that are coordinates of the linkage themselves: runs in the link and in the linkage.
    following : list of tuple of slice
        Pairs that are another link's end, turned.
    """

    runs: list[tuple[slice, slice]]
    following: list[tuple[slice, slice]]

    @classmethod
    def of(cls, target: IntArray, pairs: Sequence[IntArray]) -> LinkPlace:
        """Place of a link.

        Parameters
        ----------
        target : ndarray of int, shape (n,)
            Coordinate of the linkage of each of the link; -1 where held.
        pairs : sequence of ndarray of int, shape (2,)
            Coordinates of the link's ends that follow.
        """
        own = target.copy()
        for pair in pairs:
            own[pair] = -1
        free = np.flatnonzero(own >= 0)
        return cls(_runs(free, own[free]), [(_pair(pair), _pair(target[pair])) for pair in pairs])

    def add(self, total: FloatArray, matrix: FloatArray, pairs: Sequence[TurningPair]) -> None:
        """Add ``Q' X Q`` to a matrix of the linkage; only the following ends turn.

        Parameters
        ----------
        total : ndarray, shape (B, size, size)
        matrix : ndarray, shape (n, n) or (B, n, n)
        pairs : sequence of TurningPair
        """
        self.add_resting(total, matrix)
        self.add_turning(total, matrix, pairs)

    def add_resting(self, total: FloatArray, matrix: FloatArray) -> None:
        """Add the part of ``Q' X Q`` that does not turn, to (size, size) or (B, size, size)."""
        for row, to_row in self.runs:
            for column, to_column in self.runs:
                total[..., to_row, to_column] += matrix[..., row, column]

    def add_turning(
        self, total: FloatArray, matrix: FloatArray, pairs: Sequence[TurningPair]
    ) -> None:
        """Add the rest of ``Q' X Q``.

        Parameters
        ----------
        total : ndarray, shape (B, size, size)
        matrix : ndarray, shape (n, n) or (B, n, n)
        pairs : sequence of TurningPair
        """
        for (row, to_row), turning in zip(self.following, pairs, strict=True):
            for column, to_column in self.runs:
                total[:, to_row, to_column] += _turned(turning.turn, matrix[..., row, column])
        self.add_following(total, matrix, pairs, [turning.turn for turning in pairs])

    def add_following(
        self,
        total: FloatArray,
        matrix: FloatArray,
        pairs: Sequence[TurningPair],
        right: Sequence[FloatArray],
    ) -> None:
        """Add ``Q' X P``, where P holds the following ends alone.

        Parameters
        ----------
        total : ndarray, shape (B, size, size)
        matrix : ndarray, shape (n, n) or (B, n, n)
        pairs : sequence of TurningPair
        right : sequence of ndarray, shape (B, 2, 2)
            ``P`` of each end.
        """
        for (column, to_column), by in zip(self.following, right, strict=True):
            transposed = np.swapaxes(matrix[..., column], -1, -2)
            turned = np.swapaxes(_turned(by, transposed), 1, 2)
            for row, to_row in self.runs:
                total[:, to_row, to_column] += turned[:, row]
            for (row, to_row), turning in zip(self.following, pairs, strict=True):
                total[:, to_row, to_column] += np.swapaxes(turning.turn, 1, 2) @ turned[:, row]


def _turned(turn: FloatArray, rows: FloatArray) -> FloatArray:
    """``R' X`` for rows (2, n) or (B, 2, n) of a link matrix; (B, 2, n)."""
    transposed = np.swapaxes(turn, 1, 2)
    if rows.ndim == 3:
        return transposed @ rows
    return (transposed.reshape(-1, 2) @ rows).reshape(len(turn), 2, -1)


def _pair(numbers: IntArray) -> slice:
    """Slice of two numbers, in their order."""
    first, second = (int(n) for n in numbers)
    step = second - first
    stop = second + step
    return slice(first, stop if stop >= 0 else None, step)


def _runs(source: IntArray, target: IntArray) -> list[tuple[slice, slice]]:
    """Runs of consecutive numbers in both."""
    breaks = np.flatnonzero((np.diff(source) != 1) | (np.diff(target) != 1)) + 1
    parts = zip(np.split(source, breaks), np.split(target, breaks), strict=True)
    return [
        (slice(int(s[0]), int(s[-1]) + 1), slice(int(t[0]), int(t[-1]) + 1))
        for s, t in parts
        if len(s)
    ]
