"""Closed forms of the four-bar's motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linkages.motion import RigidMotion, direction, normal


@dataclass(frozen=True)
class FourBarDimensions:
    """Lengths and branch of a four-bar.

    Parameters
    ----------
    ground, crank, coupler, rocker : float
        In m.
    side : float or ndarray, shape (...)
        1 where B is to the left of the line from A to O4, -1 where it is to the right.
    """

    ground: float
    crank: float
    coupler: float
    rocker: float
    side: FloatArray | float

    def cosine_at_b(self, crank_cosine: FloatArray) -> FloatArray:
        """Cosine of the angle at B, by the cosine rule, from that of the crank angle (...)."""
        sides = self.coupler**2 + self.rocker**2 - self.ground**2 - self.crank**2
        opposite = 2 * self.ground * self.crank * crank_cosine
        return np.asarray((sides + opposite) / (2 * self.coupler * self.rocker))

    def follower_angles(self, theta2: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Coupler and rocker angles (...) from the two circles about A and O4 that meet in B."""
        to_o4_x = self.ground - self.crank * np.cos(theta2)
        to_o4_y = -self.crank * np.sin(theta2)
        distance = np.hypot(to_o4_x, to_o4_y)
        cosine = (self.coupler**2 + distance**2 - self.rocker**2) / (2 * self.coupler * distance)
        opening = np.arccos(np.clip(cosine, -1.0, 1.0))
        theta3 = np.arctan2(to_o4_y, to_o4_x) + self.side * opening
        theta4 = np.arctan2(
            self.coupler * np.sin(theta3) - to_o4_y, self.coupler * np.cos(theta3) - to_o4_x
        )
        return theta3, theta4

    def motion(self, theta2: FloatArray, omega2: FloatArray, alpha2: FloatArray) -> RigidMotion:
        """Motion of crank, coupler and rocker where the linkage does not lock.

        Kumar & Chandrakar, eqs. 1.22, 1.23 (angular velocities), 1.35 and 1.36 (angular
        accelerations, corrected: the alpha2 term of 1.36 has sin(theta2 - theta3)).

        Parameters
        ----------
        theta2, omega2, alpha2 : ndarray, shape (...)
            Of the crank: angle in rad, speed in rad/s and acceleration in rad/s^2.

        Returns
        -------
        RigidMotion
        """
        theta3, theta4 = self.follower_angles(theta2)
        cos_43, sin_43 = np.cos(theta4 - theta3), np.sin(theta4 - theta3)
        cos_24, sin_24 = np.cos(theta2 - theta4), np.sin(theta2 - theta4)
        cos_23, sin_23 = np.cos(theta2 - theta3), np.sin(theta2 - theta3)
        omega3 = self.crank * omega2 * sin_24 / (self.coupler * sin_43)
        omega4 = self.crank * omega2 * sin_23 / (self.rocker * sin_43)
        alpha3 = (
            self.crank * (omega2**2 * cos_24 + alpha2 * sin_24)
            + self.coupler * omega3**2 * cos_43
            - self.rocker * omega4**2
        ) / (self.coupler * sin_43)
        alpha4 = (
            self.crank * (omega2**2 * cos_23 + alpha2 * sin_23)
            - self.rocker * omega4**2 * cos_43
            + self.coupler * omega3**2
        ) / (self.rocker * sin_43)

        along, across = self.crank * direction(theta2), self.crank * normal(theta2)
        position, velocity, acceleration = np.zeros((3, *theta2.shape, 3, 2))
        position[..., 1, :] = along
        position[..., 2, 0] = self.ground
        velocity[..., 1, :] = omega2[..., None] * across
        acceleration[..., 1, :] = alpha2[..., None] * across - omega2[..., None] ** 2 * along
        return RigidMotion(
            crank_angle=theta2,
            crank_speed=omega2,
            angle=np.stack([theta2, theta3, theta4], axis=-1),
            angular_velocity=np.stack([omega2, omega3, omega4], axis=-1),
            angular_acceleration=np.stack([alpha2, alpha3, alpha4], axis=-1),
            origin=position,
            origin_velocity=velocity,
            origin_acceleration=acceleration,
        )
