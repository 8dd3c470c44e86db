"""Constraint equations of joints: gap, Jacobian and rates, over a batch of positions.

Two constraints make all joints: two points coincide, two bodies keep their angle. A point on a line
coincides with one that slides along it (Shabana, *Computational Dynamics*, ch. 3). The Jacobian
transposed gives the joint forces; its rates in rotating frames give the linear constraints between
elastic coordinates.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.linkages.body_motion import BodyMotion, BodyPoint, BodyPoints, parts_of
from flexmech.linkages.matrix_with_rates import MatrixWithRates


@dataclass(frozen=True)
class Coincidence:
    """Two points coincide: an equation along each ground axis."""

    first: BodyPoint
    second: BodyPoint

    rows: ClassVar = 2


@dataclass(frozen=True)
class EqualAngle:
    """Two bodies, by their numbers, keep the angle between them."""

    first: int
    second: int

    rows: ClassVar = 1


Condition = Coincidence | EqualAngle


class Constraints:
    """Constraint equations between bodies.

    Parameters
    ----------
    conditions : sequence of Condition
    unknown : sequence of int
        Bodies whose three coordinates count, in order.
    slides : int
        Number of slides, whose coordinates come after those.

    Attributes
    ----------
    count : int
        Number of equations.
    first, second : BodyPoints
        Both points of each coincidence.
    """

    def __init__(
        self, conditions: Sequence[Condition], unknown: Sequence[int], slides: int = 0
    ) -> None:
        *rows, self.count = np.cumsum([0, *(own.rows for own in conditions)]).tolist()
        numbered = list(zip(rows, conditions, strict=True))
        of_points = [(row, own) for row, own in numbered if isinstance(own, Coincidence)]
        self._row = np.array([row for row, _ in of_points], dtype=np.intp)
        first = 3 * len(unknown)
        self._columns = {body: 3 * n for n, body in enumerate(unknown)}
        self._size, self._slides = first + slides, range(first, first + slides)
        self._points: dict[tuple[BodyPoint, ...], BodyPoints] = {}
        self.first = self._of_joints([own.first for _, own in of_points])
        self.second = self._of_joints([own.second for _, own in of_points])
        self._rotation = np.zeros((self.count, self._size))
        for row, own in numbered:
            if isinstance(own, EqualAngle):
                for body, sign in ((own.first, 1.0), (own.second, -1.0)):
                    if body in self._columns:
                        self._rotation[row, self._columns[body] + 2] = sign

    def _of_joints(self, points: Sequence[BodyPoint]) -> BodyPoints:
        return BodyPoints(points, self._columns, self._slides, self._size, self._row)

    def points(self, points: Sequence[BodyPoint]) -> BodyPoints:
        """Points with their Jacobian by the coordinates of the constraints."""
        own = tuple(points)
        if own not in self._points:
            self._points[own] = BodyPoints(own, self._columns, self._slides, self._size)
        return self._points[own]

    def gap(self, bodies: BodyMotion, slid: ComplexArray) -> FloatArray:
        """Violation of the constraints of points in m; shape (B, count), zero of equal angles.

        Parameters
        ----------
        bodies : BodyMotion
            Batch of shape (B, n).
        slid : ndarray of complex, shape (B, n_slides)
            Where the points that slide are in the axes of their guides.
        """
        return self._in_rows(self.first.places(bodies, slid) - self.second.places(bodies, slid))

    def gap_rate(self, bodies: BodyMotion, slid: ComplexArray, order: int) -> FloatArray:
        """First or second derivative of the gaps; shape (B, count), zero of equal angles.

        Parameters
        ----------
        bodies : BodyMotion
            Batch of shape (B, n).
        slid : ndarray of complex, shape (3, B, n_slides)
            As of :meth:`gap`, with first and second derivative.
        order : {1, 2}
        """
        first, second = (own.rate(bodies, slid, order) for own in (self.first, self.second))
        return self._in_rows(first - second)

    def jacobian(
        self, bodies: BodyMotion, axes: ComplexArray | None, slid: ComplexArray
    ) -> FloatArray:
        """Constraint Jacobian by the coordinates; shape (B, count, 3 n + slides).

        Parameters
        ----------
        bodies : BodyMotion
            Batch of shape (B, n).
        axes : ndarray of complex, shape (B, n), optional
            Unit vectors along which the bodies' first coordinates count; the ground's x axis
            of None.
        slid : ndarray of complex, shape (B, n_slides)
            As of :meth:`gap`.
        """
        axes = np.ones_like(bodies.turn) if axes is None else axes
        matrix = np.zeros((self.count, self._size, len(axes)))
        for own, sign in ((self.first, 1.0), (self.second, -1.0)):
            arms, turn = own.arms(bodies, slid), bodies.turn[:, own.body]
            own.add_to(matrix, sign, axes[:, own.body], turn, arms)
        turns = np.nonzero(self._rotation)
        matrix[turns] += self._rotation[turns][:, None]
        return np.ascontiguousarray(matrix.transpose(2, 0, 1))

    def jacobian_with_rates(self, bodies: BodyMotion, slid: ComplexArray) -> MatrixWithRates:
        """Constraint Jacobian by coordinates in the bodies' rotating axes, with time derivatives.

        Parameters
        ----------
        bodies : BodyMotion
            Batch of shape (B, n).
        slid : ndarray of complex, shape (3, B, n_slides)
            As of :meth:`gap`, with first and second time derivative.

        Returns
        -------
        MatrixWithRates
            Of shape (B, count, 3 n + slides).
        """
        matrix = np.zeros((self.count, self._size, len(bodies.place), 4))
        self.first.add_rates(matrix, 1.0, bodies, slid)
        self.second.add_rates(matrix, -1.0, bodies, slid)
        matrix[..., 0] += self._rotation[..., None]
        return parts_of(matrix)

    def angle_gaps(self, coordinates: FloatArray) -> FloatArray:
        """Gaps (B, count) of equal angles in rad, by the coordinates (B, 3 n + slides)."""
        return np.asarray(coordinates @ self._rotation.T)

    def geometric_stiffness(
        self, bodies: BodyMotion, slid: ComplexArray, forces: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Geometric stiffness by the constraint forces: derivative of ``G' lambda``.

        Parameters
        ----------
        bodies : BodyMotion
            Batch of shape (B, n).
        slid : ndarray of complex, shape (B, n_slides)
            As of :meth:`gap`.
        forces : ndarray, shape (B, count)

        Returns
        -------
        tuple of ndarray
            See :meth:`BodyPoints.geometric_stiffness`.
        """
        vectors = forces[:, self._row] + 1j * forces[:, self._row + 1]
        first = self.first.geometric_stiffness(bodies, slid, vectors)
        second = self.second.geometric_stiffness(bodies, slid, -vectors)
        return first[0] + second[0], first[1] + second[1]

    def _in_rows(self, vectors: ComplexArray) -> FloatArray:
        """Rows (B, count) of vectors (B, C) along the axes."""
        rows = np.zeros((len(vectors), self.count))
        rows[:, self._row], rows[:, self._row + 1] = vectors.real, vectors.imag
        return rows
