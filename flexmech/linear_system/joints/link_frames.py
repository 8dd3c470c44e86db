"""Link frames: how the links' own coordinates hang together while the frames turn.

Each link's displacement is written in the frame of its rigid motion. A pin keeps the
displacement of its joint in the leader's frame; the follower's end is
``R(theta_follower)^T R(theta_leader)`` times it. A weld turns by an angle that does not change,
and the rotation is one; an end on a line follows the slide; ends on rigid links follow these
(:mod:`flexmech.linear_system.joints.rigid_coordinates`). With ``q = N(t) z``::

    M_r = N'MN
    C_r = N'(2 M Ndot + 2 omega S N) + N'DN
    K_r = N'(M Nddot + 2 omega S Ndot + (K - omega^2 M_t + alpha S) N) + N'D Ndot

These are Turcic and Midha's M_d, M_dd, M_vel, M_d,vel and M_acc (Kumar & Chandrakar,
eq. 1.57). The same code serves every engine: only the link matrices differ.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system.joints.link_place import DependentRows, LinkPlace
from flexmech.linear_system.joints.link_ties import LinkTies
from flexmech.linear_system.joints.rigid_coordinates import RigidCoordinates
from flexmech.linear_system.joints.rigid_pose import DisplacedTies, RigidPose
from flexmech.linear_system.joints.steady_links import SteadyLinks
from flexmech.linear_system.links.chains import LinkMatrix, whole
from flexmech.linear_system.links.link_model import LinkModel, WholeLink
from flexmech.linear_system.links.rotation_terms import LinkDamping, RotationTerms, SystemMatrices
from flexmech.linkages import RigidMotion, Topology


class LinkFrames:
    """The map from independent coordinates z to the coordinates of all links.

    Parameters
    ----------
    topology : Topology
    links : sequence of LinkModel
        In the topology's order; full or reduced.
    last : sequence of ndarray of bool, shape (n_link,), optional
        Coordinates of each link to number after all others.

    Attributes
    ----------
    targets : list of ndarray of int, shape (n_link,)
        For each link coordinate the coordinate of z that it takes: its own, or another link's
        that it equals or, turned, follows. -1 where it is held, and where it follows several.
    size : int
        Number of independent coordinates.
    end_count : int
        How many of them, the first ones, may lead others: those of rigid links and of sliders,
        displacements of link ends, rotations of welded ends and of a free shaft.
    """

    def __init__(
        self,
        topology: Topology,
        links: Sequence[LinkModel],
        last: Sequence[NDArray[np.bool_]] | None = None,
    ) -> None:
        self.topology = topology
        self.links = tuple(links)
        if last is None:
            last = [np.zeros(link.size, dtype=bool) for link in self.links]
        self._ties = LinkTies(topology, self.links, last)
        self.targets = self._ties.targets
        self.size, self.end_count = self._ties.size, self._ties.end_count

    def following(self, link: int) -> IntArray:
        """Coordinates of a link that follow others, turned."""
        rows = [rows for rows, _ in self._ties.following(link)]
        return np.concatenate([np.zeros(0, dtype=np.intp), *rows])

    def followed(self, link: int) -> list[tuple[IntArray, IntArray]]:
        """Coordinates of a link that follow, and those of z that they follow, tie by tie."""
        return self._ties.following(link)

    def own(self, link: int) -> IntArray:
        """Coordinates of a link that are independent ones of the linkage, and lead themselves."""
        return self._ties.own(link)

    def dependent_rows(self, motion: RigidMotion) -> list[list[DependentRows]]:
        """What follows in each link, and its time derivatives.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).

        Returns
        -------
        list of list of DependentRows
            A list for each link.
        """
        return self._ties.dependent_rows(motion)

    @property
    def rigid(self) -> RigidCoordinates:
        """Coordinates of rigid links and sliders."""
        return self._ties.rigid

    @property
    def has_arms(self) -> bool:
        """Whether forces act on arms that turn: there are rigid links, sliders or a hub."""
        return bool(self.rigid.size or self._ties.hubs)

    def displaced_ties(self, motion: RigidMotion, w: FloatArray) -> DisplacedTies:
        """Ties where the rigid links are displaced by finite amounts.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        w : ndarray, shape (B, n)
            Independent coordinates of rigid links and sliders, the first ones of z, as they are
            in the frames of the rigid motion.

        Returns
        -------
        DisplacedTies
        """
        return self._ties.displaced_ties(
            motion, RigidPose.solve_position_constraints(self.rigid, motion, w)
        )

    def displaced_ties_by(
        self, motion: RigidMotion, displacement: Sequence[FloatArray]
    ) -> DisplacedTies:
        """Ties where the links have displacements (B, n_link) in the rigid motion's frames."""
        return self._ties.displaced_ties(motion, self._ties.pose_of(motion, displacement))

    def displaced(
        self, motion: RigidMotion, displacement: Sequence[FloatArray] | None
    ) -> RigidMotion:
        """The motion whose rigid links are where displacements (B, n_link) have turned them.

        Coordinates of rigid links are then those in their displaced frames.
        """
        if displacement is None or not self.rigid.size:
            return motion
        return self._ties.pose_of(motion, displacement).displaced

    def assemble(
        self,
        motion: RigidMotion,
        stiffness: Sequence[LinkMatrix],
        terms: RotationTerms,
        damping: Sequence[LinkDamping] | None = None,
        guiding: FloatArray | None = None,
        turns: Sequence[Sequence[FloatArray]] | None = None,
    ) -> SystemMatrices:
        """Matrices of the whole linkage in the independent coordinates.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        stiffness : sequence of ndarray, shape (n, n) or (B, n, n)
            Tangent stiffness of each link in its frame, at the prestress wanted.
        terms : RotationTerms
        damping : sequence of LinkDamping, optional
            At the prestress wanted; that of the straight links where it is left out.
        guiding : ndarray, shape (B, n_sliders), optional
            Stiffness between the rotation of a slider's guide and its slide in N/rad.
        turns : sequence of sequence of ndarray, shape (B,), optional
            Of the bodies on each link; see :func:`flexmech.linear_system.body_turns`.

        Returns
        -------
        SystemMatrices
        """
        batch = len(motion.crank_angle)
        if damping is None:
            damping = [LinkDamping(link.damping, link.ends.damping) for link in self.links]
        links, resisting = [link.whole() for link in self.links], [own.whole() for own in damping]
        turned: dict[int, WholeLink] = {}
        for number, angles in enumerate(turns or ()):
            if (change := self.links[number].inertia_change(angles)) is not None:
                turned[number], links[number] = change, links[number] + change
        shape = (batch, self.size, self.size)
        # One block of memory: the allocator keeps it for the next batch.
        mass, total = np.empty((2, *shape))
        damps = terms.coriolis or any(matrix.any() for matrix, _ in resisting)
        rates = np.zeros(shape) if damps else np.broadcast_to(0.0, shape)
        tangents = [_tangent(links[n], motion, n, whole(x), terms) for n, x in enumerate(stiffness)]
        factors = self._steady.factors.at(motion.angle)
        self._steady.mass.write(mass, factors)
        steady = {n: tangents[n] for n in self._steady.numbers if tangents[n].ndim == 2}
        self._steady.sum_of_tangents(steady).write(total, factors)
        following: list[list[DependentRows]] | None = None
        for number, (link, tangent, (damping_matrix, damped_ends)) in enumerate(
            zip(links, tangents, resisting, strict=True)
        ):
            damped = bool(damping_matrix.any())
            if number in steady and number not in turned and not damped and not terms.any:
                continue
            if following is None:
                following = self.dependent_rows(motion)
            place, pairs = self._places[number], following[number]
            speed = motion.angular_velocity[:, number, None, None]
            if number not in self._steady.numbers:
                place.add(mass, link.mass, pairs)
            elif number in turned:
                place.add(mass, turned[number].mass, pairs)
            if number not in steady:
                place.add(total, tangent, pairs)
            if damped:
                place.add(rates, damping_matrix, pairs)
            turning = [p.rate for p in pairs]
            if terms.coriolis:
                place.add(rates, 2 * speed * link.gyroscopic, pairs)
                place.add_following(rates, 2 * link.end_mass, pairs, turning)
                if damped:
                    place.add_following(total, damped_ends, pairs, turning)
            if terms.centripetal:
                coriolis = [2 * speed * rate for rate in turning]
                place.add_following(total, link.end_gyroscopic, pairs, coriolis)
            if terms.centripetal or terms.tangential:
                accelerating = [p.acceleration(terms) for p in pairs]
                place.add_following(total, link.end_mass, pairs, accelerating)
        if guiding is not None and guiding.any():
            total += self.guided(motion, guiding)
        return SystemMatrices(mass, rates, total)

    def guided(self, motion: RigidMotion, guiding: FloatArray) -> FloatArray:
        """Stiffness between the rotations of guides and the slides on them, (B, size, size).

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        guiding : ndarray, shape (B, n_sliders)
            In N/rad; see :class:`flexmech.linear_system.StressedLinks`.
        """
        first = len(self.rigid.independent_coordinates)
        total = np.zeros((len(guiding), self.size, self.size))
        total[:, :first, :first] = self._ties.guided(motion, guiding)
        return total

    @cached_property
    def _steady(self) -> SteadyLinks:
        return SteadyLinks(self._ties, self.links, self._places)

    @cached_property
    def _places(self) -> list[LinkPlace]:
        numbered = enumerate(self.targets)
        return [LinkPlace.of(target, self._ties.following(n)) for n, target in numbered]

    def link_coordinates(self, motion: RigidMotion, vectors: NDArray[Any]) -> list[NDArray[Any]]:
        """Coordinates of each link from independent ones.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        vectors : ndarray, shape (B, size, m)

        Returns
        -------
        list of ndarray, shape (B, n_link, m)
        """
        result = []
        for number, (link, following) in enumerate(
            zip(self.links, self.dependent_rows(motion), strict=True)
        ):
            target = self.targets[number]
            free = target >= 0
            q = np.zeros((len(vectors), link.size, vectors.shape[2]), dtype=vectors.dtype)
            q[:, free] = vectors[:, target[free]]
            for led in following:
                q[:, led.rows] = led.turn @ vectors[:, led.columns]
            result.append(q)
        return result

    def independent(
        self, motion: RigidMotion, displacement: Sequence[NDArray[Any]]
    ) -> NDArray[Any]:
        """Independent coordinates of displacements of all links, (B, size, m).

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        displacement : sequence of ndarray, shape (B, n_link, m)
            An end that follows is taken to be where that is which it follows.
        """
        shape = (len(displacement[0]), self.size, displacement[0].shape[2])
        z = np.zeros(shape, dtype=displacement[0].dtype)
        for number, q in enumerate(displacement):
            own = self.own(number)
            z[:, self.targets[number][own]] = q[:, own]
        if self.topology.sliders:
            first = len(self.rigid.independent_coordinates)
            z[:, :first] += self._ties.slides(motion, displacement)
        return z

    def link_motion(
        self,
        motion: RigidMotion,
        position: FloatArray,
        velocity: FloatArray,
        acceleration: FloatArray,
    ) -> list[tuple[FloatArray, FloatArray, FloatArray]]:
        """Coordinates of each link and their time derivatives in its frame.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        position, velocity, acceleration : ndarray, shape (B, size)
            Independent coordinates z and their time derivatives.

        Returns
        -------
        list of tuple of ndarray, shape (B, n_link)
            ``q = N z``, ``N z' + N' z`` and ``N z'' + 2 N' z' + N'' z`` of each link.
        """
        result = []
        for number, (link, following) in enumerate(
            zip(self.links, self.dependent_rows(motion), strict=True)
        ):
            target = self.targets[number]
            free = target >= 0
            q, rate, change = np.zeros((3, len(position), link.size))
            for values, given in ((q, position), (rate, velocity), (change, acceleration)):
                values[:, free] = given[:, target[free]]
            for led in following:
                z0, z1, z2 = (v[:, led.columns, None] for v in (position, velocity, acceleration))
                twice = led.centripetal + led.tangential
                q[:, led.rows] = (led.turn @ z0)[..., 0]
                rate[:, led.rows] = (led.turn @ z1 + led.rate @ z0)[..., 0]
                change[:, led.rows] = (led.turn @ z2 + 2 * led.rate @ z1 + twice @ z0)[..., 0]
            result.append((q, rate, change))
        return result

    def gather(self, motion: RigidMotion, loads: Sequence[FloatArray]) -> FloatArray:
        """Generalized force in the independent coordinates, ``N' f``; shape (B, size).

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        loads : sequence of ndarray, shape (B, n_link)
            Forces on each link in its frame.
        """
        total = np.zeros((len(motion.crank_angle), self.size))
        for number, (load, following) in enumerate(
            zip(loads, self.dependent_rows(motion), strict=True)
        ):
            target = self.targets[number].copy()
            for led in following:
                total[:, led.columns] += led.leading(load[:, led.rows])
                target[led.rows] = -1
            free = np.flatnonzero(target >= 0)
            total[:, target[free]] += load[:, free]
        return total


def _tangent(
    link: WholeLink, motion: RigidMotion, number: int, stiffness: FloatArray, terms: RotationTerms
) -> FloatArray:
    """Stiffness of a link with what its frame's turning adds; (n, n) or (B, n, n)."""
    if terms.centripetal:
        speed = motion.angular_velocity[:, number, None, None]
        stiffness = stiffness - speed**2 * link.centrifugal_mass
    if terms.tangential:
        change = motion.angular_acceleration[:, number, None, None]
        stiffness = stiffness + change * link.gyroscopic
    return stiffness
