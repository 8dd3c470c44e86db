"""Inertia forces at the displaced places of links that rotate as one body.

All links of such a body are at rest in their frames at constant speed, with their matter at
``x + u`` and not at ``x``. Its inertia force in the frame is, by mass, ``omega^2 (x + u)``, and
``-alpha J (x + u)`` while the crank's speed changes. The part by u is
``(omega^2 M_t - alpha S) q``: the terms of the linear equations about the steady state. A linkage
whose links rotate against each other has no such state: there displacements change as fast as the
links rotate, and the forces by their velocities and accelerations are as great. Bodies and rigid
links rotate by finite angles.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linear_system.links.link_model import LinkModel
from flexmech.linear_system.links.rigid_body import RigidBody
from flexmech.linkages import RigidMotion, Topology

_OnBodies = list[list[tuple[FloatArray, FloatArray]]]


def turns_as_one_body(topology: Topology) -> bool:
    """Whether all links rotate with the shaft and are joined to nothing else.

    Parameters
    ----------
    topology : Topology
    """
    return not (topology.pins or topology.sliders or topology.pivots)


@dataclass(frozen=True)
class DisplacedInertia:
    """Inertia forces by displacements that are constant in the rotating link frames.

    Bodies and rigid links rotate by finite angles.

    Parameters
    ----------
    links : tuple of LinkModel
    speed, change : ndarray, shape (n_links, B)
        Angular velocities and accelerations of the links.
    """

    links: tuple[LinkModel, ...]
    speed: FloatArray
    change: FloatArray

    @classmethod
    def of(cls, topology: Topology, links: Sequence[LinkModel], motion: RigidMotion) -> Self | None:
        """Of links in a rigid motion.

        Parameters
        ----------
        topology : Topology
            With a prescribed shaft.
        links : sequence of LinkModel
            Unreduced.
        motion : RigidMotion
            Batch of shape (B,).

        Returns
        -------
        DisplacedInertia or None
            None where links rotate against each other, and at rest.
        """
        speed, change = motion.angular_velocity.T, motion.angular_acceleration.T
        if not turns_as_one_body(topology) or not (speed.any() or change.any()):
            return None
        return cls(tuple(links), speed, change)

    @cached_property
    def linear(self) -> list[FloatArray]:
        """Derivatives (B, n_link, n_link) of the forces by small displacements."""
        rates = zip(
            self.links, self.speed[..., None, None], self.change[..., None, None], strict=True
        )
        return [
            speed**2 * link.centrifugal_mass - change * link.gyroscopic
            for link, speed, change in rates
        ]

    def of_body(
        self, number: int, body: RigidBody, displacement: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Force on a body of a link and its derivative; see :meth:`RigidBody.displaced_inertia`.

        Parameters
        ----------
        number : int
            Of the link.
        body : RigidBody
        displacement : ndarray, shape (B, n_link)
            Of the link.

        Returns
        -------
        ndarray, shape (B, 3)
        ndarray, shape (B, 3, 3)
        """
        moved = displacement @ body.rows.T
        return body.displaced_inertia(self.speed[number], self.change[number], moved)

    def forces(self, displacement: Sequence[FloatArray]) -> list[FloatArray]:
        """Forces (B, n_link) by displacements (B, n_link)."""
        return self._forces_and_matrices(displacement, self._on_bodies(displacement))[0]

    def matrices(self, displacement: Sequence[FloatArray]) -> list[FloatArray]:
        """Derivatives (B, n_link, n_link) of these forces."""
        return self._forces_and_matrices(displacement, self._on_bodies(displacement))[1]

    def moments(self, displacement: Sequence[FloatArray]) -> list[list[FloatArray]]:
        """Couples on bodies and rigid links as virial and moment of dead loads.

        A couple that does not depend on the rotation phi of its point has the moment
        ``couple cos(phi)`` and the virial ``-couple sin(phi)`` on the straight link.

        Parameters
        ----------
        displacement : sequence of ndarray, shape (B, n_link)

        Returns
        -------
        list of list of ndarray, shape (2, B)
            Virial and moment of each body of each link.
        """
        return self._moments(displacement, self._on_bodies(displacement))

    def on_undeformed(self, displacement: Sequence[FloatArray]) -> list[FloatArray]:
        """Forces (B, n_link) with the couples of bodies referred to the undeformed links."""
        on_bodies = self._on_bodies(displacement)
        forces, moments = (
            self._forces_and_matrices(displacement, on_bodies)[0],
            self._moments(displacement, on_bodies),
        )
        for number, link in enumerate(self.links):
            of_bodies = zip(link.bodies, on_bodies[number], moments[number], strict=True)
            for body, (force_on_body, _), (_, moment) in of_bodies:
                forces[number] += np.outer(moment - force_on_body[:, 2], body.rows[2])
        return forces

    def _on_bodies(self, displacement: Sequence[FloatArray]) -> _OnBodies:
        """Force on each body of each link and its derivative; see :meth:`of_body`."""
        return [
            [self.of_body(number, body, q) for body in link.bodies]
            for number, (link, q) in enumerate(zip(self.links, displacement, strict=True))
        ]

    def _moments(
        self, displacement: Sequence[FloatArray], on_bodies: _OnBodies
    ) -> list[list[FloatArray]]:
        """See :meth:`moments`."""
        return [
            [
                force_on_body[:, 2]
                * np.stack([-np.sin(q @ body.rows[2]), np.cos(q @ body.rows[2])])
                for body, (force_on_body, _) in zip(link.bodies, own, strict=True)
            ]
            for link, q, own in zip(self.links, displacement, on_bodies, strict=True)
        ]

    def _forces_and_matrices(
        self, displacement: Sequence[FloatArray], on_bodies: _OnBodies
    ) -> tuple[list[FloatArray], list[FloatArray]]:
        """Forces and their derivatives."""
        forces, matrices = [], []
        for number, (link, q) in enumerate(zip(self.links, displacement, strict=True)):
            force, matrix = (self.linear[number] @ q[..., None])[..., 0], self.linear[number]
            speed, change = self.speed[number, :, None, None], self.change[number, :, None, None]
            for body, (force_on_body, by_place) in zip(link.bodies, on_bodies[number], strict=True):
                _, gyroscopic, centrifugal = body.matrices(np.zeros(()))
                linear = speed**2 * centrifugal - change * gyroscopic
                nonlinear = force_on_body - (linear @ (body.rows @ q.T).T[..., None])[..., 0]
                force = force + nonlinear @ body.rows
                matrix = matrix + body.rows.T @ (by_place - linear) @ body.rows
            forces.append(force)
            matrices.append(matrix)
        return forces, matrices
