"""Inertial terms of rotating frames, and the system matrices that contain them."""

from __future__ import annotations

from dataclasses import dataclass

from flexmech.arrays import FloatArray
from flexmech.linear_system.links.chains import LinkMatrix, in_positions, whole


@dataclass(frozen=True)
class RotationTerms:
    """Selection of the inertial terms of the rotating frames.

    Parameters
    ----------
    coriolis : bool
        Velocity-proportional terms: ``2 M_d`` and ``2 M_vel``, and ``N'D Ndot``, which damped
        links add to the stiffness where a pin turns.
    centripetal : bool
        Terms in squares and products of angular velocities: ``M_acc``, ``M_dd``,
        ``2 M_d,vel``.
    tangential : bool
        Terms in angular accelerations of ``M_acc`` and ``M_dd``.
    """

    coriolis: bool = True
    centripetal: bool = True
    tangential: bool = True

    @classmethod
    def all_or_none(cls, wanted: bool) -> RotationTerms:
        """All terms, or the frozen inertial form."""
        return cls(wanted, wanted, wanted)

    @property
    def any(self) -> bool:
        """Whether any term is included."""
        return self.coriolis or self.centripetal or self.tangential


@dataclass(frozen=True)
class SystemMatrices:
    """Mass, damping and stiffness over a batch; each of shape (B, n, n)."""

    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray


@dataclass(frozen=True)
class LinkDamping:
    """Damping of one link in its state of stress.

    Parameters
    ----------
    matrix : ndarray, shape (n, n) or (B, n, n)
    ends : ndarray, shape (n, n) or (B, n, n)
        Forces from the rate of the joined ends alone; see
        :class:`flexmech.linear_system.links.link_model.EndMatrices`.
    """

    matrix: LinkMatrix
    ends: LinkMatrix

    def at(self, which: slice) -> LinkDamping:
        """Damping in some positions; constant matrices stay."""
        return LinkDamping(in_positions(self.matrix, which), in_positions(self.ends, which))

    def whole(self) -> tuple[FloatArray, FloatArray]:
        """Both as full matrices."""
        return whole(self.matrix), whole(self.ends)
