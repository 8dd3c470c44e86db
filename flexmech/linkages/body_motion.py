"""Motion of rigid bodies over a batch of positions, points on them, and constraints between them.

Vectors of the plane are complex numbers, x + i y. A body has a reference point at p and is turned
by phi: its point at r is at ``p + exp(i phi) r``, and it has three coordinates, displacements of
its reference point and a rotation. Two constraints make all joints: two points coincide, two bodies
keep their angle. A point on a line coincides with one that slides along it (Shabana, *Computational
Dynamics*, ch. 3). The Jacobian transposed gives the joint forces; its rates in rotating frames give
the linear constraints between elastic coordinates.

A Jacobian is a :class:`MatrixWithRates`, with its first and second time derivatives.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, NamedTuple, Self

import numpy as np

from flexmech.arrays import ComplexArray, FloatArray, IntArray
from flexmech.linkages.motion import RigidMotion, as_pairs


@dataclass(frozen=True)
class MatrixWithRates:
    """A matrix and its time derivatives over a batch of positions.

    Parameters
    ----------
    value : ndarray, shape (B, r, c)
    rate : ndarray, shape (B, r, c)
        First time derivative.
    centripetal, tangential : ndarray, shape (B, r, c)
        Second time derivative: the parts in squares and products of velocities of the rigid
        motion, and in its accelerations.

    Examples
    --------
    >>> import numpy as np
    >>> from flexmech.linkages.body_motion import MatrixWithRates
    >>> turn = MatrixWithRates.rotation(np.array([0.5]), np.array([2.0]), np.array([0.0]))
    >>> still = turn.solve(turn)
    >>> bool(np.allclose(still.value, np.eye(2)))
    True
    >>> bool(np.allclose(still.rate, 0.0))
    True
    """

    value: FloatArray
    rate: FloatArray
    centripetal: FloatArray
    tangential: FloatArray

    @classmethod
    def constant(cls, matrix: FloatArray, batch: int) -> Self:
        """A constant matrix.

        Parameters
        ----------
        matrix : ndarray, shape (r, c)
        batch : int
            How many times.
        """
        nothing = np.zeros((batch, *matrix.shape))
        return cls(nothing + matrix, nothing, nothing, nothing)

    @classmethod
    def rotation(cls, angle: FloatArray, speed: FloatArray, change: FloatArray) -> Self:
        """Rotation by an angle, (B, 2, 2).

        Parameters
        ----------
        angle, speed, change : ndarray, shape (B,)
            In rad, with its first and second time derivative.
        """
        cosine, sine = np.cos(angle), np.sin(angle)
        turn = np.stack([cosine, -sine, sine, cosine], axis=-1).reshape(-1, 2, 2)
        quarter = np.stack([-sine, -cosine, cosine, -sine], axis=-1).reshape(-1, 2, 2)
        return cls(
            turn,
            speed[:, None, None] * quarter,
            -(speed[:, None, None] ** 2) * turn,
            change[:, None, None] * quarter,
        )

    def rows(self, which: IntArray) -> Self:
        """Some rows, by their numbers."""
        return type(self)(*(matrix[:, which] for matrix in self.parts))

    def columns(self, which: IntArray) -> Self:
        """Some columns, by their numbers."""
        return type(self)(*(matrix[:, :, which] for matrix in self.parts))

    def __matmul__(self, other: MatrixWithRates) -> MatrixWithRates:
        return MatrixWithRates(
            self.value @ other.value,
            self.rate @ other.value + self.value @ other.rate,
            self.centripetal @ other.value
            + 2 * self.rate @ other.rate
            + self.value @ other.centripetal,
            self.tangential @ other.value + self.value @ other.tangential,
        )

    def __sub__(self, other: MatrixWithRates) -> MatrixWithRates:
        return MatrixWithRates(
            *(left - right for left, right in zip(self.parts, other.parts, strict=True))
        )

    def __neg__(self) -> MatrixWithRates:
        return MatrixWithRates(*(-matrix for matrix in self.parts))

    def solve(self, right: MatrixWithRates) -> MatrixWithRates:
        """``X`` of ``self @ X = right``, by implicit differentiation.

        Parameters
        ----------
        right : MatrixWithRates
            Right-hand side of shape (B, n, c); ``self`` is of shape (B, n, n).

        Returns
        -------
        MatrixWithRates
            ``X``, of shape (B, n, c).
        """
        inverse = np.asarray(np.linalg.inv(self.value), dtype=float)
        value = inverse @ right.value
        rate = inverse @ (right.rate - self.rate @ value)
        centripetal = right.centripetal - self.centripetal @ value - 2 * self.rate @ rate
        tangential = right.tangential - self.tangential @ value
        return MatrixWithRates(value, rate, inverse @ centripetal, inverse @ tangential)

    @classmethod
    def stacked(cls, parts: list[MatrixWithRates]) -> MatrixWithRates:
        """Several matrices stacked by rows."""
        every = zip(*(block.parts for block in parts), strict=True)
        return cls(*(np.concatenate(one, axis=1) for one in every))

    @property
    def parts(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Value, rate, and the two parts of the second derivative."""
        return self.value, self.rate, self.centripetal, self.tangential


GROUND_BODY, CRANK = 0, 1
"""Numbers of the two bodies of a drawn linkage whose motion is known from the start."""
GROUND_AFTER_LINKS = -1
"""Number of the ground where bodies are the links of a topology: the last body."""


def dot(first: ComplexArray | complex, second: ComplexArray | complex) -> FloatArray:
    """Scalar product of vectors that are complex numbers."""
    return np.asarray((first.conjugate() * second).real)


def cross(first: ComplexArray | complex, second: ComplexArray | complex) -> FloatArray:
    """Product of vectors that are complex numbers, positive where the second is to the left."""
    return np.asarray((first.conjugate() * second).imag)


class MovingPoint(NamedTuple):
    """Motion of a point over a batch, with derivatives as of :class:`BodyMotion`.

    Parameters
    ----------
    place, rate, change : ndarray of complex, shape (B,)
        Where it is, and its first and second derivative.
    """

    place: ComplexArray
    rate: ComplexArray
    change: ComplexArray


@dataclass(frozen=True)
class BodyMotion:
    """Position and rotation of bodies over a batch, with derivatives by time or crank angle.

    Parameters
    ----------
    drawn : ndarray of complex, shape (n,)
        The reference point in the body's own axes.
    place, place_1, place_2 : ndarray of complex, shape (B, n)
        Where that point is, and its derivatives.
    turn : ndarray of complex, shape (B, n)
        ``exp(i phi)`` with the angle phi of the body's axes.
    turn_1, turn_2 : ndarray, shape (B, n)
        Derivatives of phi.
    """

    drawn: ComplexArray
    place: ComplexArray
    turn: ComplexArray
    place_1: ComplexArray
    place_2: ComplexArray
    turn_1: FloatArray
    turn_2: FloatArray

    @classmethod
    def of_links(cls, motion: RigidMotion) -> Self:
        """Motion of the links, referred to their starts, and of the ground, which comes last."""
        batch, links = motion.angle.shape
        place = np.zeros((3, batch, links + 1), dtype=complex)
        vectors = motion.origin, motion.origin_velocity, motion.origin_acceleration
        for target, vector in zip(place, vectors, strict=True):
            target.real[:, :-1], target.imag[:, :-1] = vector[..., 0], vector[..., 1]
        turn = np.zeros((3, batch, links + 1))
        turn[..., :-1] = motion.angle, motion.angular_velocity, motion.angular_acceleration
        drawn = np.zeros(links + 1, dtype=complex)
        return cls(drawn, place[0], np.exp(1j * turn[0]), *place[1:], *turn[1:])

    @classmethod
    def at_rest(cls, drawn: ComplexArray, batch: int) -> Self:
        """Bodies in the places (n,) in which they are drawn, ``batch`` times."""
        # A body's values over the batch are one after the other in memory.
        place, place_1, place_2, turn = np.zeros((4, len(drawn), batch), dtype=complex)
        turn_1, turn_2 = np.zeros((2, len(drawn), batch))
        place += drawn[:, None]
        turn += 1.0
        return cls(drawn, place.T, turn.T, place_1.T, place_2.T, turn_1.T, turn_2.T)

    @classmethod
    def cranked(cls, drawn: ComplexArray, angle: FloatArray) -> Self:
        """Bodies at rest but for the crank, which is turned by angles (B,) in rad."""
        bodies = cls.at_rest(drawn, len(angle))
        bodies.turn[:, CRANK], bodies.turn_1[:, CRANK] = np.exp(1j * angle), 1.0
        return bodies

    def moving_point(self, body: int, drawn: complex) -> MovingPoint:
        """Motion of a point of a body.

        Parameters
        ----------
        body : int
        drawn : complex
            In the body's own axes.
        """
        place, rate, change = (
            values[:, body] for values in (self.place, self.place_1, self.place_2)
        )
        if from_reference := drawn - self.drawn[body]:
            spin, arm = 1j * self.turn_1[:, body], self.turn[:, body] * from_reference
            turning = (spin**2 + 1j * self.turn_2[:, body]) * arm
            return MovingPoint(place + arm, rate + spin * arm, change + turning)
        return MovingPoint(place, rate, change)

    def move(
        self,
        body: int,
        drawn: complex,
        point: MovingPoint,
        turn: ComplexArray,
        spin: FloatArray,
        swing: FloatArray,
    ) -> None:
        """Give a body its motion by that of a point and by its rotation.

        Parameters
        ----------
        body : int
        drawn : complex
            The point in the body's own axes.
        point : MovingPoint
        turn, spin, swing : ndarray, shape (B,)
            As ``turn``, ``turn_1`` and ``turn_2``.
        """
        self.turn[:, body], self.turn_1[:, body], self.turn_2[:, body] = turn, spin, swing
        place, rate, change = point
        if to_reference := self.drawn[body] - drawn:
            arm = turn * to_reference
            turning = (1j * swing - spin**2) * arm
            place, rate, change = place + arm, rate + 1j * spin * arm, change + turning
        self.place[:, body], self.place_1[:, body], self.place_2[:, body] = place, rate, change

    def driven_motion(
        self,
        links: IntArray | slice,
        starts: ComplexArray,
        angle: FloatArray,
        crank: tuple[FloatArray, ...],
    ) -> RigidMotion:
        """Motion of links in time, where derivatives are those by the crank angle.

        Parameters
        ----------
        links : ndarray of int, shape (m,), or slice
            Body of each link.
        starts : ndarray of complex, shape (m,)
            Start of each link in the axes of its body.
        angle : ndarray, shape (B, m)
            Angle of the links in rad.
        crank : tuple of ndarray, shape (...)
            Angle, speed and acceleration of the crank in each of the B positions.
        """
        theta, speed, acceleration = crank
        shape = (*theta.shape, angle.shape[-1])
        place, rate, change = (
            values[:, links] for values in (self.place, self.place_1, self.place_2)
        )
        spin, swing = self.turn_1[:, links], self.turn_2[:, links]
        if np.any(from_reference := starts - self.drawn[links]):
            arm = self.turn[:, links] * from_reference
            turning = (1j * swing - spin**2) * arm
            place, rate, change = place + arm, rate + 1j * spin * arm, change + turning
        w, a = speed.reshape(-1, 1), acceleration.reshape(-1, 1)
        square = w**2
        return RigidMotion(
            crank_angle=theta,
            crank_speed=speed,
            angle=np.ascontiguousarray(angle).reshape(shape),
            angular_velocity=np.ascontiguousarray(spin * w).reshape(shape),
            angular_acceleration=np.ascontiguousarray(swing * square + spin * a).reshape(shape),
            origin=as_pairs(place).reshape(*shape, 2),
            origin_velocity=as_pairs(rate * w).reshape(*shape, 2),
            origin_acceleration=as_pairs(change * square + rate * a).reshape(*shape, 2),
        )


@dataclass(frozen=True)
class BodyPoint:
    """A point of a body, in its axes, or one that moves in these.

    Parameters
    ----------
    body : int
    place : complex
        Place of one that moves it is given with the positions.
    slide : int, optional
        Number of its place among those.
    along : complex
        Unit vector in the body's axes of the line along which it slides; zero of a point of a body
        that deforms, whose place is no coordinate.
    """

    body: int
    place: complex = 0.0
    slide: int | None = None
    along: complex = 0.0


class BodyPoints:
    """Points of bodies with their Jacobian by the bodies' coordinates.

    Parameters
    ----------
    points : sequence of BodyPoint
    columns : mapping of int to int
        First of the three coordinates of each body that has some.
    slides : sequence of int
        Coordinate of each slide.
    size : int
        Number of all coordinates.
    rows : ndarray of int, shape (P,), optional
        First row of each point in a Jacobian, which gives it two, along x and y, by default one
        point after the other.

    Attributes
    ----------
    body : ndarray of int, shape (P,)
    place : ndarray of complex, shape (P,)
    """

    def __init__(
        self,
        points: Sequence[BodyPoint],
        columns: Mapping[int, int],
        slides: Sequence[int],
        size: int,
        rows: IntArray | None = None,
    ) -> None:
        count = len(points)
        self.body = np.array([point.body for point in points], dtype=np.intp)
        self.place = np.array([point.place for point in points], dtype=complex)
        self._shape = 2 * count, size
        row = 2 * np.arange(count) if rows is None else rows
        first = np.array([columns.get(point.body, -1) for point in points], dtype=np.intp)
        self._moving = moving = np.flatnonzero(first >= 0)
        self._target = row[moving, None], first[moving, None] + np.arange(3)
        sliding = [n for n, point in enumerate(points) if point.slide is not None]
        self._sliding = np.array(sliding, dtype=np.intp)
        self._slide = np.array([points[n].slide for n in sliding], dtype=np.intp)
        self._along = np.array([points[n].along for n in sliding], dtype=complex)
        self._on_lines = np.flatnonzero(self._along)
        own_slides = np.array([slides[n] for n in self._slide[self._on_lines]], dtype=np.intp)
        self._slide_places = row[self._sliding[self._on_lines]], own_slides

    def arms(self, bodies: BodyMotion, slid: ComplexArray) -> ComplexArray:
        """Arms from the bodies' reference points to the points in ground axes, (B, P).

        Parameters
        ----------
        bodies : BodyMotion
            Batch of shape (B, n).
        slid : ndarray of complex, shape (B, n_slides)
            Where the points that slide are in the axes of their guides.
        """
        arm: ComplexArray = bodies.turn[:, self.body] * (self.place - bodies.drawn[self.body])
        if len(self._sliding):
            turn = bodies.turn[:, self.body[self._sliding]]
            arm[:, self._sliding] = turn * slid[:, self._slide]
        return arm

    def places(self, bodies: BodyMotion, slid: ComplexArray) -> ComplexArray:
        """Positions of the points in ground axes, (B, P); as :meth:`arms`."""
        return np.asarray(bodies.place[:, self.body] + self.arms(bodies, slid))

    def rate(self, bodies: BodyMotion, slid: ComplexArray, order: int) -> ComplexArray:
        """First or second derivative of the positions, (B, P).

        Parameters
        ----------
        bodies : BodyMotion
            Batch of shape (B, n).
        slid : ndarray of complex, shape (3, B, n_slides)
            As of :meth:`arms`, and its first and second derivative.
        order : {1, 2}
        """
        spin, arm = 1j * bodies.turn_1[:, self.body], self.arms(bodies, slid[0])
        if order == 1:
            rate = bodies.place_1[:, self.body] + spin * arm
        else:
            rate = bodies.place_2[:, self.body] + (1j * bodies.turn_2[:, self.body] + spin**2) * arm
        if len(sliding := self._sliding):
            moved = slid[order][:, self._slide]
            if order == 2:
                moved = moved + 2 * spin[:, sliding] * slid[1][:, self._slide]
            rate[:, sliding] += bodies.turn[:, self.body[sliding]] * moved
        return np.asarray(rate)

    def jacobian(self, bodies: BodyMotion, axes: ComplexArray, slid: ComplexArray) -> FloatArray:
        """Jacobian of the points by the coordinates of the bodies and by the slides.

        Parameters
        ----------
        bodies : BodyMotion
            Batch of shape (B, n).
        axes : ndarray of complex, shape (B, n)
            Unit vectors along which the reference points' first coordinates count.
        slid : ndarray of complex, shape (B, n_slides)
            As of :meth:`arms`.

        Returns
        -------
        ndarray, shape (B, 2 P, size)
        """
        matrix = np.zeros((*self._shape, len(axes)))
        turn, arm = bodies.turn[:, self.body], self.arms(bodies, slid)
        self.add_to(matrix, 1.0, axes[:, self.body], turn, arm)
        return np.ascontiguousarray(matrix.transpose(2, 0, 1))

    def jacobian_with_rates(self, bodies: BodyMotion, slid: ComplexArray) -> MatrixWithRates:
        """Jacobian by coordinates in the bodies' rotating axes, with its time derivatives.

        Parameters
        ----------
        bodies : BodyMotion
            Batch of shape (B, n).
        slid : ndarray of complex, shape (3, B, n_slides)
            As of :meth:`arms`, and its first and second time derivative.

        Returns
        -------
        MatrixWithRates
            Jacobian and its derivatives, of shape (B, 2 P, size).
        """
        matrix = np.zeros((*self._shape, len(bodies.place), 4))
        self.add_rates(matrix, 1.0, bodies, slid)
        return parts_of(matrix)

    def add_rates(
        self, matrix: FloatArray, sign: float, bodies: BodyMotion, slid: ComplexArray
    ) -> None:
        """Add a sign times the parts of :meth:`jacobian_with_rates` to a matrix.

        Parameters
        ----------
        matrix : ndarray, shape (rows, size, B, 4)
        sign : float
        bodies : BodyMotion
            Batch of shape (B, n).
        slid : ndarray of complex, shape (3, B, n_slides)
            As of :meth:`jacobian_with_rates`.
        """
        speed, change = bodies.turn_1[:, self.body], bodies.turn_2[:, self.body]
        factors = np.stack([np.ones_like(speed), 1j * speed, -(speed**2), 1j * change])
        turn = factors * bodies.turn[:, self.body]
        arm = factors * self.arms(bodies, slid[0])
        if len(self._sliding):
            at = (slice(None), self._sliding)
            first, second = (rate[:, self._slide] for rate in slid[1:])
            arm[1][at] += turn[0][at] * first
            arm[2][at] += 2 * turn[1][at] * first
            arm[3][at] += turn[0][at] * second
        self.add_to(matrix, sign, turn, turn, arm)

    def add_to(
        self,
        matrix: FloatArray,
        sign: float,
        axes: ComplexArray,
        turn: ComplexArray,
        arm: ComplexArray,
    ) -> None:
        """Add a sign times a Jacobian, or a time derivative of it, to a matrix.

        Parameters
        ----------
        matrix : ndarray, shape (rows, size, B) or (rows, size, B, 4)
        sign : float
        axes, turn, arm : ndarray of complex, shape (B, P) or (4, B, P)
            Unit vectors along which the reference points' first coordinates count, those of the
            turned bodies, and vectors from the reference points; or time derivatives of these.
        """
        axes, turn, arm = axes.T, turn.T, arm.T
        block = sign * np.stack([axes, 1j * axes, 1j * arm], axis=1)
        rows, columns = self._target
        matrix[rows, columns] += block[self._moving].real
        matrix[rows + 1, columns] += block[self._moving].imag
        if len(self._on_lines):
            slide_rows, slides = self._slide_places
            sliding, along = self._sliding[self._on_lines], self._along[self._on_lines]
            along = sign * (turn[sliding].T * along).T
            matrix[slide_rows, slides] += along.real
            matrix[slide_rows + 1, slides] += along.imag

    def geometric_stiffness(
        self, bodies: BodyMotion, slid: ComplexArray, forces: ComplexArray
    ) -> tuple[FloatArray, FloatArray]:
        """Geometric stiffness by dead loads on the points, whose arms rotate.

        Parameters
        ----------
        bodies : BodyMotion
            Batch of shape (B, n).
        slid : ndarray of complex, shape (B, n_slides)
            As of :meth:`arms`.
        forces : ndarray of complex, shape (B, P)
            On the points, in N.

        Returns
        -------
        tuple of ndarray, shape (B, n), (B, n_slides)
            By the rotation of bodies, and between the rotation of a guide and the slide on it.
        """
        rotation_stiffness, guide_stiffness = np.zeros(bodies.place.shape), np.zeros(slid.shape)
        by_arm = dot(forces, self.arms(bodies, slid))
        for point in self._moving:
            rotation_stiffness[:, self.body[point]] += by_arm[:, point]
        for point, slide, along in zip(self._sliding, self._slide, self._along, strict=True):
            if point in self._moving:
                across = 1j * along * bodies.turn[:, self.body[point]]
                guide_stiffness[:, slide] -= dot(forces[:, point], across)
        return rotation_stiffness, guide_stiffness


def parts_of(matrix: FloatArray) -> MatrixWithRates:
    """Matrix with rates from its four parts (rows, columns, B, 4)."""
    return MatrixWithRates(*np.ascontiguousarray(matrix.transpose(3, 2, 0, 1)))


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
        *rows, self.count = np.cumsum([0, *(condition.rows for condition in conditions)]).tolist()
        numbered = list(zip(rows, conditions, strict=True))
        of_points = [
            (row, condition) for row, condition in numbered if isinstance(condition, Coincidence)
        ]
        self._row = np.array([row for row, _ in of_points], dtype=np.intp)
        first = 3 * len(unknown)
        self._columns = {body: 3 * n for n, body in enumerate(unknown)}
        self._size, self._slides = first + slides, range(first, first + slides)
        self._points: dict[tuple[BodyPoint, ...], BodyPoints] = {}
        self.first = self._of_joints([condition.first for _, condition in of_points])
        self.second = self._of_joints([condition.second for _, condition in of_points])
        self._rotation = np.zeros((self.count, self._size))
        for row, condition in numbered:
            if isinstance(condition, EqualAngle):
                for body, sign in ((condition.first, 1.0), (condition.second, -1.0)):
                    if body in self._columns:
                        self._rotation[row, self._columns[body] + 2] = sign

    def _of_joints(self, points: Sequence[BodyPoint]) -> BodyPoints:
        return BodyPoints(points, self._columns, self._slides, self._size, self._row)

    def points(self, points: Sequence[BodyPoint]) -> BodyPoints:
        """Points with their Jacobian by the coordinates of the constraints."""
        key = tuple(points)
        if key not in self._points:
            self._points[key] = BodyPoints(key, self._columns, self._slides, self._size)
        return self._points[key]

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
        first, second = (points.rate(bodies, slid, order) for points in (self.first, self.second))
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
        for points, sign in ((self.first, 1.0), (self.second, -1.0)):
            arms, turn = points.arms(bodies, slid), bodies.turn[:, points.body]
            points.add_to(matrix, sign, axes[:, points.body], turn, arms)
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
            Jacobian and its derivatives, of shape (B, count, 3 n + slides).
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
