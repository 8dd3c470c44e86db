"""Coordinates of rigid links and of sliders, and which of them the others follow from.

A rigid link has three coordinates in its link frame: the displacement of its start along and
across, and its rotation. A slider has one: the displacement along its line. Pins, welds, pivots,
clamps and lines tie them together: ``G(t) y = 0``. Some of them, ``w``, are independent, and
``y = Y(t) w``; the derivatives of Y follow by implicit differentiation. Flexible links follow:
rigid ones never follow them.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from flexmech.linear_system.joint_points import JointPoint, joint_points, turning_joints
from flexmech.linear_system.moving_matrix import MovingMatrix
from flexmech.linear_system.position_errors import refuse_positions
from flexmech.linkages import LinkEnd, RigidMotion, Topology
from flexmech.types import FloatArray, IntArray

__all__ = ["DisplacedMotion", "RigidCoordinates"]

# Singular values of the conditions, relative to the greatest, that count as none.
DEPENDENT = 1e-9
# Part of a column that is none of those before it, below which it adds nothing to the rank.
ADDS = 1e-7


@dataclass(frozen=True)
class DisplacedMotion(RigidMotion):
    """Motion whose rigid links are displaced, as in an equilibrium: their frames turn with them.

    Parameters
    ----------
    crank_angle, crank_speed, angle, angular_velocity, angular_acceleration : ndarray
        See :class:`RigidMotion`; batch of shape (B,).
    origin, origin_velocity, origin_acceleration : ndarray
        Likewise.
    turn : ndarray, shape (B, n_links)
        By how much each angle is that of the displaced rigid link rather than that of the rigid
        motion, in rad; zero of flexible links.
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
        own = {field.name: getattr(motion, field.name) for field in fields(RigidMotion)}
        own["angle"] = motion.angle + turn
        return cls(**own, turn=turn, slide=slide)

    def at(self, which: NDArray[np.bool_] | slice) -> DisplacedMotion:
        """See :meth:`RigidMotion.at`."""
        return type(self)(*(getattr(self, field.name)[which] for field in fields(self)))


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
    independent : ndarray of int, shape (n,)
        Which of them are w.
    """

    def __init__(self, topology: Topology) -> None:
        self.topology = topology
        self.links = tuple(n for n, link in enumerate(topology.links) if link.rigid)
        self.size = 3 * len(self.links) + len(topology.sliders)
        self._points = [point for point in joint_points(topology) if self._is_tied(point)]
        self._turns = [
            turn for turn in turning_joints(topology) if any(map(self.is_rigid, turn.ends))
        ]
        self.independent, self._dependent, self._rows = self._choose()

    def is_rigid(self, end: LinkEnd) -> bool:
        """Whether an end is that of a rigid link."""
        return self.topology.index(end.link) in self.links

    def of_link(self, link: int) -> IntArray:
        """The three coordinates of a rigid link among y."""
        return 3 * self.links.index(link) + np.arange(3)

    def moving(self, motion: RigidMotion) -> MovingMatrix:
        """``Y``: all coordinates from the independent ones, (B, size, n).

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).

        Returns
        -------
        MovingMatrix

        Raises
        ------
        ComputationError
            Where the independent ones do not settle the others; names the crank angle.
        """
        batch, count = len(motion.crank_angle), len(self.independent)
        chosen = np.zeros((self.size, count))
        chosen[self.independent, np.arange(count)] = 1.0
        if not len(self._dependent):
            return MovingMatrix.constant(chosen, batch)
        conditions = self._conditions(motion)
        across = conditions.columns(self._dependent)
        self._refuse_locked(motion, across.value)
        led = across.solve(-conditions.columns(self.independent))
        value, rate, centripetal, tangential = np.zeros((4, batch, self.size, count))
        value += chosen
        value[:, self._dependent] = led.value
        rate[:, self._dependent] = led.rate
        centripetal[:, self._dependent] = led.centripetal
        tangential[:, self._dependent] = led.tangential
        return MovingMatrix(value, rate, centripetal, tangential)

    def point(self, motion: RigidMotion, point: JointPoint) -> MovingMatrix | None:
        """Displacement of a point in ground axes by y, (B, 2, size).

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        point : JointPoint

        Returns
        -------
        MovingMatrix or None
            None of a point that is held, or that no rigid link and no line leads.
        """
        if point.slider is not None:
            return self._on_line(motion, point.slider)
        leads = [end for end in point.ends if self.is_rigid(end)]
        return None if point.held or not leads else self._end(motion, leads[0])

    def moves(self, rows: MovingMatrix) -> NDArray[np.bool_]:
        """Which of w a matrix (1, r, n) in a general position depends on."""
        value = np.abs(rows.value[0])
        return np.asarray(value.max(axis=0, initial=0.0) > DEPENDENT, dtype=bool)

    @cached_property
    def general_position(self) -> RigidMotion:
        """A motion of one position in which no links are in line, and which need not close."""
        return _general_position(self.topology)

    def _is_tied(self, point: JointPoint) -> bool:
        return any(map(self.is_rigid, point.ends))

    def _end(self, motion: RigidMotion, end: LinkEnd) -> MovingMatrix:
        """Displacement of a rigid link's end in ground axes by y."""
        link = self.topology.index(end.link)
        x = 0.0 if end.end == "start" else self.topology.links[link].length
        local = np.zeros((2, self.size))
        local[:, self.of_link(link)] = [[1.0, 0.0, 0.0], [0.0, 1.0, x]]
        return _rotation(motion, link) @ MovingMatrix.constant(local, len(motion.crank_angle))

    def _on_line(self, motion: RigidMotion, number: int) -> MovingMatrix:
        """Displacement of the point that slides on a line, in ground axes by y."""
        slider = self.topology.sliders[number]
        along = np.array([np.cos(slider.direction), np.sin(slider.direction)])
        batch, place = len(motion.crank_angle), 3 * len(self.links) + number
        local = np.zeros((2, self.size))
        local[:, place] = along
        if not slider.guide:
            return MovingMatrix.constant(local, batch)
        guide = self.topology.index(slider.guide)
        own = self.of_link(guide)
        local[:, own[:2]] = np.eye(2)
        moving = MovingMatrix.constant(local, batch)
        lever = _lever(motion, self.topology, number)
        quarter = np.array([[0.0, -1.0], [1.0, 0.0]])
        parts = {"value": lever.value, "rate": lever.rate, "tangential": lever.tangential}
        turned = {name: part[..., 0] @ quarter.T for name, part in parts.items()}
        local_parts = [
            _with_column(getattr(moving, name), own[2], turned.get(name))
            for name in ("value", "rate", "centripetal", "tangential")
        ]
        return _rotation(motion, guide) @ MovingMatrix(*local_parts)

    def _conditions(self, motion: RigidMotion) -> MovingMatrix:
        every = self._every_condition(motion)
        assert every is not None
        return MovingMatrix(
            *(
                part[:, self._rows]
                for part in (every.value, every.rate, every.centripetal, every.tangential)
            )
        )

    def _every_condition(self, motion: RigidMotion) -> MovingMatrix | None:
        """``G``, (B, conditions, size); displacements in m, rotations times one metre."""
        batch, parts = len(motion.crank_angle), []
        for point in self._points:
            leader = self.point(motion, point)
            rigid = [end for end in point.ends if self.is_rigid(end)]
            if leader is not None and point.slider is None:
                rigid = rigid[1:]
            for end in rigid:
                own = self._end(motion, end)
                parts.append(own if leader is None else own - leader)
        for turn in self._turns:
            rigid = [end for end in turn.ends if self.is_rigid(end)]
            rows = [self._turn_row(end) for end in rigid]
            if not turn.held:
                rows = [row - rows[0] for row in rows[1:]]
            parts += [MovingMatrix.constant(row, batch) for row in rows]
        return MovingMatrix.stacked(parts) if parts else None

    def _turn_row(self, end: LinkEnd) -> FloatArray:
        row = np.zeros((1, self.size))
        row[0, self.of_link(self.topology.index(end.link))[2]] = 1.0
        return row

    def _choose(self) -> tuple[IntArray, IntArray, IntArray]:
        """Independent and dependent coordinates, and the conditions that settle the latter.

        Chosen once, in a general position: who comes first and adds to the rank depends.
        """
        every = self._every_condition(_general_position(self.topology))
        if every is None:
            none = np.zeros(0, dtype=np.intp)
            return np.arange(self.size), none, none
        conditions = every.value[0]
        order = self._order()
        dependent = np.sort(order[_adding_to_the_rank(conditions[:, order])])
        rows = _adding_to_the_rank(conditions[:, dependent].T)
        independent = np.setdiff1d(np.arange(self.size), dependent)
        return independent, dependent, rows

    def _order(self) -> IntArray:
        """All coordinates; those that should be independent come last.

        Rotations, of the first links most of all, before slides, and these before displacements:
        what turns with a crank tells where the others are, what stands in a dead point does not.
        """
        count = len(self.links)
        every = np.arange(self.size)
        displacements = every[: 3 * count][every[: 3 * count] % 3 < 2]
        rotations = every[: 3 * count][every[: 3 * count] % 3 == 2]
        return np.concatenate([displacements, every[3 * count :], rotations[::-1]])

    def _refuse_locked(self, motion: RigidMotion, across: FloatArray) -> None:
        size = np.linalg.svd(across, compute_uv=False)
        names = ", ".join(self.topology.links[n].name for n in self.links)
        refuse_positions(
            motion,
            size[:, -1] <= DEPENDENT * size[:, 0],
            f"the rigid links ({names}) and lines lock or come loose",
            ": their ties do not settle how they move together; leave that crank angle out, or "
            "make one of the links elastic",
        )


def _adding_to_the_rank(matrix: FloatArray) -> IntArray:
    """Numbers of the columns that are no combination of those before them."""
    basis = np.zeros((len(matrix), 0))
    chosen = []
    for number, column in enumerate(matrix.T):
        rest = column
        for _ in range(2):  # twice is enough against round-off
            rest = rest - basis @ (basis.T @ rest)
        size = float(np.linalg.norm(rest))
        if size > ADDS * float(np.linalg.norm(column)):
            chosen.append(number)
            basis = np.column_stack([basis, rest / size])
    return np.array(chosen, dtype=np.intp)


def _rotation(motion: RigidMotion, link: int) -> MovingMatrix:
    """From a link's frame to ground axes, (B, 2, 2)."""
    return MovingMatrix.rotation(
        motion.angle[:, link],
        motion.angular_velocity[:, link],
        motion.angular_acceleration[:, link],
    )


def _lever(motion: RigidMotion, topology: Topology, number: int) -> MovingMatrix:
    """Where the point of a slider is in the frame of its guide, (B, 2, 1)."""
    slider = topology.sliders[number]
    guide, held = topology.index(slider.guide), topology.index(slider.held.link)
    x = 0.0 if slider.held.end == "start" else topology.links[held].length
    angle, moved = motion.angle, np.zeros(len(motion.crank_angle))
    if isinstance(motion, DisplacedMotion):
        angle, moved = motion.angle - motion.turn, motion.slide[:, number]
        motion = DisplacedMotion.of(motion, -motion.turn, motion.slide)
    back = MovingMatrix.rotation(
        -angle[:, guide],
        -motion.angular_velocity[:, guide],
        -motion.angular_acceleration[:, guide],
    )
    distance = MovingMatrix(
        (motion.position(held, x) - motion.origin[:, guide])[..., None],
        (motion.velocity(held, x) - motion.origin_velocity[:, guide])[..., None],
        np.zeros((len(angle), 2, 1)),
        (motion.acceleration(held, x) - motion.origin_acceleration[:, guide])[..., None],
    )
    lever = back @ distance
    along = np.array([np.cos(slider.direction), np.sin(slider.direction)])
    # The point stays on its line: what round-off leaves across it is not motion. The lever's
    # second derivative is an acceleration of the rigid motion along the line.
    sliding = [
        (part[..., 0] @ along)[:, None, None] * along[:, None] for part in (lever.rate, lever.twice)
    ]
    displaced = lever.value + moved[:, None, None] * along[:, None]
    return MovingMatrix(displaced, sliding[0], np.zeros_like(displaced), sliding[1])


def _with_column(matrix: FloatArray, column: int, values: FloatArray | None) -> FloatArray:
    if values is None:
        return matrix
    changed = matrix.copy()
    changed[:, :, column] = values
    return changed


def _general_position(topology: Topology) -> RigidMotion:
    """One position with the links at angles that have nothing to do with each other."""
    random = np.random.default_rng(0)
    count = len(topology.links)
    angle, still = random.uniform(-np.pi, np.pi, (1, count)), np.zeros((1, count))
    length = max(link.length for link in topology.links)
    origin = length * random.uniform(-1.0, 1.0, (1, count, 2))
    nowhere = np.zeros((1, count, 2))
    return RigidMotion(still[:, 0], still[:, 0], angle, still, still, origin, nowhere, nowhere)
