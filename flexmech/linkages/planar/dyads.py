"""Motion of one or two bodies in closed form, over a batch of crank angles.

A point that stays at a distance from a known point is on a circle, one that slides is on a
line. Two of these loci give the point (RRR: two circles, RRP and PRR: circle and line, PRP:
two lines); the bodies follow from it. A body that turns about one known point while another
slides along it (RPR) follows from the two. Norton, Design of Machinery, ch. 4. Derivatives are by
the crank angle: each locus carries the point, which moves along its tangent besides.
"""

from __future__ import annotations

import abc
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from flexmech.arrays import ROUND_OFF, ComplexArray, FloatArray
from flexmech.linkages.body_motion import BodyMotion, MovingPoint, cross, dot
from flexmech.linkages.change_points import Clearance
from flexmech.linkages.motion import LOCKING_SINE
from flexmech.linkages.planar.bodies import Refusal

# Sine between loci below which rounding has left a place that is worse than some ten round-offs.
NEARLY_LOCKED = 0.1


class Contact(NamedTuple):
    """A point on a locus.

    Parameters
    ----------
    bodies : BodyMotion
        All bodies of the linkage, (B, n).
    base : MovingPoint
        Centre of a circle, or the point through which a line passes.
    place, normal : ndarray of complex, shape (B,)
        Where the point is, and the unit normal there, of a line to its left.
    """

    bodies: BodyMotion
    base: MovingPoint
    place: ComplexArray
    normal: ComplexArray


class Locus(abc.ABC):
    """Curve on a known body on which a point of another one stays.

    Attributes
    ----------
    known : int
    centre : complex
        Centre of a circle, or a point of a line, in the known body's axes.
    body : int, optional
        That of the point, if the point's way along the curve determines its motion.
    """

    known: int
    centre: complex
    body: int | None

    def base(self, bodies: BodyMotion) -> MovingPoint:
        """Motion of the centre, or of the point of the line."""
        return bodies.moving_point(self.known, self.centre)

    @property
    @abc.abstractmethod
    def drawn_normal(self) -> complex:
        """Normal at the point in the drawing."""

    @abc.abstractmethod
    def at(self, bodies: BodyMotion, base: MovingPoint, place: ComplexArray) -> Contact:
        """Contact at places on the locus or beside it.

        Parameters
        ----------
        bodies : BodyMotion
        base : MovingPoint
            Base of :meth:`base`.
        place : ndarray of complex, shape (B,)
        """

    @abc.abstractmethod
    def gap(self, contact: Contact) -> FloatArray:
        """Distance (B,) of the place from the curve along the normal."""

    @abc.abstractmethod
    def carried(self, contact: Contact) -> ComplexArray:
        """First derivative (B,) of the point where it does not move along the curve."""

    @abc.abstractmethod
    def turned(self, contact: Contact, along: FloatArray) -> ComplexArray:
        """Second derivative (B,) of the point where it moves at a rate (B,) along the curve.

        Rates are along the tangent that is a quarter turn ahead of the normal.
        """

    @abc.abstractmethod
    def move(self, contact: Contact, rate: FloatArray, change: FloatArray) -> None:
        """Give the body its motion by that of its point.

        Parameters
        ----------
        contact : Contact
        rate, change : ndarray, shape (B,)
            First and second derivative of the point's way along the curve.
        """


@dataclass(frozen=True)
class Circle(Locus):
    """Circular locus of a point of a body that turns about a point of a known one.

    Parameters
    ----------
    known : int
    centre : complex
        In the known body's axes.
    body : int
    pivot : complex
        The centre in the axes of the body.
    arm : complex
        From there to the point, in the axes of the body.
    """

    known: int
    centre: complex
    body: int
    pivot: complex
    arm: complex

    @property
    def radius(self) -> float:
        """Distance of the point from the centre in m."""
        return abs(self.arm)

    @property
    def drawn_normal(self) -> complex:
        """Normal at the point in the drawing."""
        return self.arm

    def at(self, bodies: BodyMotion, base: MovingPoint, place: ComplexArray) -> Contact:
        """Contact at places (B,)."""
        return Contact(bodies, base, place, (place - base.place) * (1 / self.radius))

    def gap(self, contact: Contact) -> FloatArray:
        """Distance (B,) of the place from the circle."""
        return np.asarray((dot(contact.normal, contact.normal) - 1) * (self.radius / 2))

    def carried(self, contact: Contact) -> ComplexArray:
        """First derivative (B,) of the centre."""
        return contact.base.rate

    def turned(self, contact: Contact, along: FloatArray) -> ComplexArray:
        """Second derivative (B,) of the centre, and what turns the rate along the circle."""
        return np.asarray(contact.base.change - along**2 / self.radius * contact.normal)

    def move(self, contact: Contact, rate: FloatArray, change: FloatArray) -> None:
        """Turn the body about the centre."""
        turn = contact.normal * (self.radius / self.arm)
        spin, swing = rate / self.radius, change / self.radius
        contact.bodies.move(self.body, self.pivot, contact.base, turn, spin, swing)


@dataclass(frozen=True)
class Line(Locus):
    """Straight locus of a point on a known body.

    Parameters
    ----------
    known : int
    centre : complex
        The line passes through it in the drawing.
    along : complex
        Unit vector of the line in the drawing.
    body : int, optional
        Body of the point, if it translates along the line.
    """

    known: int
    centre: complex
    along: complex
    body: int | None = None

    @property
    def drawn_normal(self) -> complex:
        """Normal in the drawing, to the left of the line."""
        return 1j * self.along

    def at(self, bodies: BodyMotion, base: MovingPoint, place: ComplexArray) -> Contact:
        """Contact at places (B,)."""
        return Contact(bodies, base, place, bodies.turn[:, self.known] * self.drawn_normal)

    def gap(self, contact: Contact) -> FloatArray:
        """Distance (B,) of the place from the line, to its left."""
        return dot(contact.normal, contact.place - contact.base.place)

    def carried(self, contact: Contact) -> ComplexArray:
        """First derivative (B,) of the known body's point at the place."""
        spin, arm = contact.bodies.turn_1[:, self.known], contact.place - contact.base.place
        return np.asarray(contact.base.rate + 1j * spin * arm)

    def turned(self, contact: Contact, along: FloatArray) -> ComplexArray:
        """Second derivative (B,) of the known body's point, and Coriolis acceleration."""
        bodies, arm = contact.bodies, contact.place - contact.base.place
        spin, swing = bodies.turn_1[:, self.known], bodies.turn_2[:, self.known]
        change = contact.base.change + (1j * swing - spin**2) * arm
        return np.asarray(change - 2 * spin * along * contact.normal)

    def move(self, contact: Contact, rate: FloatArray, change: FloatArray) -> None:
        """Move the body with its point; it turns as the known one does."""
        assert self.body is not None
        bodies, known, tangent = contact.bodies, self.known, 1j * contact.normal
        point = MovingPoint(
            contact.place,
            self.carried(contact) + rate * tangent,
            self.turned(contact, rate) + change * tangent,
        )
        turning = bodies.turn[:, known], bodies.turn_1[:, known], bodies.turn_2[:, known]
        bodies.move(self.body, self.centre, point, *turning)


@dataclass(frozen=True)
class TwoLoci:
    """Intersection point of two loci, and the bodies that it determines.

    Parameters
    ----------
    refusal : Refusal
    first, second : Circle or Line
        Not a line before a circle.
    size : float
        Size of the linkage.
    side : float
        Sign of the product of the normals, which tells the branch.
    """

    refusal: Refusal
    first: Circle | Line
    second: Circle | Line
    size: float
    side: float

    @property
    def unknown(self) -> tuple[int, ...]:
        """Bodies that the dyad determines."""
        loci = self.first, self.second
        return tuple(locus.body for locus in loci if locus.body is not None)

    def move(self, bodies: BodyMotion, angle: FloatArray, sides: FloatArray) -> None:
        """Give the bodies that the dyad determines their motion.

        Parameters
        ----------
        bodies : BodyMotion
            All bodies of the linkage, (B, n), those that are known before in their motion.
        angle : ndarray, shape (B,)
            Crank angle less that of the drawing in rad.
        sides : ndarray, shape (B,)
            1 where the point is on the side of the drawing, -1 where it is on the other one.

        Raises
        ------
        InputError
            Where the bodies do not meet, or lock.
        """
        first, second = self.first, self.second
        base, other = first.base(bodies), second.base(bodies)
        place = self._place(bodies, base, other, angle, self.side * sides)
        one, two = first.at(bodies, base, place), second.at(bodies, other, place)
        sine = cross(one.normal, two.normal)
        if (size := np.abs(sine)).min(initial=1.0) < NEARLY_LOCKED:
            self.refusal.refuse("locked", size < LOCKING_SINE, angle)
            # One step of Newton's method takes off what rounding has left there.
            place = place - _vector(one, two, sine, first.gap(one), second.gap(two))
            one, two = first.at(bodies, base, place), second.at(bodies, other, place)
            sine = cross(one.normal, two.normal)
        by_sine = 1 / sine
        apart = (second.carried(two) - first.carried(one)) * by_sine
        rate, rate_2 = dot(two.normal, apart), dot(one.normal, apart)
        apart = (second.turned(two, rate_2) - first.turned(one, rate)) * by_sine
        if first.body is not None:
            first.move(one, rate, dot(two.normal, apart))
        if second.body is not None:
            second.move(two, rate_2, dot(one.normal, apart))

    def transmission_angle(self, bodies: BodyMotion) -> FloatArray | None:
        """Acute angle in rad at which the loci meet, (B,); None of two lines, which are drawn."""
        first, second = self.first, self.second
        if not isinstance(first, Circle):
            return None
        base = first.base(bodies)
        place = base.place + bodies.turn[:, first.body] * first.arm
        one = first.at(bodies, base, place).normal
        two = second.at(bodies, second.base(bodies), place).normal
        return np.arctan2(np.abs(cross(one, two)), np.abs(dot(one, two)))

    def clearances(self, bodies: BodyMotion) -> list[Clearance]:
        """How far the loci are from touching; none of two lines, which meet in one point."""
        first, second = self.first, self.second
        if not isinstance(first, Circle):
            return []
        centre, base = first.base(bodies).place, second.base(bodies)
        if isinstance(second, Circle):
            between = np.abs(base.place - centre)
            outside, inside = first.radius + second.radius, abs(first.radius - second.radius)
            return [
                Clearance.of(outside, between, outside, self.size),
                Clearance.of(between, inside, inside, self.size),
            ]
        aside = np.abs(second.gap(second.at(bodies, base, centre)))
        return [Clearance.of(first.radius, aside, first.radius, self.size)]

    def _place(
        self,
        bodies: BodyMotion,
        base: MovingPoint,
        other: MovingPoint,
        angle: FloatArray,
        side: FloatArray,
    ) -> ComplexArray:
        """Where the loci meet on a side."""
        first, second, start, through = self.first, self.second, base.place, other.place
        if not isinstance(first, Circle):
            # Two lines: the gaps of any place lead to where they meet.
            one, two = first.at(bodies, base, start), second.at(bodies, other, start)
            sine = cross(one.normal, two.normal)
            self.refusal.refuse("locked", np.abs(sine) < LOCKING_SINE, angle)
            return start - _vector(one, two, sine, np.zeros_like(sine), second.gap(two))
        if isinstance(second, Circle):
            between = through - start
            distance = np.abs(between)
            self.refusal.refuse("apart", distance <= ROUND_OFF * self.size, angle)
            ahead = (first.radius**2 - second.radius**2) / 2 / distance + distance / 2
            aside = self._leg(first.radius, ahead, angle)
            return np.asarray(start + (ahead + 1j * (side * aside)) * (1 / distance) * between)
        along = bodies.turn[:, second.known] * second.along
        to_centre = start - through
        leg = self._leg(first.radius, np.abs(cross(along, to_centre)), angle)
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
    def unknown(self) -> tuple[int, ...]:
        """The body."""
        return (self.body,)

    @property
    def beside(self) -> float:
        """Distance of the slider's point from the pivot across the line, to its left."""
        return float(cross(self.along, self.slider - self.pivot))

    def transmission_angle(self, bodies: BodyMotion) -> FloatArray:
        """Acute angle in rad from the normal of the arm to the line, (B,)."""
        arm = self._arm(bodies)[1].place
        along = bodies.turn[:, self.body] * self.along
        return np.arctan2(np.abs(dot(along, arm)), np.abs(cross(along, arm)))

    def clearances(self, bodies: BodyMotion) -> list[Clearance]:
        """How far the line, on a circle about the pivot, is from touching the slider's point."""
        distance, beside = np.abs(self._arm(bodies)[1].place), abs(self.beside)
        return [Clearance.of(distance, beside, beside, self.size)]

    def move(self, bodies: BodyMotion, angle: FloatArray, sides: FloatArray) -> None:
        """Give the body its motion.

        Parameters
        ----------
        bodies, angle
            As in :meth:`TwoLoci.move`.
        sides : ndarray, shape (B,)
            1 where the slider is on the side of the drawing, -1 where it is on the other one.

        Raises
        ------
        InputError
            Where the line does not reach the point, or locks.
        """
        pivot, arm = self._arm(bodies)
        beside, distance = self.beside, np.abs(arm.place)
        square = (distance - abs(beside)) * (distance + abs(beside))
        self.refusal.refuse("apart", square < -ROUND_OFF * self.size**2, angle)
        side = np.sign(float(dot(self.along, self.slider - self.pivot))) * sides
        ahead = side * np.sqrt(np.maximum(square, 0.0))
        self.refusal.refuse("locked", np.abs(ahead) < LOCKING_SINE * distance, angle)
        # The line's direction now: arm = (ahead + i beside) times it.
        along = arm.place / (ahead + 1j * beside)
        along = along / np.abs(along)
        # Derivatives of cross(along, arm) = beside.
        spin = cross(along, arm.rate) / ahead
        turning = 2 * spin * dot(along, arm.rate) + spin**2 * beside
        swing = (cross(along, arm.change) - turning) / ahead
        bodies.move(self.body, self.pivot, pivot, along / self.along, spin, swing)

    def _arm(self, bodies: BodyMotion) -> tuple[MovingPoint, MovingPoint]:
        """Motion of the pivot, and of the arm from it to the slider's point."""
        pivot = bodies.moving_point(self.pivot_body, self.pivot)
        slider = bodies.moving_point(self.slider_body, self.slider)
        return pivot, MovingPoint(*(s - p for s, p in zip(slider, pivot, strict=True)))


Dyad = TwoLoci | SlidingBody


def _vector(
    one: Contact, two: Contact, sine: FloatArray, along: FloatArray, along_2: FloatArray
) -> ComplexArray:
    """Vector with given components along two normals, between which the sine is."""
    return np.asarray((one.normal * along_2 - two.normal * along) * (1j / sine))
