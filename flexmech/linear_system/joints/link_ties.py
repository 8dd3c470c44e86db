"""Independent coordinates of all links, and the dependence of the others on them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system.joints.joint_points import (
    JointPoint,
    JointRotation,
    joint_points,
    joint_rotations,
)
from flexmech.linear_system.joints.link_place import DependentRows
from flexmech.linear_system.joints.rigid_coordinates import (
    RigidGeometricStiffness,
)
from flexmech.linear_system.joints.rigid_pose import (
    CoordinateRows,
    DisplacedRows,
    DisplacedTies,
    HubRow,
    PointRows,
    RigidPose,
)
from flexmech.linear_system.joints.ties import (
    HubEnd,
    MovingFrames,
    PointEnd,
    RigidRows,
    RotatedEnd,
    Tie,
    general_frames,
)
from flexmech.linear_system.links.link_model import LinkModel
from flexmech.linkages import LinkEnd, RigidMotion, Topology
from flexmech.linkages.connection_forces import RANK_TOLERANCE, end_point
from flexmech.linkages.matrix_with_rates import MatrixWithRates
from flexmech.linkages.motion import direction, normal


class LinkTies:
    """Constraints between the coordinates of all links, and the numbering of independent ones.

    Parameters
    ----------
    topology : Topology
    links : sequence of LinkModel
    last : sequence of ndarray of bool, shape (n_link,)
        Coordinates of each link to number after all others.

    Attributes
    ----------
    targets : list of ndarray of int, shape (n_link,)
        See :class:`flexmech.linear_system.LinkFrames`.
    size, end_count : int
        Likewise.
    rigid : RigidCoordinates
        Of the rigid links and sliders.
    hubs : list of HubRow
        Of elastic links that are clamped to a hub.
    """

    def __init__(
        self,
        topology: Topology,
        links: Sequence[LinkModel],
        last: Sequence[NDArray[np.bool_]],
    ) -> None:
        self.topology = topology
        self._general = general_frames(topology)
        self.rigid = self._general.rigid
        self._links = links
        self._ties: list[list[Tie]] = [[] for _ in links]
        self._at_rest: list[PointRows] = []  # ends on rigid links that do not move
        self.hubs = list(self._flexible_hubs())
        self.targets = [np.full(link.size, -2, dtype=np.intp) for link in links]
        self._points, self._turns = joint_points(topology), joint_rotations(topology)
        self._number_rigid()
        self._mark()
        self.size = self._number(last)
        self._add_ties()

    def dependencies(self, link: int) -> list[tuple[IntArray, IntArray]]:
        """Dependent rows of a link and the columns that determine them, tie by tie."""
        return [(tie.rows, tie.columns) for tie in self._ties[link]]

    def independent_coordinates(self, link: int) -> IntArray:
        """Coordinates of a link that are independent coordinates of the linkage, (k,)."""
        own = self.targets[link] >= 0
        for rows, _ in self.dependencies(link):
            own[rows] = False
        return np.flatnonzero(own)

    def dependent_rows(self, motion: RigidMotion) -> list[list[DependentRows]]:
        """Dependent rows of each link over a batch of shape (B,)."""
        moving = MovingFrames(self.rigid, motion)
        return [
            [self._tie_rows(moving, link, tie) for tie in ties]
            for link, ties in enumerate(self._ties)
        ]

    def displaced_ties(self, motion: RigidMotion, pose: RigidPose) -> DisplacedTies:
        """Constraints at finite displacements of the rigid links.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,), not displaced.
        pose : RigidPose

        Returns
        -------
        DisplacedTies
        """
        moving = MovingFrames(self.rigid, motion)
        rows: list[list[DisplacedRows]] = []
        at_points, at_coordinates = list(self._at_rest), []
        for link, ties in enumerate(self._ties):
            rows.append([])
            for tie in ties:
                place = None
                if isinstance(tie, PointEnd):
                    back = moving.rotation(link).value
                    turn = (back @ pose.rows([tie.point]) @ pose.coordinates)[:, :, tie.columns]
                    place = (back @ pose.displacement([tie.point])[:, 0, :, None])[..., 0]
                    at_points.append(PointRows(link, tie.rows, tie.point))
                elif isinstance(tie, RigidRows):
                    turn = pose.coordinates[:, tie.among][:, :, tie.columns]
                    place = pose.y[:, tie.among]
                    if link not in self.rigid.links:
                        at_coordinates.append(CoordinateRows(link, tie.rows, tie.among))
                else:
                    turn = self._tie_rows(moving, link, tie).turn
                rows[-1].append(DisplacedRows(tie.rows, tie.columns, turn, place))
            if link in self.rigid.links:
                among = self.rigid.of_link(link)
                at_coordinates.append(CoordinateRows(link, np.arange(3), among))
                continue
            free = self.independent_coordinates(link)
            chosen = free[self.targets[link][free] < len(self.rigid.independent_coordinates)]
            among = self.rigid.independent_coordinates[self.targets[link][chosen]]
            at_coordinates.append(CoordinateRows(link, chosen, among))
        return DisplacedTies(pose, rows, at_points, at_coordinates, self.hubs)

    def guide_matrix(self, motion: RigidMotion, guide_stiffness: FloatArray) -> FloatArray:
        """Geometric stiffness between guides' rotations and slides, by independent coordinates."""
        zero = np.zeros((len(guide_stiffness), len(self.topology.links)))
        dependence = self.rigid.dependence(motion).value
        return self.rigid.projected(RigidGeometricStiffness(zero, guide_stiffness), dependence)

    def slides(self, motion: RigidMotion, displacement: Sequence[NDArray[Any]]) -> NDArray[Any]:
        """Slide coordinates of displacements (B, n_link, m) of all links, at their places in w."""
        rigid = self.rigid
        shape = (len(displacement[0]), rigid.size, displacement[0].shape[2])
        y = np.zeros(shape, dtype=displacement[0].dtype)
        for link in rigid.links:
            y[:, rigid.of_link(link)] = displacement[link]
        found = np.zeros_like(y)
        for point in self._points:
            if point.slider is None:
                continue
            line, end = rigid.point_on_line(point.slider), point.ends[0]
            rows = rigid.displacement_rows(motion, [line, end_point(self.topology, end)]).value
            slide, link = 3 * len(rigid.links) + point.slider, self.topology.index(end.link)
            if rigid.is_rigid(end):
                moved = rows[:, 2:] @ y
            else:
                to_ground = np.swapaxes(MovingFrames(rigid, motion).rotation(link).value, 1, 2)
                moved = to_ground @ displacement[link][:, self._rows(end)]
            along = rows[:, :2, slide]
            found[:, slide] = np.einsum("bc,bcm->bm", along, moved - rows[:, :2] @ y)
        return found[:, rigid.independent_coordinates]

    def pose_of(self, motion: RigidMotion, displacement: Sequence[FloatArray]) -> RigidPose:
        """Finite displacements of rigid links and sliders at displacements (B, n_link) of links."""
        sliding = {}
        for number, slider in enumerate(self.topology.sliders):
            if not self.rigid.is_rigid(slider.link_end):
                link = self.topology.index(slider.link_end.link)
                q = displacement[link][:, self._rows(slider.link_end)]
                angle = motion.angle[:, link]
                sliding[number] = q[:, :1] * direction(angle) + q[:, 1:] * normal(angle)
        return RigidPose.displaced_by(self.rigid, motion, displacement, sliding)

    def _tie_rows(self, moving: MovingFrames, link: int, tie: Tie) -> DependentRows:
        return DependentRows.of(tie.rows, tie.columns, tie.matrix(moving, link))

    def _rows(self, end: LinkEnd) -> IntArray:
        return self._links[self.topology.index(end.link)].end_displacement(end.end)

    def _rotations(self, end: LinkEnd) -> IntArray:
        return self._links[self.topology.index(end.link)].end_rotation_of(end.end)

    def _flexible_hubs(self) -> Iterator[HubRow]:
        for clamp in self.topology.clamps:
            end = clamp.link_end
            if clamp.hub and not self.rigid.is_rigid(end) and len(rows := self._rows(end)):
                yield HubRow(self.topology.index(end.link), int(rows[0]), clamp.hub)

    def _number_rigid(self) -> None:
        """Number the independent coordinates of rigid links; the others depend on them."""
        own, place = self.rigid.independent_coordinates, np.full(self.rigid.size, -1, dtype=np.intp)
        place[own] = np.arange(len(own))
        for link in self.rigid.links:
            among = self.rigid.of_link(link)
            self.targets[link][:] = place[among]
            self._add_rigid(link, np.arange(3), among)

    def _add_rigid(self, link: int, rows: IntArray, among: IntArray) -> None:
        """Add the dependence of rows of a link that are not in w."""
        chosen = self.targets[link][rows] < 0
        if not chosen.any():
            return
        rows, among = rows[chosen], among[chosen]
        columns = _depends_on(self._general.coordinates.rows(among))
        if len(columns):
            self._ties[link].append(RigidRows(rows, columns, among))

    def _mark(self) -> None:
        """Mark fixed and dependent coordinates, which are not independent."""
        for end in self.topology.joined_ends:
            link = self.topology.index(end.link)
            self.targets[link][self._links[link].end_warping_of(end.end)] = -1
        for point in self._points:
            elsewhere = point.fixed or point.hub or self._is_on_rigid_link_or_line(point)
            for end in point.ends if elsewhere else point.ends[1:]:
                if not self.rigid.is_rigid(end):
                    self.targets[self.topology.index(end.link)][self._rows(end)] = -1
        for turn in self._turns:
            on_rigid = turn.fixed or any(map(self.rigid.is_rigid, turn.ends))
            for number, end in enumerate(turn.ends):
                if not self.rigid.is_rigid(end):
                    dependent = self._rotations(end)[0 if on_rigid or number else 1 :]
                    self.targets[self.topology.index(end.link)][dependent] = -1

    def _is_on_rigid_link_or_line(self, point: JointPoint) -> bool:
        return point.slider is not None or any(map(self.rigid.is_rigid, point.ends))

    def _number(self, last: Sequence[NDArray[np.bool_]]) -> int:
        """Number the free coordinates, those of the links' ends and of a free shaft first."""
        count = len(self.rigid.independent_coordinates)
        ends = [~late for late in last]
        for number, (link, end) in enumerate(zip(self._links, ends, strict=True)):
            elsewhere = np.ones(link.size, dtype=bool)
            elsewhere[link.start] = elsewhere[link.end] = elsewhere[link.receding] = False
            elsewhere[self._leading_rotations(number)] = False
            end[elsewhere] = False
        inner = [~(end | late) for end, late in zip(ends, last, strict=True)]
        for group in (ends, inner, last):
            for target, chosen in zip(self.targets, group, strict=True):
                free = (target == -2) & chosen
                target[free] = np.arange(count, count + free.sum())
                count += int(free.sum())
            if group is ends:
                self.end_count = count
        return count

    def _leading_rotations(self, link: int) -> list[int]:
        """Rotations of a link's ends on which others depend, or that are a free shaft's."""
        name = self.topology.links[link].name
        return [
            int(self._rotations(turn.ends[0])[0])
            for turn in self._turns
            if turn.ends[0].link == name and len(self._rotations(turn.ends[0]))
        ]

    def _add_ties(self) -> None:
        """Add the constraints of the marked ends of flexible links."""
        for point in self._points:
            if point.fixed:
                continue
            by_rigid = self._is_on_rigid_link_or_line(point)
            for end in point.ends if by_rigid or point.hub else point.ends[1:]:
                rows, link = self._rows(end), self.topology.index(end.link)
                if self.rigid.is_rigid(end) or not len(rows):
                    continue
                if by_rigid:
                    leader = self.rigid.leader(point)
                    assert leader is not None
                    columns = _depends_on(self._general.point(leader))
                    if len(columns):
                        self._ties[link].append(PointEnd(rows, columns, leader))
                    else:
                        self._at_rest.append(PointRows(link, rows, leader))
                elif point.hub:
                    self._add_hub(link, rows, point)
                else:
                    self._add_pinned_end(link, rows, point.ends[0])
        for turn in self._turns:
            if not turn.fixed:
                self._add_rotation(turn)

    def _add_pinned_end(self, link: int, rows: IntArray, leading: LinkEnd) -> None:
        leader = self.topology.index(leading.link)
        columns = self.targets[leader][self._rows(leading)]
        self.targets[link][rows] = columns
        if (columns >= 0).any():
            self._ties[link].append(RotatedEnd(rows, columns, leader))

    def _add_hub(self, link: int, rows: IntArray, point: JointPoint) -> None:
        """Displacement of a hub's end: across by its rotation, along in natural coordinates."""
        clamped = self.topology.index(point.ends[0].link)
        own = [*self._links[clamped].receding, *self._rotations(point.ends[0])[:1]]
        arm = point.hub * np.eye(2)[:, 2 - len(own) :]
        self._ties[link].append(HubEnd(rows, self.targets[clamped][own], clamped, arm))

    def _add_rotation(self, turn: JointRotation) -> None:
        rigid = [end for end in turn.ends if self.rigid.is_rigid(end)]
        if rigid:
            among = self.rigid.of_link(self.topology.index(rigid[0].link))[2]
            for end in turn.ends:
                if not self.rigid.is_rigid(end):
                    rows = self._rotations(end)
                    link = self.topology.index(end.link)
                    self._add_rigid(link, rows, np.full(len(rows), among))
            return
        root = self.topology.index(turn.ends[0].link)
        column = self.targets[root][self._rotations(turn.ends[0])[:1]]
        for number, end in enumerate(turn.ends):
            link, rows = self.topology.index(end.link), self._rotations(end)
            if number:
                self.targets[link][rows[:1]] = column
            if len(rows) > 1:
                self._ties[link].append(Tie(rows[1:], column))


def _depends_on(matrix: MatrixWithRates) -> IntArray:
    """Independent coordinates with a column in a matrix (1, r, n) in a general position."""
    return np.flatnonzero(np.abs(matrix.value[0]).max(axis=0, initial=0.0) > RANK_TOLERANCE)
