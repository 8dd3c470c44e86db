"""Radial springs of sprung joints in a nonlinear equilibrium."""

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
from flexmech.reference.assembly import LinkRows, Ties


@dataclass(frozen=True)
class _End:
    """An end of a spring: sign, coordinates of its link that move it, and point of a rigid one."""

    sign: float
    rows: IntArray
    by_z: LinkRows
    point: BodyPoint | None

    @classmethod
    def of(cls, frames: LinkFrames, end: LinkEnd, sign: float) -> _End:
        number = frames.topology.index(end.link)
        link = frames.links[number]
        rows = np.arange(3) if link.rigid else link.end_displacement(end.end)
        point = end_point(frames.topology, end) if link.rigid else None
        return cls(sign, rows, LinkRows(frames, number, rows), point)

    def moved(self, motion: RigidMotion, displaced: DisplacedTies | None) -> FloatArray:
        """Derivative of its place in ground axes by the coordinates of its link, (2, r, B)."""
        if self.point is None:
            angle = motion.angle[:, self.by_z.link]
            return self.sign * np.stack([direction(angle).T, normal(angle).T], axis=1)
        assert displaced is not None
        own = displaced.pose.rigid.of_link(self.by_z.link)
        moved = displaced.pose.rows([self.point])[:, :, own]
        return np.asarray(self.sign * np.moveaxis(moved, 0, -1))


class RadialSprings:
    """Radial springs of the joints of one linkage.

    The force of a joint is ``F = k d`` in ground axes with the gap d between its two ends, which is
    part of the equilibrium. It does not rotate with the links. The place of an end of a rigid link
    is that of its pose, so that the force has a geometric stiffness as well.

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
        topology = frames.topology
        own = [x for x in springs if x.joint in topology.sprung_joints and x.radial_stiffness]
        self._stiffness = [float(spring.radial_stiffness or 0.0) for spring in own]
        self._ends = [
            [_End.of(frames, end, sign) for sign, end in zip((1.0, -1.0), ends, strict=True) if end]
            for ends in (topology.pinned_ends[spring.joint] for spring in own)
        ]
        self.columns = [
            np.unique(np.concatenate([end.by_z.columns for end in ends])) for ends in self._ends
        ]

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
        rotation_stiffness = np.zeros(motion.angle.shape)
        for stiffness, ends in zip(self._stiffness, self._ends, strict=True):
            moved, gap = [end.moved(motion, displaced) for end in ends], np.zeros(1)
            for end, by_link in zip(ends, moved, strict=True):
                if end.point is None:
                    q = displacement[end.by_z.link][end.rows]
                    gap = gap + np.einsum("crb,rb->cb", by_link, q)
                else:
                    assert displaced is not None
                    gap = gap + end.sign * displaced.pose.displacement([end.point])[:, 0].T
            force = stiffness * gap
            for end, by_link in zip(ends, moved, strict=True):
                forces[end.by_z.link][end.rows] += np.einsum("crb,cb->rb", by_link, force)
                if end.point is not None:
                    # A quarter turn back from how a rotation moves the end is its arm.
                    along, across = by_link[:, 2]
                    rotation_stiffness[:, end.by_z.link] -= force[0] * across - force[1] * along
        return rotation_stiffness

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
            moved = np.zeros((2, len(columns), len(motion.crank_angle)))
            for end in ends:
                by_link = end.moved(motion, ties.displaced)
                by_z = np.einsum("crb,rnb->cnb", by_link, end.by_z.derivative(ties))
                moved[:, np.searchsorted(columns, end.by_z.columns)] += by_z
            yield stiffness * np.einsum("cib,cjb->ijb", moved, moved)
