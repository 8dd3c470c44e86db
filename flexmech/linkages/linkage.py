"""What every linkage offers, whatever its kind."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Protocol, Self

from numpy.typing import ArrayLike

from flexmech.linkages.motion import RigidMotion
from flexmech.linkages.topology import Topology
from flexmech.model_text import TomlTable


class Linkage(Protocol):
    """A rigid linkage of one degree of freedom, driven by its crank."""

    @property
    def kind(self) -> str:
        """Its name in model files, such as ``"four-bar"``."""
        ...

    @property
    def topology(self) -> Topology:
        """Links and connections."""
        ...

    def resized(self, lengths: Mapping[str, float], ground_growth: float) -> Self:
        """The linkage with links of other lengths, as after swelling.

        Parameters
        ----------
        lengths : mapping of str to float
            New length in m of each link of the topology.
        ground_growth : float
            New over old size of what the links are mounted to.

        Returns
        -------
        Linkage
        """
        ...

    def sprung_at(self, joints: Collection[str]) -> Self:
        """The linkage with springs alone holding these joints, and no others.

        Parameters
        ----------
        joints : collection of str
            Pins or pivots.

        Returns
        -------
        Linkage
        """
        ...

    def described(self) -> list[str]:
        """Lines that say what was understood: kind, lengths, range of motion."""
        ...

    def to_table(self) -> TomlTable:
        """Table ``[linkage]`` of a model file."""
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
