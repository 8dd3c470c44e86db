"""Forces of connectors on points of links, and how they answer displacements of these."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linear_system.joints.link_frames import LinkFrames
from flexmech.linear_system.loads.attached_points import AttachedPoint, MovedPoint
from flexmech.linkages import JointSpring, RigidMotion, Spring
from flexmech.linkages.applied_forces import SpringLine
from flexmech.mechanism import Mechanism


def acts_still(mechanism: Mechanism) -> bool:
    """Whether loads or springs act on a linkage that stands still."""
    loads = any(load.over != "time" for load in mechanism.loads)
    return bool(loads or mechanism.springs or mechanism.joint_springs)


@dataclass(frozen=True)
class PointForce:
    """Force of connectors on one point: ground axes (B, 2) and torque (B,)."""

    point: AttachedPoint
    force: FloatArray
    torque: FloatArray


@dataclass(frozen=True)
class Answer:
    """How a connector answers displacements of its two points, one of which may be the ground.

    Parameters
    ----------
    first, second : AttachedPoint or None
    stiffness, damping : ndarray, shape (B, 3, 3)
        By the displacement (ground axes) and rotation of the second against the first.
    in_joint : bool
        Whether it is that of the springs in a joint, whose radial force the joint carries.
    """

    first: AttachedPoint | None
    second: AttachedPoint | None
    stiffness: FloatArray
    damping: FloatArray
    in_joint: bool = False

    @classmethod
    def of_turning_force(cls, point: AttachedPoint, force: FloatArray) -> Self:
        """Of a force that turns with its link's section.

        Parameters
        ----------
        point : AttachedPoint
            Where it acts.
        force : ndarray, shape (B, 2)
            In ground axes.

        Returns
        -------
        Answer
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
        """Of a spring at its length.

        Parameters
        ----------
        first, second : AttachedPoint or None
            Its ends; None on the ground.
        spring : Spring
        line : SpringLine
            Of shape (B,); its relative velocity is that of the rigid motion.
        stressed : bool
            Whether that of the tension and of the rigid motion counts.

        Returns
        -------
        Answer
        """
        along = line.along
        stiffness, damping = np.zeros((2, len(along), 3, 3))
        lengthwise = along[:, :, None] * along[:, None]
        across = np.eye(2) - lengthwise
        stiffness[:, :2, :2] = spring.stiffness * lengthwise
        damping[:, :2, :2] = spring.damping * lengthwise
        if stressed:
            stiffness[:, :2, :2] += (line.tension / line.length)[:, None, None] * across
            turning = (across @ line.relative_velocity[..., None])[..., 0] / line.length[:, None]
            stiffness[:, :2, :2] += spring.damping * along[:, :, None] * turning[:, None]
        return cls(first, second, stiffness, damping)

    @classmethod
    def of_joint(
        cls, first: AttachedPoint | None, second: AttachedPoint, own: JointSpring, batch: int
    ) -> Self:
        """Of the springs and dampers in a joint.

        Parameters
        ----------
        first, second : AttachedPoint or None
            Ends of the leading and the following link.
        own : JointSpring
        batch : int
            Number of positions.

        Returns
        -------
        Answer
        """
        holds, damps = np.zeros((2, batch, 3, 3))
        holds[:] = np.diag([own.radial_stiffness or 0.0] * 2 + [own.torsional_stiffness])
        damps[:] = np.diag([own.radial_damping] * 2 + [own.torsional_damping])
        return cls(first, second, holds, damps, in_joint=True)


@dataclass(frozen=True)
class ConnectedMatrices:
    """What connectors add to a linkage whose points move by ``D(t) z``.

    Parameters
    ----------
    stiffness : ndarray, shape (B, n, n)
        ``D' K D``; not symmetric where forces follow what moves.
    damping : ndarray, shape (B, n, n)
        ``D' C D``.
    turning : ndarray, shape (B, n, n)
        ``D' C D'`` with the rate of D: what dampers answer to displacements because the frames
        turn. It stands beside the stiffness.
    is_conservative : bool
        Whether there is a potential: no dampers and no forces that follow.
    """

    stiffness: FloatArray
    damping: FloatArray
    turning: FloatArray
    is_conservative: bool

    @classmethod
    def of_stiffness(cls, stiffness: FloatArray) -> ConnectedMatrices:
        """A symmetric stiffness (B, n, n) alone."""
        nothing = np.zeros_like(stiffness)
        return cls(stiffness, nothing, nothing, is_conservative=True)

    def plus_stiffness(self, stiffness: FloatArray) -> ConnectedMatrices:
        """These with a symmetric stiffness (B, n, n) more."""
        return replace(self, stiffness=self.stiffness + stiffness)

    @property
    def potential(self) -> FloatArray:
        """Symmetric part of the stiffness, (B, n, n)."""
        return (self.stiffness + np.swapaxes(self.stiffness, 1, 2)) / 2

    @property
    def circulatory(self) -> FloatArray:
        """Skew part of the stiffness, (B, n, n), which has no potential."""
        return (self.stiffness - np.swapaxes(self.stiffness, 1, 2)) / 2


def connected_matrices(
    frames: LinkFrames, motion: RigidMotion, answers: Sequence[Answer], *, is_conservative: bool
) -> ConnectedMatrices:
    """Sum of what connectors answer.

    Parameters
    ----------
    frames : LinkFrames
    motion : RigidMotion
        Batch of shape (B,).
    answers : sequence of Answer
        Of points of the links of ``frames``, reduced or not.
    is_conservative : bool

    Returns
    -------
    ConnectedMatrices
        In the coordinates of ``frames``.
    """
    following = frames.dependent_rows(motion)
    maps: dict[tuple[int, float], MovedPoint] = {}

    def moved(point: AttachedPoint) -> MovedPoint:
        key = (point.link, point.x)
        if key not in maps:
            length = frames.topology.links[point.link].length
            own = AttachedPoint.of(frames.links, point.link, point.x / length, length)
            maps[key] = MovedPoint.of(own, frames, motion, following[point.link])
        return maps[key]

    batch, size = len(motion.crank_angle), frames.size
    stiffness, damping, turning = np.zeros((3, batch, size, size))
    for answer in answers:
        value, rate = np.zeros((2, batch, 3, size))
        for point, sign in ((answer.second, 1.0), (answer.first, -1.0)):
            if point is not None:
                value += sign * moved(point).value
                rate += sign * moved(point).rate
        across = np.swapaxes(value, 1, 2)
        stiffness += across @ (answer.stiffness @ value)
        if answer.damping.any():
            damping += across @ (answer.damping @ value)
            turning += across @ (answer.damping @ rate)
    return ConnectedMatrices(stiffness, damping, turning, is_conservative)
