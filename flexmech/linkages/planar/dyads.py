"""Motion of groups of one or two bodies in closed form, over a batch of crank angles.

A point that stays at a distance from a known point is on a circle, one that slides is on a
line. Two of these loci give the point (RRR: two circles, RRP and PRR: circle and line, PRP:
two lines); the bodies follow from it. A body that turns about one known point while another
slides along it (RPR) follows from the two. Norton, Design of Machinery, ch. 4; the loci's
derivatives are written for lines that move.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flexmech.arrays import ROUND_OFF, ComplexArray, FloatArray
from flexmech.linkages.body_motion import BodyMotion, dot
from flexmech.linkages.change_points import Clearance
from flexmech.linkages.motion import LOCKING_SINE
from flexmech.linkages.planar.bodies import Refusal

Known = Mapping[int, BodyMotion]


def cross(first: ComplexArray | complex, second: ComplexArray | complex) -> FloatArray:
    """Product of two vectors, positive where the second is to the left of the first."""
    return np.imag(np.conj(first) * second)


@dataclass(frozen=True)
class PointPath:
    """Positions of a point with derivatives by the crank angle; each of shape (B,)."""

    place: ComplexArray
    first: ComplexArray
    second: ComplexArray

    @classmethod
    def of(cls, body: BodyMotion, drawn: complex) -> PointPath:
        """Path of a point of a body."""
        return cls(body.point(drawn), body.point_1(drawn), body.point_2(drawn))


@dataclass(frozen=True)
class Circle:
    """Circular locus about a point of a known body."""

    body: int
    centre: complex
    radius: float

    def gradient(self, bodies: Known, place: ComplexArray) -> ComplexArray:
        """Unit normal at a place."""
        return (place - bodies[self.body].point(self.centre)) / self.radius

    def gap(self, bodies: Known, place: ComplexArray) -> FloatArray:
        """Distance of a place from the circle, along the normal."""
        arm = place - bodies[self.body].point(self.centre)
        return np.asarray((np.abs(arm) ** 2 - self.radius**2) / (2 * self.radius))

    def speed(self, bodies: Known, place: ComplexArray) -> FloatArray:
        """First derivative along the normal of a point on the circle."""
        return dot(self.gradient(bodies, place), bodies[self.body].point_1(self.centre))

    def acceleration(self, bodies: Known, place: ComplexArray, first: ComplexArray) -> FloatArray:
        """Second derivative along the normal of a point on the locus.

        Parameters
        ----------
        bodies : mapping of int to BodyMotion
            Those known so far.
        place, first : ndarray of complex, shape (B,)
            Of the point, and its first derivative.
        """
        body = bodies[self.body]
        relative = np.abs(first - body.point_1(self.centre)) ** 2 / self.radius
        return dot(self.gradient(bodies, place), body.point_2(self.centre)) - relative


@dataclass(frozen=True)
class Line:
    """Straight locus on a known body, by a point and its direction in the drawing."""

    body: int
    through: complex
    along: complex

    def gradient(self, bodies: Known, place: ComplexArray) -> ComplexArray:
        """Unit normal at a place, to the left of the line."""
        return 1j * bodies[self.body].turn * self.along

    def gap(self, bodies: Known, place: ComplexArray) -> FloatArray:
        """Distance of a place from the line, along the normal."""
        body = bodies[self.body]
        return dot(1j * body.turn * self.along, place - body.point(self.through))

    def speed(self, bodies: Known, place: ComplexArray) -> FloatArray:
        """First derivative along the normal of a point on the line."""
        return bodies[self.body].line_rates(self.through, self.along, place)[0]

    def acceleration(self, bodies: Known, place: ComplexArray, first: ComplexArray) -> FloatArray:
        """Second derivative along the normal of a point on the locus.

        Parameters
        ----------
        bodies : mapping of int to BodyMotion
            Those known so far.
        place, first : ndarray of complex, shape (B,)
            Of the point, and its first derivative.
        """
        return bodies[self.body].line_rates(self.through, self.along, place, first)[1]


@dataclass(frozen=True)
class Placed:
    """A body determined by the intersection point of two loci.

    Parameters
    ----------
    body : int
    point : complex
        The point, in the drawing.
    known : int
        Body that carries the other point or, where the body does not turn against it, the
        body that carries its line.
    pivot : complex, optional
        Point of the known body about which the body turns; None where it only slides.
    """

    body: int
    point: complex
    known: int
    pivot: complex | None

    def motion(self, bodies: Known, path: PointPath) -> BodyMotion:
        """Motion of the body.

        Parameters
        ----------
        bodies : sequence of BodyMotion
            Those known so far.
        path : PointPath
            Of its point.
        """
        known = bodies[self.known]
        if self.pivot is None:
            return BodyMotion(
                self.point,
                path.place,
                known.turn,
                path.first,
                path.second,
                known.turn_1,
                known.turn_2,
            )
        drawn = self.point - self.pivot
        centre = PointPath.of(known, self.pivot)
        arm = path.place - centre.place
        square = abs(drawn) ** 2
        return BodyMotion(
            self.pivot,
            centre.place,
            arm / drawn / (np.abs(arm) / abs(drawn)),
            centre.first,
            centre.second,
            cross(arm, path.first - centre.first) / square,
            cross(arm, path.second - centre.second) / square,
        )


@dataclass(frozen=True)
class TwoLoci:
    """Intersection point of two loci, and the bodies that it determines.

    Parameters
    ----------
    refusal : Refusal
    drawn : complex
    first, second : Circle or Line
        Not a line before a circle.
    side : float
        Sign of the product of the normals at the point, which tells its branch.
    placed : tuple of Placed
    size : float
        Of the linkage.
    """

    refusal: Refusal
    drawn: complex
    first: Circle | Line
    second: Circle | Line
    side: float
    placed: tuple[Placed, ...]
    size: float

    @property
    def solves(self) -> tuple[int, ...]:
        """Bodies that the dyad determines."""
        return tuple(own.body for own in self.placed)

    def motion(self, bodies: Known, angle: FloatArray, sides: FloatArray) -> dict[int, BodyMotion]:
        """Motion of the bodies that the dyad determines.

        Parameters
        ----------
        bodies : mapping of int to BodyMotion
            Those known so far.
        angle : ndarray, shape (B,)
            Crank angle less that of the drawing in rad.
        sides : ndarray, shape (B,)
            1 where the point is on the side of the drawing, -1 where it is on the other one.
        """
        path = self._path(bodies, angle, self.side * sides)
        return {own.body: own.motion(bodies, path) for own in self.placed}

    def transmission_angle(self, bodies: Known) -> FloatArray | None:
        """Acute angle in rad at which the loci meet, (B,); None of two lines, which are drawn."""
        if not isinstance(self.first, Circle):
            return None
        place = bodies[self.placed[0].body].point(self.drawn)
        normals = (locus.gradient(bodies, place) for locus in (self.first, self.second))
        return np.asarray(np.arcsin(np.minimum(np.abs(cross(*normals)), 1.0)))

    def clearances(self, bodies: Known) -> list[Clearance]:
        """How far the loci are from touching; none of two lines, which meet in one point."""
        first, second = self.first, self.second
        if not isinstance(first, Circle):
            return []
        centre = bodies[first.body].point(first.centre)
        if isinstance(second, Circle):
            between = np.abs(bodies[second.body].point(second.centre) - centre)
            outside, inside = first.radius + second.radius, abs(first.radius - second.radius)
            return [
                Clearance.of(outside, between, outside, self.size),
                Clearance.of(between, inside, inside, self.size),
            ]
        guide = bodies[second.body]
        aside = np.abs(cross(guide.turn * second.along, centre - guide.point(second.through)))
        return [Clearance.of(first.radius, aside, first.radius, self.size)]

    def _path(self, bodies: Known, angle: FloatArray, side: FloatArray) -> PointPath:
        first, second = self.first, self.second
        place = self._place(bodies, angle, side)
        normals = first.gradient(bodies, place), second.gradient(bodies, place)
        sine = cross(*normals)
        self.refusal.refuse("locked", np.abs(sine) < LOCKING_SINE, angle)
        # One step of Newton's method takes off what rounding has left near locked positions.
        place = place - _vector(*normals, sine, first.gap(bodies, place), second.gap(bodies, place))
        normals = first.gradient(bodies, place), second.gradient(bodies, place)
        sine = cross(*normals)
        rate = _vector(*normals, sine, first.speed(bodies, place), second.speed(bodies, place))
        rate_2 = _vector(
            *normals,
            sine,
            first.acceleration(bodies, place, rate),
            second.acceleration(bodies, place, rate),
        )
        return PointPath(place, rate, rate_2)

    def _place(self, bodies: Known, angle: FloatArray, side: FloatArray) -> ComplexArray:
        if isinstance(self.first, Circle):
            centre = bodies[self.first.body].point(self.first.centre)
            if isinstance(self.second, Circle):
                return self._on_circles(bodies, angle, side, centre)
            return self._on_circle_and_line(bodies, angle, side, centre)
        # Two lines: the gaps of any place lead to where they meet.
        start = bodies[self.first.body].point(self.first.through)
        normals = (self.first.gradient(bodies, start), self.second.gradient(bodies, start))
        sine = cross(*normals)
        self.refusal.refuse("locked", np.abs(sine) < LOCKING_SINE, angle)
        return start - _vector(
            *normals, sine, self.first.gap(bodies, start), self.second.gap(bodies, start)
        )

    def _on_circles(
        self, bodies: Known, angle: FloatArray, side: FloatArray, centre: ComplexArray
    ) -> ComplexArray:
        assert isinstance(self.first, Circle)
        assert isinstance(self.second, Circle)
        line = bodies[self.second.body].point(self.second.centre) - centre
        distance = np.abs(line)
        self.refusal.refuse("apart", distance <= ROUND_OFF * self.size, angle)
        ahead = (self.first.radius**2 - self.second.radius**2 + distance**2) / (2 * distance)
        aside = self._leg(self.first.radius, ahead, angle)
        return np.asarray(centre + (ahead + 1j * side * aside) * line / distance)

    def _on_circle_and_line(
        self, bodies: Known, angle: FloatArray, side: FloatArray, centre: ComplexArray
    ) -> ComplexArray:
        assert isinstance(self.first, Circle)
        assert isinstance(self.second, Line)
        guide = bodies[self.second.body]
        along, through = guide.turn * self.second.along, guide.point(self.second.through)
        to_centre = centre - through
        leg = self._leg(self.first.radius, np.abs(cross(along, to_centre)), angle)
        return through + (dot(along, to_centre) + side * leg) * along

    def _leg(self, radius: float, other: FloatArray, angle: FloatArray) -> FloatArray:
        """Other leg of right triangles whose longest side is a radius."""
        square = (radius - other) * (radius + other)
        # Rounding may part loci that touch.
        self.refusal.refuse("apart", square < -ROUND_OFF * self.size * radius, angle)
        return np.sqrt(np.maximum(square, 0.0))


@dataclass(frozen=True)
class SlidingBody:
    """A body pinned at one known point with another on a line of it (RPR).

    Parameters
    ----------
    refusal : Refusal
    body : int
    pivot_body, slider_body : int
        Known bodies that carry the two points.
    pivot, slider : complex
        The points in the drawing.
    along : complex
        Unit vector of the line in the drawing.
    size : float
    """

    refusal: Refusal
    body: int
    pivot_body: int
    slider_body: int
    pivot: complex
    slider: complex
    along: complex
    size: float

    @property
    def solves(self) -> tuple[int, ...]:
        """The body."""
        return (self.body,)

    def transmission_angle(self, bodies: Known) -> FloatArray:
        """Acute angle in rad from the normal of the arm to the line, (B,)."""
        pivot = bodies[self.pivot_body].point(self.pivot)
        arm = bodies[self.slider_body].point(self.slider) - pivot
        along = bodies[self.body].turn * self.along
        return np.asarray(np.arccos(np.minimum(np.abs(cross(along, arm)) / np.abs(arm), 1.0)))

    def clearances(self, bodies: Known) -> list[Clearance]:
        """How far the line, on a circle about the pivot, is from touching the slider's point."""
        pivot = bodies[self.pivot_body].point(self.pivot)
        distance = np.abs(bodies[self.slider_body].point(self.slider) - pivot)
        beside = abs(float(cross(self.along, self.slider - self.pivot)))
        return [Clearance.of(distance, beside, beside, self.size)]

    def motion(self, bodies: Known, angle: FloatArray, sides: FloatArray) -> dict[int, BodyMotion]:
        """Motion of the body.

        Parameters
        ----------
        bodies : mapping of int to BodyMotion
            Those known so far.
        angle : ndarray, shape (B,)
            Crank angle less that of the drawing in rad.
        sides : ndarray, shape (B,)
            1 where the slider is on the side of the drawing, -1 where it is on the other one.
        """
        centre = PointPath.of(bodies[self.pivot_body], self.pivot)
        point = PointPath.of(bodies[self.slider_body], self.slider)
        drawn = self.slider - self.pivot
        beside = float(cross(self.along, drawn))
        side = np.sign(float(dot(self.along, drawn))) * sides
        arm, first, second = (
            getattr(point, name) - getattr(centre, name) for name in ("place", "first", "second")
        )
        distance = np.abs(arm)
        square = (distance - abs(beside)) * (distance + abs(beside))
        self.refusal.refuse("apart", square < -ROUND_OFF * self.size**2, angle)
        ahead = side * np.sqrt(np.maximum(square, 0.0))
        self.refusal.refuse("locked", np.abs(ahead) < LOCKING_SINE * distance, angle)
        # The line's direction now: arm = (ahead + i beside) times it.
        along = arm / (ahead + 1j * beside)
        along = along / np.abs(along)
        turn_1 = dot(1j * along, first) / ahead
        sliding = dot(along, first) + beside * turn_1
        turn_2 = (dot(1j * along, second) - 2 * sliding * turn_1 + beside * turn_1**2) / ahead
        return {
            self.body: BodyMotion(
                self.pivot,
                centre.place,
                along / self.along,
                centre.first,
                centre.second,
                turn_1,
                turn_2,
            )
        }


def _vector(
    first: ComplexArray, second: ComplexArray, sine: FloatArray, one: FloatArray, two: FloatArray
) -> ComplexArray:
    """Vector with given components along two unit normals."""
    return np.asarray((-1j * second * one + 1j * first * two) / sine)
