"""How the frames of links and the points that rigid links lead move over a batch of positions."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from flexmech.linear_system.joint_points import JointPoint
from flexmech.linkages.matrix_with_rates import MatrixWithRates as MovingMatrix
from flexmech.linear_system.rigid_coordinates import RigidCoordinates
from flexmech.linkages import RigidMotion
from flexmech.types import IntArray


class MovingFrames:
    """Matrices of one batch of positions, made when they are first asked for.

    Parameters
    ----------
    rigid : RigidCoordinates
    motion : RigidMotion
        Batch of shape (B,).
    """

    def __init__(self, rigid: RigidCoordinates, motion: RigidMotion) -> None:
        self.motion = motion
        self._rigid = rigid
        self._points: dict[JointPoint, MovingMatrix] = {}

    @cached_property
    def coordinates(self) -> MovingMatrix:
        """All coordinates of rigid links and sliders from the independent ones, (B, size, n)."""
        return self._rigid.moving(self.motion)

    def point(self, point: JointPoint) -> MovingMatrix:
        """Displacement of a point that rigid links or a line lead in ground axes, (B, 2, n)."""
        if point not in self._points:
            displaced = self._rigid.point(self.motion, point)
            assert displaced is not None
            self._points[point] = displaced @ self.coordinates
        return self._points[point]

    def to_frame(self, link: int) -> MovingMatrix:
        """From ground axes to the frame of a link, (B, 2, 2)."""
        motion = self.motion
        return MovingMatrix.rotation(
            -motion.angle[:, link],
            -motion.angular_velocity[:, link],
            -motion.angular_acceleration[:, link],
        )

    def turned(self, leader: int, link: int) -> MovingMatrix:
        """From the frame of one link to that of another, (B, 2, 2)."""
        motion = self.motion
        return MovingMatrix.rotation(
            motion.angle[:, leader] - motion.angle[:, link],
            motion.angular_velocity[:, leader] - motion.angular_velocity[:, link],
            motion.angular_acceleration[:, leader] - motion.angular_acceleration[:, link],
        )

    def columns(self, matrix: MovingMatrix) -> IntArray:
        """Which of the independent coordinates a matrix in a general position depends on."""
        return np.flatnonzero(self._rigid.moves(matrix))
