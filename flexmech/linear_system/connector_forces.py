"""Forces of connectors on points of links, and how they answer displacements of these."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.linear_system.attached_points import AttachedPoint
from flexmech.linkages import Spring
from flexmech.linkages.spring_line import SpringLine
from flexmech.types import FloatArray

__all__ = ["Answer", "Push", "SpringEnd", "SpringState"]


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
