"""Ties of links whose rigid links are displaced by finite amounts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flexmech.linear_system.joint_points import JointPoint
from flexmech.linear_system.rigid_pose import PoseStiffness, RigidPose
from flexmech.types import FloatArray, IntArray


@dataclass(frozen=True)
class PosedRows:
    """Rows of a link that follow, where the linkage is displaced.

    Parameters
    ----------
    rows, columns : ndarray of int, shape (r,), (c,)
        As of :class:`flexmech.linear_system.FollowingRows`.
    turn : ndarray, shape (B, r, c)
        Derivative of the rows by the columns.
    place : ndarray, shape (B, r), or None
        The rows themselves, where they are not linear in the columns.
    """

    rows: IntArray
    columns: IntArray
    turn: FloatArray
    place: FloatArray | None


@dataclass(frozen=True)
class PointRows:
    """Rows (r,) of a link that are the displacement of a point in the link's frame."""

    link: int
    rows: IntArray
    point: JointPoint


@dataclass(frozen=True)
class CoordinateRows:
    """Rows (r,) of a link that are coordinates ``among`` those of rigid links."""

    link: int
    rows: IntArray
    among: IntArray


class PosedTies:
    """Ties over a batch of positions at given coordinates of the rigid links.

    Parameters
    ----------
    pose : RigidPose
    rows : list of list of PosedRows
        For each link.
    at_points, at_coordinates : list
        What of the links leads to the rigid links and lines.
    """

    def __init__(
        self,
        pose: RigidPose,
        rows: list[list[PosedRows]],
        at_points: list[PointRows],
        at_coordinates: list[CoordinateRows],
    ) -> None:
        self.pose, self.rows = pose, rows
        self._at_points, self._at_coordinates = at_points, at_coordinates

    def link_displacement(
        self, z: FloatArray, targets: Sequence[IntArray], sizes: Sequence[int]
    ) -> list[FloatArray]:
        """Coordinates of each link.

        Parameters
        ----------
        z : ndarray, shape (B, size)
        targets : sequence of ndarray of int, shape (n_link,)
        sizes : sequence of int

        Returns
        -------
        list of ndarray, shape (B, n_link)
        """
        result = []
        for target, size, following in zip(targets, sizes, self.rows, strict=True):
            q, free = np.zeros((len(z), size)), target >= 0
            q[:, free] = z[:, target[free]]
            for led in following:
                q[:, led.rows] = (
                    (led.turn @ z[:, led.columns, None])[..., 0] if led.place is None else led.place
                )
            result.append(q)
        return result

    def stiffness(
        self, forces: Sequence[FloatArray], turning: Mapping[int, FloatArray]
    ) -> PoseStiffness:
        """Stiffness of rigid links and sliders from forces that keep their direction.

        Parameters
        ----------
        forces : sequence of ndarray, shape (B, n_link)
            Outer less inner ones on each link in its frame.
        turning : mapping of int to ndarray, shape (B,)
            Of each rigid link by its number: stiffness against its turn by what acts on it
            besides its joints, in N m/rad.

        Returns
        -------
        PoseStiffness
        """
        pose = self.pose
        motion, rigid = pose.motion, pose.rigid
        at_points: dict[JointPoint, FloatArray] = {}
        for led in self._at_points:
            force = forces[led.link][:, led.rows]
            angle = motion.angle[:, led.link, None]
            cosine, sine = np.cos(angle), np.sin(angle)
            x, y = force[:, :1], force[:, 1:]
            ground = np.concatenate([cosine * x - sine * y, sine * x + cosine * y], axis=1)
            at_points[led.point] = at_points.get(led.point, 0.0) + ground
        by_y = np.zeros_like(pose.y)
        for own in self._at_coordinates:
            for row, coordinate in zip(own.rows, own.among, strict=True):
                by_y[:, coordinate] += forces[own.link][:, row]
        by_link = np.zeros(motion.angle.shape)
        for link in rigid.links:
            by_link[:, link] = turning[link]
        return pose.stiffness(at_points, by_y, by_link)

    def matrix(self, stiffness: PoseStiffness) -> FloatArray:
        """A stiffness of the pose by the independent coordinates, (B, n, n)."""
        pose, rigid = self.pose, self.pose.rigid
        total = np.zeros((len(pose.y), rigid.size, rigid.size))
        for link in rigid.links:
            turn = rigid.of_link(link)[2]
            total[:, turn, turn] = stiffness.turning[:, link]
        for number, slider in enumerate(rigid.topology.sliders):
            if slider.guide:
                turn = rigid.of_link(rigid.topology.index(slider.guide))[2]
                slide = 3 * len(rigid.links) + number
                total[:, turn, slide] += stiffness.guiding[:, number]
                total[:, slide, turn] += stiffness.guiding[:, number]
        moved = pose.coordinates
        return np.asarray(np.swapaxes(moved, 1, 2) @ total @ moved)
