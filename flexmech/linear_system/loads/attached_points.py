"""Points of links at which forces act, and their displacement in link and ground axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linear_system.joints.link_frames import LinkFrames
from flexmech.linear_system.joints.link_place import DependentRows
from flexmech.linear_system.links.link_model import LinkModel
from flexmech.linkages import RigidMotion
from flexmech.linkages.motion import direction, normal


@dataclass(frozen=True)
class AttachedPoint:
    """A point on the axis of a link.

    Parameters
    ----------
    link : int
        Number of the link.
    x : float
        Distance from the link's start in m.
    rows : ndarray, shape (3, n_link)
        Displacement along and across the link's frame, and rotation, by the link's coordinates;
        of a rigid link for small rotations.
    end_rows : ndarray, shape (3, n_link)
        The same by the link's joined ends alone; see
        :class:`flexmech.linear_system.links.link_model.EndMatrices`.
    rigid : bool
        Whether the link is rigid.
    """

    link: int
    x: float
    rows: FloatArray
    end_rows: FloatArray
    rigid: bool = False

    @classmethod
    def of(
        cls, links: Sequence[LinkModel], link: int, fraction: float, length: float
    ) -> AttachedPoint:
        """A point of a link.

        Parameters
        ----------
        links : sequence of LinkModel
            Reduced or not.
        link : int
        fraction : float
            Of the link's length from its start.
        length : float
            Of the link in m.
        """
        rows, end_rows = (
            np.concatenate(
                [each.displacement_at(np.array([fraction]))[0], each.rotation_at(fraction)[None]]
            )
            for each in (links[link].readings, links[link].ends.readings)
        )
        return cls(link, fraction * length, rows, end_rows, links[link].rigid)

    def force(
        self,
        motion: RigidMotion,
        force: FloatArray,
        torque: FloatArray,
        q: FloatArray | None = None,
    ) -> FloatArray:
        """Generalized force on the link's coordinates.

        The moment on a rigid link at the rotation phi is
        ``cos(phi) moment - sin(phi) virial``; see
        :mod:`flexmech.linear_system.links.dead_moments`. A torque does not
        depend on the rotation: its part of the moment is ``torque cos(phi)``, and of the virial
        ``-torque sin(phi)``.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        force : ndarray, shape (B, 2)
            In ground axes.
        torque : ndarray, shape (B,)
        q : ndarray, shape (B, n_link), optional
            Displacement of the link; zero where it is left out.

        Returns
        -------
        ndarray, shape (B, n_link)
        """
        angle = motion.angle[:, self.link]
        if self.rigid and q is not None:
            torque = torque * np.cos(q[:, 2])
        cosine, sine = np.cos(angle), np.sin(angle)
        along = cosine * force[:, 0] + sine * force[:, 1]
        across = cosine * force[:, 1] - sine * force[:, 0]
        return np.asarray(np.stack([along, across, torque], axis=1) @ self.rows)

    def finite_force(
        self, motion: RigidMotion, force: FloatArray, torque: FloatArray, q: FloatArray
    ) -> FloatArray:
        """Generalized force on the coordinates of the displaced link, with its arm as it is turned.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        force : ndarray, shape (B, 2)
            In ground axes.
        torque : ndarray, shape (B,)
        q : ndarray, shape (B, n_link)
            Displacement of the link.

        Returns
        -------
        ndarray, shape (B, n_link)
        """
        if not self.rigid:
            return self.force(motion, force, torque)
        turned = motion.angle[:, self.link] + q[:, 2]
        moment = torque + self.x * np.sum(force * normal(turned), axis=1)
        found = self.force(motion, force, moment)
        found[:, 2] = moment
        return found

    def finite_rows(self, q: FloatArray) -> FloatArray:
        """Derivative of :meth:`finite_displacement` in the link's axes by its coordinates.

        Parameters
        ----------
        q : ndarray, shape (B, n_link)
            Displacement of the link.

        Returns
        -------
        ndarray, shape (B, 3, n_link)
        """
        rows = np.tile(self.rows, (len(q), 1, 1))
        if self.rigid:
            rows[:, 0, 2], rows[:, 1, 2] = -self.x * np.sin(q[:, 2]), self.x * np.cos(q[:, 2])
        return rows

    def virial(
        self,
        motion: RigidMotion,
        force: FloatArray,
        torque: FloatArray,
        q: FloatArray | None = None,
    ) -> FloatArray:
        """Virial of a force on a rigid link about the link's start; see :meth:`force`.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        force : ndarray, shape (B, 2)
            In ground axes.
        torque : ndarray, shape (B,)
        q : ndarray, shape (B, n_link), optional
            Displacement of the link; zero where it is left out.

        Returns
        -------
        ndarray, shape (B,)
            In N m.
        """
        along = np.sum(force * direction(motion.angle[:, self.link]), axis=1)
        turned = np.zeros_like(along) if q is None else torque * np.sin(q[:, 2])
        return np.asarray(self.x * along - turned)

    def finite_displacement(self, motion: RigidMotion, q: FloatArray) -> FloatArray:
        """As :meth:`displacement`, with finite rotation of a rigid link.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,), not displaced.
        q : ndarray, shape (B, n_link)
            Displacement of the link.

        Returns
        -------
        ndarray, shape (B, 3)
        """
        found = self.displacement(motion, q)
        if self.rigid:
            angle, turn = motion.angle[:, self.link], q[:, 2:3]
            back = (np.cos(turn) - 1.0) * direction(angle)
            found[:, :2] += self.x * (back + (np.sin(turn) - turn) * normal(angle))
        return found

    def displacement(self, motion: RigidMotion, q: FloatArray) -> FloatArray:
        """Displacement in ground axes and rotation, (B, 3), at coordinates (B, n_link)."""
        return self._in_ground_axes(motion, q)[0]

    def displacement_rate(self, motion: RigidMotion, q: FloatArray, rate: FloatArray) -> FloatArray:
        """Time derivative of :meth:`displacement`.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        q, rate : ndarray, shape (B, n_link)
            Coordinates of the link and their rates in its frame.

        Returns
        -------
        ndarray, shape (B, 3)
        """
        moved, found = self._in_ground_axes(motion, q, rate)
        speed = motion.angular_velocity[:, self.link]
        found[:, 0] -= speed * moved[:, 1]
        found[:, 1] += speed * moved[:, 0]
        return found

    def finite_displacement_rate(
        self, motion: RigidMotion, q: FloatArray, rate: FloatArray
    ) -> FloatArray:
        """Time derivative of :meth:`finite_displacement`.

        Parameters
        ----------
        motion : RigidMotion
        q, rate : ndarray
            As of :meth:`displacement_rate`.

        Returns
        -------
        ndarray
        """
        found = self.displacement_rate(motion, q, rate)
        if self.rigid:
            angle, speed = motion.angle[:, self.link], motion.angular_velocity[:, self.link, None]
            turn = q[:, 2:3]
            back = (speed + rate[:, 2:3]) * (normal(angle + q[:, 2]) - normal(angle))
            found[:, :2] += self.x * (back + speed * turn * direction(angle))
        return found

    def _in_ground_axes(self, motion: RigidMotion, *parts: FloatArray) -> list[FloatArray]:
        """Displacement and rotation, or rates of them, (B, 3), at each of some (B, n_link)."""
        angle = motion.angle[:, self.link]
        cosine, sine = np.cos(angle), np.sin(angle)
        found = []
        for part in parts:
            along, across, turned = (part @ self.rows.T).T
            x, y = cosine * along - sine * across, sine * along + cosine * across
            found.append(np.stack([x, y, turned], axis=1))
        return found


@dataclass(frozen=True)
class PointJacobian:
    """Jacobian of a point's displacement in ground axes and rotation by independent coordinates.

    Parameters
    ----------
    value, rate : ndarray, shape (B, 3, size)
        The Jacobian, and its time derivative.
    """

    value: FloatArray
    rate: FloatArray

    @classmethod
    def of(
        cls,
        point: AttachedPoint,
        frames: LinkFrames,
        motion: RigidMotion,
        dependent: Sequence[DependentRows],
    ) -> PointJacobian:
        """Jacobian of a point.

        Parameters
        ----------
        point : AttachedPoint
            Of the links of ``frames``.
        frames : LinkFrames
        motion : RigidMotion
            Batch of shape (B,).
        dependent : sequence of DependentRows
            Of the point's link.
        """
        batch, link = len(motion.crank_angle), point.link
        value, rate = np.zeros((2, batch, 3, frames.size))
        own = frames.independent_coordinates(link)
        value[:, :, frames.targets[link][own]] = point.rows[:, own]
        for tie in dependent:
            value[:, :, tie.columns] += point.rows[:, tie.rows] @ tie.turn
            rate[:, :, tie.columns] += point.end_rows[:, tie.rows] @ tie.rate
        angle, speed = motion.angle[:, link], motion.angular_velocity[:, link]
        cosine, sine = np.cos(angle), np.sin(angle)
        turn, quarter = np.zeros((2, batch, 3, 3))
        turn[:, 0, 0], turn[:, 0, 1], turn[:, 1, 0], turn[:, 1, 1] = cosine, -sine, sine, cosine
        turn[:, 2, 2] = 1.0
        quarter[:, 0], quarter[:, 1] = -turn[:, 1], turn[:, 0]
        return cls(turn @ value, turn @ rate + speed[:, None, None] * (quarter @ value))
