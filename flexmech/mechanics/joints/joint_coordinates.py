"""Coordinates of rigid links, sliders and leading ends of elastic links: coordinate partitioning.

A rigid link is a body with three coordinates in its link frame: the displacement of its start along
and across, and its rotation. The end of an elastic link on which others depend is one as well, in
the same frame. A slider has one: the displacement along its line. Pins, welds, pivots, clamps and
lines are constraints ``G(t) y = 0``. Some coordinates are independent, and ``y = Y(t) w``; the
derivatives of Y come from implicit differentiation (Shabana, *Computational Dynamics*, coordinate
partitioning). Ends of elastic links depend on rigid ones, never these on them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields, replace
from functools import cache, cached_property
from typing import Self

import numpy as np

from flexmech.arrays import ComplexArray, FloatArray, IntArray
from flexmech.linkages import LinkEnd, Pin, RigidMotion, Topology, Weld
from flexmech.linkages.body_motion import (
    GROUND_AFTER_LINKS,
    BodyMotion,
    BodyPoint,
    Coincidence,
    Condition,
    Constraints,
    EqualAngle,
    MatrixWithRates,
    dot,
)
from flexmech.linkages.inverse_dynamics import RANK_TOLERANCE, end_point, slider_line
from flexmech.linkages.topology import leading_end
from flexmech.mechanics.joints.position_errors import refuse_positions


@dataclass(frozen=True)
class DisplacedMotion(RigidMotion):
    """Rigid motion whose rigid links, with their frames, are displaced as in an equilibrium.

    Parameters
    ----------
    crank_angle, crank_speed, angle, angular_velocity, angular_acceleration : ndarray
        See :class:`RigidMotion`; batch of shape (B,).
    origin, origin_velocity, origin_acceleration : ndarray
        Likewise.
    turn : ndarray, shape (B, n_links)
        Rotation of each displaced rigid link against the rigid motion in rad; zero of flexible
        links.
    slide : ndarray, shape (B, n_sliders)
        Displacement of each slider along its line in m.
    """

    turn: FloatArray
    slide: FloatArray

    @classmethod
    def of(cls, motion: RigidMotion, turn: FloatArray, slide: FloatArray) -> Self:
        """A rigid motion with its rigid links displaced.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        turn : ndarray, shape (B, n_links)
        slide : ndarray, shape (B, n_sliders)
        """
        values = {field.name: getattr(motion, field.name) for field in fields(RigidMotion)}
        values["angle"] = motion.angle + turn
        return cls(**values, turn=turn, slide=slide)

    @property
    def undisplaced(self) -> RigidMotion:
        """The rigid motion itself."""
        values = {field.name: getattr(self, field.name) for field in fields(RigidMotion)}
        values["angle"] = self.angle - self.turn
        return RigidMotion(**values)


def link_bodies(motion: RigidMotion, topology: Topology) -> tuple[BodyMotion, ComplexArray]:
    """Links as bodies, and positions of sliders in the axes of their guides.

    Parameters
    ----------
    motion : RigidMotion
        Batch of shape (B,); its rigid links may be displaced.
    topology : Topology

    Returns
    -------
    bodies : BodyMotion
        Motion of the bodies, of shape (B, n_links + 1), the ground last.
    slid : ndarray of complex, shape (3, B, n_sliders)
        Places in m, and their first and second time derivative: an acceleration of the rigid
        motion along the line. On the ground the displacement alone.
    """
    bodies = drawn = BodyMotion.of_links(motion)
    slid = np.zeros((3, len(motion.crank_angle), len(topology.sliders)), dtype=complex)
    lines = [slider_line(topology, slider) for slider in topology.sliders]
    if isinstance(motion, DisplacedMotion) and lines:
        slid[0] = motion.slide * np.array([line.along for line in lines])
        if topology.has_moving_guides:
            drawn = BodyMotion.of_links(motion.undisplaced)
    for number, (slider, line) in enumerate(zip(topology.sliders, lines, strict=True)):
        if slider.guide:
            guide = line.second.body
            point = drawn.moving_point(line.first.body, line.first.place)
            relative, relative_1, relative_2 = (
                on_body - of_guide
                for on_body, of_guide in zip(point, drawn.moving_point(guide, 0j), strict=True)
            )
            back, turning = np.conj(drawn.turn[:, guide]), 1j * drawn.turn_1[:, guide]
            changing = turning**2 - 1j * drawn.turn_2[:, guide]
            rate = back * (relative_1 - turning * relative)
            second = back * (relative_2 - 2 * turning * relative_1 + changing * relative)
            slid[0][:, number] += back * relative
            # The point stays on its line: what round-off leaves across it is not motion.
            slid[1][:, number] = line.along * dot(line.along, rate)
            slid[2][:, number] = line.along * dot(line.along, second)
    return bodies, slid


@dataclass(frozen=True)
class JoinedEnds:
    """Link ends that coincide at a pin or a weld, or whose rotations are equal at a weld.

    Parameters
    ----------
    ends : tuple of LinkEnd
        The leader, by the topology, comes first.
    fixed : bool
        Whether they are fixed to the ground or to the prescribed shaft; ends on the hub of a free
        shaft, and rotations of one, are not.
    slider : int, optional
        Number of the slider on whose line they are.
    """

    ends: tuple[LinkEnd, ...]
    fixed: bool
    slider: int | None = None


class JointCoordinates:
    """Coordinates ``y`` of rigid links, leading ends and sliders of a topology.

    Parameters
    ----------
    topology : Topology

    Attributes
    ----------
    points, turns : list of JoinedEnds
        Ends that coincide, and ends whose rotations are equal or that a shaft turns.
    links : tuple of int
        Numbers of the rigid links; link ``links[k]`` has the coordinates ``3 k`` to ``3 k + 2``.
    ends : dict of LinkEnd to int
        Leading ends of elastic links by their numbers as bodies, which come after all links; their
        coordinates come after those of the rigid links.
    slides : ndarray of int, shape (n_sliders,)
        Coordinate of each slider; they come last.
    size : int
        Number of all coordinates y.
    w : ndarray of int, shape (n,)
        Independent ones; those of leading ends come last.
    independent_coordinates : ndarray of int
        The first of them, of rigid links and sliders.
    dependent_coordinates : ndarray of int, shape (d,)
        Those that depend on these.
    receding : list of LinkEnd
        Leading ends on a hub. A last coordinate of w of each moves it along by the hub's radius:
        ``cos(phi) - 1`` in natural coordinates.
    constraints : Constraints
        All constraints, redundant ones included.
    rows : ndarray of int, shape (d,)
        Constraint equations that determine the dependent coordinates.
    """

    def __init__(self, topology: Topology) -> None:
        self.topology = topology
        self.points, self.turns = joint_points(topology), _joint_rotations(topology)
        self.links = tuple(n for n, link in enumerate(topology.links) if link.rigid)
        self._hubs = {clamp.link_end: clamp.hub for clamp in topology.clamps if clamp.hub}
        ends = dict.fromkeys(self._leading_ends())
        self.ends = {end: len(topology.links) + n for n, end in enumerate(ends)}
        self._link_of = [topology.index(end.link) for end in self.ends]
        self._bodies = (*self.links, *self.ends.values())
        count = 3 * len(self._bodies)
        self.slides = np.arange(count, count + len(topology.sliders))
        self.size = count + len(self.slides)
        conditions: list[Condition] = [*self._coincidences(), *self._equal_angles()]
        self.constraints = Constraints(conditions, self._bodies, len(self.slides))
        independent, self.dependent_coordinates, self.rows = self._choose()
        of_ends = (independent >= 3 * len(self.links)) & (independent < count)
        self.independent_coordinates = independent[~of_ends]
        self.w = np.concatenate([self.independent_coordinates, independent[of_ends]])
        self.receding = [end for end in self.ends if end in self._hubs]

    @property
    def are_finite(self) -> bool:
        """Whether some may be large, on which constraints then depend: of rigid links and lines."""
        return bool(self.links or len(self.slides))

    def is_rigid(self, end: LinkEnd) -> bool:
        """Whether an end is that of a rigid link."""
        return self.topology.index(end.link) in self.links

    def of_body(self, number: int) -> IntArray:
        """The three coordinates among y of a rigid link or of a leading end, by its number."""
        return 3 * self._bodies.index(number) + np.arange(3)

    def rotation(self, turn: JoinedEnds) -> int:
        """The coordinate among y that is the rotation of ends which are not fixed."""
        return int(self.of_body(self._leading(turn).body)[2])

    def _leading(self, joined: JoinedEnds) -> BodyPoint:
        """Point of the end that leads: the first of a rigid link, or of all."""
        return self._point(next(filter(self.is_rigid, joined.ends), joined.ends[0]))

    def _point(self, end: LinkEnd) -> BodyPoint:
        """Point that an end of a rigid link, or a leading one, is of its body."""
        return BodyPoint(self.ends[end]) if end in self.ends else end_point(self.topology, end)

    def bodies(self, motion: RigidMotion) -> tuple[BodyMotion, ComplexArray]:
        """All links, leading ends and the ground about their reference points, and what slides.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).

        Returns
        -------
        bodies : BodyMotion
            Bodies of shape (B, n); their reference points are at zero.
        slid : ndarray of complex, shape (3, B, n_sliders)
            See :func:`link_bodies`.
        """
        links, slid = link_bodies(motion, self.topology)
        which = [*range(len(self.topology.links)), *self._link_of, GROUND_AFTER_LINKS]
        turn = links.turn[:, which]
        nowhere = np.zeros_like(turn)
        turning = links.turn_1[:, which], links.turn_2[:, which]
        return BodyMotion(nowhere[0], nowhere, turn, nowhere, nowhere, *turning), slid

    def by_links(self, of_bodies: FloatArray) -> FloatArray:
        """Sums (B, n_links) over each link and its leading ends of values of bodies (B, n)."""
        count = len(self.topology.links)
        total = of_bodies[:, :count].copy()
        for link, values in zip(self._link_of, of_bodies[:, count:-1].T, strict=True):
            total[:, link] += values
        return total

    def dependence(self, motion: RigidMotion) -> MatrixWithRates:
        """``Y``: derivative of all coordinates by w, (B, size, n).

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
        dependent = self.dependent_coordinates
        if not len(dependent):
            of_all = np.broadcast_to(
                self._of_chosen, (len(motion.crank_angle), *self._of_chosen.shape)
            )
            zero = np.broadcast_to(0.0, of_all.shape)
            return MatrixWithRates(of_all, zero, zero, zero)
        jacobian = self.constraints.jacobian_with_rates(*self.bodies(motion)).rows(self.rows)
        across = jacobian.columns(dependent)
        self.refuse_locked(motion, across.value)
        return MatrixWithRates(*self._completed(across.solve(-jacobian.columns(self.w)).parts))

    def finite_dependence(self, jacobian: FloatArray) -> FloatArray:
        """Derivative of all coordinates by w, (B, size, n), by a Jacobian (B, d, size)."""
        across, by_w = jacobian[:, :, self.dependent_coordinates], jacobian[:, :, self.w]
        solved = np.asarray(-np.linalg.solve(across, by_w), dtype=float)
        return np.asarray(self._completed([solved])[0])

    def _completed(self, dependent: Sequence[FloatArray]) -> FloatArray:
        """All coordinates by w: value and rates (k, B, size, n), from dependent ones (B, d, n)."""
        parts = np.zeros((len(dependent), len(dependent[0]), *self._of_chosen.shape))
        parts[0] = self._of_chosen
        for order, solved in enumerate(dependent):
            parts[order][:, self.dependent_coordinates, : len(self.w)] = solved
        return parts

    @cached_property
    def _of_chosen(self) -> FloatArray:
        """Coordinates (size, n) by the independent ones, without the dependent ones."""
        chosen = np.zeros((self.size, len(self.w) + len(self.receding)))
        chosen[self.w, np.arange(len(self.w))] = 1.0
        for number, end in enumerate(self.receding):
            chosen[self.of_body(self.ends[end])[0], len(self.w) + number] = self._hubs[end]
        return chosen

    def leader(self, point: JoinedEnds) -> BodyPoint | None:
        """Point of a line, of a rigid link or of an end on which other ends at a joint depend.

        Parameters
        ----------
        point : JoinedEnds

        Returns
        -------
        BodyPoint or None
            None of a fixed point.
        """
        if point.fixed:
            return None
        if point.slider is not None:
            return self.point_on_line(point.slider)
        return self._leading(point)

    def point_on_line(self, number: int) -> BodyPoint:
        """Point of a slider on its line."""
        line = slider_line(self.topology, self.topology.sliders[number])
        return BodyPoint(line.second.body, slide=number, along=line.along)

    def displacement_rows(
        self, motion: RigidMotion, points: Sequence[BodyPoint]
    ) -> MatrixWithRates:
        """Jacobian of points in ground axes by y, (B, 2 P, size).

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        points : sequence of BodyPoint
        """
        return self.constraints.points(points).jacobian_with_rates(*self.bodies(motion))

    @cached_property
    def general_position(self) -> RigidMotion:
        """One position with random link angles and origins, for rank decisions.

        The links are at rest and need not meet in it.
        """
        random, links = np.random.default_rng(0), self.topology.links
        angle, zero = random.uniform(-np.pi, np.pi, (1, len(links))), np.zeros((1, len(links)))
        length = max(link.length for link in links)
        origin = length * random.uniform(-1.0, 1.0, (1, len(links), 2))
        nowhere = np.zeros_like(origin)
        return RigidMotion(zero[:, 0], zero[:, 0], angle, zero, zero, origin, nowhere, nowhere)

    @cached_property
    def general_rows(self) -> Callable[[BodyPoint], FloatArray]:
        """From a point to its displacement in that position by w, (1, 2, n)."""

        @cache
        def rows(point: BodyPoint) -> FloatArray:
            moved = self.displacement_rows(self.general_position, [point]).value
            return np.asarray(moved @ self.general_dependence)

        return rows

    @cached_property
    def general_dependence(self) -> FloatArray:
        """Derivative of all coordinates by w in that position, (1, size, n)."""
        return self.dependence(self.general_position).value

    def _leading_ends(self) -> Iterator[LinkEnd]:
        """Ends of elastic links that others depend on, that a free shaft turns, or on a hub."""
        joined = [point.ends for point in self.points if not point.fixed and point.slider is None]
        joined += [turn.ends for turn in self.turns if not turn.fixed]
        yield from (ends[0] for ends in joined if not any(map(self.is_rigid, ends)))
        yield from (end for end in self._hubs if not self.is_rigid(end))

    def _coincidences(self) -> Iterator[Coincidence]:
        """Ends of rigid links that coincide with the leader or a fixed point, and ends on hubs."""
        ground = BodyPoint(GROUND_AFTER_LINKS)
        for joined in self.points:
            leader = self.leader(joined) or ground
            for end in filter(self.is_rigid, joined.ends):
                if self._point(end) != leader:
                    yield Coincidence(self._pinned(end), leader)
        yield from (Coincidence(self._pinned(end), ground) for end in self._hubs)

    def _pinned(self, end: LinkEnd) -> BodyPoint:
        """Point of a body that is pinned for an end: of a clamped one that on the axis."""
        point = self._point(end)
        return replace(point, place=point.place - self._hubs.get(end, 0.0))

    def _equal_angles(self) -> Iterator[EqualAngle]:
        """Rigid links whose rotation equals that of others or of the shaft."""
        for turn in self.turns:
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
        bodies, slid = self.bodies(self.general_position)
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
        stationary in a dead point does not. Displacements of ends depend on rotations, too.
        """
        links, ends = np.split(
            np.arange(self.size - len(self.slides)).reshape(-1, 3), [len(self.links)]
        )
        of_ends = [ends[:, :2].ravel(), ends[:, 2]]
        rotations = links[::-1, 2]
        return np.concatenate([*of_ends, links[:, :2].ravel(), self.slides, rotations])

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


@dataclass(frozen=True)
class RigidGeometricStiffness:
    """Geometric stiffness of rigid links and sliders under dead loads and joint forces.

    Parameters
    ----------
    rotation_stiffness : ndarray, shape (B, n_links)
        Rotation stiffness of each rigid link by its rotation in N m/rad; of a flexible one that of
        its hub.
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
            turn = joints.of_body(link)[2]
            total[:, turn, turn] = self.rotation_stiffness[:, link]
        for number, slider in enumerate(joints.topology.sliders):
            if slider.guide:
                turn, slide = (
                    joints.of_body(joints.topology.index(slider.guide))[2],
                    joints.slides[number],
                )
                total[:, turn, slide] = total[:, slide, turn] = self.guide_stiffness[:, number]
        return np.asarray(np.swapaxes(dependence, 1, 2) @ total @ dependence)


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


def held_ends(topology: Topology) -> set[LinkEnd]:
    """Ends whose displacement the ground or the shaft fixes; those on the hub of a free one move.

    Parameters
    ----------
    topology : Topology
    """
    held = {clamp.link_end for clamp in topology.clamps if not (clamp.free and clamp.hub)}
    return held | {pivot.link_end for pivot in topology.pivots if not pivot.sprung}


def joint_points(topology: Topology) -> list[JoinedEnds]:
    """Ends that are joined, fixed or on a slider's line; free tips are not among them.

    Parameters
    ----------
    topology : Topology

    Returns
    -------
    list of JoinedEnds
    """
    fixed, clamped = held_ends(topology), [clamp.link_end for clamp in topology.clamps]
    sliders = {slider.link_end: number for number, slider in enumerate(topology.sliders)}
    joined = _joined(topology, topology.rigid_ties, [*fixed, *clamped, *sliders])
    return [JoinedEnds(ends, ends[0] in fixed, sliders.get(ends[0])) for ends in joined]


def _joint_rotations(topology: Topology) -> list[JoinedEnds]:
    """Ends whose rotations are equal, fixed, or that of a free shaft."""
    fixed = {clamp.link_end: not clamp.free for clamp in topology.clamps}
    joined = _joined(topology, topology.welds, [*fixed])
    return [JoinedEnds(ends, fixed.get(ends[0], False)) for ends in joined]


def _joined(
    topology: Topology, ties: Sequence[Pin | Weld], leaders: Sequence[LinkEnd]
) -> list[tuple[LinkEnd, ...]]:
    """Some leaders and those of ties, with the ends that follow directly or through others."""
    joined = {leader: [leader] for leader in leaders}
    for tie in ties:
        leader = leading_end(tie.follower, ties)
        joined.setdefault(leader, [leader]).append(tie.follower)
    ordered = sorted(joined, key=lambda end: (topology.index(end.link), end.end == "end"))
    return [tuple(joined[leader]) for leader in ordered]
