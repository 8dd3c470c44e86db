"""The path of a point of a four-bar's coupler: places, derivatives and curvature."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from flexmech.errors import InputError
from flexmech.linkages.fourbar import FourBar
from flexmech.linkages.motion import RigidMotion, direction, normal
from flexmech.model_text import TomlTable, quantity
from flexmech.numbers import POSITIVE, check_angle, check_instance, check_number
from flexmech.short_repr import short_repr
from flexmech.types import FloatArray
from flexmech.units import ANGLE, LENGTH

COUPLER = 1

# Below this part of the linkage's size, in m per rad, the tangent's direction is round-off.
STANDSTILL = 1e-9


class CouplerTriangle(NamedTuple):
    """The coupler as its point E sees it: the triangle A-E-B.

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

    @property
    def place(self) -> FloatArray:
        """Place in the coupler's frame (origin A, x along A-B) in m; shape (2,)."""
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
        return {"distance": quantity(self.distance, LENGTH), "angle": quantity(self.angle, ANGLE)}


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
        """Places of the point in ground axes in m.

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
        motion = self._motion(crank_angle)
        return motion.origin[..., COUPLER, :] + self.point.distance * direction(self._angle(motion))

    def derivative(self, crank_angle: ArrayLike) -> FloatArray:
        """First derivative of the place by the crank angle in m/rad.

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
        return self._derivatives(crank_angle)[0]

    def second_derivative(self, crank_angle: ArrayLike) -> FloatArray:
        """Second derivative of the place by the crank angle in m/rad^2.

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
        return self._derivatives(crank_angle)[1]

    def speed(self, crank_angle: ArrayLike) -> FloatArray:
        """Length of the path by the crank angle in m/rad: zero at a cusp.

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
        first, second = self._derivatives(crank_angle)
        speed = np.hypot(first[..., 0], first[..., 1])
        self._refuse_standstill(np.asarray(crank_angle, dtype=float), speed)
        turning = first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]
        return np.asarray(turning / speed**3)

    def _derivatives(self, crank_angle: ArrayLike) -> tuple[FloatArray, FloatArray]:
        motion = self._motion(crank_angle)
        angle = self._angle(motion)
        arm = self.point.distance
        turning = motion.angular_velocity[..., COUPLER, None]
        spin = motion.angular_acceleration[..., COUPLER, None]
        along, across = direction(angle), normal(angle)
        first = motion.origin_velocity[..., COUPLER, :] + arm * turning * across
        second = motion.origin_acceleration[..., COUPLER, :] + arm * (
            spin * across - turning**2 * along
        )
        return first, second

    def _motion(self, crank_angle: ArrayLike) -> RigidMotion:
        return self.linkage.motion(crank_angle, crank_speed=1.0)

    def _angle(self, motion: RigidMotion) -> FloatArray:
        """Angle of A-E in ground axes in rad; shape (...)."""
        angle: FloatArray = motion.angle[..., COUPLER] + self.point.angle
        return angle

    def _refuse_standstill(self, theta: FloatArray, speed: FloatArray) -> None:
        still = speed <= STANDSTILL * (self.linkage.crank + self.point.distance)
        if np.any(still):
            angle = float(np.round(np.degrees(theta[still].flat[0]), 9))
            raise InputError(
                f"the coupler point stands still at crank angle {angle:g} deg: the path has a "
                "cusp and no finite curvature there; leave that crank angle out"
            )
