"""One link clamped to a turning hub: the rotating beam of the textbooks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flexmech.errors import InputError
from flexmech.linkages.motion import RigidMotion, direction, normal
from flexmech.linkages.topology import Clamp, Link, LinkEnd, Topology

__all__ = ["RotatingArm"]


@dataclass(frozen=True)
class RotatingArm:
    """An arm clamped at ``hub_radius`` from the axis about which the hub turns.

    Parameters
    ----------
    length : float
        Arm length in m.
    hub_radius : float
        Distance from the axis to the clamp in m; zero or more.

    Raises
    ------
    InputError
        If the length is not positive or the hub radius is negative.
    """

    length: float
    hub_radius: float = 0.0

    def __post_init__(self) -> None:
        if not (np.isfinite(self.length) and self.length > 0):
            raise InputError(f"length of the arm must be positive, got {self.length} m")
        if not (np.isfinite(self.hub_radius) and self.hub_radius >= 0):
            raise InputError(f"hub_radius must be zero or positive, got {self.hub_radius} m")

    @property
    def topology(self) -> Topology:
        """One link, clamped at its start (joint ``O2``)."""
        return Topology(
            links=(Link("arm", self.length),),
            clamps=(Clamp("O2", LinkEnd("arm", "start")),),
        )

    def motion(
        self,
        crank_angle: ArrayLike,
        crank_speed: ArrayLike = 0.0,
        crank_acceleration: ArrayLike = 0.0,
    ) -> RigidMotion:
        """Rigid motion of the arm.

        Parameters
        ----------
        crank_angle, crank_speed, crank_acceleration : array_like
            Angle in rad, speed in rad/s, acceleration in rad/s^2; broadcast together.

        Returns
        -------
        RigidMotion
            With one link.
        """
        theta, omega, alpha = np.broadcast_arrays(
            *(np.asarray(a, dtype=float) for a in (crank_angle, crank_speed, crank_acceleration))
        )
        along, across = direction(theta), normal(theta)
        hub = self.hub_radius
        return RigidMotion(
            crank_angle=theta,
            crank_speed=omega,
            angle=theta[..., None],
            angular_velocity=omega[..., None],
            angular_acceleration=alpha[..., None],
            origin=(hub * along)[..., None, :],
            origin_velocity=(hub * omega[..., None] * across)[..., None, :],
            origin_acceleration=(hub * (alpha[..., None] * across - omega[..., None] ** 2 * along))[
                ..., None, :
            ],
        )
