"""Forces of connectors on points of links, and how they answer displacements of these."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexmech.errors import InputError
from flexmech.linear_system.attached_points import AttachedPoint
from flexmech.linkages import RigidMotion, Spring
from flexmech.types import FloatArray

__all__ = ["Answer", "Push", "SpringEnd", "SpringState"]

# Of the longest link: the ends of a spring that are nearer have met.
MET = 1e-9


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
    """

    first: AttachedPoint | None
    second: AttachedPoint | None
    stiffness: FloatArray
    damping: FloatArray


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
    along : ndarray, shape (B, 2)
        Direction from the first to the second.
    length : ndarray, shape (B,)
    approach : ndarray, shape (B, 2)
        Velocity of the second against the first in the rigid motion.
    tension : ndarray, shape (B,)
    """

    first: AttachedPoint | None
    second: AttachedPoint | None
    along: FloatArray
    length: FloatArray
    approach: FloatArray
    tension: FloatArray

    @classmethod
    def of(
        cls,
        spring: Spring,
        motion: RigidMotion,
        ends: Sequence[SpringEnd],
        size: float,
    ) -> SpringState:
        """State of a spring.

        Parameters
        ----------
        spring : Spring
        motion : RigidMotion
            Batch of shape (B,).
        ends : sequence of SpringEnd
            Its first and its second.
        size : float
            Of the linkage in m.

        Raises
        ------
        InputError
            Where the ends meet; names the crank angle.
        """
        line, approach = ends[1].place - ends[0].place, ends[1].velocity - ends[0].velocity
        length = np.linalg.norm(line, axis=1)
        met = length <= MET * size
        if np.any(met):
            angle = np.degrees(motion.crank_angle[met][0])
            raise InputError(
                f"spring {spring.name}: its ends meet at crank angle {angle:.6g} deg, where its "
                "force has no direction; move an end, or leave that crank angle out"
            )
        along = line / length[:, None]
        tension = spring.stiffness * (length - spring.free_length)
        tension = tension + spring.damping * np.sum(along * approach, axis=1)
        return cls(ends[0].point, ends[1].point, along, length, approach, tension)

    def answer(self, spring: Spring, *, stressed: bool) -> Answer:
        """Stiffness and damping; that of the tension and of the rigid motion if ``stressed``."""
        batch = len(self.length)
        stiffness, damping = np.zeros((2, batch, 3, 3))
        line = self.along[:, :, None] * self.along[:, None]
        across = np.eye(2) - line
        stiffness[:, :2, :2] = spring.stiffness * line
        damping[:, :2, :2] = spring.damping * line
        if stressed:
            stiffness[:, :2, :2] += (self.tension / self.length)[:, None, None] * across
            turning = (across @ self.approach[..., None])[..., 0] / self.length[:, None]
            stiffness[:, :2, :2] += spring.damping * self.along[:, :, None] * turning[:, None]
        return Answer(self.first, self.second, stiffness, damping)
