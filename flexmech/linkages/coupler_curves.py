r"""Coupler curve of a four-bar: positions, derivatives, curvature, equation, double points.

A double point E, a crunode or a cusp, is reached with the coupler in two attitudes. A and its
second place are then mirror images in the line O2-E, since both lie on the circles about O2 and
about E; so are B and its second place in O4-E. The coupler turns by the same angle about E
whichever pin is looked at, so that E sees O2-O4 under the angle epsilon from E-A to E-B, or epsilon
plus pi: the finite double points lie on the *circle of singular foci* through O2 and O4
(Hartenberg & Denavit 1964, ch. 6; Hunt, Kinematic Geometry of Mechanisms, 1978).

With d the ground, a, c crank and rocker, e = E-A, f = E-B, and signed distances rho2 from O2
along the direction eta and rho4 from O4 along eta + epsilon, the place is
E = rho2 (cos eta, sin eta), where

    rho2 = d sin(eta + epsilon) / sin(epsilon),    rho4 = d sin(eta) / sin(epsilon).

tan eta = w sin epsilon keeps both finite where epsilon = 0, E lies on the line A-B and the circle
becomes the ground's line:

    rho2 = d (1 + w cos epsilon) / q,    rho4 = d w / q,    q^2 = 1 + w^2 sin^2 epsilon.

E-A makes the angle +kappa with eta in one attitude and -kappa in the other, and E-B the same
with eta + epsilon. The circles of A and B ask for

    cos kappa = (a^2 - e^2 - rho2^2) / (2 e rho2) = (c^2 - f^2 - rho4^2) / (2 f rho4),

a cubic in w:

    ((a^2 - e^2) q^2 - d^2 (1 + w cos epsilon)^2) f w
        = ((c^2 - f^2) q^2 - d^2 w^2) e (1 + w cos epsilon).

Each real root with \|cos kappa\| < 1 is a crunode if the linkage passes from one attitude to the
other without being taken apart, and else a place where two curves cross. Where \|cos kappa\| = 1
the attitudes are one, E is the coupler's instant centre, and the point stands still: a cusp.
Where \|cos kappa\| > 1 the point is isolated (an acnode) and no attitude reaches it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from flexmech import si
from flexmech.arrays import ROUND_OFF, FloatArray
from flexmech.errors import InputError
from flexmech.linkages.fourbar import FourBar
from flexmech.linkages.motion import RigidMotion, cross, direction
from flexmech.model_text import TomlTable, short_repr
from flexmech.plausible import check_plausible, of_dimension
from flexmech.units import ANGLE, LENGTH, parse_quantity
from flexmech.validation import POSITIVE, check_angle, check_instance, check_number

# Number of the coupler among the links of a four-bar.
COUPLER = 1

# Part of the linkage's size, in m per rad. A velocity is known to 1e-15 of the size: below this
# one the direction of the tangent has fewer than six digits, and the curvature none.
STANDSTILL = 1e-9


class CouplerTriangle(NamedTuple):
    """Coupler triangle A-E-B of a coupler point E.

    Parameters
    ----------
    near, far : float
        Distances of E from A and from B in m.
    cosine, sine : float
        Cosine and sine of the angle epsilon from E-A to E-B, counter-clockwise. Where E is in a pin
        there is no such angle, and these are those of zero.
    """

    near: float
    far: float
    cosine: float
    sine: float


@dataclass(frozen=True)
class CouplerPoint:
    """Point E fixed to the coupler: E = A + e (cos(gamma + theta3), sin(gamma + theta3)).

    Singh & Sanyal 2022, section 4; Hartenberg & Denavit 1964, ch. 6.

    Parameters
    ----------
    distance : float
        Distance e of the point from pin A in m; zero puts it in the pin.
    angle : float
        Angle gamma in rad at A from the line A-B to the point, to the left positive.

    Raises
    ------
    InputError
        If the distance is negative or either is not finite.

    Examples
    --------
    >>> point = flexmech.CouplerPoint(distance=0.033, angle=np.radians(320))
    >>> point.place.round(5)
    array([ 0.02528, -0.02121])
    """

    distance: si.LengthOrZero
    angle: si.Angle

    def __post_init__(self) -> None:
        check_number(self.distance, "distance of the coupler point from pin A", "m")
        if self.distance < 0:
            raise InputError(
                "distance of the coupler point from pin A must not be negative, got "
                f"{self.distance} m; for the other side of the pin turn the angle by 180 deg"
            )
        check_angle(self.angle, "angle of the coupler point")

    @classmethod
    def parse(cls, text: str) -> CouplerPoint:
        """Read a point as a user writes it, such as ``"33 mm,320 deg"``.

        Parameters
        ----------
        text : str
            Distance and angle, each with its unit.

        Returns
        -------
        CouplerPoint

        Raises
        ------
        InputError
            If it is anything else.
        """
        parts = [stated.strip() for stated in text.split(",")]
        try:
            if len(parts) != 2:
                raise InputError(f"got {text!r}, which has {len(parts)} parts")
            dimensions = (LENGTH, ANGLE)
            distance, angle = map(parse_quantity, parts, dimensions)
            for value, stated, dimension in zip((distance, angle), parts, dimensions, strict=True):
                if (sizes := of_dimension(dimension)) is not None:
                    check_plausible(value, stated, sizes)
            return cls(distance, angle)
        except InputError as error:
            raise InputError(
                f'{error}; write distance and angle, each with its unit, as in "33 mm,320 deg"'
            ) from error

    @property
    def place(self) -> FloatArray:
        """Position in the coupler's frame (origin A, x along A-B) in m; shape (2,)."""
        return self.distance * direction(np.asarray(self.angle))

    def triangle(self, coupler: float) -> CouplerTriangle:
        """Triangle that the point makes with the pins of a coupler.

        Parameters
        ----------
        coupler : float
            Length A-B in m.

        Returns
        -------
        CouplerTriangle
        """
        ahead = self.distance - coupler * math.cos(self.angle)
        aside = coupler * math.sin(self.angle)
        far = math.hypot(ahead, aside)
        if far == 0.0:
            return CouplerTriangle(self.distance, far, 1.0, 0.0)
        return CouplerTriangle(self.distance, far, ahead / far, aside / far)

    def scaled(self, factor: float) -> CouplerPoint:
        """The same point of a coupler that is larger by a factor, as after even swelling.

        Parameters
        ----------
        factor : float
            New over old lengths; positive.

        Returns
        -------
        CouplerPoint

        Raises
        ------
        InputError
            If the factor is not a positive number.
        """
        check_number(factor, "factor of the coupler's lengths", bounds=POSITIVE)
        return CouplerPoint(self.distance * factor, self.angle)

    def to_table(self) -> TomlTable:
        """Table ``[linkage.coupler_point]`` of a model file."""
        return si.table(self)


@dataclass(frozen=True)
class CouplerCurve:
    """Path of a coupler point on the linkage's branch, over the crank angle.

    Every method refuses crank angles at which the linkage cannot be assembled or locks, as
    :meth:`FourBar.motion` does.

    Parameters
    ----------
    linkage : FourBar
    point : CouplerPoint

    Examples
    --------
    >>> linkage = flexmech.FourBar(ground=0.254, crank=0.102, coupler=0.2794, rocker=0.2667)
    >>> curve = flexmech.CouplerCurve(linkage, flexmech.CouplerPoint(0.15, np.radians(30)))
    >>> curve.position(np.radians([0, 90])).round(4)
    array([[0.0778, 0.148 ],
           [0.0616, 0.2388]])
    """

    linkage: FourBar
    point: CouplerPoint

    def __post_init__(self) -> None:
        check_instance(self.linkage, FourBar, "linkage", "a coupler curve needs a four-bar")
        check_instance(self.point, CouplerPoint, "point", "give CouplerPoint(distance, angle)")

    def __repr__(self) -> str:
        lengths = ", ".join(f"{x * 1e3:.6g}" for x in self.linkage.lengths.values())
        place = f"{self.point.distance * 1e3:.6g} mm from A"
        angle = f"{np.degrees(self.point.angle):.6g} deg"
        return short_repr(self, f"four-bar of {lengths} mm", f"point {place}", angle)

    def position(self, crank_angle: ArrayLike) -> FloatArray:
        """Positions of the point in ground axes in m.

        Singh & Sanyal 2022, section 4.

        Parameters
        ----------
        crank_angle : array_like, shape (...)
            In rad.

        Returns
        -------
        ndarray, shape (..., 2)

        Raises
        ------
        InputError
            Where the linkage cannot be assembled or locks.
        """
        return self._motion(crank_angle).position(COUPLER, *self.point.place)

    def derivative(self, crank_angle: ArrayLike) -> FloatArray:
        """First derivative of the position by the crank angle in m/rad.

        It is the point's velocity at unit crank speed.

        Parameters
        ----------
        crank_angle : array_like, shape (...)
            In rad.

        Returns
        -------
        ndarray, shape (..., 2)

        Raises
        ------
        InputError
            Where the linkage cannot be assembled or locks.
        """
        return self._motion(crank_angle).velocity(COUPLER, *self.point.place)

    def second_derivative(self, crank_angle: ArrayLike) -> FloatArray:
        """Second derivative of the position by the crank angle in m/rad^2.

        It is the point's acceleration at unit, constant crank speed.

        Parameters
        ----------
        crank_angle : array_like, shape (...)
            In rad.

        Returns
        -------
        ndarray, shape (..., 2)

        Raises
        ------
        InputError
            Where the linkage cannot be assembled or locks.
        """
        return self._motion(crank_angle).acceleration(COUPLER, *self.point.place)

    def speed(self, crank_angle: ArrayLike) -> FloatArray:
        """Arc length by crank angle in m/rad: zero at a cusp.

        Parameters
        ----------
        crank_angle : array_like, shape (...)
            In rad.

        Returns
        -------
        ndarray, shape (...)

        Raises
        ------
        InputError
            Where the linkage cannot be assembled or locks.
        """
        first = self.derivative(crank_angle)
        return np.asarray(np.hypot(first[..., 0], first[..., 1]))

    def curvature(self, crank_angle: ArrayLike) -> FloatArray:
        """Signed curvature of the path in 1/m.

        Positive where the path turns counter-clockwise with growing crank angle.

        Parameters
        ----------
        crank_angle : array_like, shape (...)
            In rad.

        Returns
        -------
        ndarray, shape (...)
            Finite.

        Raises
        ------
        InputError
            Where the point stands still (a cusp: the curvature is infinite there), and where
            the linkage cannot be assembled or locks.
        """
        motion, place = self._motion(crank_angle), self.point.place
        first, second = motion.velocity(COUPLER, *place), motion.acceleration(COUPLER, *place)
        speed = np.hypot(first[..., 0], first[..., 1])
        still = speed <= STANDSTILL * (self.linkage.crank + self.point.distance)
        if np.any(still):
            angle = float(np.round(np.degrees(motion.crank_angle[still].flat[0]), 9))
            raise InputError(
                f"the coupler point stands still at crank angle {angle:g} deg: the path has a "
                "cusp and no finite curvature there; leave that crank angle out"
            )
        return np.asarray(cross(first, second) / speed**3)

    def _motion(self, crank_angle: ArrayLike) -> RigidMotion:
        return self.linkage.motion(crank_angle, crank_speed=1.0)


def coupler_sextic(linkage: FourBar, point: CouplerPoint, position: ArrayLike) -> FloatArray:
    """Residual of the coupler curve's equation, zero on the curves of all its circuits.

    The circles on which A and B stay, about O2 and O4 and about E, are linear in the sine and
    the cosine of the coupler's angle, which are eliminated (S. Roberts 1876; Hartenberg &
    Denavit 1964, ch. 6). With d the ground, a and c crank and rocker, e and f the distances of
    E from A and B under the angle epsilon, r2 and r4 those from O2 and O4:

        U = r2^2 + e^2 - a^2,    V = r4^2 + f^2 - c^2,    W = x^2 - x d + y^2,
        f^2 r4^2 U^2 + e^2 r2^2 V^2 - 2 e f U V (W cos epsilon + y d sin epsilon)
            = 4 e^2 f^2 (y d cos epsilon - W sin epsilon)^2.

    The right side vanishes on the circle of singular foci, on which the double points lie. The
    highest power is b^2 r2^6, b being the coupler's length.

    Parameters
    ----------
    linkage : FourBar
        Its branch is without effect.
    point : CouplerPoint
    position : array_like, shape (..., 2)
        Places (x, y) in ground axes in m.

    Returns
    -------
    ndarray, shape (...)
        Left less right side over b^2 (a + e)^6, where a + e is the longest reach from O2:
        about (r2 / (a + e))^6 far from the curve, some 1e-14 on it.

    Raises
    ------
    InputError
        If the last axis of the places is not of length two.
    """
    place = np.asarray(position, dtype=float)
    if place.ndim == 0 or place.shape[-1] != 2:
        raise InputError(
            f"places must be (x, y) along their last axis, got an array of shape {place.shape}"
        )
    e, f, cosine, sine = point.triangle(linkage.coupler)
    ground = linkage.ground
    x, y = place[..., 0], place[..., 1]
    r2, r4 = x**2 + y**2, (x - ground) ** 2 + y**2
    u = r2 + e**2 - linkage.crank**2
    v = r4 + f**2 - linkage.rocker**2
    w = r2 - x * ground
    left = (f * u) ** 2 * r4 + (e * v) ** 2 * r2
    left -= 2 * e * f * u * v * (w * cosine + y * ground * sine)
    right = (2 * e * f * (y * ground * cosine - w * sine)) ** 2
    residual: FloatArray = (left - right) / (linkage.coupler**2 * (linkage.crank + e) ** 6)
    return residual


Coefficients = tuple[float, ...]

# Directions of (s, t) of which at least one is well away from all three roots.
CHARTS = tuple(math.pi * n / 4 for n in range(-1, 3))
# What the three roots of Viete's formula differ by in its angle.
THIRDS = (0.0, 2 * math.pi / 3, -2 * math.pi / 3)
# A bound of work: steps end where they no longer improve a root. A root of the formulas has half of
# its digits or more where two nearly merge; each step doubles them, and one more meets what
# rounding allows.
NEWTON_STEPS = 3


@dataclass(frozen=True)
class FocalCubic:
    """Closure of both circles at a point of the circle of singular foci.

    The cubic of the module's text with homogeneous w = t / s, a binary form of degree three: a
    root at infinity is as good as another.

    Parameters
    ----------
    ground, crank, rocker : float
        Link lengths d, a and c in m.
    triangle : CouplerTriangle
        With both arms positive.
    """

    ground: float
    crank: float
    rocker: float
    triangle: CouplerTriangle

    def value(self, s: float, t: float) -> float:
        """Residual of the cubic in m^3, homogeneous of degree three in its arguments."""
        e, f, cosine, sine = self.triangle
        square = s * s + (sine * t) ** 2
        to_o2, to_o4 = self.ground * (s + cosine * t), self.ground * t
        near = (self.crank - e) * (self.crank + e) * square - to_o2**2
        far = (self.rocker - f) * (self.rocker + f) * square - to_o4**2
        return (near * f * to_o4 - far * e * to_o2) / self.ground

    def discriminant(self) -> float:
        """Positive with three real roots, negative with one, zero where two merge; in m^12."""
        d, c, b, a = self._chart(self._away())
        return (b * c) ** 2 - 4 * a * c**3 - 4 * b**3 * d - 27 * (a * d) ** 2 + 18 * a * b * c * d

    def roots(self) -> tuple[float, ...]:
        """Real roots as angles arctan(t / s) from -pi/2 to pi/2, growing; one or three.

        A double root counts twice or not at all as round-off has it.
        """
        away = self._away()
        chart = self._chart(away)
        places = (self._polished(away, chart, x) for x in _real_roots(chart))
        return tuple(sorted(_half_turn(away + math.pi / 2 + math.atan(x)) for x in places))

    def _away(self) -> float:
        """Direction away from the roots."""
        return max(CHARTS, key=lambda angle: abs(self.value(math.cos(angle), math.sin(angle))))

    def _chart(self, away: float) -> Coefficients:
        """Coefficients, constant first, in x = tan(angle - away - pi/2)."""
        cos, sin = math.cos(away), math.sin(away)
        # (s, t) = (-sin, cos) - x (cos, sin): the direction ``away`` is at infinity.
        values = [self.value(-sin - x * cos, cos - x * sin) for x in (-1.0, 0.0, 1.0)]
        leading = -self.value(cos, sin)
        even = (values[2] + values[0]) / 2 - values[1]
        odd = (values[2] - values[0]) / 2 - leading
        return (values[1], odd, even, leading)

    def _polished(self, away: float, chart: Coefficients, x: float) -> float:
        """Newton's steps on the cubic as it is written, as long as they improve it."""
        cos, sin = math.cos(away), math.sin(away)

        def residual(x: float) -> float:
            return self.value(-sin - x * cos, cos - x * sin)

        value = residual(x)
        for _ in range(NEWTON_STEPS):
            slope = _slope(chart, x)
            if value == 0 or slope == 0:
                break
            ahead = x - value / slope
            next_value = residual(ahead)
            if abs(next_value) >= abs(value):
                break
            x, value = ahead, next_value
        return x


def _real_roots(coefficients: Coefficients) -> list[float]:
    """Real roots of a cubic by Viete's cosines, or Cardano's formula for a single one."""
    constant, linear, square = (c / coefficients[3] for c in coefficients[:3])
    centre = -square / 3
    # y^3 - 3 p y - 2 q = 0 with x = y + centre.
    p = centre**2 - linear / 3
    q = -(((centre + square) * centre + linear) * centre + constant) / 2
    cube = p**3
    if cube > 0 and q * q <= cube:
        third = math.acos(max(-1.0, min(1.0, q / math.sqrt(cube)))) / 3
        return [centre + 2 * math.sqrt(p) * math.cos(third + turn) for turn in THIRDS]
    larger = math.copysign(math.cbrt(abs(q) + math.sqrt(max(q * q - cube, 0.0))), q)
    return [centre + larger + p / larger] if larger else [centre]


def _slope(coefficients: Coefficients, x: float) -> float:
    _, linear, square, leading = coefficients
    return (3 * leading * x + 2 * square) * x + linear


def _half_turn(angle: float) -> float:
    """The angle from -pi/2 to pi/2."""
    return math.remainder(angle, math.pi)


Circuit = Literal["open", "crossed", "upper", "lower", "whole"]
CrankMotion = Literal["turns", "swings in two ranges", "swings in one range"]


@lru_cache(maxsize=16)
def crank_motion(linkage: FourBar) -> CrankMotion:
    """Range of the crank's motion, which distinguishes the circuits.

    Parameters
    ----------
    linkage : FourBar

    Returns
    -------
    {"turns", "swings in two ranges", "swings in one range"}
        A full turn on either branch (crank-rocker and double-crank); between limits on either
        side of the ground's line, over both branches (double-rocker and rocker-crank); or over
        both branches between limits on one circuit (triple-rocker).

    Raises
    ------
    InputError
        If the linkage has a change point, where circuits meet.
    """
    grashof_class = linkage.grashof_class
    if grashof_class == "change-point":
        raise InputError(
            "the linkage has a change point (shortest and longest link together are as long as "
            "the other two): its circuits meet there and cannot be distinguished; change a link "
            "length slightly"
        )
    if grashof_class in ("crank-rocker", "double-crank"):
        return "turns"
    return "swings in one range" if grashof_class == "triple-rocker" else "swings in two ranges"


def circuit_of(linkage: FourBar, crank_angle: float | None = None) -> Circuit:
    """Name of the circuit in which a linkage moves.

    Parameters
    ----------
    linkage : FourBar
    crank_angle : float, optional
        A crank angle of the circuit in rad, where the crank swings within two ranges; without
        it the one above the ground's line is meant. Otherwise without effect.

    Returns
    -------
    {"open", "crossed", "upper", "lower", "whole"}
        The branch of a crank that turns fully, the side of the ground's line of one that swings
        in two ranges, or the only circuit.

    Raises
    ------
    InputError
        If the linkage has a change point or cannot be assembled at the crank angle.
    """
    motion = crank_motion(linkage)
    if motion == "turns":
        return linkage.branch
    if motion == "swings in one range":
        return "whole"
    if crank_angle is None:
        return "upper"
    linkage.transmission_angle(crank_angle)
    return "upper" if math.sin(crank_angle) > 0 else "lower"


def circuit_of_position(
    linkage: FourBar, motion: CrankMotion, pin: tuple[float, float], coupler_angle: float
) -> Circuit:
    """Name of the circuit to which a position of the linkage belongs.

    Parameters
    ----------
    linkage : FourBar
        Its branch is without effect.
    motion : {"turns", "swings in two ranges", "swings in one range"}
        As :func:`crank_motion` gives it.
    pin : tuple of two floats
        Place of pin A in m.
    coupler_angle : float
        Angle theta3 in rad.

    Returns
    -------
    {"open", "crossed", "upper", "lower", "whole"}
    """
    if motion == "turns":
        to_o4 = linkage.ground - pin[0]
        left = to_o4 * math.sin(coupler_angle) + pin[1] * math.cos(coupler_angle)
        return "open" if left > 0 else "crossed"
    if motion == "swings in two ranges":
        return "upper" if pin[1] > 0 else "lower"
    return "whole"


# The loop of a crunode is about margin^1.5 of the linkage in size: below this margin it is
# smaller than the round-off of a place, and crunode, cusp and acnode are one.
CUSP_MARGIN = 1e-10


class Attitude(NamedTuple):
    """Configuration of the linkage at a double point.

    Parameters
    ----------
    crank_angle, coupler_angle : float
        In rad.
    circuit : Circuit
    """

    crank_angle: float
    coupler_angle: float
    circuit: Circuit


@dataclass(frozen=True)
class DoublePoint:
    r"""Real double point of a coupler curve: a crunode, a cusp or an acnode.

    Parameters
    ----------
    place : float
        Where on the circle of singular foci: arctan w, from -pi/2 to pi/2, the ends being one
        point.
    position : ndarray, shape (2,)
        In ground axes in m.
    margin : float
        1 - \|cos kappa\| over the square of crank / (E-A) or rocker / (E-B) where that is less
        than one: positive for a crunode, zero for a cusp, negative for an acnode.
    attitudes : tuple of Attitude
        Attitudes of the two passages, that with the smaller crank angle first; none of an acnode.
    """

    place: float
    position: FloatArray
    margin: float
    attitudes: tuple[Attitude, ...]

    @property
    def kind(self) -> Literal["crunode", "cusp", "acnode"]:
        """Self-intersection, point of zero speed or isolated point: by the margin in round-off."""
        if abs(self.margin) <= CUSP_MARGIN:
            return "cusp"
        return "crunode" if self.margin > 0 else "acnode"

    @property
    def crank_angles(self) -> FloatArray:
        """Crank angles of the two passages in rad, from 0 to 2 pi, ascending; equal for a cusp."""
        return np.array([attitude.crank_angle for attitude in self.attitudes])

    @property
    def coupler_angles(self) -> FloatArray:
        """Angles theta3 of the coupler at those crank angles in rad, from 0 to 2 pi.

        They tell the branch where the crank cannot turn fully and a curve runs over both.
        """
        return np.array([attitude.coupler_angle for attitude in self.attitudes])

    def lies_on(self, circuit: Circuit) -> bool:
        """Whether both attitudes belong to a circuit."""
        return bool(self.attitudes) and all(a.circuit == circuit for a in self.attitudes)


def double_points(
    linkage: FourBar, point: CouplerPoint, crank_angle: float | None = None
) -> tuple[DoublePoint, ...]:
    """Crunodes and cusps of the curve that a coupler point traces, without a search.

    The curve is that of one circuit: what the linkage reaches without being taken apart. With
    a crank that turns fully it is the linkage's branch; with a crank that swings, both branches
    between two limit positions. The roots of the cubic in the module's text (Hartenberg &
    Denavit 1964, ch. 6), at most three.

    Parameters
    ----------
    linkage : FourBar
    point : CouplerPoint
        A point in pin A or B has a circle or an arc for its curve, and no double points.
    crank_angle : float, optional
        A crank angle of the circuit in rad, where the crank swings within two separate ranges;
        without it the range above the ground's line is meant. Otherwise without effect.

    Returns
    -------
    tuple of DoublePoint
        By their first crank angle.

    Raises
    ------
    InputError
        If the linkage has a change point, where circuits meet, or cannot be assembled at
        ``crank_angle``.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/neat_resin_figure_8.toml")
    >>> points = flexmech.double_points(mechanism.linkage, mechanism.coupler_point, 0.0)
    >>> [point.kind for point in points]
    ['crunode']
    """
    _check_coupler(linkage, point)
    circuit = circuit_of(linkage, crank_angle)
    nodes = (node for node in finite_double_points(linkage, point) if node.lies_on(circuit))
    return tuple(sorted(nodes, key=lambda node: node.attitudes))


def finite_double_points(linkage: FourBar, point: CouplerPoint) -> tuple[DoublePoint, ...]:
    """Real double points of the sextic: of every circuit, between circuits, and isolated ones.

    Parameters
    ----------
    linkage : FourBar
        Its branch is without effect.
    point : CouplerPoint

    Returns
    -------
    tuple of DoublePoint
        One or three by growing place; none of a point in a pin.

    Raises
    ------
    InputError
        If the linkage has a change point.
    """
    _check_coupler(linkage, point)
    motion = crank_motion(linkage)
    cubic = focal_cubic(linkage, point)
    near, far, *_ = cubic.triangle
    if min(near, far) <= ROUND_OFF * linkage.coupler:  # the point is in a pin
        return ()
    return tuple(_node(linkage, point, cubic.triangle, motion, place) for place in cubic.roots())


def _check_coupler(linkage: object, point: object) -> None:
    check_instance(linkage, FourBar, "linkage", "give a flexmech.FourBar")
    check_instance(point, CouplerPoint, "point", "give a flexmech.CouplerPoint")


def focal_cubic(linkage: FourBar, point: CouplerPoint) -> FocalCubic:
    """Cubic whose roots are the double points; its discriminant tells how many are real."""
    # NumPy's scalars, where the lengths come from an array, take three times as long.
    d, a, b, c = (float(length) for length in linkage.lengths.values())
    return FocalCubic(d, a, c, CouplerTriangle(*map(float, point.triangle(b))))


def _node(
    linkage: FourBar,
    point: CouplerPoint,
    triangle: CouplerTriangle,
    motion: CrankMotion,
    place: float,
) -> DoublePoint:
    t, s = math.sin(place), math.cos(place)
    scale = math.hypot(s, triangle.sine * t)
    along = (s / scale, triangle.sine * t / scale)
    to_o2 = linkage.ground * (s + triangle.cosine * t) / scale
    to_o4 = linkage.ground * t / scale
    # The side with the longer arms keeps its meaning where E is in O2 or O4.
    if triangle.near * abs(to_o2) >= triangle.far * abs(to_o4):
        less, more = _versines(linkage.crank, triangle.near, to_o2)
    else:
        less, more = _versines(linkage.rocker, triangle.far, to_o4)
    position = (to_o2 * along[0], to_o2 * along[1])
    # Far from the pins kappa is small by itself.
    longest = max(1.0, triangle.near / linkage.crank, triangle.far / linkage.rocker)
    margin = min(less, more) * longest**2
    attitudes: tuple[Attitude, ...] = ()
    if margin >= -CUSP_MARGIN:
        kappa = 2 * math.atan2(math.sqrt(max(less, 0.0)), math.sqrt(max(more, 0.0)))
        if margin <= CUSP_MARGIN:
            kappa = math.pi * round(kappa / math.pi)
        eta = math.atan2(along[1], along[0])
        turned = (eta + kappa, eta - kappa)
        attitudes = tuple(sorted(_attitude(linkage, point, motion, position, x) for x in turned))
    return DoublePoint(place, np.array(position), margin, attitudes)


def _versines(radius: float, arm: float, distance: float) -> tuple[float, float]:
    """1 - cos kappa and 1 + cos kappa, without the difference of nearly equal squares."""
    scale = 2 * arm * distance
    reach = arm + distance
    gap = distance - arm
    return (
        (reach - radius) * (reach + radius) / scale,
        (radius - gap) * (radius + gap) / scale,
    )


def _attitude(
    linkage: FourBar,
    point: CouplerPoint,
    motion: CrankMotion,
    position: tuple[float, float],
    to_pin: float,
) -> Attitude:
    """Configuration in which E-A has a given direction."""
    a_x = position[0] + point.distance * math.cos(to_pin)
    a_y = position[1] + point.distance * math.sin(to_pin)
    coupler_angle = full_turn(to_pin + math.pi - point.angle)
    circuit = circuit_of_position(linkage, motion, (a_x, a_y), coupler_angle)
    return Attitude(full_turn(math.atan2(a_y, a_x)), coupler_angle, circuit)


def full_turn(angle: float) -> float:
    """The angle from 0 to 2 pi, the latter excluded."""
    turned = angle % (2 * math.pi)
    return turned if turned < 2 * math.pi else 0.0
