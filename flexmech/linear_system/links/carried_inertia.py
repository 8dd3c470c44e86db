"""Inertia forces of links that turn as one body, at the places to which they are displaced.

All links of such a body stand still in their frames once it turns steadily. Their matter is then at
``x + u`` and not at ``x``. Its inertia force in the frame is, by mass, ``omega^2 (x + u)``, and
``-alpha J (x + u)`` while the crank's speed changes. The part by u is
``(omega^2 M_t - alpha S) q``: the terms that the linear equations about the steady state have. Of a
linkage whose links turn against each other no such state exists: there displacements change as fast
as the links turn, and the velocities and accelerations by this would give forces as great. Bodies
and rigid links, which may turn far, are where they are then.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linear_system.links.chains import whole
from flexmech.linear_system.links.link_model import LinkModel
from flexmech.linear_system.links.rigid_body import RigidBody
from flexmech.linkages import RigidMotion, Topology

_OnBodies = list[list[tuple[FloatArray, FloatArray]]]


def turns_as_one_body(topology: Topology) -> bool:
    """Whether all links turn with the shaft and nothing else holds them.

    Parameters
    ----------
    topology : Topology
    """
    return not (topology.pins or topology.sliders or topology.pivots)


@dataclass(frozen=True)
class CarriedInertia:
    """Inertia forces by displacements that stand still in the links' frames.

    Bodies and rigid links turn by finite angles.

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
            With the shaft held.
        links : sequence of LinkModel
            Unreduced.
        motion : RigidMotion
            Batch of shape (B,).

        Returns
        -------
        CarriedInertia or None
            None of linkages whose loads are those of the undisplaced links, and of links at rest.
        """
        speed, change = motion.angular_velocity.T, motion.angular_acceleration.T
        if not turns_as_one_body(topology) or not (speed.any() or change.any()):
            return None
        return cls(tuple(links), speed, change)

    @cached_property
    def linear(self) -> list[FloatArray]:
        """Forces (B, n_link, n_link) by small displacements of straight links."""
        rates = zip(
            self.links, self.speed[..., None, None], self.change[..., None, None], strict=True
        )
        return [
            speed**2 * whole(link.centrifugal_mass) - change * whole(link.gyroscopic)
            for link, speed, change in rates
        ]

    def of_body(
        self, number: int, body: RigidBody, displacement: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Force on a body of a link and its derivative; see :meth:`RigidBody.carried`.

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
        return body.carried(self.speed[number], self.change[number], moved)

    def forces(self, displacement: Sequence[FloatArray]) -> list[FloatArray]:
        """Forces (B, n_link) by displacements (B, n_link)."""
        return self._answers(displacement, self._on_bodies(displacement))[0]

    def matrices(self, displacement: Sequence[FloatArray]) -> list[FloatArray]:
        """Derivatives (B, n_link, n_link) of these forces."""
        return self._answers(displacement, self._on_bodies(displacement))[1]

    def moments(self, displacement: Sequence[FloatArray]) -> list[list[FloatArray]]:
        """The couples on bodies and rigid links as those of forces that keep their direction.

        A couple that is the same however far its point has turned has on the straight link the
        moment ``couple cos(phi)`` and the virial ``-couple sin(phi)``.

        Parameters
        ----------
        displacement : sequence of ndarray, shape (B, n_link)

        Returns
        -------
        list of list of ndarray, shape (2, B)
            Virial and moment of each body of each link.
        """
        return self._moments(displacement, self._on_bodies(displacement))

    def on_drawn(self, displacement: Sequence[FloatArray]) -> list[FloatArray]:
        """The forces with the couples of bodies by their :meth:`moments`."""
        answers = self._on_bodies(displacement)
        forces, moments = (
            self._answers(displacement, answers)[0],
            self._moments(displacement, answers),
        )
        for number, link in enumerate(self.links):
            of_bodies = zip(link.bodies, answers[number], moments[number], strict=True)
            for body, (pushed, _), (_, moment) in of_bodies:
                forces[number] += np.outer(moment - pushed[:, 2], body.rows[2])
        return forces

    def _on_bodies(self, displacement: Sequence[FloatArray]) -> _OnBodies:
        """Force on each body of each link and its derivative; see :meth:`of_body`."""
        return [
            [self.of_body(number, body, q) for body in link.bodies]
            for number, (link, q) in enumerate(zip(self.links, displacement, strict=True))
        ]

    def _moments(
        self, displacement: Sequence[FloatArray], answers: _OnBodies
    ) -> list[list[FloatArray]]:
        """See :meth:`moments`."""
        return [
            [
                pushed[:, 2] * np.stack([-np.sin(q @ body.rows[2]), np.cos(q @ body.rows[2])])
                for body, (pushed, _) in zip(link.bodies, own, strict=True)
            ]
            for link, q, own in zip(self.links, displacement, answers, strict=True)
        ]

    def _answers(
        self, displacement: Sequence[FloatArray], answers: _OnBodies
    ) -> tuple[list[FloatArray], list[FloatArray]]:
        """Forces and their derivatives."""
        forces, matrices = [], []
        for number, (link, q) in enumerate(zip(self.links, displacement, strict=True)):
            force, matrix = (self.linear[number] @ q[..., None])[..., 0], self.linear[number]
            speed, change = self.speed[number, :, None, None], self.change[number, :, None, None]
            for body, (pushed, by_place) in zip(link.bodies, answers[number], strict=True):
                _, gyroscopic, centrifugal = body.matrices(np.zeros(()), on_axis=True)
                linear = speed**2 * centrifugal - change * gyroscopic
                beyond = pushed - (linear @ (body.rows @ q.T).T[..., None])[..., 0]
                force = force + beyond @ body.rows
                matrix = matrix + body.rows.T @ (by_place - linear) @ body.rows
            forces.append(force)
            matrices.append(matrix)
        return forces, matrices
