"""Elements at dependent ends, with their constraints; arrays end with the batch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system import DisplacedTies
from flexmech.reference.element_arrays import in_positions


@dataclass(frozen=True)
class Ties:
    """Constraints of the links in a batch of positions.

    Parameters
    ----------
    turns : list of list of ndarray, shape (r, c, B)
        Of each link: derivative of the dependent rows of each tie by the independent ones.
    displaced : DisplacedTies, optional
        Where rigid links and lines are, if there are any.
    """

    turns: list[list[FloatArray]]
    displaced: DisplacedTies | None

    def at(self, which: IntArray) -> Ties:
        """Constraints of some positions, where they do not depend on displacements."""
        return Ties([[in_positions(turn, which) for turn in turns] for turns in self.turns], None)


@dataclass(frozen=True)
class DependentElement:
    """An element with dependent coordinates.

    Parameters
    ----------
    link, element : int
    ties : list of tuple of int and ndarray of int, shape (r,)
        Number of each tie of the link, and the element's coordinates that depend by it.
    columns : ndarray of int, shape (c,)
        Coordinates of z that move the element; -1 where it is fixed.
    places : list of ndarray of int
        Where the columns of each tie are among these.
    independent : tuple of ndarray of int, shape (k,)
        The element's other free coordinates, and where they are among the columns.
    in_place : bool
        Whether each dependent row has a column in its own place.
    first : int
        Row of the entries where its matrix begins.
    """

    link: int
    element: int
    ties: list[tuple[int, IntArray]]
    columns: IntArray
    places: list[IntArray]
    independent: tuple[IntArray, IntArray]
    in_place: bool
    first: int

    @classmethod
    def of(
        cls,
        link: int,
        element: int,
        ties: list[tuple[int, IntArray]],
        target: IntArray,
        leading: Sequence[IntArray],
        first: int,
    ) -> DependentElement:
        """Element with the independent coordinates on which it depends.

        Parameters
        ----------
        link, element, first : int
        ties : list of tuple of int and ndarray of int, shape (r,)
        target : ndarray of int, shape (2 p,)
            Coordinate of z of each of the element; -1 where fixed.
        leading : sequence of ndarray of int, shape (c,)
            Coordinates of z on which each tie depends.

        Returns
        -------
        DependentElement
        """
        in_place = all(
            len(rows) == len(columns) and (target[rows] == columns).all()
            for (_, rows), columns in zip(ties, leading, strict=True)
        )
        if in_place:
            nothing = np.zeros(0, dtype=np.intp)
            places = [rows for _, rows in ties]
            return cls(link, element, ties, target, places, (nothing, nothing), True, first)
        free = target >= 0
        for _, rows in ties:
            free[rows] = False
        independent = np.flatnonzero(free)
        columns = np.unique(np.concatenate([target[independent], *leading]))
        found = [np.searchsorted(columns, each) for each in (target[independent], *leading)]
        return cls(link, element, ties, columns, found[1:], (independent, found[0]), False, first)

    def turned(self, matrix: FloatArray, turns: Sequence[FloatArray]) -> FloatArray:
        """Matrix in the independent coordinates from that in nodal coordinates.

        Parameters
        ----------
        matrix : ndarray, shape (2 p, 2 p, B)
            Overwritten.
        turns : sequence of ndarray, shape (r, c, B)
            Of each tie.

        Returns
        -------
        ndarray, shape (c, c, B)
        """
        if self.in_place:
            for (_, rows), turn in zip(self.ties, turns, strict=True):
                matrix[:, rows] = (matrix[:, rows, None] * turn).sum(axis=1)
                matrix[rows] = (turn[:, :, None] * matrix[rows][:, None]).sum(axis=0)
            return matrix
        dependence = np.zeros((matrix.shape[2], len(matrix), len(self.columns)))
        dependence[:, self.independent[0], self.independent[1]] = 1.0
        for (_, rows), places, turn in zip(self.ties, self.places, turns, strict=True):
            dependence[:, rows[:, None], places] = np.moveaxis(turn, -1, 0)
        product = np.swapaxes(dependence, 1, 2) @ np.moveaxis(matrix, -1, 0) @ dependence
        return np.moveaxis(product, 0, -1)
