"""Stiffness and damping of what connects points of links, in the linkage's coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmech.linear_system.attached_points import AttachedPoint, MovedPoint
from flexmech.linear_system.connector_forces import Answer
from flexmech.linear_system.link_frames import LinkFrames
from flexmech.linkages import RigidMotion
from flexmech.types import FloatArray


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
