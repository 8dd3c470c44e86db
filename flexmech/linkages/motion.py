"""Rigid motion of every link, batched over positions of the linkage."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexmech.errors import InputError
from flexmech.numbers import checked_array
from flexmech.short_repr import shapes, short_repr
from flexmech.types import FloatArray, IntArray

# In rad/s: no shaft turns faster.
FASTEST = 1e9


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
        return tuple(np.broadcast_arrays(*given))
    except ValueError as error:
        shapes = ", ".join(str(each.shape) for each in given)
        raise InputError(
            f"crank_angle, crank_speed and crank_acceleration have the shapes {shapes}, which do "
            "not go together; give single numbers or arrays of one shape"
        ) from error


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

    def at(self, which: NDArray[np.bool_] | IntArray | slice) -> RigidMotion:
        """Motion in some of the positions.

        Parameters
        ----------
        which : ndarray of bool, shape (...), or of int, or slice

        Returns
        -------
        RigidMotion
            Batch of shape (B,).
        """
        return RigidMotion(*(getattr(self, field.name)[which] for field in fields(self)))

    def position(self, link: int, x: float) -> FloatArray:
        """Ground position of the point at ``x`` along a link; shape (..., 2)."""
        return self.origin[..., link, :] + x * direction(self.angle[..., link])

    def velocity(self, link: int, x: float) -> FloatArray:
        """Ground velocity of the point at ``x`` along a link; shape (..., 2)."""
        turning = self.angular_velocity[..., link, None] * normal(self.angle[..., link])
        return self.origin_velocity[..., link, :] + x * turning

    def acceleration(self, link: int, x: float) -> FloatArray:
        """Ground acceleration of the point at ``x`` along a link; shape (..., 2).

        Kumar & Chandrakar, eqs. 1.37-1.42, for any point of the link.
        """
        angle = self.angle[..., link]
        tangential = self.angular_acceleration[..., link, None] * normal(angle)
        centripetal = -(self.angular_velocity[..., link, None] ** 2) * direction(angle)
        return self.origin_acceleration[..., link, :] + x * (tangential + centripetal)
