"""Coupler curve of a four-bar: positions, derivatives, curvature, equation."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages.fourbar import FourBar
from flexmech.linkages.motion import RigidMotion, cross, direction
from flexmech.model_text import TomlTable, fields_table, short_repr
from flexmech.plausible import check_plausible, of_dimension
from flexmech.units import ANGLE, LENGTH, parse_quantity
from flexmech.validation import POSITIVE, check_angle, check_instance, check_number

# Number of the coupler among the links of a four-bar.
COUPLER = 1

# Of the linkage's size, in m per rad. A velocity is known to about 1e-15 of the size: below this
# one the direction of the tangent has fewer than six digits, and the curvature none.
STANDSTILL = 1e-9


class CouplerTriangle(NamedTuple):
    """Coupler triangle A-E-B of a coupler point E.

    Parameters
    ----------
    near, far : float
        Distances of E from A and from B in m.
    cosine, sine : float
        Of the angle epsilon from E-A to E-B, counter-clockwise. Where E is in a pin there is no
        such angle, and these are those of zero.
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
        Angle gamma from the coupler's line A-B to A-E in rad, counter-clockwise.

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

    distance: float
    angle: float

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
        parts = [part.strip() for part in text.split(",")]
        try:
            if len(parts) != 2:
                raise InputError(f"got {text!r}, which has {len(parts)} parts")
            dimensions = (LENGTH, ANGLE)
            distance, angle = map(parse_quantity, parts, dimensions)
            for value, part, dimension in zip((distance, angle), parts, dimensions, strict=True):
                if (sizes := of_dimension(dimension)) is not None:
                    check_plausible(value, part, sizes)
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
        return fields_table(self, {"distance": LENGTH, "angle": ANGLE})


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
