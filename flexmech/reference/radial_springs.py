"""Radial springs of sprung joints in a nonlinear equilibrium.

The force of the joint is ``F = k d`` in ground axes with the gap d between its two ends, which is
part of the equilibrium. It does not rotate with the links. The place of an end of a rigid link is
that of its pose, so that the force has a geometric stiffness as well.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system import DisplacedTies, LinkFrames
from flexmech.linkages import JointSpring, LinkEnd, RigidMotion
from flexmech.linkages.body_motion import BodyPoint
from flexmech.linkages.connection_forces import end_point
from flexmech.linkages.motion import direction, normal
from flexmech.reference.dependent_element import Ties


@dataclass(frozen=True)
class _End:
    """An end of a spring: sign, link, rows (2,) of a flexible link, and point of a rigid one."""

    sign: float
    link: int
    rows: IntArray
    point: BodyPoint | None


class RadialSprings:
    """Radial springs of the joints of one linkage.

    Parameters
    ----------
    frames : LinkFrames
        Of the unreduced links, without constraints of these joints.
    springs : sequence of JointSpring

    Attributes
    ----------
    columns : list of ndarray of int
        Independent coordinates that move the ends of each spring.
    """

    columns: list[IntArray]

    def __init__(self, frames: LinkFrames, springs: Sequence[JointSpring]) -> None:
        self._frames = frames
        topology = frames.topology
        sprung = topology.sprung_joints
        sprung_joints = [own for own in springs if own.joint in sprung and own.radial_stiffness]
        self._stiffness = [float(own.radial_stiffness or 0.0) for own in sprung_joints]
        self._ends = [
            [self._end(sign, end) for sign, end in zip((1.0, -1.0), ends, strict=True) if end]
            for ends in (topology.pinned_ends[own.joint] for own in sprung_joints)
        ]
        self.columns = [self._columns(ends) for ends in self._ends]

    def add_forces(
        self,
        motion: RigidMotion,
        displacement: Sequence[FloatArray],
        forces: Sequence[FloatArray],
        displaced: DisplacedTies | None,
    ) -> FloatArray:
        """Add the spring forces to the internal forces; returns the geometric stiffness.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        displacement, forces : sequence of ndarray, shape (n_link, B)
        displaced : DisplacedTies or None
            Of the rigid links at these displacements.

        Returns
        -------
        ndarray, shape (B, n_links)
            Geometric stiffness of rigid links.
        """
        stiffness_of_rotation = np.zeros(motion.angle.shape)
        for stiffness, ends in zip(self._stiffness, self._ends, strict=True):
            force = stiffness * self._gap(motion, displacement, ends, displaced)
            for end in ends:
                if end.point is None:
                    own, angle = forces[end.link], motion.angle[:, end.link]
                    own[end.rows[0]] += end.sign * np.sum(force * direction(angle), axis=1)
                    own[end.rows[1]] += end.sign * np.sum(force * normal(angle), axis=1)
                    continue
                moved = self._moved_by_link(end, displaced)
                forces[end.link][:] += np.einsum("cyb,bc->yb", moved, force)
                # A quarter turn back from how a rotation moves the end is its arm.
                along, across = moved[:, 2]
                stiffness_of_rotation[:, end.link] -= force[:, 0] * across - force[:, 1] * along
        return stiffness_of_rotation

    def tangents(self, motion: RigidMotion, ties: Ties) -> Iterator[FloatArray]:
        """Stiffness of each spring by its :attr:`columns`, (m, m, B), one after the other.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        ties : Ties
            Of the displaced links.
        """
        for stiffness, ends, columns in zip(self._stiffness, self._ends, self.columns, strict=True):
            moved = np.zeros((2, self._frames.size, len(motion.crank_angle)))
            for end in ends:
                self._add_moved(moved, end, motion, ties)
            own = moved[:, columns]
            yield stiffness * np.einsum("cib,cjb->ijb", own, own)

    def _end(self, sign: float, end: LinkEnd) -> _End:
        number = self._frames.topology.index(end.link)
        link = self._frames.links[number]
        point = end_point(self._frames.topology, end) if link.rigid else None
        return _End(sign, number, link.end_displacement(end.end), point)

    def _columns(self, ends: Sequence[_End]) -> IntArray:
        """Coordinates that may move these ends."""
        found = [np.zeros(0, dtype=np.intp)]
        for end in ends:
            if end.point is not None:
                found.append(np.arange(len(self._frames.rigid.independent_coordinates)))
                continue
            target = self._frames.targets[end.link][end.rows]
            found.append(target[target >= 0])
            for rows, columns in self._frames.dependencies(end.link):
                if np.isin(end.rows, rows).any():
                    found.append(columns[columns >= 0])
        return np.unique(np.concatenate(found))

    def _gap(
        self,
        motion: RigidMotion,
        displacement: Sequence[FloatArray],
        ends: Sequence[_End],
        displaced: DisplacedTies | None,
    ) -> FloatArray:
        """Gap between the ends in ground axes, (B, 2)."""
        gap = np.zeros((len(motion.crank_angle), 2))
        for end in ends:
            if end.point is not None:
                assert displaced is not None
                gap += end.sign * displaced.pose.displacement([end.point])[:, 0]
                continue
            q, angle = displacement[end.link], motion.angle[:, end.link]
            gap += end.sign * q[end.rows[0], :, None] * direction(angle)
            gap += end.sign * q[end.rows[1], :, None] * normal(angle)
        return gap

    def _moved_by_link(self, end: _End, displaced: DisplacedTies | None) -> FloatArray:
        """Derivative of an end's place by the coordinates of its rigid link, (2, 3, B)."""
        assert end.point is not None
        assert displaced is not None
        moved = displaced.pose.rows([end.point])[:, :, self._frames.rigid.of_link(end.link)]
        return np.asarray(end.sign * np.moveaxis(moved, 0, -1))

    def _add_moved(self, moved: FloatArray, end: _End, motion: RigidMotion, ties: Ties) -> None:
        """Add the derivative of an end's place by the coordinates to ``moved`` (2, size, B)."""
        if end.point is not None:
            assert ties.displaced is not None
            by_y = ties.displaced.pose.coordinates[:, self._frames.rigid.of_link(end.link)]
            own = self._moved_by_link(end, ties.displaced)
            moved[:, : by_y.shape[2]] += np.einsum("cyb,byn->cnb", own, by_y)
            return
        angle = motion.angle[:, end.link]
        axes = end.sign * np.stack([direction(angle).T, normal(angle).T], axis=1)
        dependencies = self._frames.dependencies(end.link)
        target = self._frames.targets[end.link][end.rows]
        for number, (rows, columns) in enumerate(dependencies):
            place = np.flatnonzero(np.isin(end.rows, rows))
            if len(place):
                turn = ties.turns[end.link][number][np.searchsorted(rows, end.rows[place])]
                moved[:, columns] += np.einsum("crb,rnb->cnb", axes[:, place], turn)
                target = np.where(np.isin(np.arange(2), place), -1, target)
        for row in np.flatnonzero(target >= 0):
            moved[:, target[row]] += axes[:, row]
