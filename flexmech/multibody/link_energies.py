"""Kinetic energy and weight of links in an Exudyn system in ground axes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmech.linear_system import LinkModel
from flexmech.linkages.motion import direction, normal
from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.link_parts import RigidPart
from flexmech.types import FloatArray

__all__ = ["LinkEnergies"]


class LinkEnergies:
    """Energies of the links of an assembly, but for those of their strains.

    Parameters
    ----------
    assembly : LinkAssembly
    links : sequence of LinkModel
        The links' matrices in the same coordinates.
    """

    def __init__(self, assembly: LinkAssembly, links: Sequence[LinkModel]) -> None:
        self._assembly = assembly
        self._links = links

    def weight(self, link: int) -> FloatArray:
        """Generalized weight of a link, shape (n_link,)."""
        x, y = self._assembly.mechanism.gravity
        fields = self._links[link].fields
        return self._links[link].mass @ (x * fields.along + y * fields.across)

    def kinetic(self, link: int, position: FloatArray, velocity: FloatArray) -> FloatArray:
        """Kinetic energy of a link.

        Parameters
        ----------
        link : int
        position, velocity : ndarray, shape (m, n_link)
            Its coordinates in ground axes.

        Returns
        -------
        ndarray, shape (m,)
        """
        mass, part = self._links[link].mass, self._assembly.parts[link]
        if isinstance(part, RigidPart):
            total, along, across, second = part.moments
            angle, spin = position[:, 2], velocity[:, 2]
            moment = along * normal(angle) - across * direction(angle)
            crossed = spin * np.sum(velocity[:, :2] * moment, axis=1)
            square = total * np.sum(velocity[:, :2] ** 2, axis=1) + second * spin**2
            return np.asarray(square / 2 + crossed)
        if part.bodies is None:
            rate = velocity if part.polar is None else part.polar.moved_rate(position, velocity)
            return np.asarray(np.sum(rate @ mass * rate, axis=1) / 2)
        # By the nodes only the first moments of the bodies there turn with the sections.
        rate = velocity
        if part.arms is not None:
            rate = part.arms.moved_rate(position, velocity)
            mass = part.arms.back.matrix(np.zeros(len(mass)), mass)
        angles = np.arange(2, len(mass), self._assembly.kind.per_node)
        x, y = rate[:, angles - 2], rate[:, angles - 1]
        turn, spin = position[:, angles], rate[:, angles]
        sine, lowered = np.sin(turn), 1 - np.cos(turn)
        along, across = (part.bodies.centre * part.bodies.mass[:, None]).T
        turned = across * (lowered * x - sine * y) - along * (sine * x + lowered * y)
        energy = np.sum(rate @ mass * rate, axis=1) / 2
        return np.asarray(energy + np.sum(spin * turned, axis=1))

    def gravity(self, link: int, position: FloatArray) -> FloatArray:
        """Potential of a link's weight but for a constant.

        Parameters
        ----------
        link : int
        position : ndarray, shape (m, n_link)
            Its coordinates in ground axes.

        Returns
        -------
        ndarray, shape (m,)
        """
        part = self._assembly.parts[link]
        x, y = self._assembly.mechanism.gravity
        if isinstance(part, RigidPart):
            total, along, across, _ = part.moments
            angle = position[:, 2]
            moment = total * position[:, :2] + along * direction(angle) + across * normal(angle)
            return np.asarray(-moment @ np.array([x, y]))
        if part.bodies is None:
            nodes = position if part.polar is None else part.polar.moved(position)
            return np.asarray(-nodes @ self.weight(link))
        nodes = position if part.arms is None else part.arms.moved(position)
        nodes = nodes.reshape(len(position), -1, self._assembly.kind.per_node)
        (along, across), turn = part.bodies.centre.T, nodes[..., 2]
        cosine, sine = np.cos(turn), np.sin(turn)
        lifted = x * (nodes[..., 0] + along * cosine - across * sine)
        lifted = lifted + y * (nodes[..., 1] + along * sine + across * cosine)
        return np.asarray(-lifted @ part.bodies.mass)
