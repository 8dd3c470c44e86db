"""Forces of connectors on points of links, and how they answer displacements of these."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from flexmech.linear_system.attached_points import AttachedPoint
from flexmech.linkages import JointSpring, Spring
from flexmech.linkages.applied_forces import SpringLine
from flexmech.mechanism import Mechanism
from flexmech.types import FloatArray


def acts_still(mechanism: Mechanism) -> bool:
    """Whether loads or springs act on a linkage that stands still."""
    loads = any(load.over != "time" for load in mechanism.loads)
    return bool(loads or mechanism.springs or mechanism.joint_springs)


@dataclass(frozen=True)
class Push:
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
class SpringEnd:
    """Where an end of a spring is.

    Parameters
    ----------
    point : AttachedPoint or None
        None on the ground.
    place, velocity : ndarray, shape (B, 2)
        In ground axes; the velocity is that of the rigid motion.
    """

    point: AttachedPoint | None
    place: FloatArray
    velocity: FloatArray


@dataclass(frozen=True)
class SpringState:
    """A spring at its length.

    Parameters
    ----------
    first, second : AttachedPoint or None
        Its ends; None on the ground.
    line : SpringLine
        Of shape (B,); its relative velocity is that of the rigid motion.
    """

    first: AttachedPoint | None
    second: AttachedPoint | None
    line: SpringLine

    def answer(self, spring: Spring, *, stressed: bool) -> Answer:
        """Stiffness and damping; that of the tension and of the rigid motion if ``stressed``."""
        line, along = self.line, self.line.along
        stiffness, damping = np.zeros((2, len(line.length), 3, 3))
        lengthwise = along[:, :, None] * along[:, None]
        across = np.eye(2) - lengthwise
        stiffness[:, :2, :2] = spring.stiffness * lengthwise
        damping[:, :2, :2] = spring.damping * lengthwise
        if stressed:
            stiffness[:, :2, :2] += (line.tension / line.length)[:, None, None] * across
            turning = (across @ line.relative_velocity[..., None])[..., 0] / line.length[:, None]
            stiffness[:, :2, :2] += spring.damping * along[:, :, None] * turning[:, None]
        return Answer(self.first, self.second, stiffness, damping)
