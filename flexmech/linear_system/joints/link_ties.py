"""Independent coordinates of all links, and the dependence of the others on them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system.joints.joint_coordinates import JointCoordinates
from flexmech.linear_system.joints.rigid_pose import (
    DisplacedRows,
    DisplacedTies,
    RigidGeometricStiffness,
    RigidPose,
)
from flexmech.linear_system.links.link_model import LinkModel
from flexmech.linear_system.links.rotation_terms import RotationTerms
from flexmech.linkages import LinkEnd, RigidMotion, Topology
from flexmech.linkages.body_motion import BodyPoint, dot
from flexmech.linkages.connection_forces import end_point
from flexmech.linkages.matrix_with_rates import MatrixWithRates


@dataclass(frozen=True)
class DependentRows:
    """Dependent coordinates of a link: ``q[rows] = turn @ z[columns]``.

    A pinned end depends on its leader's end, rotated from that frame: two rows, two columns.
    An end on a line depends on the slide, one on a rigid link on that link's three coordinates.

    Parameters
    ----------
    rows : ndarray of int, shape (r,)
        Coordinates of the link.
    columns : ndarray of int, shape (c,)
        Independent coordinates of the linkage, all different.
    turn : ndarray, shape (B, r, c)
    rate : ndarray, shape (B, r, c)
        Time derivative of ``turn``.
    centripetal, tangential : ndarray, shape (B, r, c)
        Second time derivative of ``turn``: the parts in squares and products of velocities of
        the rigid motion, and in its accelerations.
    """

    rows: IntArray
    columns: IntArray
    turn: FloatArray
    rate: FloatArray
    centripetal: FloatArray
    tangential: FloatArray

    def acceleration(self, terms: RotationTerms) -> FloatArray:
        """Second time derivative of ``turn``: the terms that are included, (B, r, c)."""
        if terms.centripetal and terms.tangential:
            return self.centripetal + self.tangential
        return self.centripetal if terms.centripetal else self.tangential


@dataclass(frozen=True)
class Tie:
    """Rows of a link that depend on independent coordinates.

    Parameters
    ----------
    rows : ndarray of int, shape (r,)
        Coordinates of the link.
    source : BodyPoint, or ndarray of int, shape (r,)
        The point whose displacement they are in the link's frame, or the joint coordinates that
        they are.
    which : ndarray of int, shape (c,)
        Columns of the dependence of the joint coordinates.
    columns : ndarray of int, shape (c,)
        The same independent coordinates by their numbers in the linkage.
    leader : LinkEnd, optional
        The leading end that the point is.
    """

    rows: IntArray
    source: BodyPoint | IntArray
    which: IntArray
    columns: IntArray
    leader: LinkEnd | None


# Speed and memory alone: an engine numbers the coordinates of its linkage several times.
@lru_cache(maxsize=16)
def _joint_coordinates(topology: Topology) -> JointCoordinates:
    return JointCoordinates(topology)


class LinkTies:
    """Constraints between the coordinates of all links, and the numbering of independent ones.

    Parameters
    ----------
    topology : Topology
    links : sequence of LinkModel
        In the topology's order; full or reduced.
    last : sequence of ndarray of bool, shape (n_link,), optional
        Coordinates of each link to number after all others.

    Attributes
    ----------
    targets : list of ndarray of int, shape (n_link,)
        For each link coordinate its coordinate of z: its own, or that of another link to which it
        is equal. -1 where it is fixed, and where it depends on several.
    size : int
        Number of independent coordinates.
    end_count : int
        How many of them, the first ones, others may depend on: those of rigid links and of sliders,
        displacements of link ends, rotations of welded ends and of a free shaft.
    rigid : JointCoordinates
        Of rigid links, sliders and leading ends.
    """

    def __init__(
        self,
        topology: Topology,
        links: Sequence[LinkModel],
        last: Sequence[NDArray[np.bool_]] | None = None,
    ) -> None:
        self.topology, self.links = topology, tuple(links)
        self.rigid = _joint_coordinates(topology)
        self.targets = [np.full(link.size, -2, dtype=np.intp) for link in links]
        # Rows whose forces act on joint coordinates and on points, by their links.
        self._at_coordinates = [
            (link, np.arange(3), self.rigid.of_link(link)) for link in self.rigid.links
        ]
        self._at_points: list[tuple[int, IntArray, BodyPoint]] = []
        self._connect_ends()
        # A system asks for them ten times in the same positions.
        self._latest: tuple[RigidMotion, list[list[DependentRows]]] | None = None
        self._ties: list[list[Tie]] = [[] for _ in links]
        self._add_ties(self._number(last or [np.zeros(link.size, dtype=bool) for link in links]))

    def dependencies(self, link: int) -> list[tuple[IntArray, IntArray]]:
        """Dependent coordinates of a link and the coordinates of z that determine them, by tie."""
        return [(tie.rows, tie.columns) for tie in self._ties[link]]

    def dependent_coordinates(self, link: int) -> IntArray:
        """Dependent coordinates of a link, (k,)."""
        rows = [tie.rows for tie in self._ties[link]]
        return np.concatenate([np.zeros(0, dtype=np.intp), *rows])

    def independent_coordinates(self, link: int) -> IntArray:
        """Coordinates of a link that are independent coordinates of the linkage, (k,)."""
        own = self.targets[link] >= 0
        own[self.dependent_coordinates(link)] = False
        return np.flatnonzero(own)

    def dependent_rows(self, motion: RigidMotion) -> list[list[DependentRows]]:
        """Dependent coordinates of each link by the independent ones, with time derivatives.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).

        Returns
        -------
        list of list of DependentRows
            A list for each link.
        """
        if (latest := self._latest) is not None and latest[0] is motion:
            return latest[1]
        y = self.rigid.dependence(motion)
        moved: dict[BodyPoint, MatrixWithRates] = {}
        rows: list[list[DependentRows]] = []
        for link, ties in enumerate(self._ties):
            rows.append([])
            for tie in ties:
                source, leader = tie.source, tie.leader
                if not isinstance(source, BodyPoint):
                    matrix = y.rows(source).columns(tie.which)
                elif leader is None:
                    if source not in moved:
                        moved[source] = self.rigid.displacement_rows(motion, [source]) @ y
                    matrix = _to_frame(motion, link) @ moved[source].columns(tie.which)
                else:
                    matrix = _to_frame(motion, link, self.topology.index(leader.link))
                    if leader in self.rigid.receding:  # whose displacement depends on others
                        own = self.rigid.of_end(leader)[:2]
                        matrix = matrix @ y.rows(own).columns(tie.which)
                rows[-1].append(DependentRows(tie.rows, tie.columns, *matrix.parts))
        self._latest = motion, rows
        return rows

    @property
    def has_arms(self) -> bool:
        """Whether forces act on arms that turn: there are rigid links, sliders or a hub."""
        return self.rigid.are_finite or bool(self.rigid.constraints.count)

    def displaced_ties(self, motion: RigidMotion, w: FloatArray) -> DisplacedTies:
        """Constraints at finite displacements of the rigid links.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        w : ndarray, shape (B, n)
            Independent coordinates of rigid links and sliders, the first ones of z, in the
            frames of the rigid motion.

        Returns
        -------
        DisplacedTies
        """
        return self._displaced_ties(RigidPose.solve_position_constraints(self.rigid, motion, w))

    def displaced_ties_by(
        self, motion: RigidMotion, displacement: Sequence[FloatArray]
    ) -> DisplacedTies:
        """Constraints at displacements (B, n_link) of the links in the rigid motion's frames."""
        return self._displaced_ties(self._pose_of(motion, displacement))

    def displaced(
        self, motion: RigidMotion, displacement: Sequence[FloatArray] | None
    ) -> RigidMotion:
        """Motion of the link frames with rigid links displaced by (B, n_link).

        Coordinates of rigid links are then those in their displaced frames.
        """
        if displacement is None or not self.rigid.are_finite:
            return motion
        return self._pose_of(motion, displacement).displaced

    def guide_matrix(self, motion: RigidMotion, guide_stiffness: FloatArray) -> FloatArray:
        """Geometric stiffness between rotations of guides and slides on them, (B, size, size).

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        guide_stiffness : ndarray, shape (B, n_sliders)
            In N/rad; see :class:`flexmech.linear_system.StressedLinks`.
        """
        first = len(self.rigid.independent_coordinates)
        total = np.zeros((len(guide_stiffness), self.size, self.size))
        zero = np.zeros((len(guide_stiffness), len(self.topology.links)))
        dependence = self.rigid.dependence(motion).value
        stiffness = RigidGeometricStiffness(zero, guide_stiffness)
        total[:, :first, :first] = stiffness.projected(self.rigid, dependence)
        return total

    def _slides(self, motion: RigidMotion, displacement: Sequence[NDArray[Any]]) -> NDArray[Any]:
        """Slides of displacements (B, n_link, m) of all links, at their places in z."""
        rigid = self.rigid
        shape = (len(displacement[0]), rigid.size, displacement[0].shape[2])
        y = np.zeros(shape, dtype=displacement[0].dtype)
        for link in rigid.links:
            y[:, rigid.of_link(link)] = displacement[link]
        slid = np.zeros_like(y)
        for slide, (number, slider) in zip(
            rigid.slides, enumerate(self.topology.sliders), strict=True
        ):
            end, line = slider.link_end, rigid.point_on_line(number)
            rows = rigid.displacement_rows(motion, [line, end_point(self.topology, end)]).value
            of_body = rigid.is_rigid(end)
            moved = rows[:, 2:] @ y if of_body else self._in_ground(motion, end, displacement)
            along = rows[:, :2, slide]
            slid[:, slide] = np.einsum("bc,bcm->bm", along, moved - rows[:, :2] @ y)
        return slid[:, rigid.independent_coordinates]

    def _pose_of(self, motion: RigidMotion, displacement: Sequence[FloatArray]) -> RigidPose:
        """Finite displacements of rigid links and sliders at displacements (B, n_link) of links."""
        rigid, y = self.rigid, np.zeros((len(motion.crank_angle), self.rigid.size))
        for link in rigid.links:
            y[:, rigid.of_link(link)] = displacement[link]
        pose = RigidPose(rigid, motion, y)
        for number, slider in enumerate(self.topology.sliders):
            end, line = slider.link_end, rigid.point_on_line(number)
            moved = (
                pose.displacement([end_point(self.topology, end)])[:, 0]
                if rigid.is_rigid(end)
                else self._in_ground(motion, end, displacement)
            )
            moved = moved - pose.displacement([line])[:, 0]  # whose slide is not there yet
            along = line.along * pose.after[0].turn[:, line.body]
            y[:, rigid.slides[number]] = dot(along, moved[:, 0] + 1j * moved[:, 1])
        return RigidPose(rigid, motion, y)

    def _in_ground(
        self, motion: RigidMotion, end: LinkEnd, displacement: Sequence[NDArray[Any]]
    ) -> NDArray[Any]:
        """Displacement of an elastic link's end in ground axes, (B, 2, ...)."""
        link = self.topology.index(end.link)
        moved = displacement[link][:, self._displacement_of(end)]
        return np.asarray(np.einsum("bij,bi...->bj...", _to_frame(motion, link).value, moved))

    def _displaced_ties(self, pose: RigidPose) -> DisplacedTies:
        first = len(self.rigid.independent_coordinates)
        rows: list[list[DisplacedRows]] = []
        for link, ties in enumerate(self._ties):
            rows.append([])
            for tie in ties:
                if isinstance(tie.source, BodyPoint):
                    back = _to_frame(pose.motion, link).value
                    turn = back @ (pose.rows([tie.source]) @ pose.coordinates)[:, :, tie.which]
                    place = (back @ pose.displacement([tie.source])[:, 0, :, None])[..., 0]
                else:
                    turn = pose.coordinates[:, tie.source][:, :, tie.which]
                    place = pose.y[:, tie.source]
                finite = bool((tie.which < first).all())
                rows[-1].append(
                    DisplacedRows(tie.rows, tie.columns, turn, place if finite else None)
                )
        return DisplacedTies(pose, rows, self._at_points, self._at_coordinates)

    def _displacement_of(self, end: LinkEnd) -> IntArray:
        return self.links[self.topology.index(end.link)].end_displacement(end.end)

    def _rotations_of(self, end: LinkEnd) -> IntArray:
        return self.links[self.topology.index(end.link)].end_rotation_of(end.end)

    def _connect_ends(self) -> None:
        """Find what the ends of elastic links depend on; mark fixed and dependent coordinates."""
        rigid = self.rigid
        for end in self.topology.joined_ends:
            link = self.topology.index(end.link)
            self.targets[link][self.links[link].end_warping_of(end.end)] = -1
        for point in rigid.points:
            leader = rigid.leader(point)
            for end in point.ends:
                link, rows = self.topology.index(end.link), self._displacement_of(end)
                if rigid.is_rigid(end) or not len(rows):
                    continue
                body = rigid.ends.get(end)
                if leader is not None and leader.body != body:
                    self._at_points.append((link, rows, leader))
                elif body is not None:
                    self._at_coordinates.append((link, rows, rigid.of_end(end)[:2]))
                leads = leader is not None and leader.body == body
                if not (leads and np.isin(rigid.of_end(end)[:2], rigid.w).all()):
                    self.targets[link][rows] = -1
        for turn in rigid.turns:
            for end in turn.ends:
                link, rows = self.topology.index(end.link), self._rotations_of(end)
                if rigid.is_rigid(end):
                    continue
                leads = not turn.fixed and end in rigid.ends and end == turn.ends[0]
                self.targets[link][rows[1:] if leads else rows] = -1
                if not turn.fixed:
                    among = np.full(len(rows), rigid.rotation(turn))
                    self._at_coordinates.append((link, rows, among))

    def _number(self, last: Sequence[NDArray[np.bool_]]) -> IntArray:
        """Number the free coordinates: of rigid links, of ends and of a free shaft, and others.

        Returns the numbers of the joint coordinates, (size,); -1 of those that are none.
        """
        rigid, count = self.rigid, len(self.rigid.independent_coordinates)
        place = np.full(rigid.size, -1, dtype=np.intp)
        place[rigid.independent_coordinates] = np.arange(count)
        for number in rigid.links:
            self.targets[number][:] = place[rigid.of_link(number)]
        ends = [np.zeros(model.size, dtype=bool) for model in self.links]
        for model, end in zip(self.links, ends, strict=True):
            end[model.start] = end[model.end] = end[model.receding] = True
        for turn in rigid.turns:
            first = turn.ends[0]
            ends[self.topology.index(first.link)][self._rotations_of(first)[:1]] = True
        ends = [end & ~late for end, late in zip(ends, last, strict=True)]
        inner = [~(end | late) for end, late in zip(ends, last, strict=True)]
        for group in (ends, inner, last):
            for target, chosen in zip(self.targets, group, strict=True):
                free = (target == -2) & chosen
                target[free] = np.arange(count, count + free.sum())
                count += int(free.sum())
            if group is ends:
                self.end_count = count
        self.size = count
        for number, rows, among in self._at_coordinates:
            numbered = self.targets[number][rows]
            place[among[numbered >= 0]] = numbered[numbered >= 0]
        return place

    def _add_ties(self, place: IntArray) -> None:
        """Add the dependence of marked coordinates on the joint coordinates that are numbered."""
        rigid = self.rigid
        receding = [-1] * len(rigid.receding)
        for number, end in enumerate(rigid.receding):
            link = self.topology.index(end.link)
            for coordinate in self.links[link].receding:
                receding[number] = int(self.targets[link][coordinate])
        z = np.array([*place[rigid.w], *receding])
        of_ends = 3 * len(rigid.links)

        def add(link: int, rows: IntArray, source: BodyPoint | IntArray) -> None:
            which = np.flatnonzero(rigid.determining(source) & (z >= 0))
            if len(which):
                leader = rigid.end_at(source) if isinstance(source, BodyPoint) else None
                self._ties[link].append(Tie(rows, source, which, z[which], leader))

        for link, rows, among in self._at_coordinates:
            if len(rows) and of_ends <= among[-1] == among[0] < of_ends + 3 * len(rigid.ends):
                self.targets[link][rows[0]] = place[among[0]]
            chosen = self.targets[link][rows] < 0
            add(link, rows[chosen], among[chosen])
        for link, rows, point in self._at_points:
            add(link, rows, point)


def _to_frame(motion: RigidMotion, link: int, leader: int | None = None) -> MatrixWithRates:
    """Rotation to the frame of a link from that of another, or from ground axes, (B, 2, 2)."""
    turn = np.stack([motion.angle, motion.angular_velocity, motion.angular_acceleration])
    others = 0.0 if leader is None else turn[..., leader]
    return MatrixWithRates.rotation(*(others - turn[..., link]))
