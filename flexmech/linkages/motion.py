"""Rigid motion of every link, batched over positions of the linkage, and as a frame carries it."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexmech.arrays import ComplexArray, FloatArray, IntArray
from flexmech.errors import InputError
from flexmech.model_text import shapes, short_repr
from flexmech.validation import checked_array

# In rad/s: points 0.3 m from the axis of such a shaft would be as fast as light, so that a unit is
# wrong. The squares of greater speeds are beyond what the equations of a linkage resolve.
FASTEST = 1e9
# Sine of the angle in which two loci meet, or least singular value of the equations of a group of
# bodies in parts of their size. Positions are known to some 1e-15, so that velocities, which go
# with its inverse, are known to 1e-9; below it the position counts as locked.
LOCKING_SINE = 1e-6


def direction(angle: FloatArray) -> FloatArray:
    """Unit vectors at given angles; shape (...) -> (..., 2)."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def normal(angle: FloatArray) -> FloatArray:
    """Unit vectors a quarter turn ahead of given angles; shape (...) -> (..., 2)."""
    return np.stack([-np.sin(angle), np.cos(angle)], axis=-1)


def checked_drive(
    crank_angle: ArrayLike, crank_speed: ArrayLike, crank_acceleration: ArrayLike
) -> tuple[FloatArray, ...]:
    """Angle, speed and acceleration of the crank as arrays of one shape.

    Parameters
    ----------
    crank_angle, crank_speed, crank_acceleration : array_like
        Angle in rad, speed in rad/s, acceleration in rad/s^2; broadcast together.

    Returns
    -------
    tuple of ndarray

    Raises
    ------
    InputError
        If one is not made of finite numbers, a speed is beyond all shafts, or the shapes do not
        go together.
    """
    given = (
        checked_array(crank_angle, "crank_angle", "rad"),
        checked_array(crank_speed, "crank_speed", "rad/s"),
        checked_array(crank_acceleration, "crank_acceleration", "rad/s^2"),
    )
    fastest = float(np.abs(given[1]).max(initial=0.0))
    if fastest > FASTEST:
        raise InputError(
            f"crank_speed reaches {fastest:.3g} rad/s, beyond {FASTEST:g} rad/s, which no shaft "
            "does; check its unit"
        )
    try:
        shape = np.broadcast(*given).shape
    except ValueError as error:
        shapes = ", ".join(str(values.shape) for values in given)
        raise InputError(
            f"crank_angle, crank_speed and crank_acceleration have the shapes {shapes}, which do "
            "not go together; give single numbers or arrays of one shape"
        ) from error
    return tuple(
        np.broadcast_to(values, shape) if values.shape != shape else values for values in given
    )


@dataclass(frozen=True)
class RigidMotion:
    """Position, velocity and acceleration of the link frames.

    Leading dimensions ``...`` run over positions (crank angles, crank speeds); the last
    before any vector component over the links of the topology. SI units, rad.

    Parameters
    ----------
    crank_angle : ndarray, shape (...)
    crank_speed : ndarray, shape (...)
    angle, angular_velocity, angular_acceleration : ndarray, shape (..., n_links)
        Absolute angle of each link frame and its time derivatives.
    origin, origin_velocity, origin_acceleration : ndarray, shape (..., n_links, 2)
        Start of each link, in ground axes.
    """

    crank_angle: FloatArray
    crank_speed: FloatArray
    angle: FloatArray
    angular_velocity: FloatArray
    angular_acceleration: FloatArray
    origin: FloatArray
    origin_velocity: FloatArray
    origin_acceleration: FloatArray

    def __repr__(self) -> str:
        return short_repr(self, *shapes(self))

    def at(self, which: NDArray[np.bool_] | IntArray | slice) -> Self:
        """Motion in some of the positions.

        Parameters
        ----------
        which : ndarray of bool, shape (...), or of int, or slice

        Returns
        -------
        RigidMotion
            Batch of shape (B,).
        """
        return type(self)(*(getattr(self, entry.name)[which] for entry in fields(self)))

    def arm(self, link: int, x: ArrayLike, y: ArrayLike = 0.0) -> FloatArray:
        """From a link's start to the point at ``(x, y)`` in its frame, ground axes in m.

        Parameters
        ----------
        link : int
            Number of the link in the topology.
        x, y : array_like, shape (...)
            Along and across the link in m; arrays where the point moves along the link.

        Returns
        -------
        ndarray, shape (..., 2)
        """
        angle = self.angle[..., link]
        along = np.asarray(x)[..., None] * direction(angle)
        return np.asarray(along + np.asarray(y)[..., None] * normal(angle) if np.any(y) else along)

    def position(self, link: int, x: ArrayLike, y: ArrayLike = 0.0) -> FloatArray:
        """Ground position of a point of a link in m.

        Parameters
        ----------
        link, x, y
            As in :meth:`arm`.

        Returns
        -------
        ndarray, shape (..., 2)
        """
        return np.asarray(self.origin[..., link, :] + self.arm(link, x, y))

    def velocity(self, link: int, x: ArrayLike, y: ArrayLike = 0.0) -> FloatArray:
        """Ground velocity of a point of a link in m/s.

        Parameters
        ----------
        link, x, y
            As in :meth:`arm`.

        Returns
        -------
        ndarray, shape (..., 2)
        """
        turning = self.angular_velocity[..., link, None] * quarter_turn(self.arm(link, x, y))
        return np.asarray(self.origin_velocity[..., link, :] + turning)

    def acceleration(self, link: int, x: ArrayLike, y: ArrayLike = 0.0) -> FloatArray:
        """Ground acceleration of a point of a link in m/s^2.

        Kumar & Chandrakar, eqs. 1.37-1.42, for any point of the link.

        Parameters
        ----------
        link, x, y
            As in :meth:`arm`.

        Returns
        -------
        ndarray, shape (..., 2)
        """
        arm = self.arm(link, x, y)
        tangential = self.angular_acceleration[..., link, None] * quarter_turn(arm)
        centripetal = self.angular_velocity[..., link, None] ** 2 * arm
        return np.asarray(self.origin_acceleration[..., link, :] + tangential - centripetal)


def as_pairs(vectors: ComplexArray) -> FloatArray:
    """Components of vectors that are complex numbers; shape (...) -> (..., 2)."""
    return np.ascontiguousarray(vectors).view(float).reshape(*vectors.shape, 2)


def cross(first: FloatArray, second: FloatArray) -> FloatArray:
    """Vector product of plane vectors, as of an arm and a force; shapes (..., 2) -> (...)."""
    return np.asarray(first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0])


def quarter_turn(vector: FloatArray) -> FloatArray:
    """Vectors (..., 2) turned by 90 deg to the left."""
    return np.stack([-vector[..., 1], vector[..., 0]], axis=-1)


def carried_motion(
    centre: tuple[float, float],
    motion: RigidMotion,
    place: FloatArray,
    rate: FloatArray,
    change: FloatArray | None = None,
) -> RigidMotion:
    """Motion of link frames in ground axes, as a frame carries them.

    Parameters
    ----------
    centre : tuple of float
        Centre of the frame as it is drawn, in m.
    motion : RigidMotion
        In the axes of the frame, batch of shape (B,).
    place, rate, change : ndarray, shape (B, 3)
        Coordinates of the frame and their time derivatives; the second ones count for nothing but
        accelerations, and are zero if left out.

    Returns
    -------
    RigidMotion
    """
    change = np.zeros_like(place) if change is None else change
    turn, spin, swing = (values[:, 2, None] for values in (place, rate, change))
    arm = turned(motion.origin - np.asarray(centre), turn)
    velocity = turned(motion.origin_velocity, turn)
    acceleration = turned(motion.origin_acceleration, turn)
    by_spin = spin[..., None] * quarter_turn(arm)
    by_swing = swing[..., None] * quarter_turn(arm) - spin[..., None] ** 2 * arm
    coriolis = 2 * spin[..., None] * quarter_turn(velocity)
    return replace(
        motion,
        angle=motion.angle + turn,
        angular_velocity=motion.angular_velocity + spin,
        angular_acceleration=motion.angular_acceleration + swing,
        origin=np.asarray(centre) + place[:, None, :2] + arm,
        origin_velocity=rate[:, None, :2] + velocity + by_spin,
        origin_acceleration=change[:, None, :2] + acceleration + coriolis + by_swing,
    )


def turned(vector: FloatArray, angle: FloatArray) -> FloatArray:
    """Vectors (..., 2) turned by angles (...) in rad to the left."""
    return np.asarray(vector[..., :1] * direction(angle) + vector[..., 1:] * normal(angle))
