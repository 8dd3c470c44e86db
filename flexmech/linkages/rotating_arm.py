"""One link clamped to a turning hub: the rotating beam of the textbooks."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from flexmech import si
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages.motion import RigidMotion, checked_drive, direction, normal
from flexmech.linkages.topology import Clamp, Link, LinkEnd, Topology
from flexmech.model_text import TomlTable


@dataclass(frozen=True)
class RotatingArm:
    """An arm clamped at ``hub_radius`` from the axis about which the hub turns.

    Parameters
    ----------
    length : float
        Arm length in m, from the clamp to the free end.
    hub_radius : float
        Distance from the axis to the clamp in m; zero or more.

    Raises
    ------
    InputError
        If the length is not positive or the hub radius is negative.

    Examples
    --------
    >>> arm = flexmech.RotatingArm(length=0.3, hub_radius=0.02)
    >>> arm.motion(crank_angle=0.0).position(0, arm.length)
    array([0.32, 0.  ])
    """

    length: si.Length
    hub_radius: si.LengthOrZero = 0.0

    kind: ClassVar[str] = "rotating-arm"

    def __post_init__(self) -> None:
        si.check(self, "{} of the arm")

    @property
    def topology(self) -> Topology:
        """One link, clamped at its start (joint ``O2``)."""
        return Topology(
            links=(Link("arm", self.length),),
            clamps=(Clamp("O2", LinkEnd("arm", "start"), self.hub_radius),),
        )

    def sprung_at(self, joints: Collection[str]) -> Self:
        """The same: an arm has neither pins nor pivots.

        Parameters
        ----------
        joints : collection of str

        Raises
        ------
        InputError
            If there is one.
        """
        if joints:
            raise InputError(f"an arm has no pin or pivot, got the sprung joints {sorted(joints)}")
        return self

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
        theta, omega, alpha = checked_drive(crank_angle, crank_speed, crank_acceleration)
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

    @property
    def change_angles(self) -> FloatArray:
        """None: a single link is in one posture at each crank angle."""
        return np.zeros(0)

    def resized(self, lengths: Mapping[str, float], ground_growth: float) -> RotatingArm:
        """Arm of another length on a larger hub.

        Parameters
        ----------
        lengths : mapping of str to float
            New length in m of the link ``arm``.
        ground_growth : float
            New over old radius of the hub.

        Returns
        -------
        RotatingArm
        """
        return RotatingArm(lengths["arm"], self.hub_radius * ground_growth)

    def described(self) -> list[str]:
        """Kind, length and radius of the hub, a line each."""
        return [
            "kind: rotating arm",
            f"lengths: arm {self.length * 1e3:.6g} mm",
            f"hub radius: {self.hub_radius * 1e3:.6g} mm",
        ]

    def to_table(self) -> TomlTable:
        """Table ``[linkage]`` of a model file."""
        return {"kind": self.kind, **si.table(self)}
