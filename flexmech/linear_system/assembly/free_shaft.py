"""A shaft that is free: its rotation is one more coordinate of the linkage.

The frames of the links go on turning with the prescribed, mean motion. Against it the shaft turns
by a small angle, which is the rotation of the clamped end: on a hub that end moves with it. The
shaft's inertia stands in the mass matrix by that coordinate. Its weight is on its axis.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np

from flexmech.errors import InputError
from flexmech.linear_system.links.chains import with_entries
from flexmech.linear_system.links.link_model import LinkModel
from flexmech.linkages import Clamp, Topology, picture_crank_angle
from flexmech.mechanism import Mechanism

# Part of the shaft's speed by which that of the clamped link may be off: what the kinematics of any
# linkage leave, 1e-12 or less; a link that is geared is off by more than this.
TURNS_ALIKE = 1e-9


@dataclass(frozen=True)
class FreeShaft:
    """The shaft of a mechanism, whose rotation is a coordinate.

    Parameters
    ----------
    topology : Topology
        Of the linkage, with the one clamp that it drives.
    inertia : float
        About the axis, in kg m^2.
    """

    topology: Topology
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
        return cls(topology.with_free_shaft(), mechanism.shaft_inertia)

    @property
    def clamp(self) -> Clamp:
        """The connection that it drives."""
        return self.topology.clamps[0]

    @cached_property
    def link(self) -> int:
        """Number of the clamped link."""
        return self.topology.index(self.clamp.link_end.link)

    @property
    def is_stiff(self) -> bool:
        """Whether there are rigid links or a hub: a turn of these meets no tension of their own."""
        return bool(self.clamp.hub) or any(link.rigid for link in self.topology.links)

    def rotation(self, link: LinkModel) -> int:
        """Which coordinate of the clamped link, reduced or not, is the shaft's rotation."""
        return int(link.end_rotation_of(self.clamp.link_end.end)[0])

    def links(self, links: tuple[LinkModel, ...]) -> tuple[LinkModel, ...]:
        """Unreduced links, of which the clamped one has the shaft's inertia.

        That link turns with the shaft as a rigid body, and so has the rotary inertia of its
        sections whatever its elements. It is on the mean rotation weighted by mass, to which
        all its vibration is orthogonal.
        """
        turn, own = np.array([self.rotation(links[self.link])]), links[self.link]
        mass = with_entries(own.mass, turn, turn, np.array([self.inertia]))
        if own.uncounted_rotary_inertia:
            length = own.readings.nodes[-1]
            start = self.clamp.hub - (length if self.clamp.link_end.end == "end" else 0.0)
            rigid = own.fields.tangential + start * own.fields.across
            rotary = float(own.uncounted_rotary_inertia) * length
            mean = (momentum := mass @ rigid) / (rigid @ momentum)
            mass = mass + rotary * np.outer(mean, mean)
        clamped = replace(own, mass=mass, uncounted_rotary_inertia=0.0)
        return tuple(clamped if link is own else link for link in links)
