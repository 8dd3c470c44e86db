"""Moments of dead loads on bodies and rigid links that rotate by finite angles."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system.links.chains import with_entries
from flexmech.linear_system.links.displaced_inertia import DisplacedInertia
from flexmech.linear_system.links.link_model import LinkModel
from flexmech.linear_system.links.stressed_links import StressedLinks
from flexmech.linkages import RigidMotion


def body_turns(
    links: Sequence[LinkModel], displacement: Sequence[FloatArray] | None
) -> list[list[FloatArray]] | None:
    """Rotation of the bodies on links in the link frames.

    The frame of a rigid link rotates with it.

    Parameters
    ----------
    links : sequence of LinkModel
        Unreduced.
    displacement : sequence of ndarray, shape (B, n_link), or None
        Of the state about which matrices are linearized; None of straight links.

    Returns
    -------
    list of list of ndarray, shape (B,), or None
        For each body of each link, in rad; None where no rotation changes the inertia.
    """
    elastic = [link for link in links if not link.rigid]
    off_axis = any(body.is_off_axis for link in elastic for body in link.bodies)
    if displacement is None or not off_axis:
        return None
    return [
        [(0.0 if link.rigid else 1.0) * (q @ body.rows[2]) for body in link.bodies]
        for link, q in zip(links, displacement, strict=True)
    ]


@dataclass(frozen=True)
class DeadMoments:
    """Moments of dead loads about k points that rotate, in B positions.

    Parameters
    ----------
    links, rows : ndarray of int, shape (k,)
        The link of each point, and the coordinate that is its rotation.
    virial, moment : ndarray, shape (k, B)
        On the straight link: scalar product of the forces and their arms from the point, and
        their moment about it.
    """

    links: IntArray
    rows: IntArray
    virial: FloatArray
    moment: FloatArray

    @classmethod
    def of(
        cls,
        links: Sequence[LinkModel],
        motion: RigidMotion,
        gravity: tuple[float, float],
        loads: Sequence[FloatArray],
        virial: FloatArray | None = None,
        displaced_inertia: Sequence[Sequence[FloatArray]] | None = None,
    ) -> Self:
        """Moments of inertia forces and weight of all bodies, and of loads on rigid links.

        Parameters
        ----------
        links : sequence of LinkModel
            Unreduced.
        motion : RigidMotion
            Batch of shape (B,).
        gravity : tuple of float
            In ground axes, m/s^2.
        loads : sequence of ndarray, shape (B, n_link)
            On the links; of a rigid one with the moment about its start.
        virial : ndarray, shape (B, n_links), optional
            Of other loads on rigid links than inertia forces and weight.
        displaced_inertia : sequence of sequence of ndarray, shape (2, B), optional
            See :meth:`flexmech.linear_system.DisplacedInertia.moments`; their moments are among the
            loads.

        Returns
        -------
        DeadMoments
        """
        found: dict[tuple[int, int], FloatArray] = {}
        for number, link in enumerate(links):
            for place, body in enumerate(link.bodies):
                own, moment = body.dead_moment(motion, number, gravity)
                value = np.stack([own, moment])
                if displaced_inertia is not None:
                    value += displaced_inertia[number][place]
                if link.rigid:
                    value[1] = loads[number][:, 2]
                    value[0] += 0.0 if virial is None else virial[:, number]
                # Bodies on one section have one rotation.
                found[number, body.row] = found.get((number, body.row), 0.0) + value
        places = np.array(list(found), dtype=np.intp).reshape(-1, 2).T
        shape = (len(found), 2, len(motion.crank_angle))
        return cls(*places, *np.moveaxis(np.reshape(list(found.values()), shape), 1, 0))

    def scaled(self, part: float) -> Self:
        """Moments of a part of the forces."""
        return replace(self, virial=part * self.virial, moment=part * self.moment)

    def at(self, which: NDArray[np.bool_] | IntArray) -> Self:
        """Moments in some positions."""
        return replace(self, virial=self.virial[:, which], moment=self.moment[:, which])

    def decrease(self, points: IntArray, angle: FloatArray) -> FloatArray:
        """Decrease of the moments about some points (m,) at rotations (m, B)."""
        half = 2 * np.sin(angle / 2) ** 2
        return np.asarray(self.virial[points] * np.sin(angle) + self.moment[points] * half)

    def stiffness(self, points: IntArray, angle: FloatArray) -> FloatArray:
        """Geometric stiffness: derivative of :meth:`decrease` by the angles, (m, B)."""
        cosine, sine = np.cos(angle), np.sin(angle)
        return np.asarray(self.virial[points] * cosine + self.moment[points] * sine)

    def add_forces(self, force: Sequence[FloatArray], displacement: Sequence[FloatArray]) -> None:
        """Add the decrease of the moments to the internal forces of links, in place.

        Parameters
        ----------
        force, displacement : sequence of ndarray, shape (n_link, B)
        """
        for link, points in self._of_links():
            rows = self.rows[points]
            force[link][rows] += self.decrease(points, displacement[link][rows])

    def rotation_stiffness(
        self, displacement: Sequence[FloatArray]
    ) -> dict[int, tuple[IntArray, FloatArray]]:
        """Rotations (m,) of each link, and the geometric stiffness by them (m, B).

        Parameters
        ----------
        displacement : sequence of ndarray, shape (n_link, B)
        """
        return {
            link: (self.rows[points], self.stiffness(points, displacement[link][self.rows[points]]))
            for link, points in self._of_links()
        }

    def by_link(self, displacement: Sequence[FloatArray]) -> dict[int, FloatArray]:
        """Geometric stiffness (B,) of rigid links, which have one point each, by link."""
        return {
            link: stiffness[0]
            for link, (_, stiffness) in self.rotation_stiffness(displacement).items()
        }

    def _of_links(self) -> Iterator[tuple[int, IntArray]]:
        """Numbers of the points of each link that has some."""
        for link in np.unique(self.links).tolist():
            yield link, np.flatnonzero(self.links == link)

    def add_stiffness(
        self, tangent: Mapping[int, FloatArray], displacement: Sequence[FloatArray]
    ) -> dict[int, FloatArray]:
        """Tangents (n, n) or (B, n, n) of elastic links with the geometric stiffness of bodies."""
        stiffened = dict(tangent)
        for link, (rows, stiffness) in self.rotation_stiffness(displacement).items():
            if link in stiffened:
                stiffened[link] = with_entries(stiffened[link], rows, rows, stiffness.T)
        return stiffened


def without_spin_softening(
    links: Sequence[LinkModel],
    motion: RigidMotion,
    stressed: StressedLinks,
    displaced_inertia: DisplacedInertia | None,
) -> StressedLinks:
    """Stressed links without the centrifugal stiffness against the rotation of bodies.

    A rotation keeps the centrifugal potential, whose forces resist it as dead loads. The part is
    left out that the centrifugal mass leaves out too: on straight links that of all matter off the
    axis, in a displaced state that of the inertia about the centres of mass. Inertia forces of
    links that rotate as one body are those at the displaced places, which the terms of the rotating
    frame change as well.

    Parameters
    ----------
    links : sequence of LinkModel
        Unreduced.
    motion : RigidMotion
        Batch of shape (B,).
    stressed : StressedLinks
        Under dead loads.
    displaced_inertia : DisplacedInertia or None
        Of links that rotate as one body.

    Returns
    -------
    StressedLinks
    """
    tangent, moved = list(stressed.tangent), stressed.displacement
    for number, link in enumerate(links):
        square, less = motion.angular_velocity[:, number] ** 2, []
        for body in link.bodies:
            stiffness = -square * body.central_inertia
            if moved is not None and displaced_inertia is not None:
                by_turn = displaced_inertia.of_body(number, body, moved[number])[1][:, 2, 2]
                stiffness = square * body.translational_inertia - by_turn
            less.append(stiffness)
        tangent[number] = _with_rotation_stiffness(tangent[number], link, less)
    return replace(stressed, tangent=tangent)


def _with_rotation_stiffness(
    tangent: FloatArray, link: LinkModel, stiffness: Sequence[FloatArray]
) -> FloatArray:
    """A tangent with stiffness (B,) added against the rotation of each body of a link."""
    by_row: dict[int, FloatArray] = {}
    for body, own in zip(link.bodies, stiffness, strict=True):
        if own.any():
            by_row[body.row] = by_row.get(body.row, 0.0) + own
    if not by_row:
        return tangent
    rows = np.array(list(by_row))
    return with_entries(tangent, rows, rows, np.stack(list(by_row.values()), axis=1))
