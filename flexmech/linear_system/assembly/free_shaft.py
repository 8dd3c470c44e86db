"""A shaft that is free: its rotation is one more coordinate of the linkage.

The frames of the links go on turning with the prescribed, mean motion. Against it the shaft turns
by a small angle, by which it takes the clamped end along about its axis: of that end's coordinates
``q = r phi``, with r the rigid rotation about the axis. The clamp becomes a pivot, and the shaft's
inertia stands in the mass matrix by that coordinate. Its weight is on its axis.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linear_system.links.link_model import LinkModel
from flexmech.linear_system.links.link_stretch import LinkStretch
from flexmech.linear_system.links.stressed_links import StressedLinks
from flexmech.linkages import Clamp, Pivot, RigidMotion, Topology, picture_crank_angle
from flexmech.linkages.motion import direction, normal
from flexmech.mechanism import Mechanism

# Part of the shaft's speed by which that of the clamped link may be off: what the kinematics of any
# linkage leave, 1e-12 or less; a link that is geared is off by more than this. By this part of the
# link's length its clamped end may be off the axis, where there is no hub.
TURNS_ALIKE = 1e-9


@dataclass(frozen=True)
class FreeShaft:
    """The shaft of a mechanism, released.

    Parameters
    ----------
    clamped : Topology
        Of the linkage, with the one clamp that it drives.
    lever : tuple of float
        From the shaft's axis to the clamped end, in the link's frame, in m.
    inertia : float
        About the axis, in kg m^2.
    """

    clamped: Topology
    lever: tuple[float, float]
    inertia: float

    @classmethod
    def of(cls, mechanism: Mechanism) -> Self:
        """The shaft of a mechanism.

        Parameters
        ----------
        mechanism : Mechanism

        Returns
        -------
        FreeShaft

        Raises
        ------
        InputError
            If nothing or more than one link is clamped, or the clamped link does not turn with
            the shaft or is rigid and ends at it.
        """
        topology = mechanism.linkage.topology
        if len(topology.clamps) != 1:
            raise InputError(
                f"shaft 'free' needs one clamp, which the shaft drives; this linkage has "
                f"{len(topology.clamps)}: use shaft 'prescribed'"
            )
        clamp = topology.clamps[0]
        link = topology.index(clamp.link_end.link)
        motion = mechanism.linkage.motion(picture_crank_angle(mechanism.linkage), 1.0)
        if abs(float(motion.angular_velocity[link]) - 1.0) > TURNS_ALIKE:
            raise InputError(
                f"shaft 'free' needs a link that turns with the shaft, and the "
                f"{clamp.link_end.link} does not: use shaft 'prescribed'"
            )
        if topology.links[link].rigid and clamp.link_end.end == "end":
            raise InputError(
                f"shaft 'free' needs a rigid link that starts at the shaft, and the "
                f"{clamp.link_end.link} ends there: give its points in the other order"
            )
        speed, angle = motion.velocity(*topology.end_place(clamp.link_end)), motion.angle[link]
        lever = (float(speed @ normal(angle)), -float(speed @ direction(angle)))
        if np.hypot(*lever) <= TURNS_ALIKE * topology.links[link].length:
            lever = (0.0, 0.0)
        return cls(topology, lever, mechanism.shaft_inertia)

    @property
    def clamp(self) -> Clamp:
        """The connection that it drives."""
        return self.clamped.clamps[0]

    @cached_property
    def link(self) -> int:
        """Number of the clamped link."""
        return self.clamped.index(self.clamp.link_end.link)

    @property
    def has_lever(self) -> bool:
        """Whether the clamped end is off the shaft's axis."""
        return bool(np.any(self.lever))

    @property
    def is_stiff(self) -> bool:
        """Whether there are rigid links or a hub: a turn of these meets no tension of their own."""
        return self.has_lever or any(link.rigid for link in self.clamped.links)

    @property
    def turns_far(self) -> bool:
        """Whether these may turn by finite angles in a run in time: no links guide others."""
        return self.is_stiff and not self.clamped.has_moving_guides

    @property
    def topology(self) -> Topology:
        """The topology with a pivot in place of the clamp."""
        pivot = Pivot(self.clamp.joint, self.clamp.link_end)
        return replace(self.clamped, clamps=(), pivots=(pivot, *self.clamped.pivots))

    def links(self, links: tuple[LinkModel, ...]) -> tuple[LinkModel, ...]:
        """The links with the clamped one released.

        Parameters
        ----------
        links : tuple of LinkModel
            Unreduced.

        Returns
        -------
        tuple of LinkModel
        """
        link, end = links[self.link], self.clamp.link_end.end
        released = link.in_coordinates(self.basis(link))
        rotation = link.end_rotation_of(end)[:1]
        mass = np.array(released.mass)
        mass[rotation, rotation] += self.inertia
        # What else a clamp holds a pivot would let go, but the shaft does not.
        besides = np.concatenate([link.end_warping_of(end), link.end_rotation_of(end)[1:]])
        readings = released.readings if self.has_lever else link.readings
        released = replace(released, mass=mass, readings=readings, shaft=rotation)
        if end == "start":
            released = replace(released, start_rotation=rotation, start_warping=besides)
        else:
            released = replace(released, end_rotation=rotation, end_warping=besides)
        return tuple(released if other is link else other for other in links)

    def basis(self, link: LinkModel) -> FloatArray:
        """From the released link's coordinates to those of the clamped one, (n, n)."""
        end, basis = self.clamp.link_end.end, np.eye(link.size)
        rotations = link.end_rotation_of(end)
        turned, (x, y) = int(rotations[0]), link.end_displacement(end)
        basis[rotations, turned] = link.fields.tangential[rotations]
        basis[[x, y], turned] = -self.lever[1], self.lever[0]
        return basis

    def reaction(
        self, links: tuple[LinkModel, ...], motion: RigidMotion, loads: list[FloatArray] | None
    ) -> FloatArray | None:
        """Force of the clamp on links that turn as one body, in the clamped link's frame.

        Parameters
        ----------
        links : tuple of LinkModel
            Unreduced and clamped.
        motion : RigidMotion
            Batch of shape (B,).
        loads : list of ndarray, shape (B, n_link), optional
            Told in states under load.

        Returns
        -------
        ndarray, shape (B, 2), or None
            None where the clamped end is on the shaft's axis.
        """
        if not self.has_lever:
            return None
        assert loads is not None
        total = np.zeros((len(motion.crank_angle), 2))
        for number, (link, load) in enumerate(zip(links, loads, strict=True)):
            turn = motion.angle[:, number] - motion.angle[:, self.link]
            along, across = load @ link.fields.along, load @ link.fields.across
            total -= along[:, None] * direction(turn) + across[:, None] * normal(turn)
        return total

    def stressed(
        self,
        links: tuple[LinkModel, ...],
        stressed: StressedLinks,
        reaction: FloatArray | None = None,
    ) -> StressedLinks:
        """Stressed links with the clamped one released.

        Parameters
        ----------
        links : tuple of LinkModel
            Unreduced and clamped.
        stressed : StressedLinks
            In a state with the shaft held.
        reaction : ndarray, shape (B, 2), optional
            Force of the clamp in that state. On a hub it is a spring against the shaft's
            rotation, as the clamped end moves on a circle.

        Returns
        -------
        StressedLinks
        """
        basis = self.basis(links[self.link])
        turned = int(links[self.link].end_rotation_of(self.clamp.link_end.end)[0])
        tangent = list(stressed.tangent)
        force = None if stressed.internal_force is None else list(stressed.internal_force)
        damping = None if stressed.damping is None else list(stressed.damping)
        own = basis.T @ tangent[self.link] @ basis
        if reaction is not None:
            own = np.array(np.broadcast_to(own, (len(reaction), *basis.shape)))
            own[:, turned, turned] -= reaction @ np.array(self.lever)
        tangent[self.link] = own
        if force is not None:
            force[self.link] = force[self.link] @ basis
        if damping is not None:
            damping[self.link] = basis.T @ damping[self.link] @ basis
        return replace(stressed, tangent=tangent, internal_force=force, damping=damping)

    def displacements(
        self, links: tuple[LinkModel, ...], displacement: list[FloatArray]
    ) -> list[FloatArray]:
        """Displacements (B, n_link) of clamped links from those of released ones."""
        clamped = list(displacement)
        clamped[self.link] = displacement[self.link] @ self.basis(links[self.link]).T
        return clamped

    def stretches(
        self, links: tuple[LinkModel, ...], stretches: tuple[LinkStretch, ...]
    ) -> tuple[LinkStretch, ...] | None:
        """Second-order stretches of the links with the clamped one released, where they tell all.

        What turns with the shaft is stiffened by what pulls at it, which rigid links and a hub tell
        by a stretch in natural coordinates alone.
        """
        if self.is_stiff and not self.turns_far:
            return None
        own = stretches[self.link]
        released = own.in_coordinates(self.basis(links[self.link]))
        return tuple(released if other is own else other for other in stretches)
