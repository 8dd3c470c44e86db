"""Inertia forces of a link in its moving frame (floating frame of reference)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from flexmech.arrays import FloatArray, row_products
from flexmech.linkages import RigidMotion
from flexmech.linkages.motion import direction, normal
from flexmech.mechanics.links.link_model import LinkModel

# Rigid fields of a link, in this order: unit translation along and across, unit turn about
# the start, and the field of points at their distance from the start.
FIELDS = ("along", "across", "tangential", "centripetal")


@dataclass(frozen=True)
class MovingLink:
    """One link's motion at m instants, in its frame.

    Parameters
    ----------
    displacement, rate, change : ndarray, shape (m, n)
        Elastic coordinates and their first and second time derivatives.
    angular_velocity, angular_acceleration : ndarray, shape (m,)
    velocity, acceleration : ndarray, shape (m, 4)
        Coefficients of the rigid fields; weight counts as acceleration.
    virtual_velocity : ndarray, shape (m, 4)
        Coefficients of the rigid fields at unit crank speed.
    virtual_turn : ndarray, shape (m,)
        Angular velocity at unit crank speed.
    """

    displacement: FloatArray
    rate: FloatArray
    change: FloatArray
    angular_velocity: FloatArray
    angular_acceleration: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    virtual_velocity: FloatArray
    virtual_turn: FloatArray

    @classmethod
    def of(
        cls,
        link: int,
        elastic: tuple[FloatArray, FloatArray, FloatArray],
        motion: RigidMotion,
        unit_motion: RigidMotion,
        gravity: FloatArray,
    ) -> Self:
        """Motion of a link by its rigid fields and elastic coordinates.

        Parameters
        ----------
        link : int
        elastic : tuple of ndarray, shape (m, n)
            Displacement, rate and change.
        motion, unit_motion : RigidMotion
            Batches of shape (m,): as it is, and at unit crank speed.
        gravity : ndarray, shape (2,)

        Returns
        -------
        MovingLink
        """
        omega, alpha = motion.angular_velocity[:, link], motion.angular_acceleration[:, link]
        angle, nothing = motion.angle[:, link], np.zeros_like(omega)
        pull = motion.origin_acceleration[:, link] - gravity
        return cls(
            *elastic,
            angular_velocity=omega,
            angular_acceleration=alpha,
            velocity=field_coefficients(angle, motion.origin_velocity[:, link], omega, nothing),
            acceleration=field_coefficients(angle, pull, alpha, -(omega**2)),
            virtual_velocity=field_coefficients(
                angle,
                unit_motion.origin_velocity[:, link],
                unit_motion.angular_velocity[:, link],
                nothing,
            ),
            virtual_turn=unit_motion.angular_velocity[:, link],
        )


def rigid_inertia(link: LinkModel) -> FloatArray:
    """Forces on an unreduced link that give it unit accelerations of its rigid fields.

    Mass times field, and the couples that accelerate the sections as the link turns. These are
    there whatever the element: its theory says whether vibration has them too. Sections whose
    rotary inertia ``rho I`` the mass leaves out are normal to the axis. Their couples
    ``rho I`` per length do the work ``rho I (v(L) - v(0))``: they are two forces at the ends.

    Parameters
    ----------
    link : LinkModel

    Returns
    -------
    ndarray, shape (n, 4)
        By the fields in the order of :data:`FIELDS`.
    """
    forces = np.asarray(link.mass @ np.stack([getattr(link.fields, f) for f in FIELDS], axis=-1))
    if link.uncounted_rotary_inertia:
        turning = FIELDS.index("tangential")
        forces[link.end[1], turning] += link.uncounted_rotary_inertia
        forces[link.start[1], turning] -= link.uncounted_rotary_inertia
    return forces


def field_coefficients(
    angle: FloatArray, origin: FloatArray, turn: FloatArray, distance: FloatArray
) -> FloatArray:
    """Coefficients of the rigid fields, by how the start of a link moves and how it turns.

    Parameters
    ----------
    angle : ndarray, shape (m,)
        Angle of the link in rad.
    origin : ndarray, shape (m, 2)
        Velocity or acceleration of its start in ground axes.
    turn, distance : ndarray, shape (m,)
        Rate of the turn about the start, and of the field of points at their distance from it.

    Returns
    -------
    ndarray, shape (m, 4)
    """
    along, across = direction(angle), normal(angle)
    return np.stack(
        [row_products(origin, along), row_products(origin, across), turn, distance], axis=1
    )


def inertia_loads(
    links: Sequence[LinkModel], motion: RigidMotion, gravity: tuple[float, float]
) -> list[FloatArray]:
    """Distributed inertia forces of the rigid motion and weight, each in its link frame.

    A rigid acceleration is linear along the link and so lies in the space of the shape
    functions: ``-M a`` with the nodal accelerations ``a`` is the exact consistent load. The couples
    of sections whose rotary inertia M leaves out are added; see :func:`rigid_inertia`.

    Parameters
    ----------
    links : sequence of LinkModel
    motion : RigidMotion
        Batch of shape (B,).
    gravity : tuple of float
        In ground axes, m/s^2.

    Returns
    -------
    list of ndarray, shape (B, n)
    """
    loads = []
    for number, link in enumerate(links):
        pull = motion.origin_acceleration[:, number] - np.asarray(gravity)
        turning = motion.angular_velocity[:, number] ** 2
        change = motion.angular_acceleration[:, number]
        factors = -field_coefficients(motion.angle[:, number], pull, change, -turning)
        unit = rigid_inertia(link)
        # Matter that is elsewhere than the field says, as off the pins' axis, is pulled as well.
        unit[..., FIELDS.index("centripetal")] += link.first_moment[..., 1, :]
        # Several designs have equally many positions, one design after the other.
        *designs, size, count = unit.shape
        load = factors.reshape(*designs, -1, count) @ np.swapaxes(unit, -1, -2)
        loads.append(load.reshape(-1, size))
    return loads


@dataclass(frozen=True)
class LinkInertia:
    """Inertia integrals of a reduced link's shapes and rigid fields.

    Parameters
    ----------
    model : LinkModel
        Reduced, n coordinates.
    rigid : ndarray, shape (4, 4)
        Field with field.
    mass, turned, translational : ndarray, shape (n, 4)
        Shape with field, by the mass matrix, by S and by M_t.
    """

    model: LinkModel
    rigid: FloatArray
    mass: FloatArray
    turned: FloatArray
    translational: FloatArray

    @classmethod
    def of(cls, model: LinkModel, full: LinkModel, basis: FloatArray) -> Self:
        """Inertia integrals of a link by its shapes and rigid fields.

        Parameters
        ----------
        model, full : LinkModel
            Reduced and not.
        basis : ndarray, shape (n_full, n)

        Returns
        -------
        LinkInertia
        """
        fields = np.stack([getattr(full.fields, name) for name in FIELDS], axis=1)
        forces = rigid_inertia(full)
        rigid, mass = fields.T @ forces, basis.T @ forces
        turned = basis.T @ full.gyroscopic @ fields
        # Matter off the pins' axis has a distance from the start across it as well.
        distance = FIELDS.index("centripetal")
        along, across = full.first_moment
        rigid[distance] += across @ fields
        mass[:, distance] += basis.T @ across
        turned[:, distance] -= basis.T @ along
        return cls(model, rigid, mass, turned, basis.T @ full.centrifugal_mass @ fields)

    def shape_forces(self, link: MovingLink) -> FloatArray:
        """Mass times acceleration, weighted with each shape; (m, n)."""
        omega, alpha = link.angular_velocity[:, None], link.angular_acceleration[:, None]
        turned = (2 * omega * link.rate + alpha * link.displacement) @ self.model.gyroscopic.T
        return np.asarray(
            link.acceleration @ self.mass.T
            + link.change @ self.model.mass
            + turned
            - omega**2 * (link.displacement @ self.model.centrifugal_mass)
        )

    def field_forces(self, link: MovingLink) -> FloatArray:
        """Mass times acceleration, weighted with each rigid field; (m, 4)."""
        omega, alpha = link.angular_velocity[:, None], link.angular_acceleration[:, None]
        turned = (2 * omega * link.rate + alpha * link.displacement) @ self.turned
        return np.asarray(
            link.acceleration @ self.rigid
            + link.change @ self.mass
            - turned
            - omega**2 * (link.displacement @ self.translational)
        )

    def turning_power(self, link: MovingLink) -> FloatArray:
        """Virtual power of the inertia on the displacement at 1 rad/s of the frame, (m,)."""
        p = link.displacement
        turning = (
            2 * link.angular_velocity[:, None] * link.rate + link.angular_acceleration[:, None] * p
        )
        return (
            row_products(p, turning @ self.model.centrifugal_mass)
            - row_products(p, link.acceleration @ self.turned.T)
            - row_products(p, link.change @ self.model.gyroscopic.T)
        )

    def kinetic_energy(self, link: MovingLink) -> FloatArray:
        """Kinetic energy of the rigid motion with the vibration, (m,)."""
        p, rate, c, omega = link.displacement, link.rate, link.velocity, link.angular_velocity
        return np.asarray(
            row_products(c, c @ self.rigid) / 2
            + row_products(c, rate @ self.mass)
            + row_products(rate, rate @ self.model.mass) / 2
            + omega
            * (row_products(rate, p @ self.model.gyroscopic.T) - row_products(c, p @ self.turned))
            + omega**2 * row_products(p, p @ self.model.centrifugal_mass) / 2
        )

    def gravity_energy(
        self, origin: FloatArray, angle: FloatArray, displacement: FloatArray, gravity: FloatArray
    ) -> FloatArray:
        """Potential of the weight, zero at the ground's origin.

        Parameters
        ----------
        origin : ndarray, shape (m, 2)
        angle : ndarray, shape (m,)
        displacement : ndarray, shape (m, n)
        gravity : ndarray, shape (2,)

        Returns
        -------
        ndarray, shape (m,)
        """
        along, across = direction(angle), normal(angle)
        distance = FIELDS.index("centripetal")
        mass, (moment, lifted) = self.rigid[0, 0], self.rigid[distance, :2]
        moved = np.stack([along @ gravity, across @ gravity], axis=1)
        elastic = row_products(moved, displacement @ self.mass[:, :2])
        centre = mass * origin + moment * along + lifted * across
        return np.asarray(-centre @ gravity - elastic)
