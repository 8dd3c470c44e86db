"""Coordinates of rigid links and of sliders: coordinate partitioning.

A rigid link has three coordinates in its link frame: the displacement of its start along and
across, and its rotation. A slider has one: the displacement along its line. Pins, welds, pivots,
clamps and lines are constraints ``G(t) y = 0``. Some coordinates, ``w``, are independent, and
``y = Y(t) w``; the derivatives of Y come from implicit differentiation (Shabana, *Computational
Dynamics*, coordinate partitioning). Flexible links depend on rigid ones, never these on them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system.joints.displaced_motion import general_position, link_bodies
from flexmech.linear_system.joints.joint_points import JointPoint, joint_points, joint_rotations
from flexmech.linear_system.joints.position_errors import refuse_positions
from flexmech.linkages import LinkEnd, RigidMotion, Topology
from flexmech.linkages.body_motion import GROUND_AFTER_LINKS, BodyPoint
from flexmech.linkages.connection_forces import RANK_TOLERANCE, end_point, slider_line
from flexmech.linkages.constraints import Coincidence, Constraints, EqualAngle
from flexmech.linkages.matrix_with_rates import MatrixWithRates


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


class RigidCoordinates:
    """Coordinates ``y`` of the rigid links and sliders of a topology, and the independent ones.

    Parameters
    ----------
    topology : Topology

    Attributes
    ----------
    links : tuple of int
        Numbers of the rigid links; link ``links[k]`` has the coordinates ``3 k`` to ``3 k + 2``.
    size : int
        Number of all coordinates y: those of the links, then one a slider.
    independent_coordinates, dependent_coordinates : ndarray of int, shape (n,), (size - n,)
        Which of them are w, and which depend on these.
    constraints : Constraints
        All constraints, redundant ones included.
    rows : ndarray of int, shape (size - n,)
        Constraint equations that determine the dependent coordinates.
    """

    def __init__(self, topology: Topology) -> None:
        self.topology = topology
        self.links = tuple(n for n, link in enumerate(topology.links) if link.rigid)
        self.size = 3 * len(self.links) + len(topology.sliders)
        # Those of elastic links do not stand here, and most linkages have no rigid one.
        own = (self._coincidences(), self._equal_angles()) if self.links else ()
        self.constraints = Constraints([*chain(*own)], self.links, len(topology.sliders))
        self.independent_coordinates, self.dependent_coordinates, self.rows = self._choose()

    def is_rigid(self, end: LinkEnd) -> bool:
        """Whether an end is that of a rigid link."""
        return self.topology.index(end.link) in self.links

    def of_link(self, link: int) -> IntArray:
        """The three coordinates of a rigid link among y."""
        return 3 * self.links.index(link) + np.arange(3)

    def dependence(self, motion: RigidMotion) -> MatrixWithRates:
        """``Y``: derivative of all coordinates by the independent ones, (B, size, n).

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).

        Returns
        -------
        MatrixWithRates

        Raises
        ------
        ComputationError
            Where the independent ones do not determine the others; names the crank angle.
        """
        batch, count = len(motion.crank_angle), len(self.independent_coordinates)
        chosen = np.zeros((self.size, count))
        chosen[self.independent_coordinates, np.arange(count)] = 1.0
        if not len(self.dependent_coordinates):
            return MatrixWithRates.constant(chosen, batch)
        jacobian = self.constraint_jacobian(motion)
        across = jacobian.columns(self.dependent_coordinates)
        self.refuse_locked(motion, across.value)
        solved = across.solve(-jacobian.columns(self.independent_coordinates))
        parts = np.zeros((4, batch, self.size, count))
        parts[0] += chosen
        parts[:, :, self.dependent_coordinates] = solved.parts
        return MatrixWithRates(*parts)

    def leader(self, point: JointPoint) -> BodyPoint | None:
        """Point of a line or of a rigid link on which the other ends at a joint depend.

        Parameters
        ----------
        point : JointPoint

        Returns
        -------
        BodyPoint or None
            None of a fixed point, and where no rigid link and no line is at the joint.
        """
        if point.slider is not None:
            return self.point_on_line(point.slider)
        leading = [end for end in point.ends if self.is_rigid(end)]
        return None if point.fixed or not leading else end_point(self.topology, leading[0])

    def point_on_line(self, number: int) -> BodyPoint:
        """Point of a slider on its line."""
        line = slider_line(self.topology, self.topology.sliders[number])
        return BodyPoint(line.second.body, slide=number, along=line.along)

    def displacement_rows(
        self, motion: RigidMotion, points: Sequence[BodyPoint]
    ) -> MatrixWithRates:
        """Jacobian of points of rigid links and lines in ground axes by y, (B, 2 P, size).

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        points : sequence of BodyPoint
        """
        bodies, slid = link_bodies(motion, self.topology)
        return self.constraints.points(points).jacobian_with_rates(bodies, slid)

    @cached_property
    def general_position(self) -> RigidMotion:
        """One generic position for rank decisions; the links need not meet in it."""
        return general_position(self.topology)

    def constraint_jacobian(self, motion: RigidMotion) -> MatrixWithRates:
        """``G``: Jacobian of the constraints that determine the dependent coordinates.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).

        Returns
        -------
        MatrixWithRates
            Of shape (B, size - n, size); displacements in ground axes in m, rotations in rad.
        """
        bodies, slid = link_bodies(motion, self.topology)
        return self.constraints.jacobian_with_rates(bodies, slid).rows(self.rows)

    def projected(self, stiffness: RigidGeometricStiffness, dependence: FloatArray) -> FloatArray:
        """Geometric stiffness by the independent coordinates, (B, n, n).

        Parameters
        ----------
        stiffness : RigidGeometricStiffness
        dependence : ndarray, shape (B, size, n)
            Derivative of y by the independent coordinates.
        """
        total = np.zeros((len(dependence), self.size, self.size))
        for link in self.links:
            turn = self.of_link(link)[2]
            total[:, turn, turn] = stiffness.rotation_stiffness[:, link]
        for number, slider in enumerate(self.topology.sliders):
            if slider.guide:
                turn = self.of_link(self.topology.index(slider.guide))[2]
                slide = 3 * len(self.links) + number
                total[:, turn, slide] = total[:, slide, turn] = stiffness.guide_stiffness[:, number]
        return np.asarray(np.swapaxes(dependence, 1, 2) @ total @ dependence)

    def _coincidences(self) -> Iterator[Coincidence]:
        """Ends of rigid links that coincide with the leader or a fixed point of their joint."""
        for point in joint_points(self.topology):
            rigid = [end for end in point.ends if self.is_rigid(end)]
            leader = self.leader(point)
            leading = leader is not None and leader.slide is None
            for end in rigid[1 if leading else 0 :]:
                other = BodyPoint(GROUND_AFTER_LINKS) if leader is None else leader
                yield Coincidence(self._pinned(end), other)
            if point.hub and self.is_rigid(point.ends[0]):
                yield Coincidence(self._pinned(point.ends[0]), BodyPoint(GROUND_AFTER_LINKS))

    def _pinned(self, end: LinkEnd) -> BodyPoint:
        """Point of a rigid link that is pinned for an end: of a clamped one that on the axis."""
        point = end_point(self.topology, end)
        hubs = (clamp.hub for clamp in self.topology.clamps if clamp.link_end == end)
        return replace(point, place=point.place - sum(hubs))

    def _equal_angles(self) -> Iterator[EqualAngle]:
        """Rigid links whose rotation equals that of others or of the shaft."""
        for turn in joint_rotations(self.topology):
            rigid = [self.topology.index(end.link) for end in turn.ends if self.is_rigid(end)]
            others = rigid if turn.fixed else rigid[1:]
            leader = GROUND_AFTER_LINKS if turn.fixed else rigid[0] if rigid else 0
            yield from (EqualAngle(other, leader) for other in others)

    def _choose(self) -> tuple[IntArray, IntArray, IntArray]:
        """Independent and dependent coordinates, and the constraints that determine the latter.

        Chosen once, in a general position: the first columns that add to the rank are dependent.
        """
        none = np.zeros(0, dtype=np.intp)
        if not self.constraints.count:
            return np.arange(self.size), none, none
        bodies, slid = link_bodies(self.general_position, self.topology)
        conditions = self.constraints.jacobian_with_rates(bodies, slid).value[0]
        order = self._order()
        dependent = np.sort(order[_independent_columns(conditions[:, order])])
        rows = _independent_columns(conditions[:, dependent].T)
        independent = np.setdiff1d(np.arange(self.size), dependent)
        return independent, dependent, rows

    def _order(self) -> IntArray:
        """All coordinates; those that should be independent come last.

        Rotations, of the first links most of all, are preferred to slides, and these to
        displacements: the rotation of a crank determines the position, a coordinate that is
        stationary in a dead point does not.
        """
        count = len(self.links)
        every = np.arange(self.size)
        displacements = every[: 3 * count][every[: 3 * count] % 3 < 2]
        rotations = every[: 3 * count][every[: 3 * count] % 3 == 2]
        return np.concatenate([displacements, every[3 * count :], rotations[::-1]])

    def refuse_locked(self, motion: RigidMotion, across: FloatArray) -> None:
        """Refuse positions in which the constraints do not determine the dependent coordinates.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        across : ndarray, shape (B, n, n)
            Jacobian of the constraints by these.

        Raises
        ------
        ComputationError
            Names the crank angle.
        """
        size = np.linalg.svd(across, compute_uv=False)
        names = ", ".join(self.topology.links[n].name for n in self.links)
        refuse_positions(
            motion,
            size[:, -1] <= RANK_TOLERANCE * size[:, 0],
            f"the rigid links ({names}) and lines lock or come loose",
            ": their constraints do not determine their motion; leave that crank angle out, or "
            "make one of the links elastic",
        )


def _independent_columns(matrix: FloatArray) -> IntArray:
    """Numbers of the columns that are linearly independent of those before them."""
    basis = np.zeros((len(matrix), 0))
    chosen = []
    for number, column in enumerate(matrix.T):
        rest = column
        for _ in range(2):  # twice is enough against round-off
            rest = rest - basis @ (basis.T @ rest)
        size = float(np.linalg.norm(rest))
        if size > RANK_TOLERANCE * float(np.linalg.norm(column)):
            chosen.append(number)
            basis = np.column_stack([basis, rest / size])
    return np.array(chosen, dtype=np.intp)
