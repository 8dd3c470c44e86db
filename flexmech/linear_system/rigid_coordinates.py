"""Coordinates of rigid links and of sliders, and which of them the others follow from.

A rigid link has three coordinates in its link frame: the displacement of its start along and
across, and its rotation. A slider has one: the displacement along its line. Pins, welds, pivots,
clamps and lines tie them together: ``G(t) y = 0``. Some of them, ``w``, are independent, and
``y = Y(t) w``; the derivatives of Y follow by implicit differentiation. Flexible links follow:
rigid ones never follow them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flexmech.linear_system.displaced_motion import (
    frame_rotation,
    general_position,
    slider_lever,
)
from flexmech.linear_system.joint_points import JointPoint, joint_points, turning_joints
from flexmech.linkages.matrix_with_rates import MatrixWithRates as MovingMatrix
from flexmech.linear_system.position_errors import refuse_positions
from flexmech.linkages import LinkEnd, RigidMotion, Topology
from flexmech.types import FloatArray, IntArray

# Singular values of the conditions, relative to the greatest, that count as none.
DEPENDENT = 1e-9
# Part of a column that is none of those before it, below which it adds nothing to the rank.
ADDS = 1e-7


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
    independent, dependent : ndarray of int, shape (n,), (size - n,)
        Which of them are w, and which follow.
    """

    def __init__(self, topology: Topology) -> None:
        self.topology = topology
        self.links = tuple(n for n, link in enumerate(topology.links) if link.rigid)
        self.size = 3 * len(self.links) + len(topology.sliders)
        self._points = [point for point in joint_points(topology) if self._is_tied(point)]
        self._turns = [
            turn for turn in turning_joints(topology) if any(map(self.is_rigid, turn.ends))
        ]
        self.independent, self.dependent, self._rows = self._choose()

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
        if not len(self.dependent):
            return MovingMatrix.constant(chosen, batch)
        conditions = self.conditions(motion)
        across = conditions.columns(self.dependent)
        self.refuse_locked(motion, across.value)
        led = across.solve(-conditions.columns(self.independent))
        value, rate, centripetal, tangential = np.zeros((4, batch, self.size, count))
        value += chosen
        value[:, self.dependent] = led.value
        rate[:, self.dependent] = led.rate
        centripetal[:, self.dependent] = led.centripetal
        tangential[:, self.dependent] = led.tangential
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
        return None if point.held or not leads else self.end_rows(motion, leads[0])

    def lever(self, motion: RigidMotion, slider: int) -> FloatArray:
        """Where the point of a slider is in the frame of its guide, (B, 2) in m."""
        return slider_lever(motion, self.topology, slider).value[..., 0]

    def moves(self, rows: MovingMatrix) -> NDArray[np.bool_]:
        """Which of w a matrix (1, r, n) in a general position depends on."""
        value = np.abs(rows.value[0])
        return np.asarray(value.max(axis=0, initial=0.0) > DEPENDENT, dtype=bool)

    @cached_property
    def general_position(self) -> RigidMotion:
        """A motion of one position in which no links are in line, and which need not close."""
        return general_position(self.topology)

    def _is_tied(self, point: JointPoint) -> bool:
        return any(map(self.is_rigid, point.ends))

    def end_rows(self, motion: RigidMotion, end: LinkEnd) -> MovingMatrix:
        """Displacement of a rigid link's end in ground axes by y, (B, 2, size).

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        end : LinkEnd
        """
        link = self.topology.index(end.link)
        x = 0.0 if end.end == "start" else self.topology.links[link].length
        local = np.zeros((2, self.size))
        local[:, self.of_link(link)] = [[1.0, 0.0, 0.0], [0.0, 1.0, x]]
        return frame_rotation(motion, link) @ MovingMatrix.constant(local, len(motion.crank_angle))

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
        lever = slider_lever(motion, self.topology, number)
        quarter = np.array([[0.0, -1.0], [1.0, 0.0]])
        parts = {"value": lever.value, "rate": lever.rate, "tangential": lever.tangential}
        turned = {name: part[..., 0] @ quarter.T for name, part in parts.items()}
        local_parts = [
            _with_column(getattr(moving, name), own[2], turned.get(name))
            for name in ("value", "rate", "centripetal", "tangential")
        ]
        return frame_rotation(motion, guide) @ MovingMatrix(*local_parts)

    def conditions(self, motion: RigidMotion) -> MovingMatrix:
        """``G``: ties that settle the dependent coordinates, (B, size - n, size).

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).

        Returns
        -------
        MovingMatrix
            Displacements in ground axes in m, rotations in rad.
        """
        every = self._every_condition(motion)
        assert every is not None
        return MovingMatrix(
            *(
                part[:, self._rows]
                for part in (every.value, every.rate, every.centripetal, every.tangential)
            )
        )

    def _every_condition(self, motion: RigidMotion) -> MovingMatrix | None:
        """All ties, (B, conditions, size), also those that others imply."""
        batch, parts = len(motion.crank_angle), []
        for end, point in self._tied_ends:
            own, leader = self.end_rows(motion, end), self.point(motion, point)
            parts.append(own if leader is None else own - leader)
        for one, other in self._tied_turns:
            row = self._turn_row(one)
            row = row if other is None else row - self._turn_row(other)
            parts.append(MovingMatrix.constant(row, batch))
        return MovingMatrix.stacked(parts) if parts else None

    def gaps(
        self, displacement: Callable[[JointPoint | LinkEnd], FloatArray], y: FloatArray
    ) -> FloatArray:
        """By how much :meth:`conditions` are not satisfied, (B, size - n).

        Parameters
        ----------
        displacement : callable
            Of a rigid link's end and of what leads a point, in ground axes, (B, 2).
        y : ndarray, shape (B, size)

        Returns
        -------
        ndarray
        """
        parts = []
        for end, point in self._tied_ends:
            own = displacement(end)
            parts.append(own if self._is_held(point) else own - displacement(point))
        for one, other in self._tied_turns:
            row = self._turn_row(one)
            row = row if other is None else row - self._turn_row(other)
            parts.append(y @ row.T)
        return np.concatenate(parts, axis=1)[:, self._rows]

    def tie_forces(
        self, forces: FloatArray, at_points: Mapping[JointPoint, FloatArray]
    ) -> Iterator[tuple[LinkEnd | int, FloatArray]]:
        """Forces on ends of rigid links and on lines, in ground axes.

        Parameters
        ----------
        forces : ndarray, shape (B, size - n)
            Of :meth:`conditions`.
        at_points : mapping of JointPoint to ndarray, shape (B, 2)
            Forces of flexible links on points that lead them.

        Yields
        ------
        tuple of LinkEnd or int and ndarray, shape (B, 2)
            An end, or the number of a slider, and the force on it.
        """
        every = np.zeros((len(forces), 2 * len(self._tied_ends) + len(self._tied_turns)))
        every[:, self._rows] = forces
        leading = {point: force.copy() for point, force in at_points.items()}
        for number, (end, point) in enumerate(self._tied_ends):
            force = every[:, 2 * number : 2 * number + 2]
            yield end, force
            if not self._is_held(point):
                leading[point] = leading.get(point, 0.0) - force
        for point, force in leading.items():
            if point.slider is not None:
                yield point.slider, force
            else:
                yield next(end for end in point.ends if self.is_rigid(end)), force

    def _is_held(self, point: JointPoint) -> bool:
        return point.held and point.slider is None

    @cached_property
    def _tied_ends(self) -> list[tuple[LinkEnd, JointPoint]]:
        """Ends of rigid links, and the points that they are tied to and do not lead."""
        tied = []
        for point in self._points:
            rigid = [end for end in point.ends if self.is_rigid(end)]
            leads = not point.held and point.slider is None
            tied += [(end, point) for end in rigid[1 if leads else 0 :]]
        return tied

    @cached_property
    def _tied_turns(self) -> list[tuple[LinkEnd, LinkEnd | None]]:
        """Ends of rigid links that turn with others; None with the shaft."""
        tied: list[tuple[LinkEnd, LinkEnd | None]] = []
        for turn in self._turns:
            rigid = [end for end in turn.ends if self.is_rigid(end)]
            if turn.held:
                tied += [(end, None) for end in rigid]
            else:
                tied += [(end, rigid[0]) for end in rigid[1:]]
        return tied

    def _turn_row(self, end: LinkEnd) -> FloatArray:
        row = np.zeros((1, self.size))
        row[0, self.of_link(self.topology.index(end.link))[2]] = 1.0
        return row

    def _choose(self) -> tuple[IntArray, IntArray, IntArray]:
        """Independent and dependent coordinates, and the conditions that settle the latter.

        Chosen once, in a general position: who comes first and adds to the rank depends.
        """
        every = self._every_condition(self.general_position) if self.size else None
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

    def refuse_locked(self, motion: RigidMotion, across: FloatArray) -> None:
        """Refuse positions where the ties do not settle the dependent coordinates.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        across : ndarray, shape (B, n, n)
            Derivative of the ties by these.

        Raises
        ------
        ComputationError
            Names the crank angle.
        """
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


def _with_column(matrix: FloatArray, column: int, values: FloatArray | None) -> FloatArray:
    if values is None:
        return matrix
    changed = matrix.copy()
    changed[:, :, column] = values
    return changed
