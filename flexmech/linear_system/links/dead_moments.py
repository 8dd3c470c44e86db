"""Forces that keep their direction on bodies and rigid links that turn, and how far these do."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system.links.carried_inertia import CarriedInertia
from flexmech.linear_system.links.chains import LinkMatrix, with_entries
from flexmech.linear_system.links.link_model import LinkModel
from flexmech.linear_system.links.stressed_links import StressedLinks
from flexmech.linkages import RigidMotion


def body_turns(
    links: Sequence[LinkModel], displacement: Sequence[FloatArray] | None
) -> list[list[FloatArray]] | None:
    """By what angles the bodies on links are turned in the frames of these.

    The frame of a rigid link turns with it.

    Parameters
    ----------
    links : sequence of LinkModel
        Unreduced.
    displacement : sequence of ndarray, shape (B, n_link), or None
        Of the state that matrices are about; None of straight links.

    Returns
    -------
    list of list of ndarray, shape (B,), or None
        For each body of each link, in rad; None where no turn changes any inertia.
    """
    off_axis = any(body.is_off_axis for link in links for body in link.bodies)
    if displacement is None or not off_axis:
        return None
    return [
        [(0.0 if link.rigid else 1.0) * (q @ body.rows[2]) for body in link.bodies]
        for link, q in zip(links, displacement, strict=True)
    ]


@dataclass(frozen=True)
class DeadMoments:
    """Moments of forces that keep their direction about k points that turn, in B positions.

    Parameters
    ----------
    links, rows : ndarray of int, shape (k,)
        The link of each point, and the coordinate that is its rotation.
    virial, moment : ndarray, shape (k, B)
        Where the link is straight: product of the forces with their places from the point, and
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
        carried: Sequence[Sequence[FloatArray]] | None = None,
    ) -> Self:
        """Of inertia forces and weight of all bodies, and of loads on rigid links.

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
        carried : sequence of sequence of ndarray, shape (2, B), optional
            See :meth:`flexmech.linear_system.CarriedInertia.moments`; their moments are among the
            loads.

        Returns
        -------
        DeadMoments
        """
        found: dict[tuple[int, int], FloatArray] = {}
        for number, link in enumerate(links):
            for place, body in enumerate(link.bodies):
                own, moment = body.dead(motion, number, gravity)
                value = np.stack([own, moment])
                if carried is not None:
                    value += carried[number][place]
                if link.rigid:
                    value[1] = loads[number][:, 2]
                    value[0] += 0.0 if virial is None else virial[:, number]
                # Bodies on one section turn alike.
                found[number, body.row] = found.get((number, body.row), 0.0) + value
        places = np.array(list(found), dtype=np.intp).reshape(-1, 2).T
        shape = (len(found), 2, len(motion.crank_angle))
        return cls(*places, *np.moveaxis(np.reshape(list(found.values()), shape), 1, 0))

    def scaled(self, part: float) -> Self:
        """Those of a part of the forces."""
        return replace(self, virial=part * self.virial, moment=part * self.moment)

    def at(self, which: NDArray[np.bool_] | IntArray) -> Self:
        """Those of some positions."""
        return replace(self, virial=self.virial[:, which], moment=self.moment[:, which])

    def fall(self, points: IntArray, angle: FloatArray) -> FloatArray:
        """By what moments of some points (m,) are less once these are turned by angles (m, B)."""
        half = 2 * np.sin(angle / 2) ** 2
        return np.asarray(self.virial[points] * np.sin(angle) + self.moment[points] * half)

    def stiffness(self, points: IntArray, angle: FloatArray) -> FloatArray:
        """Derivative of :meth:`fall` by the angles, (m, B)."""
        cosine, sine = np.cos(angle), np.sin(angle)
        return np.asarray(self.virial[points] * cosine + self.moment[points] * sine)

    def resist(self, force: Sequence[FloatArray], displacement: Sequence[FloatArray]) -> None:
        """Add what the moments fall by to the forces of links, in place.

        Parameters
        ----------
        force, displacement : sequence of ndarray, shape (n_link, B)
        """
        for link, points in self._of_links():
            rows = self.rows[points]
            force[link][rows] += self.fall(points, displacement[link][rows])

    def turning(self, displacement: Sequence[FloatArray]) -> dict[int, tuple[IntArray, FloatArray]]:
        """Coordinates (m,) of each link that turns, and the stiffness by them (m, B).

        Parameters
        ----------
        displacement : sequence of ndarray, shape (n_link, B)
        """
        return {
            link: (self.rows[points], self.stiffness(points, displacement[link][self.rows[points]]))
            for link, points in self._of_links()
        }

    def by_link(self, displacement: Sequence[FloatArray]) -> dict[int, FloatArray]:
        """The stiffness of :meth:`turning` by link: of rigid ones, which have one point."""
        return {link: stiffness[0] for link, (_, stiffness) in self.turning(displacement).items()}

    def _of_links(self) -> Iterator[tuple[int, IntArray]]:
        """Numbers of the points of each link that has some."""
        for link in np.unique(self.links).tolist():
            yield link, np.flatnonzero(self.links == link)

    def stiffen(
        self, tangent: Mapping[int, LinkMatrix], displacement: Sequence[FloatArray]
    ) -> dict[int, LinkMatrix]:
        """Tangents (n, n) or (B, n, n) of elastic links with what their bodies resist."""
        stiffened = dict(tangent)
        for link, (rows, stiffness) in self.turning(displacement).items():
            if link in stiffened:
                stiffened[link] = with_entries(stiffened[link], rows, rows, stiffness.T)
        return stiffened


def without_own_turning(
    links: Sequence[LinkModel],
    motion: RigidMotion,
    stressed: StressedLinks,
    carried: CarriedInertia | None,
) -> StressedLinks:
    """Stressed links without the centrifugal forces of what turns with bodies about their points.

    A rotation keeps the potential of these forces, which resist it as long as they keep their
    direction. What is left out is what the centrifugal mass leaves out too: on straight links all
    matter off the axis, in a displaced state what turns about a centre of mass of its own. Of links
    that turn as one body inertia forces are those at the displaced places, which the terms of the
    turning frame change as well.

    Parameters
    ----------
    links : sequence of LinkModel
        Unreduced.
    motion : RigidMotion
        Batch of shape (B,).
    stressed : StressedLinks
        Under forces that keep their direction.
    carried : CarriedInertia or None
        Of links that turn as one body.

    Returns
    -------
    StressedLinks
    """
    tangent, moved = list(stressed.tangent), stressed.displacement
    for number, link in enumerate(links):
        square, less = motion.angular_velocity[:, number] ** 2, []
        for body in link.bodies:
            turning = -square * (body.second_moment - body.on_axis)
            if moved is not None:
                turning = -square * body.spin
            if moved is not None and carried is not None:
                by_turn = carried.of_body(number, body, moved[number])[1][:, 2, 2]
                turning = square * (body.second_moment - body.spin) - by_turn
            less.append(turning)
        tangent[number] = _stiffened(tangent[number], link, less)
    return replace(stressed, tangent=tangent)


def with_straight_inertia(
    links: Sequence[LinkModel], motion: RigidMotion, stressed: StressedLinks
) -> StressedLinks:
    """Stressed links whose tangents stand beside the centrifugal mass of straight ones.

    Parameters
    ----------
    links : sequence of LinkModel
        Unreduced.
    motion : RigidMotion
        Batch of shape (B,).
    stressed : StressedLinks
        As of :func:`without_own_turning`.

    Returns
    -------
    StressedLinks
    """
    tangent = list(stressed.tangent)
    for number, link in enumerate(links if stressed.displacement is not None else ()):
        square = motion.angular_velocity[:, number] ** 2
        less = [-square * own.beside * own.is_off_axis for own in link.bodies]
        tangent[number] = _stiffened(tangent[number], link, less)
    return replace(stressed, tangent=tangent)


def _stiffened(tangent: LinkMatrix, link: LinkModel, turning: Sequence[FloatArray]) -> LinkMatrix:
    """A tangent with more stiffness (B,) against the turn of each body of the unreduced link."""
    by_row: dict[int, FloatArray] = {}
    for body, own in zip(link.bodies, turning, strict=True):
        if own.any():
            by_row[body.row] = by_row.get(body.row, 0.0) + own
    if not by_row:
        return tangent
    rows = np.array(list(by_row))
    return with_entries(tangent, rows, rows, np.stack(list(by_row.values()), axis=1))
