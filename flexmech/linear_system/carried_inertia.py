"""Inertia forces of links that turn as one body, at the places to which they are displaced.

All links of such a body stand still in their frames once it turns steadily. Their matter is then at
``x + u`` and not at ``x``. Its inertia force in the frame is, by mass, ``omega^2 (x + u)``, and
``-alpha J (x + u)`` while the crank's speed changes. The part by u is
``(omega^2 M_t - alpha S) q``: the terms that the linear equations about the steady state have. Of a
linkage whose links turn against each other no such state exists: there displacements change as fast
as the links turn, and the velocities and accelerations by this would give forces as great.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

from flexmech.linear_system.chains import whole
from flexmech.linear_system.link_model import LinkModel
from flexmech.linkages import RigidMotion, Topology
from flexmech.types import FloatArray


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

    Parameters
    ----------
    matrices : list of ndarray, shape (B, n_link, n_link)
        Forces by displacements.
    """

    matrices: list[FloatArray]

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
        speed, change = (
            rate.T[..., None, None]
            for rate in (motion.angular_velocity, motion.angular_acceleration)
        )
        if not turns_as_one_body(topology) or not (speed.any() or change.any()):
            return None
        return cls(
            [
                speed[number] ** 2 * whole(link.translational_mass)
                - change[number] * whole(link.gyroscopic)
                for number, link in enumerate(links)
            ]
        )

    def forces(self, displacement: Sequence[FloatArray]) -> list[FloatArray]:
        """Forces (B, n_link) by displacements (B, n_link)."""
        pairs = zip(self.matrices, displacement, strict=True)
        return [(matrix @ q[..., None])[..., 0] for matrix, q in pairs]
