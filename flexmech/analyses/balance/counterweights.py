"""Counterweights, and a mechanism with them."""

from __future__ import annotations

import cmath
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

from flexmech.linkages.frame_forces import TurningLink
from flexmech.linkages.link_mass import LinkBody, LinkMass
from flexmech.mechanism import AttachedBody, Mechanism


@dataclass(frozen=True)
class Counterweight:
    """A point mass on a link, at a radius from the point about which the link rotates.

    Parameters
    ----------
    link : TurningLink
    length : float
        Of the link in m.
    mass : float
        In kg.
    radius : float
        In m.
    direction : complex
        From the point to the mass in the link's frame, of size 1.
    """

    link: TurningLink
    length: float
    mass: float
    radius: float
    direction: complex

    @classmethod
    def of_moment(cls, link: TurningLink, length: float, moment: complex, radius: float) -> Self:
        """The counterweight with a first moment about the link's point of the ground.

        Parameters
        ----------
        link : TurningLink
        length : float
        moment : complex
            Along and across the link's frame, in kg m.
        radius : float
            In m.

        Returns
        -------
        Counterweight
        """
        size = abs(moment)
        return cls(link, length, size / radius, radius, moment / size if size else 1.0 + 0.0j)

    @property
    def angle(self) -> float:
        """Direction from the point to the mass against the link's frame, in rad."""
        return cmath.phase(self.direction)

    @property
    def moment(self) -> complex:
        """First moment about the point of the ground, along and across the frame, in kg m."""
        return self.mass * self.radius * self.direction

    @property
    def place(self) -> tuple[float, float]:
        """Along and across the link's frame from its start in m; it may lie beyond the joint."""
        arm = self.radius * self.direction
        return self.link.pivot + arm.real, arm.imag

    @property
    def _section(self) -> float:
        """Section that it is fixed to: the link's end at the point of the ground."""
        return 0.0 if self.link.end == "start" else self.length

    @property
    def body(self) -> AttachedBody:
        """As a part of a mechanism."""
        x, y = self.place
        offset = (x - self._section, y)
        return AttachedBody(self.link.name, self._section, self.mass, offset=offset)

    @property
    def link_mass(self) -> LinkMass:
        """A link that has this mass alone."""
        x, y = self.place
        body = LinkBody(self._section, self.mass, offset=(x - self._section, y))
        return LinkMass(self.length, 0.0, bodies=(body,))


def balanced(mechanism: Mechanism, weights: Sequence[Counterweight]) -> Mechanism:
    """A mechanism with counterweights; those without mass are left out.

    Parameters
    ----------
    mechanism : Mechanism
    weights : sequence of Counterweight

    Returns
    -------
    Mechanism
        Its name says so.
    """
    bodies = (*mechanism.bodies, *(weight.body for weight in weights if weight.mass))
    named = replace(mechanism.provenance, name=f"{mechanism.provenance.name}, balanced")
    return replace(mechanism, bodies=bodies, provenance=named)
