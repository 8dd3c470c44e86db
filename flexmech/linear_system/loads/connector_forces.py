"""Forces of connectors on points of links, with their stiffness and damping."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linear_system.joints.link_frames import LinkFrames
from flexmech.linear_system.loads.attached_points import AttachedPoint, PointJacobian
from flexmech.linkages import JointSpring, RigidMotion, Spring
from flexmech.linkages.applied_forces import SpringLine
from flexmech.mechanism import Mechanism


def acts_at_rest(mechanism: Mechanism) -> bool:
    """Whether loads or springs act on the linkage at rest."""
    loads = any(load.over != "time" for load in mechanism.loads)
    return bool(loads or mechanism.springs or mechanism.joint_springs)


@dataclass(frozen=True)
class PointForce:
    """Force of a connector on a point in ground axes, (B, 2), and torque (B,)."""

    point: AttachedPoint
    force: FloatArray
    torque: FloatArray


@dataclass(frozen=True)
class ConnectorTangent:
    """Tangent stiffness and damping of a connector between two points or a point and the ground.

    Parameters
    ----------
    first, second : AttachedPoint or None
    stiffness, damping : ndarray, shape (B, 3, 3)
        By the displacement (ground axes) and rotation of the second against the first.
    in_joint : bool
        Whether it belongs to springs in a joint, whose radial force is the joint force.
    """

    first: AttachedPoint | None
    second: AttachedPoint | None
    stiffness: FloatArray
    damping: FloatArray
    in_joint: bool = False

    @classmethod
    def of_follower_force(cls, point: AttachedPoint, force: FloatArray) -> Self:
        """Stiffness of a follower force, which rotates with its link's section.

        Parameters
        ----------
        point : AttachedPoint
            Where it acts.
        force : ndarray, shape (B, 2)
            In ground axes.

        Returns
        -------
        ConnectorTangent
        """
        turned = np.zeros((len(force), 3, 3))
        turned[:, 0, 2], turned[:, 1, 2] = force[:, 1], -force[:, 0]
        return cls(None, point, turned, np.zeros_like(turned))

    @classmethod
    def of_spring(
        cls,
        first: AttachedPoint | None,
        second: AttachedPoint | None,
        spring: Spring,
        line: SpringLine,
        *,
        stressed: bool,
    ) -> Self:
        """Stiffness and damping of a spring at its length.

        Parameters
        ----------
        first, second : AttachedPoint or None
            Its ends; None on the ground.
        spring : Spring
        line : SpringLine
            Of shape (B,); its relative velocity is that of the rigid motion.
        stressed : bool
            Whether the parts by its tension and by the rigid motion are included.

        Returns
        -------
        ConnectorTangent
        """
        along = line.along
        stiffness, damping = np.zeros((2, len(along), 3, 3))
        lengthwise = along[:, :, None] * along[:, None]
        across = np.eye(2) - lengthwise
        stiffness[:, :2, :2] = spring.stiffness * lengthwise
        damping[:, :2, :2] = spring.damping * lengthwise
        if stressed:
            stiffness[:, :2, :2] += (line.tension / line.length)[:, None, None] * across
            swing = (across @ line.relative_velocity[..., None])[..., 0] / line.length[:, None]
            stiffness[:, :2, :2] += spring.damping * along[:, :, None] * swing[:, None]
        return cls(first, second, stiffness, damping)

    @classmethod
    def of_joint(
        cls, first: AttachedPoint | None, second: AttachedPoint, own: JointSpring, batch: int
    ) -> Self:
        """Stiffness and damping of the springs and dampers in a joint.

        Parameters
        ----------
        first, second : AttachedPoint or None
            Ends of the leading and the following link.
        own : JointSpring
        batch : int
            Number of positions.

        Returns
        -------
        ConnectorTangent
        """
        stiffness, damping = np.zeros((2, batch, 3, 3))
        stiffness[:] = np.diag([own.radial_stiffness or 0.0] * 2 + [own.torsional_stiffness])
        damping[:] = np.diag([own.radial_damping] * 2 + [own.torsional_damping])
        return cls(first, second, stiffness, damping, in_joint=True)


@dataclass(frozen=True)
class ConnectedMatrices:
    """Stiffness and damping of connectors on points displaced by ``D(t) z``.

    Parameters
    ----------
    stiffness : ndarray, shape (B, n, n)
        ``D' K D``; not symmetric with follower forces.
    damping : ndarray, shape (B, n, n)
        ``D' C D``.
    rate_stiffness : ndarray, shape (B, n, n)
        ``D' C D'`` with the rate of D: stiffness by dampers, since the frames rotate. It is added
        to the stiffness.
    is_conservative : bool
        Whether there is a potential: no dampers and no follower forces.
    """

    stiffness: FloatArray
    damping: FloatArray
    rate_stiffness: FloatArray
    is_conservative: bool

    @classmethod
    def of_stiffness(cls, stiffness: FloatArray) -> ConnectedMatrices:
        """Matrices of a symmetric stiffness (B, n, n) alone."""
        nothing = np.zeros_like(stiffness)
        return cls(stiffness, nothing, nothing, is_conservative=True)

    def plus_stiffness(self, stiffness: FloatArray) -> ConnectedMatrices:
        """The matrices with a symmetric stiffness (B, n, n) added."""
        return replace(self, stiffness=self.stiffness + stiffness)

    @property
    def potential(self) -> FloatArray:
        """Symmetric part of the stiffness, which has a potential, (B, n, n)."""
        return (self.stiffness + np.swapaxes(self.stiffness, 1, 2)) / 2

    @property
    def circulatory(self) -> FloatArray:
        """Skew part of the stiffness, (B, n, n): circulatory forces, without a potential."""
        return (self.stiffness - np.swapaxes(self.stiffness, 1, 2)) / 2


def connected_matrices(
    frames: LinkFrames,
    motion: RigidMotion,
    tangents: Sequence[ConnectorTangent],
    *,
    is_conservative: bool,
) -> ConnectedMatrices:
    """Assemble stiffness and damping of connectors.

    Parameters
    ----------
    frames : LinkFrames
    motion : RigidMotion
        Batch of shape (B,).
    tangents : sequence of ConnectorTangent
        Of points of the links of ``frames``, reduced or not.
    is_conservative : bool

    Returns
    -------
    ConnectedMatrices
        In the coordinates of ``frames``.
    """
    dependent = frames.dependent_rows(motion)
    maps: dict[tuple[int, float], PointJacobian] = {}

    def moved(point: AttachedPoint) -> PointJacobian:
        key = (point.link, point.x)
        if key not in maps:
            length = frames.topology.links[point.link].length
            own = AttachedPoint.of(frames.links, point.link, point.x / length, length)
            maps[key] = PointJacobian.of(own, frames, motion, dependent[point.link])
        return maps[key]

    batch, size = len(motion.crank_angle), frames.size
    stiffness, damping, rate_stiffness = np.zeros((3, batch, size, size))
    for tangent in tangents:
        value, rate = np.zeros((2, batch, 3, size))
        for point, sign in ((tangent.second, 1.0), (tangent.first, -1.0)):
            if point is not None:
                value += sign * moved(point).value
                rate += sign * moved(point).rate
        across = np.swapaxes(value, 1, 2)
        stiffness += across @ (tangent.stiffness @ value)
        if tangent.damping.any():
            damping += across @ (tangent.damping @ value)
            rate_stiffness += across @ (tangent.damping @ rate)
    return ConnectedMatrices(stiffness, damping, rate_stiffness, is_conservative)
