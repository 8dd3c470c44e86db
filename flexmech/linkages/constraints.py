"""Constraint equations of joints: gap, Jacobian and rates, over a batch of positions.

Three constraints make all joints: two points coincide, two bodies keep their angle, a point is on a
line (Shabana, *Computational Dynamics*, ch. 3). The Jacobian transposed gives the joint forces; its
rates in rotating frames give the linear constraints between elastic coordinates.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.linkages.body_motion import BodyMotion, BodyPoint, BodyPoints, dot, parts_of
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


@dataclass(frozen=True)
class PointOnLine:
    """A point stays on a line through a point of another body.

    Parameters
    ----------
    first : BodyPoint
    second : BodyPoint
        The line passes through it.
    along : complex
        Unit vector of the line in that body's axes.
    """

    first: BodyPoint
    second: BodyPoint
    along: complex

    rows: ClassVar = 1


Condition = Coincidence | EqualAngle | PointOnLine


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
    """

    def __init__(
        self, conditions: Sequence[Condition], unknown: Sequence[int], slides: int = 0
    ) -> None:
        *rows, self.count = np.cumsum([0, *(own.rows for own in conditions)]).tolist()
        numbered = list(zip(rows, conditions, strict=True))
        of_points = [(row, own) for row, own in numbered if not isinstance(own, EqualAngle)]
        is_line = np.array([isinstance(own, PointOnLine) for _, own in of_points], dtype=bool)
        self._row = np.array([row for row, _ in of_points], dtype=np.intp)
        self._pairs, self._lines = np.flatnonzero(~is_line), np.flatnonzero(is_line)
        self._along = np.array([own.along for _, own in of_points if isinstance(own, PointOnLine)])
        first = 3 * len(unknown)
        self._columns = {body: 3 * n for n, body in enumerate(unknown)}
        self._size, self._slides = first + slides, range(first, first + slides)
        self._pair_of_points = [
            [own.first for _, own in of_points],
            [own.second for _, own in of_points],
        ]
        self._is_line = is_line
        self._points: dict[tuple[BodyPoint, ...], BodyPoints] = {}
        self._rotation = np.zeros((self.count, self._size))
        for row, own in numbered:
            if isinstance(own, EqualAngle):
                for body, sign in ((own.first, 1.0), (own.second, -1.0)):
                    if body in self._columns:
                        self._rotation[row, self._columns[body] + 2] = sign

    @cached_property
    def first(self) -> BodyPoints:
        """First point of each coincidence and line."""
        return self._of_joints(0)

    @cached_property
    def second(self) -> BodyPoints:
        """Second point of each coincidence, and the one through which each line passes."""
        return self._of_joints(1)

    def _of_joints(self, number: int) -> BodyPoints:
        points = self._pair_of_points[number]
        return BodyPoints(points, self._columns, self._slides, self._size, self._row, self._is_line)

    def points(self, points: Sequence[BodyPoint]) -> BodyPoints:
        """Points with their Jacobian by the coordinates of the constraints."""
        own = tuple(points)
        if own not in self._points:
            self._points[own] = BodyPoints(own, self._columns, self._slides, self._size)
        return self._points[own]

    def gap(self, bodies: BodyMotion, slid: ComplexArray | None = None) -> FloatArray:
        """Violation of the constraints of points in m; shape (B, count), zero of equal angles.

        Parameters
        ----------
        bodies : BodyMotion
            Batch of shape (B, n).
        slid : ndarray of complex, shape (B, n_slides), optional
            Where the points that slide are in the axes of their guides.
        """
        first, second = (own.places(bodies, slid) for own in (self.first, self.second))
        return self._in_rows(first - second, self._across(bodies))

    def gap_rate(self, bodies: BodyMotion, order: int) -> FloatArray:
        """First or second derivative of the gaps where they are closed; shape (B, count).

        Parameters
        ----------
        bodies : BodyMotion
            Batch of shape (B, n).
        order : {1, 2}
        """
        apart = self.first.rate(bodies, order) - self.second.rate(bodies, order)
        rows = self._in_rows(apart, self._across(bodies))
        if len(self._lines):
            # A line's own rotation counts across it, at the place where the point is.
            guide = self.second.body[self._lines]
            along, spin = bodies.turn[:, guide] * self._along, bodies.turn_1[:, guide]
            gap = (self.first.places(bodies) - self.second.places(bodies))[:, self._lines]
            distance, turned = dot(along, gap), spin
            if order == 2:
                rate = (self.first.rate(bodies, 1) - self.second.rate(bodies, 1))[:, self._lines]
                sliding, turned = dot(along, rate), bodies.turn_2[:, guide]
                rows[:, self._row[self._lines]] -= 2 * sliding * spin
            rows[:, self._row[self._lines]] -= distance * turned
        return rows

    def jacobian(
        self,
        bodies: BodyMotion,
        axes: ComplexArray | None = None,
        slid: ComplexArray | None = None,
    ) -> FloatArray:
        """Constraint Jacobian by the coordinates; shape (B, count, 3 n + slides).

        Parameters
        ----------
        bodies : BodyMotion
            Batch of shape (B, n).
        axes : ndarray of complex, shape (B, n), optional
            Unit vectors along which the bodies' first coordinates count; the ground's x axis
            where they are left out.
        slid : ndarray of complex, shape (B, n_slides), optional
            As of :meth:`gap`.
        """
        axes = np.ones_like(bodies.turn) if axes is None else axes
        arms = [own.arms(bodies, slid) for own in (self.first, self.second)]
        if len(self._lines):
            # A line's guide turns the place where the point is now.
            here = self.first.places(bodies, slid) - bodies.place[:, self.second.body]
            arms[1][:, self._lines] = here[:, self._lines]
        matrix = np.zeros((self.count, self._size, len(axes)))
        for own, arm, sign in zip((self.first, self.second), arms, (1.0, -1.0), strict=True):
            turn = bodies.turn[:, own.body]
            own.add_to(matrix, sign, axes[:, own.body], turn, arm, self._across(bodies))
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

    def _across(self, bodies: BodyMotion) -> ComplexArray:
        """Unit vectors to the left of the lines, (B, n_lines)."""
        return np.asarray(1j * bodies.turn[:, self.second.body[self._lines]] * self._along)

    def _in_rows(self, vectors: ComplexArray, across: ComplexArray) -> FloatArray:
        """Rows (B, count) of vectors (B, C): along the axes, or across the lines (B, n_lines)."""
        rows, first = np.zeros((len(vectors), self.count)), self._row[self._pairs]
        two = vectors[:, self._pairs]
        rows[:, first], rows[:, first + 1] = two.real, two.imag
        rows[:, self._row[self._lines]] = dot(across, vectors[:, self._lines])
        return rows
