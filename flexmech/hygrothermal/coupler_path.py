"""The path of a coupler point of a linkage in heat and water."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.hygrothermal.in_state import coupler_point_in_state, linkage_in_state
from flexmech.hygrothermal.state import State
from flexmech.linkages import (
    CouplerCurve,
    CouplerPoint,
    DoublePoint,
    FourBar,
    coupler_sextic,
    double_points,
)
from flexmech.mechanism import Mechanism
from flexmech.types import FloatArray

__all__ = ["CouplerPath", "coupler_path"]


@dataclass(frozen=True)
class CouplerPath:
    """A coupler point's path over crank angles, of a rigid linkage.

    Parameters
    ----------
    linkage : FourBar
        With its lengths in the state.
    point : CouplerPoint
        On the coupler in the state.
    crank_angle : ndarray, shape (A,)
        In rad.
    double_points : tuple of DoublePoint
        Crunodes and cusps of the whole curve, whatever the crank angles.
    """

    linkage: FourBar
    point: CouplerPoint
    crank_angle: FloatArray
    double_points: tuple[DoublePoint, ...]

    @property
    def position(self) -> FloatArray:
        """Places of the point in m, (A, 2)."""
        return CouplerCurve(self.linkage, self.point).position(self.crank_angle)

    @property
    def pins(self) -> FloatArray:
        """Places of A and B in m, (A, 2, 2)."""
        motion = self.linkage.motion(self.crank_angle)
        crank, rocker = self.linkage.crank, self.linkage.rocker
        return np.stack([motion.position(0, crank), motion.position(2, rocker)], axis=1)

    @property
    def angles(self) -> FloatArray:
        """Angles theta3 and theta4 of coupler and rocker in rad, without jumps, (A, 2)."""
        return np.unwrap(self.linkage.motion(self.crank_angle).angle[:, 1:], axis=0)

    @property
    def sextic_residual(self) -> float:
        """Greatest residual of the curve's equation at its points; zero but for rounding."""
        return float(np.abs(coupler_sextic(self.linkage, self.point, self.position)).max())

    def count(self, kind: str) -> int:
        """Number of double points of a kind, ``"crunode"`` or ``"cusp"``."""
        return sum(double.kind == kind for double in self.double_points)

    def passages(self, double: DoublePoint) -> tuple[float, float]:
        """Crank angles of both passages of a double point in rad, by the shorter way.

        Parameters
        ----------
        double : DoublePoint

        Returns
        -------
        tuple of float
            The first below zero where the way leads through crank angle zero.
        """
        first, second = (float(angle) for angle in double.crank_angles)
        return (second - 2 * np.pi, first) if second - first > np.pi else (first, second)


def coupler_path(
    mechanism: Mechanism, point: CouplerPoint, state: State, crank_angle: FloatArray
) -> CouplerPath:
    """Path of a coupler point in a state.

    Parameters
    ----------
    mechanism : Mechanism
        Of a four-bar, dry.
    point : CouplerPoint
        On the dry coupler.
    state : HygrothermalState or Exposure
    crank_angle : ndarray, shape (A,)
        In rad.

    Returns
    -------
    CouplerPath

    Raises
    ------
    InputError
        If the linkage is no four-bar, cannot be assembled at a crank angle, or as
        :func:`flexmech.hygrothermal.swollen_links`.
    """
    linkage = linkage_in_state(mechanism, state)
    moved = coupler_point_in_state(mechanism, point, state)
    linkage.motion(crank_angle)  # refuses angles that the linkage does not reach
    found = double_points(linkage, moved, float(crank_angle[0]))
    return CouplerPath(linkage, moved, crank_angle, found)
