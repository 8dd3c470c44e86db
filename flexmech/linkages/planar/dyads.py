"""Positions of one or two bodies in closed form, over a batch of crank angles.

A point that stays at a distance from a known point is on a circle, one that slides is on a
line. Two of these loci give the point (RRR: two circles, RRP and PRR: circle and line, PRP:
two lines); the bodies follow from it. A body that turns about one known point while another
slides along it (RPR) follows from the two. Norton, Design of Machinery, ch. 4.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.arrays import ROUND_OFF, ComplexArray, FloatArray
from flexmech.linkages.body_motion import BodyMotion, dot
from flexmech.linkages.change_points import Clearance
from flexmech.linkages.motion import LOCKING_SINE
from flexmech.linkages.planar.bodies import (
    Bodies,
    BodyGroup,
    GuidedPoint,
    Refusal,
    SharedPoint,
)
from flexmech.linkages.planar.drawing import Drawing

Placement = tuple[complex, ComplexArray, ComplexArray]
"""A point of a body in the drawing, where it is, (B,), and how the body is turned, (B,)."""


def point_of(bodies: BodyMotion, body: int, drawn: complex) -> ComplexArray:
    """Positions (B,) of a point of a body.

    Parameters
    ----------
    bodies : BodyMotion
        All bodies of the drawing, (B, n).
    body : int
    drawn : complex
        The point in the drawing.
    """
    arm = drawn - np.asarray(bodies.drawn)[body]
    return np.asarray(bodies.place[:, body] + bodies.turn[:, body] * arm)


def cross(first: ComplexArray | complex, second: ComplexArray | complex) -> FloatArray:
    """Product of two vectors, positive where the second is to the left of the first."""
    return np.imag(np.conj(first) * second)


@dataclass(frozen=True)
class Circle:
    """Circular locus of a point of a body that turns about a point of a known one.

    Parameters
    ----------
    known : int
    centre : complex
        In the drawing.
    body : int
    point : complex
        In the drawing.
    """

    known: int
    centre: complex
    body: int
    point: complex

    @property
    def radius(self) -> float:
        """Distance of the point from the centre in m."""
        return abs(self.point - self.centre)

    @property
    def drawn_normal(self) -> complex:
        """Normal at the point in the drawing."""
        return self.point - self.centre

    def gradient(self, bodies: BodyMotion, place: ComplexArray) -> ComplexArray:
        """Unit normal at a place."""
        return (place - point_of(bodies, self.known, self.centre)) / self.radius

    def gap(self, bodies: BodyMotion, place: ComplexArray) -> FloatArray:
        """Distance of a place from the circle, along the normal."""
        arm = place - point_of(bodies, self.known, self.centre)
        return np.asarray((np.abs(arm) ** 2 - self.radius**2) / (2 * self.radius))

    def placement(self, bodies: BodyMotion, place: ComplexArray) -> Placement:
        """Where the body is, by the place of its point, (B,)."""
        centre = point_of(bodies, self.known, self.centre)
        turn = (place - centre) / self.drawn_normal
        return self.centre, centre, turn / np.abs(turn)


@dataclass(frozen=True)
class Line:
    """Straight locus of a point on a known body.

    Parameters
    ----------
    known : int
    point : complex
        The line passes through it in the drawing.
    along : complex
        Unit vector of the line in the drawing.
    body : int, optional
        Body of the point, if it translates along the line.
    """

    known: int
    point: complex
    along: complex
    body: int | None = None

    @property
    def drawn_normal(self) -> complex:
        """Normal in the drawing, to the left of the line."""
        return 1j * self.along

    def gradient(self, bodies: BodyMotion, place: ComplexArray) -> ComplexArray:
        """Unit normal at a place, to the left of the line."""
        return np.asarray(bodies.turn[:, self.known] * self.drawn_normal)

    def gap(self, bodies: BodyMotion, place: ComplexArray) -> FloatArray:
        """Distance of a place from the line, along the normal."""
        return dot(self.gradient(bodies, place), place - point_of(bodies, self.known, self.point))

    def placement(self, bodies: BodyMotion, place: ComplexArray) -> Placement:
        """Where the body is, by the place of its point, (B,)."""
        return self.point, place, bodies.turn[:, self.known]


@dataclass(frozen=True)
class TwoLoci:
    """Intersection point of two loci, and the bodies that it determines.

    Parameters
    ----------
    refusal : Refusal
    first, second : Circle or Line
        Not a line before a circle.
    size : float
        Of the linkage.
    """

    refusal: Refusal
    first: Circle | Line
    second: Circle | Line
    size: float

    @property
    def solves(self) -> tuple[int, ...]:
        """Bodies that the dyad determines."""
        loci = self.first, self.second
        return tuple(own.body for own in loci if own.body is not None)

    @property
    def side(self) -> float:
        """Sign of the product of the normals in the drawing, which tells the branch."""
        return float(np.sign(cross(self.first.drawn_normal, self.second.drawn_normal)))

    def placements(
        self, bodies: BodyMotion, angle: FloatArray, sides: FloatArray
    ) -> list[Placement]:
        """Where the bodies are that the dyad determines.

        Parameters
        ----------
        bodies : BodyMotion
            All bodies of the drawing, those known so far in their positions; (B, n).
        angle : ndarray, shape (B,)
            Crank angle less that of the drawing in rad.
        sides : ndarray, shape (B,)
            1 where the point is on the side of the drawing, -1 where it is on the other one.
        """
        first, second = self.first, self.second
        place = self._place(bodies, angle, self.side * sides)
        normals = first.gradient(bodies, place), second.gradient(bodies, place)
        sine = cross(*normals)
        self.refusal.refuse("locked", np.abs(sine) < LOCKING_SINE, angle)
        # One step of Newton's method takes off what rounding has left near locked positions.
        place = place - _vector(*normals, sine, first.gap(bodies, place), second.gap(bodies, place))
        return [own.placement(bodies, place) for own in (first, second) if own.body is not None]

    def transmission_angle(self, bodies: BodyMotion) -> FloatArray | None:
        """Acute angle in rad at which the loci meet, (B,); None of two lines, which are drawn."""
        if not isinstance(self.first, Circle):
            return None
        place = point_of(bodies, self.first.body, self.first.point)
        normals = [locus.gradient(bodies, place) for locus in (self.first, self.second)]
        return np.arctan2(np.abs(cross(*normals)), np.abs(dot(*normals)))

    def clearances(self, bodies: BodyMotion) -> list[Clearance]:
        """How far the loci are from touching; none of two lines, which meet in one point."""
        first, second = self.first, self.second
        if not isinstance(first, Circle):
            return []
        centre = point_of(bodies, first.known, first.centre)
        if isinstance(second, Circle):
            between = np.abs(point_of(bodies, second.known, second.centre) - centre)
            outside, inside = first.radius + second.radius, abs(first.radius - second.radius)
            return [
                Clearance.of(outside, between, outside, self.size),
                Clearance.of(between, inside, inside, self.size),
            ]
        aside = np.abs(second.gap(bodies, centre))
        return [Clearance.of(first.radius, aside, first.radius, self.size)]

    def _place(self, bodies: BodyMotion, angle: FloatArray, side: FloatArray) -> ComplexArray:
        if isinstance(self.first, Circle):
            centre = point_of(bodies, self.first.known, self.first.centre)
            if isinstance(self.second, Circle):
                return self._on_circles(bodies, angle, side, centre)
            return self._on_circle_and_line(bodies, angle, side, centre)
        # Two lines: the gaps of any place lead to where they meet.
        start = point_of(bodies, self.first.known, self.first.point)
        normals = (self.first.gradient(bodies, start), self.second.gradient(bodies, start))
        sine = cross(*normals)
        self.refusal.refuse("locked", np.abs(sine) < LOCKING_SINE, angle)
        return start - _vector(
            *normals, sine, self.first.gap(bodies, start), self.second.gap(bodies, start)
        )

    def _on_circles(
        self, bodies: BodyMotion, angle: FloatArray, side: FloatArray, centre: ComplexArray
    ) -> ComplexArray:
        assert isinstance(self.first, Circle)
        assert isinstance(self.second, Circle)
        line = point_of(bodies, self.second.known, self.second.centre) - centre
        distance = np.abs(line)
        self.refusal.refuse("apart", distance <= ROUND_OFF * self.size, angle)
        ahead = (self.first.radius**2 - self.second.radius**2 + distance**2) / (2 * distance)
        aside = self._leg(self.first.radius, ahead, angle)
        return np.asarray(centre + (ahead + 1j * side * aside) * line / distance)

    def _on_circle_and_line(
        self, bodies: BodyMotion, angle: FloatArray, side: FloatArray, centre: ComplexArray
    ) -> ComplexArray:
        assert isinstance(self.first, Circle)
        assert isinstance(self.second, Line)
        along = bodies.turn[:, self.second.known] * self.second.along
        through = point_of(bodies, self.second.known, self.second.point)
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

    def transmission_angle(self, bodies: BodyMotion) -> FloatArray:
        """Acute angle in rad from the normal of the arm to the line, (B,)."""
        pivot = point_of(bodies, self.pivot_body, self.pivot)
        arm = point_of(bodies, self.slider_body, self.slider) - pivot
        along = bodies.turn[:, self.body] * self.along
        return np.arctan2(np.abs(dot(along, arm)), np.abs(cross(along, arm)))

    def clearances(self, bodies: BodyMotion) -> list[Clearance]:
        """How far the line, on a circle about the pivot, is from touching the slider's point."""
        pivot = point_of(bodies, self.pivot_body, self.pivot)
        distance = np.abs(point_of(bodies, self.slider_body, self.slider) - pivot)
        beside = abs(float(cross(self.along, self.slider - self.pivot)))
        return [Clearance.of(distance, beside, beside, self.size)]

    def placements(
        self, bodies: BodyMotion, angle: FloatArray, sides: FloatArray
    ) -> list[Placement]:
        """Where the body is.

        Parameters
        ----------
        bodies : BodyMotion
            All bodies of the drawing, those known so far in their positions; (B, n).
        angle : ndarray, shape (B,)
            Crank angle less that of the drawing in rad.
        sides : ndarray, shape (B,)
            1 where the slider is on the side of the drawing, -1 where it is on the other one.
        """
        centre = point_of(bodies, self.pivot_body, self.pivot)
        arm = point_of(bodies, self.slider_body, self.slider) - centre
        drawn = self.slider - self.pivot
        beside = float(cross(self.along, drawn))
        distance = np.abs(arm)
        square = (distance - abs(beside)) * (distance + abs(beside))
        self.refusal.refuse("apart", square < -ROUND_OFF * self.size**2, angle)
        side = np.sign(float(dot(self.along, drawn))) * sides
        ahead = side * np.sqrt(np.maximum(square, 0.0))
        self.refusal.refuse("locked", np.abs(ahead) < LOCKING_SINE * distance, angle)
        # The line's direction now: arm = (ahead + i beside) times it.
        turn = arm / (ahead + 1j * beside) / self.along
        return [(self.pivot, centre, turn / np.abs(turn))]


class Dyad(BodyGroup):
    """One or two bodies with a closed form.

    Parameters
    ----------
    drawing, bodies, joints
        As of :class:`BodyGroup`.
    form : TwoLoci or SlidingBody
    """

    def __init__(
        self,
        drawing: Drawing,
        bodies: Bodies,
        joints: tuple[SharedPoint | GuidedPoint, ...],
        form: TwoLoci | SlidingBody,
    ) -> None:
        super().__init__(drawing, bodies, joints, form.solves)
        self.form = form

    def fill_positions(self, bodies: BodyMotion, angle: FloatArray, sides: FloatArray) -> None:
        """Put the bodies where the closed form has them.

        Parameters
        ----------
        bodies : BodyMotion
            All bodies of the drawing at the crank angles, (B, n); those of the dyad are changed.
        angle : ndarray, shape (B,)
            Crank angle less that of the drawing in rad.
        sides : ndarray, shape (B,)
            1 where the dyad is on the side of the drawing, -1 where it is on the other one.

        Raises
        ------
        InputError
            Where the bodies do not meet, or lock.
        """
        placements = self.form.placements(bodies, angle, sides)
        reference = np.asarray(bodies.drawn)[self.unknown]
        places = [
            place + turn * (own - drawn)
            for own, (drawn, place, turn) in zip(reference, placements, strict=True)
        ]
        turns = [turn for *_, turn in placements]
        self.fill(bodies, np.stack(places, axis=-1), np.stack(turns, axis=-1))


def _vector(
    first: ComplexArray, second: ComplexArray, sine: FloatArray, one: FloatArray, two: FloatArray
) -> ComplexArray:
    """Vector with given components along two unit normals."""
    return np.asarray((-1j * second * one + 1j * first * two) / sine)
