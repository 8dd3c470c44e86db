"""How a link end depends on the independent coordinates: rows of a link, and columns of those.

Each kind of tie gives the matrix from the columns to the rows over a batch of positions.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system.joints.rigid_coordinates import RigidCoordinates
from flexmech.linkages import RigidMotion, Topology
from flexmech.linkages.body_motion import BodyPoint
from flexmech.linkages.matrix_with_rates import MatrixWithRates


class MovingFrames:
    """Link frames and points of rigid links or lines over a batch of positions.

    Parameters
    ----------
    rigid : RigidCoordinates
    motion : RigidMotion
        Batch of shape (B,).
    """

    def __init__(self, rigid: RigidCoordinates, motion: RigidMotion) -> None:
        self.rigid, self.motion = rigid, motion
        self._points: dict[BodyPoint, MatrixWithRates] = {}

    @cached_property
    def coordinates(self) -> MatrixWithRates:
        """All coordinates of rigid links and sliders from the independent ones, (B, size, n)."""
        return self.rigid.dependence(self.motion)

    def point(self, point: BodyPoint) -> MatrixWithRates:
        """Displacement of a point in ground axes, (B, 2, n)."""
        if point not in self._points:
            rows = self.rigid.displacement_rows(self.motion, [point])
            self._points[point] = rows @ self.coordinates
        return self._points[point]

    def constant(self, matrix: FloatArray) -> MatrixWithRates:
        """One matrix in all positions."""
        return MatrixWithRates.constant(matrix, len(self.motion.angle))

    def rotation(self, link: int, leader: int | None = None) -> MatrixWithRates:
        """To the frame of a link from that of another, or from ground axes, (B, 2, 2)."""
        m = self.motion
        of_link = [own[:, link] for own in (m.angle, m.angular_velocity, m.angular_acceleration)]
        if leader is None:
            return MatrixWithRates.rotation(*(-own for own in of_link))
        others = (m.angle, m.angular_velocity, m.angular_acceleration)
        pairs = zip(others, of_link, strict=True)
        return MatrixWithRates.rotation(*(other[:, leader] - own for other, own in pairs))


# Speed and memory alone: an engine numbers the coordinates of its linkage several times.
@lru_cache(maxsize=16)
def general_frames(topology: Topology) -> MovingFrames:
    """Frames in a general position, whose zeros show which coordinates do not depend."""
    rigid = RigidCoordinates(topology)
    return MovingFrames(rigid, rigid.general_position)


@dataclass(frozen=True)
class Tie:
    """Rows of a link that depend on independent coordinates.

    Here all equal one column, as further rotations of a welded section do.

    Parameters
    ----------
    rows : ndarray of int, shape (r,)
        Coordinates of the link.
    columns : ndarray of int, shape (c,)
        Independent coordinates of the linkage.
    """

    rows: IntArray
    columns: IntArray

    def matrix(self, moving: MovingFrames, link: int) -> MatrixWithRates:
        """The rows of a link, by its number, from the columns, (B, r, c)."""
        return moving.constant(np.ones((len(self.rows), 1)))


@dataclass(frozen=True)
class RotatedEnd(Tie):
    """An end whose displacement is that of a flexible link's end, rotated.

    Parameters
    ----------
    rows, columns : ndarray of int, shape (2,)
    leader : int
        Number of that link.
    """

    leader: int

    def matrix(self, moving: MovingFrames, link: int) -> MatrixWithRates:
        """See :meth:`Tie.matrix`."""
        return moving.rotation(link, self.leader)


@dataclass(frozen=True)
class HubEnd(Tie):
    """An end on the hub of a free shaft.

    Parameters
    ----------
    rows, columns : ndarray of int, shape (2,), (c,)
    clamped : int
        Number of the link that is clamped to the hub.
    arm : ndarray, shape (2, c)
        Displacement in that link's frame from the columns.
    """

    clamped: int
    arm: FloatArray

    def matrix(self, moving: MovingFrames, link: int) -> MatrixWithRates:
        """See :meth:`Tie.matrix`."""
        return moving.rotation(link, self.clamped) @ moving.constant(self.arm)


@dataclass(frozen=True)
class PointEnd(Tie):
    """An end whose displacement is that of a rigid link's point or of a point on a line.

    Parameters
    ----------
    rows, columns : ndarray of int, shape (2,), (c,)
    point : BodyPoint
    """

    point: BodyPoint

    def matrix(self, moving: MovingFrames, link: int) -> MatrixWithRates:
        """See :meth:`Tie.matrix`."""
        return (moving.rotation(link) @ moving.point(self.point)).columns(self.columns)


@dataclass(frozen=True)
class RigidRows(Tie):
    """Rows that are coordinates of the rigid links.

    Parameters
    ----------
    rows, columns : ndarray of int, shape (r,), (c,)
    among : ndarray of int, shape (r,)
        Which of y.
    """

    among: IntArray

    def matrix(self, moving: MovingFrames, link: int) -> MatrixWithRates:
        """See :meth:`Tie.matrix`."""
        return moving.coordinates.rows(self.among).columns(self.columns)
