"""Kinetic energy and weight of links in an Exudyn system in ground axes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmech.linear_system import LinkModel, whole
from flexmech.linkages.motion import direction, normal
from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.attached_bodies import AttachedPart
from flexmech.multibody.link_parts import RigidPart
from flexmech.types import FloatArray


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
        # Without attached bodies, which turn with their nodes.
        self._mass = [whole(link.mass) for link in links]
        for number, _ in assembly.beams:
            for body in links[number].bodies:
                own = body.matrices(np.zeros(()))[0]
                self._mass[number] = self._mass[number] - body.rows.T @ own @ body.rows

    def weight(self, link: int) -> FloatArray:
        """Generalized weight of a link without attached bodies, shape (n_link,)."""
        x, y = self._assembly.mechanism.gravity
        fields = self._links[link].fields
        return np.asarray(self._mass[link] @ (x * fields.along + y * fields.across))

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
        mass, part = self._mass[link], self._assembly.parts[link]
        if isinstance(part, RigidPart):
            return _kinetic(part.moments, position, velocity)
        added = np.zeros(len(position))
        for body in self._assembly.attached:
            if body.link == link:
                own = self._own(body)
                added += _kinetic(body.moments, position[:, own], velocity[:, own])
        if part.bodies is None:
            rate = velocity if part.polar is None else part.polar.moved_rate(position, velocity)
            return np.asarray(added + np.sum(rate @ mass * rate, axis=1) / 2)
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
        return np.asarray(added + energy + np.sum(spin * turned, axis=1))

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
        part, pull = self._assembly.parts[link], np.array(self._assembly.mechanism.gravity)
        x, y = pull
        if isinstance(part, RigidPart):
            return np.asarray(-_moment(part.moments, position) @ pull)
        added = np.zeros(len(position))
        for body in self._assembly.attached:
            if body.link == link:
                added -= _moment(body.moments, position[:, self._own(body)]) @ pull
        if part.bodies is None:
            nodes = position if part.polar is None else part.polar.moved(position)
            return np.asarray(added - nodes @ self.weight(link))
        nodes = position if part.arms is None else part.arms.moved(position)
        nodes = nodes.reshape(len(position), -1, self._assembly.kind.per_node)
        (along, across), turn = part.bodies.centre.T, nodes[..., 2]
        cosine, sine = np.cos(turn), np.sin(turn)
        lifted = x * (nodes[..., 0] + along * cosine - across * sine)
        lifted = lifted + y * (nodes[..., 1] + along * sine + across * cosine)
        return np.asarray(added - lifted @ part.bodies.mass)

    def _own(self, body: AttachedPart) -> list[int]:
        """Coordinates of an attached body among those of its link."""
        start = self._assembly.parts[body.link].coordinates.start
        return [body.place - start, body.place - start + 1, body.angle - start]


def _kinetic(
    moments: tuple[float, float, float, float], position: FloatArray, velocity: FloatArray
) -> FloatArray:
    """Kinetic energy of a rigid body by place and angle of a point, (m, 3); shape (m,)."""
    total, along, across, second = moments
    angle, spin = position[:, 2], velocity[:, 2]
    moment = along * normal(angle) - across * direction(angle)
    crossed = spin * np.sum(velocity[:, :2] * moment, axis=1)
    square = total * np.sum(velocity[:, :2] ** 2, axis=1) + second * spin**2
    return np.asarray(square / 2 + crossed)


def _moment(moments: tuple[float, float, float, float], position: FloatArray) -> FloatArray:
    """Mass times the place of a rigid body's centre but for a constant, (m, 2)."""
    total, along, across, _ = moments
    angle = position[:, 2]
    centre = along * direction(angle) + across * normal(angle)
    return np.asarray(total * position[:, :2] + centre)
