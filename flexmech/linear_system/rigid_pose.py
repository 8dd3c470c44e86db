"""Rigid links and sliders that are displaced by finite amounts.

The place of a point at r of a rigid link is ``u + R(phi) r``: it is not linear in the rotation,
and the ties of rigid links among themselves are conditions that Newton's method satisfies. Forces
that keep their direction while the links turn are springs against rotation: the force F at r has
the stiffness ``F . R(phi) r``, be it an inertia force, a weight or the force of a joint. A bar in
tension P gets ``P / L`` between its ends.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from flexmech.linear_system.displaced_motion import DisplacedMotion
from flexmech.linear_system.joint_points import JointPoint
from flexmech.linear_system.rigid_coordinates import RigidCoordinates
from flexmech.linkages import LinkEnd, RigidMotion
from flexmech.linkages.motion import direction, normal
from flexmech.types import FloatArray

ITERATIONS = 30
# Of conditions in m, to the size of the longest link, and of angles in rad.
CLOSED = 1e-14


@dataclass(frozen=True)
class PoseStiffness:
    """Stiffness of rigid links and sliders from forces that keep their direction.

    Parameters
    ----------
    turning : ndarray, shape (B, n_links)
        Of each rigid link against its rotation in N m/rad; zero of flexible ones.
    guiding : ndarray, shape (B, n_sliders)
        Between the rotation of a slider's guide and its slide, in N/rad; zero on the ground.
    """

    turning: FloatArray
    guiding: FloatArray


class RigidPose:
    """Rigid links and sliders at given coordinates.

    Parameters
    ----------
    rigid : RigidCoordinates
    motion : RigidMotion
        Batch of shape (B,), not displaced.
    y : ndarray, shape (B, size)
        Coordinates of ``rigid``: displacements in the frames of the rigid motion, finite
        rotations, slides.
    """

    def __init__(self, rigid: RigidCoordinates, motion: RigidMotion, y: FloatArray) -> None:
        self.rigid, self.motion, self.y = rigid, motion, y
        count = len(rigid.links)
        turn = np.zeros((len(y), len(rigid.topology.links)))
        turn[:, list(rigid.links)] = y[:, 2 : 3 * count : 3]
        self.displaced = DisplacedMotion.of(motion, turn, y[:, 3 * count :])

    @classmethod
    def settled(cls, rigid: RigidCoordinates, motion: RigidMotion, w: FloatArray) -> Self:
        """Rigid links and sliders at given independent coordinates, by Newton's method.

        Parameters
        ----------
        rigid : RigidCoordinates
        motion : RigidMotion
            Batch of shape (B,).
        w : ndarray, shape (B, n)
            Where no place satisfies the ties, those of the pose are out of reach: not a number.
        """
        y = np.zeros((len(w), rigid.size))
        y[:, rigid.independent] = w
        pose = cls(rigid, motion, y)
        if not len(rigid.dependent):
            return pose
        rigid.refuse_locked(motion, pose._conditions[:, :, rigid.dependent])
        length = max(link.length for link in rigid.topology.links)
        for _ in range(ITERATIONS):
            gap = rigid.gaps(pose.point, y)
            if np.nanmax(np.abs(gap), initial=0.0) <= CLOSED * max(1.0, length):
                return pose
            across = pose._conditions[:, :, rigid.dependent]
            y = y.copy()
            y[:, rigid.dependent] -= np.linalg.solve(across, gap[..., None])[..., 0]
            pose = cls(rigid, motion, y)
        gap = np.abs(rigid.gaps(pose.point, y)).max(axis=1)
        y = np.where((gap <= 1e-9 * length)[:, None], y, np.nan)
        return cls(rigid, motion, y)

    @classmethod
    def displaced_by(
        cls,
        rigid: RigidCoordinates,
        motion: RigidMotion,
        displacement: Sequence[FloatArray],
        held: Mapping[int, FloatArray],
    ) -> Self:
        """Rigid links and sliders of given displacements of all links.

        Parameters
        ----------
        rigid : RigidCoordinates
        motion : RigidMotion
            Batch of shape (B,).
        displacement : sequence of ndarray, shape (B, n_link)
            In the frames of the rigid motion.
        held : mapping of int to ndarray, shape (B, 2)
            Displacements of the ends of flexible links that slide, in ground axes, by the number
            of the slider.
        """
        y = np.zeros((len(motion.crank_angle), rigid.size))
        for link in rigid.links:
            y[:, rigid.of_link(link)] = displacement[link]
        pose = cls(rigid, motion, y)
        for number, slider in enumerate(rigid.topology.sliders):
            moved = held[number] if number in held else pose._end(slider.held)
            along = direction(np.array(slider.direction))
            if slider.guide:
                guide = rigid.topology.index(slider.guide)
                along = direction(pose.displaced.angle[:, guide] + slider.direction)
                moved = moved - pose._on_line(number)  # whose slide is not there yet
            y[:, 3 * len(rigid.links) + number] = np.sum(moved * along, axis=1)
        return cls(rigid, motion, y)

    def point(self, point: JointPoint | LinkEnd) -> FloatArray:
        """Displacement of a point of rigid links or of a line in ground axes, (B, 2)."""
        if isinstance(point, LinkEnd):
            return self._end(point)
        if point.slider is not None:
            return self._on_line(point.slider)
        return self._end(next(end for end in point.ends if self.rigid.is_rigid(end)))

    def rows(self, point: JointPoint) -> FloatArray:
        """Derivative of the displacement of a point by y, (B, 2, size)."""
        matrix = self.rigid.point(self.displaced, point)
        assert matrix is not None
        return matrix.value @ self._to_frames

    @cached_property
    def coordinates(self) -> FloatArray:
        """Derivative of y by the independent coordinates, (B, size, n)."""
        rigid = self.rigid
        moved = np.zeros((len(self.y), rigid.size, len(rigid.independent)))
        moved[:, rigid.independent, np.arange(len(rigid.independent))] = 1.0
        if len(rigid.dependent):
            across, along = (
                self._conditions[:, :, w] for w in (rigid.dependent, rigid.independent)
            )
            moved[:, rigid.dependent] = -np.linalg.solve(across, along)
        return moved

    def stiffness(
        self,
        at_points: Mapping[JointPoint, FloatArray],
        forces: FloatArray,
        virial: FloatArray,
    ) -> PoseStiffness:
        """Stiffness from forces that keep their direction, those of the joints among them.

        Parameters
        ----------
        at_points : mapping of JointPoint to ndarray, shape (B, 2)
            Forces of flexible links on points that lead them, in ground axes in N.
        forces : ndarray, shape (B, size)
            All other forces, by y.
        virial : ndarray, shape (B, n_links)
            Product of force and place of what acts on each rigid link besides its joints, in
            its displaced place, in N m.

        Returns
        -------
        PoseStiffness
        """
        rigid = self.rigid
        total = forces.copy()
        for point, force in at_points.items():
            total += np.einsum("bci,bc->bi", self.rows(point), force)
        ties: FloatArray = np.zeros((len(total), len(rigid.dependent)))
        if len(rigid.dependent):
            across = np.swapaxes(self._conditions[:, :, rigid.dependent], 1, 2)
            led = total[:, rigid.dependent, None]
            ties = -np.asarray(np.linalg.solve(across, led), dtype=float)[..., 0]
        turning, guiding = virial.copy(), np.zeros((len(total), len(rigid.topology.sliders)))
        for place, force in rigid.tie_forces(ties, at_points):
            if isinstance(place, LinkEnd):
                link = rigid.topology.index(place.link)
                turning[:, link] += np.sum(force * self._arm(place), axis=1)
                continue
            slider = rigid.topology.sliders[place]
            if slider.guide:
                guide = rigid.topology.index(slider.guide)
                along = direction(self.displaced.angle[:, guide] + slider.direction)
                across_it = normal(self.displaced.angle[:, guide] + slider.direction)
                arm, moved = self._lever(place)
                turning[:, guide] += np.sum(force * (arm + moved[:, None] * along), axis=1)
                guiding[:, place] -= np.sum(force * across_it, axis=1)
        return PoseStiffness(turning, guiding)

    @cached_property
    def _conditions(self) -> FloatArray:
        """Derivative of the ties by y, (B, conditions, size)."""
        return self.rigid.conditions(self.displaced).value @ self._to_frames

    @cached_property
    def _to_frames(self) -> FloatArray:
        """From y to the coordinates in the frames of the displaced links, (B, size, size)."""
        matrix = np.broadcast_to(np.eye(self.rigid.size), (len(self.y), *2 * (self.rigid.size,)))
        matrix = matrix.copy()
        for number in range(len(self.rigid.links)):
            first = 3 * number
            cosine, sine = np.cos(self.y[:, first + 2]), np.sin(self.y[:, first + 2])
            matrix[:, first, first] = matrix[:, first + 1, first + 1] = cosine
            matrix[:, first, first + 1], matrix[:, first + 1, first] = sine, -sine
        return matrix

    def _start(self, link: int) -> FloatArray:
        """Displacement of a rigid link's start in ground axes, (B, 2)."""
        u = self.y[:, self.rigid.of_link(link)]
        angle = self.motion.angle[:, link]
        return u[:, :1] * direction(angle) + u[:, 1:2] * normal(angle)

    def _arm(self, end: LinkEnd) -> FloatArray:
        """From the start of a displaced rigid link to an end in ground axes, (B, 2)."""
        link = self.rigid.topology.index(end.link)
        x = 0.0 if end.end == "start" else self.rigid.topology.links[link].length
        return x * direction(self.displaced.angle[:, link])

    def _end(self, end: LinkEnd) -> FloatArray:
        link = self.rigid.topology.index(end.link)
        x = 0.0 if end.end == "start" else self.rigid.topology.links[link].length
        turned = self._arm(end) - x * direction(self.motion.angle[:, link])
        return self._start(link) + turned

    def _lever(self, number: int) -> tuple[FloatArray, FloatArray]:
        """Arm of a slider on its guide without its slide, turned with the guide; the slide."""
        slider = self.rigid.topology.sliders[number]
        guide = self.rigid.topology.index(slider.guide)
        lever = self.rigid.lever(self.motion, number)
        angle = self.displaced.angle[:, guide]
        arm = lever[:, :1] * direction(angle) + lever[:, 1:] * normal(angle)
        return arm, self.displaced.slide[:, number]

    def _on_line(self, number: int) -> FloatArray:
        slider = self.rigid.topology.sliders[number]
        slide = self.displaced.slide[:, number, None]
        if not slider.guide:
            return slide * direction(np.array(slider.direction))
        guide = self.rigid.topology.index(slider.guide)
        arm, _ = self._lever(number)
        lever, angle = self.rigid.lever(self.motion, number), self.motion.angle[:, guide]
        before = lever[:, :1] * direction(angle) + lever[:, 1:] * normal(angle)
        along = direction(self.displaced.angle[:, guide] + slider.direction)
        return self._start(guide) + arm + slide * along - before
