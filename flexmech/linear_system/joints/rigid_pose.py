"""Finite displacements of rigid links and sliders.

The point r of a rigid link is at ``u + R(phi) r``: it is not linear in the rotation, and the
position constraints between rigid links are solved by Newton's method. A dead load F at r has the
geometric stiffness ``F . R(phi) r`` against the rotation, be it an inertia force, a weight or the
force of a joint. A bar in tension P has ``P / L`` between its ends.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from flexmech.arrays import ComplexArray, FloatArray, IntArray
from flexmech.linear_system.joints.joint_coordinates import DisplacedMotion, JointCoordinates
from flexmech.linkages import RigidMotion
from flexmech.linkages.body_motion import BodyMotion, BodyPoint

# Newton's method takes five to eight from the straight linkage; more is no position near it.
ITERATIONS = 30
# Of conditions in m, to the size of the longest link, and of angles in rad: fifty times the unit
# round-off. Where it stays above that, as far as it comes is enough if it closes to the second.
CLOSED, NEARLY_CLOSED = 1e-14, 1e-9


@dataclass(frozen=True)
class RigidGeometricStiffness:
    """Geometric stiffness of rigid links and sliders under dead loads and joint forces.

    Parameters
    ----------
    rotation_stiffness : ndarray, shape (B, n_links)
        Of each rigid link by its rotation in N m/rad; of a flexible one that of its hub.
    guide_stiffness : ndarray, shape (B, n_sliders)
        Between the rotation of a slider's guide and its slide in N/rad; zero on the ground.
    """

    rotation_stiffness: FloatArray
    guide_stiffness: FloatArray

    def projected(self, joints: JointCoordinates, dependence: FloatArray) -> FloatArray:
        """Geometric stiffness by the independent coordinates of rigid links and sliders, (B, n, n).

        Parameters
        ----------
        joints : JointCoordinates
        dependence : ndarray, shape (B, size, m)
            Derivative of y by w.
        """
        dependence = dependence[:, :, : len(joints.independent_coordinates)]
        total = np.zeros((len(dependence), joints.size, joints.size))
        for link in joints.links:
            turn = joints.of_link(link)[2]
            total[:, turn, turn] = self.rotation_stiffness[:, link]
        for number, (slide, slider) in enumerate(
            zip(joints.slides, joints.topology.sliders, strict=True)
        ):
            if slider.guide:
                turn = joints.of_link(joints.topology.index(slider.guide))[2]
                total[:, turn, slide] = total[:, slide, turn] = self.guide_stiffness[:, number]
        return np.asarray(np.swapaxes(dependence, 1, 2) @ total @ dependence)


class RigidPose:
    """Rigid links and sliders at given finite coordinates.

    Parameters
    ----------
    rigid : JointCoordinates
    motion : RigidMotion
        Batch of shape (B,), not displaced.
    y : ndarray, shape (B, size)
        Coordinates of ``rigid``: displacements in the frames of the rigid motion, finite
        rotations, slides; zero of ends of elastic links.
    """

    def __init__(self, rigid: JointCoordinates, motion: RigidMotion, y: FloatArray) -> None:
        self.rigid, self.motion, self.y = rigid, motion, y
        turn = np.zeros((len(y), len(rigid.topology.links)))
        turn[:, list(rigid.links)] = y[:, 2 : 3 * len(rigid.links) : 3]
        self.displaced = DisplacedMotion.of(motion, turn, y[:, rigid.slides])

    @classmethod
    def solve_position_constraints(
        cls, rigid: JointCoordinates, motion: RigidMotion, w: FloatArray
    ) -> Self:
        """Rigid links and sliders at given independent coordinates, by Newton's method.

        Parameters
        ----------
        rigid : JointCoordinates
        motion : RigidMotion
            Batch of shape (B,).
        w : ndarray, shape (B, n)
            Where no position satisfies the constraints, coordinates of the pose are not a number.
        """
        y = np.zeros((len(w), rigid.size))
        y[:, rigid.independent_coordinates] = w
        pose = cls(rigid, motion, y)
        if not len(rigid.dependent_coordinates):
            return pose
        rigid.refuse_locked(motion, pose.jacobian[:, :, rigid.dependent_coordinates])
        length = max(link.length for link in rigid.topology.links)
        for _ in range(ITERATIONS):
            gap = pose._gap()
            if np.nanmax(np.abs(gap), initial=0.0) <= CLOSED * max(1.0, length):
                return pose
            across = pose.jacobian[:, :, rigid.dependent_coordinates]
            y = y.copy()
            y[:, rigid.dependent_coordinates] -= np.linalg.solve(across, gap[..., None])[..., 0]
            pose = cls(rigid, motion, y)
        closed = np.abs(pose._gap()).max(axis=1) <= NEARLY_CLOSED * length
        y = np.where(closed[:, None], y, np.nan)
        return cls(rigid, motion, y)

    def displacement(self, points: Sequence[BodyPoint]) -> FloatArray:
        """Displacement of points of rigid links or of lines in ground axes, (B, P, 2)."""
        own = self.rigid.constraints.points(points)
        moved = own.places(*self.after) - own.places(*self.before)
        return np.stack([moved.real, moved.imag], axis=-1)

    def rows(self, points: Sequence[BodyPoint]) -> FloatArray:
        """Jacobian of the displacement of points by y, (B, 2 P, size)."""
        bodies, slid = self.after
        own = self.rigid.constraints.points(points)
        return own.jacobian(bodies, self.before[0].turn, slid)

    @cached_property
    def coordinates(self) -> FloatArray:
        """Derivative of all coordinates y by w, (B, size, n)."""
        return self.rigid.finite_dependence(self.jacobian)

    def _gap(self) -> FloatArray:
        """Violation of the constraints that determine the dependent coordinates."""
        constraints = self.rigid.constraints
        gap = constraints.gap(*self.after) - constraints.gap(*self.before)
        return (gap + constraints.angle_gaps(self.y))[:, self.rigid.rows]

    @cached_property
    def jacobian(self) -> FloatArray:
        """Constraint Jacobian by y, (B, conditions, size)."""
        bodies, slid = self.after
        jacobian = self.rigid.constraints.jacobian(bodies, self.before[0].turn, slid)
        return jacobian[:, self.rigid.rows]

    @cached_property
    def before(self) -> tuple[BodyMotion, ComplexArray]:
        """Undisplaced bodies about their reference points, and slider positions on them."""
        bodies, slid = self.rigid.bodies(self.motion)
        return bodies, slid[0]

    @cached_property
    def after(self) -> tuple[BodyMotion, ComplexArray]:
        """Displaced bodies about their former reference points, and slider positions on them."""
        bodies, slid = self.rigid.bodies(self.displaced)
        place, links = np.zeros_like(bodies.place), list(self.rigid.links)
        u, v = (self.y[:, first : 3 * len(links) : 3] for first in (0, 1))
        place[:, links] = self.before[0].turn[:, links] * (u + 1j * v)
        return replace(bodies, place=place), slid[0]


@dataclass(frozen=True)
class DisplacedRows:
    """Dependent rows of a link at finite displacements.

    Parameters
    ----------
    rows, columns : ndarray of int, shape (r,), (c,)
        As of :class:`flexmech.linear_system.DependentRows`.
    turn : ndarray, shape (B, r, c)
        Derivative of the rows by the columns.
    place : ndarray, shape (B, r), or None
        The dependent coordinates, where they are not linear in the columns.
    """

    rows: IntArray
    columns: IntArray
    turn: FloatArray
    place: FloatArray | None


@dataclass(frozen=True)
class DisplacedTies:
    """Constraints over a batch of positions at finite displacements of the rigid links.

    Parameters
    ----------
    pose : RigidPose
    rows : list of list of DisplacedRows
        For each link.
    at_points, at_coordinates : list of tuple
        Number of a link, rows (r,) of it, and the point on which forces on them act, or the
        coordinates (r,) of rigid links and ends that the rows are.
    """

    pose: RigidPose
    rows: list[list[DisplacedRows]]
    at_points: Sequence[tuple[int, IntArray, BodyPoint]]
    at_coordinates: Sequence[tuple[int, IntArray, IntArray]]

    def geometric_stiffness(
        self, forces: Sequence[FloatArray], rotation_stiffness: Mapping[int, FloatArray]
    ) -> RigidGeometricStiffness:
        """Geometric stiffness of rigid links, hubs and sliders by dead loads and joint forces.

        Parameters
        ----------
        forces : sequence of ndarray, shape (B, n_link)
            Applied less internal forces on each link in its frame.
        rotation_stiffness : mapping of int to ndarray, shape (B,)
            Of each rigid link by its number: stiffness by its rotation of all forces but those of
            its joints, in N m/rad.

        Returns
        -------
        RigidGeometricStiffness
        """
        pose, total = self.pose, np.zeros_like(self.pose.y)
        motion, rigid, (bodies, slid) = pose.motion, pose.rigid, pose.after
        for link, rows, among in self.at_coordinates:
            for row, coordinate in zip(rows, among, strict=True):
                total[:, coordinate] += forces[link][:, row]
        by_rotation, guide_stiffness = np.zeros(motion.angle.shape), np.zeros(slid.shape)
        for link in rigid.links:
            by_rotation[:, link] = rotation_stiffness[link]
        stiffnesses = []
        if self.at_points:
            vectors = [
                (forces[link][:, rows[0]] + 1j * forces[link][:, rows[1]])
                * np.exp(1j * motion.angle[:, link])
                for link, rows, _ in self.at_points
            ]
            given = np.stack(vectors, axis=1)
            points = rigid.constraints.points([point for _, _, point in self.at_points])
            jacobian = points.jacobian(bodies, pose.before[0].turn, slid)
            total += np.einsum("bpi,bp->bi", jacobian[:, ::2], given.real)
            total += np.einsum("bpi,bp->bi", jacobian[:, 1::2], given.imag)
            stiffnesses.append(points.geometric_stiffness(bodies, slid, given))
        if len(dependent := rigid.dependent_coordinates):
            across = np.swapaxes(pose.jacobian[:, :, dependent], 1, 2)
            joints = np.zeros((len(total), rigid.constraints.count))
            joints[:, rigid.rows] = -np.linalg.solve(across, total[:, dependent, None])[..., 0]
            stiffnesses.append(rigid.constraints.geometric_stiffness(bodies, slid, joints))
        for by_arm, by_line in stiffnesses:
            by_rotation += rigid.by_links(by_arm)
            guide_stiffness += by_line
        return RigidGeometricStiffness(by_rotation, guide_stiffness)

    def matrix(self, stiffness: RigidGeometricStiffness) -> FloatArray:
        """Geometric stiffness by the independent coordinates, (B, n, n)."""
        return stiffness.projected(self.pose.rigid, self.pose.coordinates)
