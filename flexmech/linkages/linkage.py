"""What every linkage offers, whatever its kind."""

from __future__ import annotations

from typing import Protocol

from numpy.typing import ArrayLike

from flexmech.linkages.motion import RigidMotion
from flexmech.linkages.topology import Topology

__all__ = ["Linkage"]


class Linkage(Protocol):
    """A rigid linkage of one degree of freedom, driven by its crank."""

    @property
    def topology(self) -> Topology:
        """Links and connections."""
        ...

    def motion(
        self,
        crank_angle: ArrayLike,
        crank_speed: ArrayLike = 0.0,
        crank_acceleration: ArrayLike = 0.0,
    ) -> RigidMotion:
        """Rigid motion of every link.

        Parameters
        ----------
        crank_angle, crank_speed, crank_acceleration : array_like
            Angle in rad, speed in rad/s, acceleration in rad/s^2; broadcast together.

        Returns
        -------
        RigidMotion

        Raises
        ------
        InputError
            Where the linkage cannot be assembled or locks; names the crank angle.
        """
        ...
