"""How the coordinates of links depend on independent ones, straight and at finite displacements.

A joint is one statement about a link's rows: they are joint coordinates y
(:mod:`flexmech.mechanics.joints.joint_coordinates`), or the displacement of a point of one of
their bodies in the link's frame. On straight links it is taken at ``y = 0``, with its time
derivatives; at finite displacements at the y of a pose.

The point r of a rigid link is at ``u + R(phi) r``: it is not linear in the rotation, and the
position constraints between rigid links are solved by Newton's method. A dead load F at r has the
geometric stiffness ``F . R(phi) r`` against the rotation, be it an inertia force, a weight or the
force of a joint. A bar in tension P has ``P / L`` between its ends.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, lru_cache, partial
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import ComplexArray, FloatArray, IntArray
from flexmech.linkages import LinkEnd, RigidMotion, Topology
from flexmech.linkages.body_motion import BodyMotion, BodyPoint, MatrixWithRates
from flexmech.linkages.inverse_dynamics import RANK_TOLERANCE, end_point
from flexmech.mechanics.joints.joint_coordinates import (
    DisplacedMotion,
    JointCoordinates,
    RigidGeometricStiffness,
)
from flexmech.mechanics.links.link_model import LinkModel
from flexmech.mechanics.links.rotation_terms import RotationTerms

# Newton's method takes five to eight from the straight linkage; more is no position near it.
ITERATIONS = 30
# Gap of the conditions in m, to the size of the longest link, and of angles in rad: fifty times the
# unit round-off. Where it stays above that, as far as it comes is enough if it closes to the
# second.
CLOSED, NEARLY_CLOSED = 1e-14, 1e-9

Matrix = TypeVar("Matrix", MatrixWithRates, FloatArray)


@dataclass(frozen=True)
class DependentRows:
    """Dependent coordinates of a link: ``q[rows] = turn @ z[columns]``; none of some links.

    A pinned end depends on its leader's end, rotated from that frame: two rows, two columns.
    An end on a line depends on the slide, one on a rigid link on that link's three coordinates.

    Parameters
    ----------
    rows : ndarray of int, shape (r,)
        Coordinates of the link, ascending.
    columns : ndarray of int, shape (c,)
        Independent coordinates of the linkage, ascending.
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
        if terms.centripetal or terms.tangential:
            return self.centripetal if terms.centripetal else self.tangential
        return np.zeros_like(self.turn)


class JointRows(NamedTuple):
    """Rows of a link that move with a joint.

    Parameters
    ----------
    link : int
    rows : ndarray of int, shape (r,)
    source : BodyPoint, or ndarray of int, shape (r,)
        The point whose displacement they are in the link's frame, or the joint coordinates that
        they are.
    """

    link: int
    rows: IntArray
    source: BodyPoint | IntArray


class Tie(NamedTuple):
    """Dependent rows of a link, and the independent coordinates that determine them.

    Parameters
    ----------
    rows : ndarray of int, shape (r,)
    source : BodyPoint, or ndarray of int, shape (r,)
        As of :class:`JointRows`.
    which : ndarray of int, shape (c,)
        Columns of the dependence of the joint coordinates.
    columns : ndarray of int, shape (c,)
        The same independent coordinates by their numbers in the linkage.
    """

    rows: IntArray
    source: BodyPoint | IntArray
    which: IntArray
    columns: IntArray


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
        Stiffness of rigid links, sliders and leading ends.
    joint_rows : list of JointRows
        All rows that move with joint coordinates.
    ties : list of list of Tie
        Ties of each link: those of them that are dependent.
    dependencies : list of tuple of ndarray of int, shape (r,), (c,)
        Dependencies of each link: its dependent coordinates and the coordinates of z that determine
        them.
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
        # A system asks for them ten times in the same positions.
        self._latest: tuple[RigidMotion, list[DependentRows]] | None = None
        self.joint_rows = [
            JointRows(link, np.arange(3), self.rigid.of_body(link)) for link in self.rigid.links
        ]
        self._connect_ends()
        self._number(last or [np.zeros(link.size, dtype=bool) for link in links])
        self.ties: list[list[Tie]] = [[] for _ in links]
        self._add_ties()
        self.dependencies = [
            (_united(tie.rows for tie in ties), _united(tie.columns for tie in ties))
            for ties in self.ties
        ]

    def _end(self, end: LinkEnd) -> tuple[int, LinkModel]:
        link = self.topology.index(end.link)
        return link, self.links[link]

    def _connect_ends(self) -> None:
        """Find what the ends of elastic links depend on; mark fixed and dependent coordinates."""
        rigid, independent = self.rigid, set(self.rigid.w.tolist())
        for end in self.topology.joined_ends:
            link, model = self._end(end)
            self.targets[link][model.end_warping_of(end.end)] = -1
        for point in rigid.points:
            leader = rigid.leader(point)
            for end in point.ends:
                link, model = self._end(end)
                rows = model.end_displacement(end.end)
                if model.rigid or not len(rows):
                    continue
                number = rigid.ends.get(end)  # of one that leads, or is held on a hub
                among = None if number is None else rigid.of_body(number)[:2]
                leads = leader is not None and leader.body == number
                if (source := among if leads or leader is None else leader) is not None:
                    self.joint_rows.append(JointRows(link, rows, source))
                if among is None or not (leads and independent.issuperset(among.tolist())):
                    self.targets[link][rows] = -1
        for turn in rigid.turns:
            for end in turn.ends:
                link, model = self._end(end)
                if model.rigid:
                    continue
                rows = model.end_rotation_of(end.end)
                leads = not turn.fixed and end in rigid.ends and end == turn.ends[0]
                self.targets[link][rows[1:] if leads else rows] = -1
                if not turn.fixed:
                    equal = np.full(len(rows), rigid.rotation(turn))
                    self.joint_rows.append(JointRows(link, rows, equal))

    def _number(self, last: Sequence[NDArray[np.bool_]]) -> None:
        """Number the free coordinates: of rigid links, of ends and of a free shaft, and others."""
        rigid, count = self.rigid, len(self.rigid.independent_coordinates)
        place = np.full(rigid.size, -1, dtype=np.intp)
        place[rigid.independent_coordinates] = np.arange(count)
        for number in rigid.links:
            self.targets[number][:] = place[rigid.of_body(number)]
        ends = [np.zeros(model.size, dtype=bool) for model in self.links]
        for model, at_ends in zip(self.links, ends, strict=True):
            at_ends[model.start] = at_ends[model.end] = at_ends[model.receding] = True
        for turn in rigid.turns:
            link, model = self._end(turn.ends[0])
            ends[link][model.end_rotation_of(turn.ends[0].end)[:1]] = True
        inner = [~(end | late) for end, late in zip(ends, last, strict=True)]
        ends = [end & ~late for end, late in zip(ends, last, strict=True)]
        for group in (ends, inner, last):
            for target, chosen in zip(self.targets, group, strict=True):
                free = np.flatnonzero((target == -2) & chosen)
                target[free] = np.arange(count, count + len(free))
                count += len(free)
            if group is ends:
                self.end_count = count
        self.size = count

    def _add_ties(self) -> None:
        """Add the dependence of marked coordinates on the joint coordinates that are numbered."""
        rigid = self.rigid
        place = np.full(rigid.size, -1, dtype=np.intp)
        place[rigid.independent_coordinates] = np.arange(len(rigid.independent_coordinates))
        for link, rows, source in self.joint_rows:
            if not isinstance(source, BodyPoint):
                numbers = self.targets[link][rows]
                place[source[numbers >= 0]] = numbers[numbers >= 0]
        receding = [-1] * len(rigid.receding)
        for number, end in enumerate(rigid.receding):
            link, model = self._end(end)
            for coordinate in model.receding:
                receding[number] = int(self.targets[link][coordinate])
        z = np.array([*place[rigid.w], *receding])
        y, moved = rigid.general_dependence, rigid.general_rows
        for link, rows, source in self.joint_rows:
            target = self.targets[link]
            if not isinstance(source, BodyPoint):
                for row, number in zip(rows, place[source], strict=True):
                    # Where two rows of one link are equal the second is dependent.
                    if target[row] < 0 <= number and number not in target:
                        target[row] = number
                source, rows = source[target[rows] < 0], rows[target[rows] < 0]
            by = moved(source) if isinstance(source, BodyPoint) else y[:, source]
            size = np.abs(by[0]).max(axis=0, initial=0.0)
            # In a general position, once and for all.
            if len(which := np.flatnonzero((size > RANK_TOLERANCE) & (z >= 0))):
                self.ties[link].append(Tie(rows, source, which, z[which]))

    def by_independent_coordinates(
        self,
        y: Matrix,
        turn: Callable[[int, int | None], Matrix],
        moved: Callable[[BodyPoint], Matrix],
    ) -> list[FloatArray]:
        """Derivatives of the dependent rows of each link by their columns.

        Parameters
        ----------
        y : MatrixWithRates or ndarray, shape (B, size, n)
            Joint coordinates by the independent ones among them.
        turn : callable
            Rotation to the frame of a link from that of another, or of None from ground axes.
        moved : callable
            Displacement of a point in ground axes by the independent joint coordinates.

        Returns
        -------
        list of ndarray, shape (k, B, r, c)
            The k parts of a matrix with rates; one of a matrix without.
        """
        elastic = {body: end for end, body in self.rigid.ends.items()}

        def derivative(link: int, tie: Tie) -> Matrix:
            if not isinstance(source := tie.source, BodyPoint):
                return _picked(y, source, tie.which)
            if (leader := elastic.get(source.body)) is None:
                return turn(link, None) @ _picked(moved(source), None, tie.which)
            # Speed: the general way takes twelve times as long for pins of elastic links.
            rotated = turn(link, self.topology.index(leader.link))
            if leader in self.rigid.receding:
                rotated = rotated @ _picked(y, self.rigid.of_body(source.body)[:2], tie.which)
            return rotated

        kinds, batch = np.shape(_parts(y))[:2]
        every = []
        for link, (rows, columns) in enumerate(self.dependencies):
            every.append(np.zeros((kinds, batch, len(rows), len(columns))))
            for tie in self.ties[link]:
                place = np.searchsorted(rows, tie.rows)[:, None]
                of_columns = np.searchsorted(columns, tie.columns)
                every[link][..., place, of_columns] = _parts(derivative(link, tie))
        return every

    def independent_coordinates(self, link: int) -> IntArray:
        """Coordinates of a link that are independent coordinates of the linkage, (k,)."""
        free = self.targets[link] >= 0
        free[self.dependencies[link][0]] = False
        return np.flatnonzero(free)

    def dependent_rows(self, motion: RigidMotion) -> list[DependentRows]:
        """Dependent coordinates of each link by the independent ones, with time derivatives.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).

        Returns
        -------
        list of DependentRows
            Dependent coordinates of each link.
        """
        if (latest := self._latest) is not None and latest[0] is motion:
            return latest[1]
        y = self.rigid.dependence(motion)

        @cache
        def moved(point: BodyPoint) -> MatrixWithRates:
            return self.rigid.displacement_rows(motion, [point]) @ y

        by = self.by_independent_coordinates(y, partial(_to_frame, motion), moved)
        rows = [
            DependentRows(*numbers, *derivative)
            for numbers, derivative in zip(self.dependencies, by, strict=True)
        ]
        self._latest = motion, rows
        return rows

    @property
    def has_arms(self) -> bool:
        """Whether forces act on arms that turn: there are rigid links, sliders or a hub."""
        return self.rigid.are_finite or bool(self.rigid.constraints.count)

    def displaced_ties(self, motion: RigidMotion, w: FloatArray) -> DisplacedTies:
        """Constraints at finite displacements of the rigid links, by Newton's method.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        w : ndarray, shape (B, n)
            Independent coordinates of rigid links and sliders, the first ones of z, in the
            frames of the rigid motion. Where no position satisfies the constraints, coordinates of
            the pose are not a number.

        Returns
        -------
        DisplacedTies
        """
        rigid, y = self.rigid, np.zeros((len(w), self.rigid.size))
        y[:, rigid.independent_coordinates] = w
        pose = DisplacedTies(self, motion, y)
        if not len(dependent := rigid.dependent_coordinates):
            return pose
        rigid.refuse_locked(motion, pose.jacobian[:, :, dependent])
        length = max(link.length for link in rigid.topology.links)
        for _ in range(ITERATIONS):
            gap = pose.gap
            if np.nanmax(np.abs(gap), initial=0.0) <= CLOSED * max(1.0, length):
                return pose
            y = pose.y.copy()
            across = pose.jacobian[:, :, dependent]
            y[:, dependent] -= np.linalg.solve(across, gap[..., None])[..., 0]
            pose = DisplacedTies(self, motion, y)
        closed = np.abs(pose.gap).max(axis=1) <= NEARLY_CLOSED * length
        return DisplacedTies(self, motion, np.where(closed[:, None], pose.y, np.nan))

    def displaced_ties_by(
        self, motion: RigidMotion, displacement: Sequence[FloatArray]
    ) -> DisplacedTies:
        """Constraints at displacements (B, n_link) of the links in the rigid motion's frames."""
        y = self._of_rigid_links(displacement)
        pose = DisplacedTies(self, motion, y)
        self._add_slides(
            motion,
            y,
            displacement,
            lambda point: pose.displacement([point])[:, 0],
            lambda line: pose.jacobian_of([line]),
        )
        return DisplacedTies(self, motion, y)

    def displaced(
        self, motion: RigidMotion, displacement: Sequence[FloatArray] | None
    ) -> RigidMotion:
        """Motion of the link frames with rigid links displaced by (B, n_link).

        Coordinates of rigid links are then those in their displaced frames.
        """
        if displacement is None or not self.rigid.are_finite:
            return motion
        return self.displaced_ties_by(motion, displacement).displaced

    def guide_matrix(self, motion: RigidMotion, guide_stiffness: FloatArray) -> FloatArray:
        """Geometric stiffness between rotations of guides and slides on them, (B, size, size).

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        guide_stiffness : ndarray, shape (B, n_sliders)
            In N/rad; see :class:`flexmech.mechanics.StressedLinks`.
        """
        first = len(self.rigid.independent_coordinates)
        total = np.zeros((len(guide_stiffness), self.size, self.size))
        zero = np.zeros((len(guide_stiffness), len(self.topology.links)))
        dependence = self.rigid.dependence(motion).value
        stiffness = RigidGeometricStiffness(zero, guide_stiffness)
        total[:, :first, :first] = stiffness.projected(self.rigid, dependence)
        return total

    def _slides(self, motion: RigidMotion, displacement: Sequence[NDArray[Any]]) -> NDArray[Any]:
        """Slides of small displacements (B, n_link, m) of all links, at their places in z."""
        rigid, y = self.rigid, self._of_rigid_links(displacement)
        self._add_slides(
            motion,
            y,
            displacement,
            lambda point: rigid.displacement_rows(motion, [point]).value @ y,
            lambda line: rigid.displacement_rows(motion, [line]).value,
        )
        y[:, : 3 * len(rigid.links)] = 0.0
        return y[:, rigid.independent_coordinates]

    def _of_rigid_links(self, displacement: Sequence[NDArray[Any]]) -> NDArray[Any]:
        """Joint coordinates (B, size, ...) of displacements of all links, without slides."""
        batch, _, *more = displacement[0].shape
        y = np.zeros((batch, self.rigid.size, *more), dtype=displacement[0].dtype)
        for link in self.rigid.links:
            y[:, self.rigid.of_body(link)] = displacement[link]
        return y

    def _add_slides(
        self,
        motion: RigidMotion,
        y: NDArray[Any],
        displacement: Sequence[NDArray[Any]],
        moved: Callable[[BodyPoint], NDArray[Any]],
        jacobian: Callable[[BodyPoint], FloatArray],
    ) -> None:
        """Fill the slides of joint coordinates: how far ends on lines are moved along these.

        ``moved`` has the displacement (B, 2, ...) of a point in ground axes, and ``jacobian`` its
        derivative (B, 2, size).
        """
        for number, slider in enumerate(self.topology.sliders):
            end, line = slider.link_end, self.rigid.point_on_line(number)
            link, model = self._end(end)
            if model.rigid:
                of_end = moved(end_point(self.topology, end))
            else:
                local = displacement[link][:, model.end_displacement(end.end)]
                back = _to_frame(motion, link).value
                of_end = np.einsum("bij,bi...->bj...", back, local)
            slide = self.rigid.slides[number]
            along = jacobian(line)[:, :, slide]
            y[:, slide] = np.einsum("bc,bc...->b...", along, of_end - moved(line))


class DisplacedTies:
    """Constraints over a batch of positions at finite displacements of rigid links and sliders.

    Parameters
    ----------
    ties : LinkTies
    motion : RigidMotion
        Batch of shape (B,), not displaced.
    y : ndarray, shape (B, size)
        Joint coordinates: displacements in the frames of the rigid motion, finite rotations,
        slides; zero of ends of elastic links.

    Attributes
    ----------
    displaced : DisplacedMotion
        Displacements of the link frames.
    """

    def __init__(self, ties: LinkTies, motion: RigidMotion, y: FloatArray) -> None:
        self._ties, self.motion, self.y = ties, motion, y
        self.rigid = rigid = ties.rigid
        turn = np.zeros((len(y), len(rigid.topology.links)))
        turn[:, list(rigid.links)] = y[:, 2 : 3 * len(rigid.links) : 3]
        self.displaced = DisplacedMotion.of(motion, turn, y[:, rigid.slides])

    @cached_property
    def _before(self) -> tuple[BodyMotion, ComplexArray]:
        """Undisplaced bodies about their reference points, and slider positions on them."""
        bodies, slid = self.rigid.bodies(self.motion)
        return bodies, slid[0]

    @cached_property
    def _after(self) -> tuple[BodyMotion, ComplexArray]:
        """Displaced bodies about their former reference points, and slider positions on them."""
        bodies, slid = self.rigid.bodies(self.displaced)
        place, links = np.zeros_like(bodies.place), list(self.rigid.links)
        u, v = (self.y[:, first : 3 * len(links) : 3] for first in (0, 1))
        place[:, links] = self._before[0].turn[:, links] * (u + 1j * v)
        return replace(bodies, place=place), slid[0]

    def displacement(self, points: Sequence[BodyPoint]) -> FloatArray:
        """Displacement of points of rigid links or of lines in ground axes, (B, P, 2)."""
        places = self.rigid.constraints.points(points).places
        moved = places(*self._after) - places(*self._before)
        return np.stack([moved.real, moved.imag], axis=-1)

    def jacobian_of(self, points: Sequence[BodyPoint]) -> FloatArray:
        """Jacobian of the displacement of points by y, (B, 2 P, size)."""
        bodies, slid = self._after
        of_points = self.rigid.constraints.points(points)
        return of_points.jacobian(bodies, self._before[0].turn, slid)

    @property
    def gap(self) -> FloatArray:
        """Violation (B, d) of the constraints that determine the dependent coordinates."""
        constraints = self.rigid.constraints
        gap = constraints.gap(*self._after) - constraints.gap(*self._before)
        return (gap + constraints.angle_gaps(self.y))[:, self.rigid.rows]

    @cached_property
    def jacobian(self) -> FloatArray:
        """Jacobian of these constraints by y, (B, d, size)."""
        bodies, slid = self._after
        jacobian = self.rigid.constraints.jacobian(bodies, self._before[0].turn, slid)
        return jacobian[:, self.rigid.rows]

    @cached_property
    def coordinates(self) -> FloatArray:
        """Derivative of all joint coordinates by the independent ones, (B, size, n)."""
        return self.rigid.finite_dependence(self.jacobian)

    @cached_property
    def rows(self) -> list[FloatArray]:
        """Derivatives (B, r, c) of the dependent rows of each link."""

        @cache
        def moved(point: BodyPoint) -> FloatArray:
            return self.jacobian_of([point]) @ self.coordinates

        by = self._ties.by_independent_coordinates(self.coordinates, self._turn, moved)
        return [derivative for (derivative,) in by]

    def _turn(self, link: int, leader: int | None) -> FloatArray:
        return _to_frame(self.motion, link, leader).value

    def put_places(self, link: int, q: FloatArray) -> None:
        """Set coordinates (B, n_link) of a link that are not linear in the independent ones."""
        count = len(self.rigid.independent_coordinates)
        for rows, source, which, _ in self._ties.ties[link]:
            if not (which < count).all():
                continue
            if isinstance(source, BodyPoint):
                moved = self.displacement([source])[:, 0, :, None]
                q[:, rows] = (self._turn(link, None) @ moved)[..., 0]
            else:
                q[:, rows] = self.y[:, source]

    def geometric_stiffness(
        self, forces: Sequence[FloatArray], rotation_stiffness: Mapping[int, FloatArray]
    ) -> RigidGeometricStiffness:
        """Geometric stiffness of rigid links, hubs and sliders by dead loads and joint forces.

        Parameters
        ----------
        forces : sequence of ndarray, shape (B, n_link)
            Applied less internal forces on each link in its frame.
        rotation_stiffness : mapping of int to ndarray, shape (B,)
            Rotation stiffness of each rigid link by its number: stiffness by its rotation of all
            forces but those of its joints, in N m/rad.

        Returns
        -------
        RigidGeometricStiffness
        """
        rigid, total, (bodies, slid) = self.rigid, np.zeros_like(self.y), self._after
        by_rotation, guide_stiffness = np.zeros(self.motion.angle.shape), np.zeros(slid.shape)
        for link in rigid.links:
            by_rotation[:, link] = rotation_stiffness[link]
        acting: dict[int, tuple[BodyPoint, ComplexArray]] = {}
        for number, (link, rows, source) in enumerate(self._ties.joint_rows):
            if isinstance(source, BodyPoint):
                force = forces[link][:, rows[0]] + 1j * forces[link][:, rows[1]]
                acting[number] = source, force * np.exp(1j * self.motion.angle[:, link])
            else:
                for row, coordinate in zip(rows, source, strict=True):
                    total[:, coordinate] += forces[link][:, row]
        stiffnesses = []
        if acting:
            sources, vectors = zip(*acting.values(), strict=True)
            given, jacobian = np.stack(vectors, axis=1), self.jacobian_of(sources)
            total += np.einsum("bpi,bp->bi", jacobian[:, ::2], given.real)
            total += np.einsum("bpi,bp->bi", jacobian[:, 1::2], given.imag)
            points = rigid.constraints.points(sources)
            stiffnesses.append(points.geometric_stiffness(bodies, slid, given))
        if len(dependent := rigid.dependent_coordinates):
            across = np.swapaxes(self.jacobian[:, :, dependent], 1, 2)
            joints = np.zeros((len(total), rigid.constraints.count))
            joints[:, rigid.rows] = -np.linalg.solve(across, total[:, dependent, None])[..., 0]
            stiffnesses.append(rigid.constraints.geometric_stiffness(bodies, slid, joints))
        for by_arm, by_line in stiffnesses:
            by_rotation += rigid.by_links(by_arm)
            guide_stiffness += by_line
        return RigidGeometricStiffness(by_rotation, guide_stiffness)


def _united(parts: Iterable[IntArray]) -> IntArray:
    """Numbers that are in any of several arrays, ascending."""
    return np.array(
        sorted({number for numbers in parts for number in numbers.tolist()}), dtype=np.intp
    )


def _parts(matrix: Matrix) -> Sequence[FloatArray]:
    """Matrix and its rates, or a matrix without rates alone."""
    return matrix.parts if isinstance(matrix, MatrixWithRates) else (matrix,)


def _picked(matrix: Matrix, rows: IntArray | None, columns: IntArray) -> Matrix:
    """Rows, or all of None, and columns of a matrix with or without rates."""
    if isinstance(matrix, MatrixWithRates):
        return (matrix if rows is None else matrix.rows(rows)).columns(columns)
    return (matrix if rows is None else matrix[:, rows])[:, :, columns]


def _to_frame(motion: RigidMotion, link: int, leader: int | None = None) -> MatrixWithRates:
    """Rotation to the frame of a link from that of another, or from ground axes, (B, 2, 2)."""
    turn = np.stack([motion.angle, motion.angular_velocity, motion.angular_acceleration])
    others = 0.0 if leader is None else turn[..., leader]
    return MatrixWithRates.rotation(*(others - turn[..., link]))
