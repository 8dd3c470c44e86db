"""Forces on bodies and rigid links that are displaced and turn by finite angles.

Dead loads keep their direction while their arms turn: see :class:`DeadMoments`. All links of a
linkage that rotates as one body are at rest in their frames at constant speed, with their matter at
``x + u`` and not at ``x``. Its inertia force in the frame is, by mass, ``omega^2 (x + u)``, and
``-alpha J (x + u)`` while the crank's speed changes. The part by u is
``(omega^2 M_t - alpha S) q``: the terms of the linear equations about the steady state. A linkage
whose links rotate against each other has no such state: there displacements change as fast as the
links rotate, and the forces by their velocities and accelerations are as great.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, IntArray
from flexmech.linkages import RigidMotion, Topology
from flexmech.mechanics.links.link_model import LinkModel, StressedLinks, with_entries

STILL = np.zeros(())  # a turn by no angle


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
        """Inertia forces by displacements of links in a rigid motion.

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

    def of_link(
        self, number: int, displacement: FloatArray
    ) -> tuple[FloatArray, FloatArray, list[FloatArray]]:
        """Inertia force on a link by its displacement, with the derivative.

        Parameters
        ----------
        number : int
        displacement : ndarray, shape (B, n_link)
            Displacement of the link.

        Returns
        -------
        ndarray, shape (B, n_link)
        ndarray, shape (B, n_link, n_link)
            Derivative by the displacement.
        list of ndarray, shape (B,)
            Couple on each of its bodies, which is part of the force.
        """
        link, couples = self.links[number], []
        speed, change = self.speed[number, :, None, None], self.change[number, :, None, None]

        def linear(centrifugal: FloatArray, gyroscopic: FloatArray) -> FloatArray:
            return np.asarray(speed**2 * centrifugal - change * gyroscopic)

        matrix = linear(link.centrifugal_mass, link.gyroscopic)
        force = (matrix @ displacement[..., None])[..., 0]
        for body in link.bodies:
            moved, (_, gyroscopic, centrifugal) = displacement @ body.rows.T, body.matrices(STILL)
            force_of_body, by_place = body.displaced_inertia(
                self.speed[number], self.change[number], moved
            )
            small = linear(centrifugal, gyroscopic)
            force += (force_of_body - (small @ moved[..., None])[..., 0]) @ body.rows
            matrix += body.rows.T @ (by_place - small) @ body.rows
            couples.append(force_of_body[:, 2])
        return force, matrix, couples

    def forces(self, displacement: Sequence[FloatArray]) -> list[FloatArray]:
        """Forces (B, n_link) by displacements (B, n_link)."""
        return [self.of_link(number, q)[0] for number, q in enumerate(displacement)]

    def matrices(self, displacement: Sequence[FloatArray]) -> list[FloatArray]:
        """Derivatives (B, n_link, n_link) of these forces."""
        return [self.of_link(number, q)[1] for number, q in enumerate(displacement)]

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
        moments: list[list[FloatArray]] = []
        for number, q in enumerate(displacement):
            turns = [q @ body.rows[2] for body in self.links[number].bodies]
            couples = zip(self.of_link(number, q)[2], turns, strict=True)
            moments.append(
                [couple * np.stack([-np.sin(turn), np.cos(turn)]) for couple, turn in couples]
            )
        return moments

    def on_undeformed(self, displacement: Sequence[FloatArray]) -> list[FloatArray]:
        """Forces (B, n_link) with the couples of bodies referred to the undeformed links."""
        forces = []
        for number, q in enumerate(displacement):
            force, _, couples = self.of_link(number, q)
            for body, couple in zip(self.links[number].bodies, couples, strict=True):
                force += np.outer(couple * (np.cos(q @ body.rows[2]) - 1.0), body.rows[2])
            forces.append(force)
        return forces


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
        Displacement of the state about which matrices are linearized; None of straight links.

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
            Virial of other loads on rigid links than inertia forces and weight.
        displaced_inertia : sequence of sequence of ndarray, shape (2, B), optional
            See :meth:`flexmech.mechanics.DisplacedInertia.moments`; their moments are among the
            loads.

        Returns
        -------
        DeadMoments
        """
        by_point: dict[tuple[int, int], FloatArray] = {}
        for number, link in enumerate(links):
            for place, body in enumerate(link.bodies):
                virial_of_body, moment = body.dead_moment(motion, number, gravity)
                value = np.stack([virial_of_body, moment])
                if displaced_inertia is not None:
                    value += displaced_inertia[number][place]
                if link.rigid:
                    value[1] = loads[number][:, 2]
                    value[0] += 0.0 if virial is None else virial[:, number]
                # Bodies on one section have one rotation.
                by_point[number, body.row] = by_point.get((number, body.row), 0.0) + value
        places = np.array(list(by_point), dtype=np.intp).reshape(-1, 2).T
        shape = (len(by_point), 2, len(motion.crank_angle))
        return cls(*places, *np.moveaxis(np.reshape(list(by_point.values()), shape), 1, 0))

    def scaled(self, fraction: float) -> Self:
        """Moments of dead loads that are a fraction of these."""
        return replace(self, virial=fraction * self.virial, moment=fraction * self.moment)

    def at(self, which: NDArray[np.bool_] | IntArray) -> Self:
        """Moments of dead loads in chosen positions of the batch."""
        return replace(self, virial=self.virial[:, which], moment=self.moment[:, which])

    def add_forces(self, force: Sequence[FloatArray], displacement: Sequence[FloatArray]) -> None:
        """Add the decrease of the moments to the internal forces of links, in place.

        Parameters
        ----------
        force, displacement : sequence of ndarray, shape (n_link, B)
        """
        for link, points in self._of_links():
            rows = self.rows[points]
            angle = displacement[link][rows]
            turned = self.moment[points] * 2 * np.sin(angle / 2) ** 2
            force[link][rows] += self.virial[points] * np.sin(angle) + turned

    def rotation_stiffness(
        self, displacement: Sequence[FloatArray]
    ) -> dict[int, tuple[IntArray, FloatArray]]:
        """Rotations (m,) of each link, and the geometric stiffness by them (m, B).

        Parameters
        ----------
        displacement : sequence of ndarray, shape (n_link, B)
        """
        by_link = {}
        for link, points in self._of_links():
            rows = self.rows[points]
            cosine, sine = np.cos(displacement[link][rows]), np.sin(displacement[link][rows])
            stiffness = self.virial[points] * cosine + self.moment[points] * sine
            by_link[link] = rows, np.asarray(stiffness)
        return by_link

    def by_link(self, displacement: Sequence[FloatArray]) -> dict[int, FloatArray]:
        """Geometric stiffness (B,) of rigid links, which have one point each, by link."""
        by_link = self.rotation_stiffness(displacement)
        return {link: stiffness[0] for link, (_, stiffness) in by_link.items()}

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
        Inertia forces by displacements of links that rotate as one body.

    Returns
    -------
    StressedLinks
    """
    tangent, moved = list(stressed.tangent), stressed.displacement
    for number, link in enumerate(links):
        square = motion.angular_velocity[:, number] ** 2
        by_row: dict[int, FloatArray] = {}
        for body in link.bodies:
            stiffness = -square * body.central_inertia
            if moved is not None and displaced_inertia is not None:
                change = motion.angular_acceleration[:, number]
                by_place = body.displaced_inertia(
                    motion.angular_velocity[:, number], change, moved[number] @ body.rows.T
                )[1]
                stiffness = square * body.translational_inertia - by_place[:, 2, 2]
            by_row[body.row] = by_row.get(body.row, 0.0) + stiffness
        if any(stiffness.any() for stiffness in by_row.values()):
            rows, values = np.array(list(by_row)), np.stack(list(by_row.values()), axis=1)
            tangent[number] = with_entries(tangent[number], rows, rows, values)
    return replace(stressed, tangent=tangent)
