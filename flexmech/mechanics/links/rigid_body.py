"""Rigid bodies: bodies on sections of elastic links, and rigid links.

A body is fixed to a point of its link, which is displaced by u and rotated by phi, both in the link
frame. With its first moment s about that point on the straight link, its centre of mass is at
``u + R(phi) s / m``. A dead load F, as an inertia force or weight, has the moment
``F . J R(phi) s / m`` about the point and the geometric stiffness ``F . R(phi) s / m`` against the
rotation: with the moment and the virial of the straight link, ``moment cos(phi) - virial sin(phi)``
and its derivative. Small displacements of the centre of mass are ``du + dphi J R(phi) s / m``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.linkages import LinkBody, LinkMass, RigidMotion
from flexmech.linkages.motion import direction, normal, quarter_turn

# Part of a second moment: what its differences leave of a body on the axis. An arm a millionth
# of the radius of gyration long counts.
ON_AXIS = 1e-12
NOWHERE = np.zeros((3, 0))
QUARTER_TURN = np.array([[0.0, -1.0], [1.0, 0.0]])


@dataclass(frozen=True)
class RigidBody:
    """Inertia of a body about the point of a link that it is fixed to.

    Parameters
    ----------
    mass : float
        In kg.
    first_moment : tuple of float
        ``s``, along and across the straight link, in kg m.
    second_moment : float
        Polar, in kg m^2.
    central_inertia : float
        Part of it about centres of mass: a rotation about these keeps the centrifugal
        potential.
    position : float
        Distance of the point from the link's start in m.
    rows : ndarray, shape (3, n)
        Displacement of the point along and across, and rotation, by the link's coordinates.
    end_rows : ndarray, shape (3, n), optional
        The same by the link's joined ends alone; see
        :class:`flexmech.mechanics.links.link_model.EndMatrices`. By default those by all
        coordinates.
    of_section : bool
        Whether it is distributed mass of the link's sections.
    """

    mass: float
    first_moment: tuple[float, float]
    second_moment: float
    central_inertia: float
    position: float = 0.0
    rows: FloatArray = field(default_factory=NOWHERE.copy)
    end_rows: FloatArray | None = None
    of_section: bool = False

    @classmethod
    def fixed(cls, body: LinkBody, rows: FloatArray = NOWHERE) -> Self:
        """Body fixed to a section of an elastic link.

        Parameters
        ----------
        body : LinkBody
        rows : ndarray, shape (3, n)
        """
        m, (a, c) = body.mass, body.offset
        second = body.inertia + m * (a**2 + c**2)
        return cls(m, (m * a, m * c), second, body.inertia, position=body.position, rows=rows)

    @classmethod
    def of_link(cls, mass: LinkMass) -> Self:
        """Rigid link, with the displacement of its start and its rotation as coordinates."""
        return cls(
            mass.moment(0),
            (mass.moment(1), mass.moment_across),
            mass.moment(2),
            mass.section_inertia + sum(body.inertia for body in mass.bodies),
            rows=np.eye(3),
        )

    @property
    def row(self) -> int:
        """Coordinate of the unreduced link that is the body's rotation."""
        return int(self.rows[2].argmax())

    @property
    def is_off_axis(self) -> bool:
        """Whether a rotation changes its inertia: its centre of mass is off the axis."""
        return self.translational_inertia > ON_AXIS * self.second_moment

    @property
    def arm(self) -> float:
        """Distance of the centre of mass from its point in m; zero without mass."""
        return float(np.hypot(*self.first_moment)) / self.mass if self.mass else 0.0

    @property
    def translational_inertia(self) -> float:
        """Part of the second moment by the displacement of centres of mass."""
        return self.second_moment - self.central_inertia

    def projected(self, basis: FloatArray, ends: FloatArray | None = None) -> Self:
        """The body in coordinates p with ``q = basis @ p`` and joined ends ``ends @ p``."""
        end_rows = None if ends is None else self.rows @ ends
        return replace(self, rows=self.rows @ basis, end_rows=end_rows)

    def matrices(self, angle: FloatArray) -> FloatArray:
        """Mass, gyroscopic and centrifugal mass matrix of the body rotated by an angle.

        Parameters
        ----------
        angle : ndarray, shape (...)
            In rad.

        Returns
        -------
        ndarray, shape (3, ..., 3, 3)
            By displacement and rotation of its point. See
            :class:`flexmech.mechanics.LinkModel` for each.
        """
        a, c = self._turned(angle)
        matrices = np.zeros((3, *np.shape(angle), 3, 3))
        mass, gyroscopic, centrifugal = matrices
        mass[..., [0, 1], [0, 1]] = self.mass
        mass[..., 0, 2] = mass[..., 2, 0] = -c
        mass[..., 1, 2] = mass[..., 2, 1] = a
        centrifugal[:] = mass
        mass[..., 2, 2] = self.second_moment
        centrifugal[..., 2, 2] = self.translational_inertia
        gyroscopic[..., 0, 1], gyroscopic[..., 1, 0] = -self.mass, self.mass
        gyroscopic[..., 0, 2], gyroscopic[..., 2, 0] = -a, a
        gyroscopic[..., 1, 2], gyroscopic[..., 2, 1] = -c, c
        return matrices

    def natural_inertia(self, turn: FloatArray) -> FloatArray:
        """Inertia of the body in natural coordinates, which is the same however far it turns.

        Its matter at r is displaced by ``u = p + d_1 r + d_2 J r``, with the displacement p of its
        point and ``d = (cos(phi) - 1, sin(phi))``.

        Parameters
        ----------
        turn : ndarray, shape (2, 2)
            One for the mass matrix, a quarter turn ``J`` for the gyroscopic one.

        Returns
        -------
        ndarray, shape (4, 4)
            ``rho N^T turn N`` by p and d, integrated.
        """
        x, y = self.first_moment
        moment = np.array([[x, -y], [y, x]])
        return np.block(
            [[self.mass * turn, turn @ moment], [moment.T @ turn, self.second_moment * turn]]
        )

    def inertia_change(self, angle: FloatArray) -> FloatArray:
        """Change of the matrices of the straight link by a rotation, (3, ..., 3, 3)."""
        return self.matrices(angle) - self.matrices(np.zeros(()))[:, *[None] * np.ndim(angle)]

    @property
    def about_centre(self) -> Self:
        """The body about its centre of mass, to which :meth:`centre_map` leads."""
        a, c = self.first_moment
        less = (a**2 + c**2) / self.mass
        return replace(self, first_moment=(0.0, 0.0), second_moment=self.second_moment - less)

    def centre_map(self, angle: FloatArray) -> FloatArray:
        """Jacobian of centre of mass and rotation by those of the point, (..., 3, 3)."""
        a, c = self._turned(angle)
        moved = np.zeros((*np.shape(angle), 3, 3))
        moved[..., [0, 1, 2], [0, 1, 2]] = 1.0
        moved[..., 0, 2], moved[..., 1, 2] = -c / self.mass, a / self.mass
        return moved

    def dead_moment(
        self, motion: RigidMotion, link: int, gravity: tuple[float, float]
    ) -> tuple[FloatArray, FloatArray]:
        """Virial and moment of inertia force and weight about its point on the straight link.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        link : int
            Number of the link.
        gravity : tuple of float
            In ground axes, m/s^2.

        Returns
        -------
        virial, moment : ndarray, shape (B,)
            In N m.
        """
        (a, c), (x, y) = self.first_moment, self.net_acceleration(motion, link, gravity).T
        virial = self.second_moment * motion.angular_velocity[:, link] ** 2 - (a * x + c * y)
        moment = c * x - a * y - self.second_moment * motion.angular_acceleration[:, link]
        return virial, moment

    def net_acceleration(
        self, motion: RigidMotion, link: int, gravity: tuple[float, float]
    ) -> FloatArray:
        """Acceleration less gravity of its point on the straight link, (B, 2), along and across.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        link : int
            Number of the link.
        gravity : tuple of float
            In ground axes, m/s^2.
        """
        angle = motion.angle[:, link]
        net_acceleration = motion.acceleration(link, self.position) - np.asarray(gravity)
        axes = (direction(angle), normal(angle))
        return np.stack([np.sum(net_acceleration * axis, axis=1) for axis in axes], axis=1)

    def inertia(
        self,
        speed: FloatArray,
        change: FloatArray,
        net_acceleration: FloatArray,
        moved: FloatArray,
        rate: FloatArray,
        acceleration: FloatArray,
    ) -> tuple[FloatArray, FloatArray]:
        """Inertia force less weight, with opposite sign, of the body at finite displacements.

        Parameters
        ----------
        speed, change : ndarray, shape (B,)
            Angular velocity and acceleration of the frame.
        net_acceleration : ndarray, shape (B, 2)
            See :meth:`net_acceleration`.
        moved, rate, acceleration : ndarray, shape (B, 3)
            Displacement of the point and rotation in the frame, and their time derivatives.

        Returns
        -------
        ndarray, shape (B, 3)
            Force on the point and moment about it.
        ndarray, shape (B, 3, 3)
            Derivative by the displacement and the rotation.
        """
        turning = _turning(speed, change)
        arm = np.stack(self._turned(moved[:, 2]), axis=1)
        lever = quarter_turn(arm)
        point_inertia = (turning @ moved[:, :2, None])[..., 0]
        point_inertia += (
            acceleration[:, :2] + 2 * speed[:, None] * quarter_turn(rate[:, :2]) + net_acceleration
        )
        spin = _turning(speed + rate[:, 2], change + acceleration[:, 2])
        force, by_q = np.zeros((len(moved), 3)), np.zeros((len(moved), 3, 3))
        force[:, :2] = self.mass * point_inertia + (spin @ arm[..., None])[..., 0]
        force[:, 2] = np.sum(lever * point_inertia, axis=1)
        force[:, 2] += self.second_moment * (change + acceleration[:, 2])
        by_q[:, :2, :2] = self.mass * turning
        by_q[:, :2, 2] = (spin @ lever[..., None])[..., 0]
        by_q[:, 2, :2] = (lever[:, None] @ turning)[:, 0]
        by_q[:, 2, 2] = -np.sum(arm * point_inertia, axis=1)
        return force, by_q

    def rotation_stiffness(
        self,
        motion: RigidMotion,
        link: int,
        gravity: tuple[float, float],
        moved: FloatArray,
        rate: FloatArray,
        acceleration: FloatArray,
    ) -> FloatArray:
        """Geometric stiffness against its rotation by its inertia and weight, (B,) in N m/rad.

        A rotation by ``dphi`` moves the centre of mass by ``-R(phi) s dphi^2 / 2m`` to second
        order, against its net acceleration.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        link : int
            Number of the link.
        gravity : tuple of float
            In ground axes, m/s^2.
        moved, rate, acceleration : ndarray, shape (B, 3)
            As of :meth:`inertia`.
        """
        by_q = self.inertia_in_motion(motion, link, gravity, moved, rate, acceleration)[1]
        spin = motion.angular_velocity[:, link] + rate[:, 2]
        return np.asarray(by_q[:, 2, 2] + self.translational_inertia * spin**2)

    def inertia_in_motion(
        self,
        motion: RigidMotion,
        link: int,
        gravity: tuple[float, float],
        moved: FloatArray,
        rate: FloatArray,
        acceleration: FloatArray,
    ) -> tuple[FloatArray, FloatArray]:
        """Inertia force less weight, with opposite sign, in a motion of its link.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        link : int
            Number of the link.
        gravity : tuple of float
            In ground axes, m/s^2.
        moved, rate, acceleration : ndarray, shape (B, 3)
            As of :meth:`inertia`.

        Returns
        -------
        ndarray, shape (B, 3)
            Force on the point and moment about it.
        ndarray, shape (B, 3, 3)
            Derivative of them by the displacement.
        """
        speed, change = motion.angular_velocity[:, link], motion.angular_acceleration[:, link]
        net = self.net_acceleration(motion, link, gravity)
        return self.inertia(speed, change, net, moved, rate, acceleration)

    def linear_inertia(
        self,
        motion: RigidMotion,
        link: int,
        gravity: tuple[float, float],
        moved: FloatArray,
        rate: FloatArray,
        acceleration: FloatArray,
    ) -> FloatArray:
        """Part of :meth:`inertia_in_motion` that is linear in its displacement.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        link : int
            Number of the link.
        gravity : tuple of float
            In ground axes, m/s^2.
        moved, rate, acceleration : ndarray, shape (B, 3)
            As of :meth:`inertia`.

        Returns
        -------
        ndarray, shape (B, 3)
            By :meth:`matrices` of the straight link, and the load on that.
        """
        speed, change = motion.angular_velocity[:, link], motion.angular_acceleration[:, link]
        straight = self.inertia_in_motion(motion, link, gravity, *3 * [np.zeros_like(moved)])[0]
        mass, gyroscopic, centrifugal = self.matrices(np.zeros(()))
        turned = 2 * speed[:, None] * rate + change[:, None] * moved
        linear = acceleration @ mass + turned @ gyroscopic.T
        linear -= speed[:, None] ** 2 * moved @ centrifugal
        return np.asarray(straight + linear)

    def displaced_inertia(
        self, speed: FloatArray, change: FloatArray, q: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Inertia force by a displacement that is constant in the rotating link frame.

        Parameters
        ----------
        speed, change : ndarray, shape (B,)
            Angular velocity and acceleration of the frame.
        q : ndarray, shape (B, 3)
            Displacement of the point and rotation.

        Returns
        -------
        ndarray, shape (B, 3)
            Force and moment besides those of dead loads; see :meth:`dead_moment`.
        ndarray, shape (B, 3, 3)
            Derivative by q.
        """
        zero, no_acceleration, turn = np.zeros_like(q), np.zeros((len(q), 2)), q[:, 2]
        displaced, by_q = self.inertia(speed, change, no_acceleration, q, zero, zero)
        force = self.inertia(speed, change, no_acceleration, zero, zero, zero)[0] - displaced
        dead = speed**2 * np.sin(turn) - change * (1 - np.cos(turn))
        force[:, 2] += self.second_moment * dead
        by_q[:, 2, 2] -= self.second_moment * (speed**2 * np.cos(turn) - change * np.sin(turn))
        return force, -by_q

    def _turned(self, angle: FloatArray) -> tuple[FloatArray, FloatArray]:
        """First moment along and across, rotated."""
        (a, c), cosine, sine = self.first_moment, np.cos(angle), np.sin(angle)
        return a * cosine - c * sine, a * sine + c * cosine


def _turning(speed: FloatArray, change: FloatArray) -> FloatArray:
    """``change J - speed^2``: second derivative of a rotating vector by the vector, (B, 2, 2)."""
    turning = np.zeros((len(speed), 2, 2))
    turning[:, 0, 0] = turning[:, 1, 1] = -(speed**2)
    turning[:, 0, 1], turning[:, 1, 0] = -change, change
    return turning


def body_nodes(nodes: FloatArray, bodies: Sequence[LinkBody | RigidBody]) -> IntArray:
    """Number of the node at each body's position.

    Parameters
    ----------
    nodes : ndarray, shape (k,)
        Node positions along the link in m.
    bodies : sequence of LinkBody or RigidBody

    Returns
    -------
    ndarray of int, shape (n_bodies,)
    """
    return np.array([np.argmin(np.abs(nodes - body.position)) for body in bodies], dtype=np.intp)
