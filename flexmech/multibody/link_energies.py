"""Kinetic energy and weight of links in an Exudyn system in ground axes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmech.linear_system import LinkModel
from flexmech.multibody.assembly import LinkAssembly
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
        mass, arms = self._links[link].mass, self._assembly.parts[link].arms
        if arms is None:
            return np.asarray(np.sum(velocity @ mass * velocity, axis=1) / 2)
        # By the nodes only the first moments of the bodies there turn with the sections.
        rate = arms.moved_rate(position, velocity)
        mass = arms.back.matrix(np.zeros(len(mass)), mass)
        angles = np.arange(2, len(mass), self._assembly.kind.per_node)
        moment = -mass[angles - 2, angles]
        turn, spin = position[:, angles], rate[:, angles]
        turned = (1 - np.cos(turn)) * rate[:, angles - 2] - np.sin(turn) * rate[:, angles - 1]
        energy = np.sum(rate @ mass * rate, axis=1) / 2
        return np.asarray(energy + (spin * turned) @ moment)

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
        if part.bodies is None or part.arms is None:
            return np.asarray(-position @ self.weight(link))
        x, y = self._assembly.mechanism.gravity
        nodes = part.arms.moved(position).reshape(len(position), -1, self._assembly.kind.per_node)
        arm, turn = part.bodies.centre, nodes[..., 2]
        lifted = x * (nodes[..., 0] - arm * np.sin(turn)) + y * (nodes[..., 1] + arm * np.cos(turn))
        return np.asarray(-lifted @ part.bodies.mass)
