"""Link frames: how the links' own coordinates hang together while the frames turn.

Each link's displacement is written in the frame of its rigid motion. A pin keeps the
displacement of its joint in the leader's frame; the follower's end is
``R(theta_follower)^T R(theta_leader)`` times it. With ``q = N(t) z``::

    M_r = N'MN
    C_r = N'(2 M Ndot + 2 omega S N) + N'DN
    K_r = N'(M Nddot + 2 omega S Ndot + (K - omega^2 M_t + alpha S) N) + N'D Ndot

These are Turcic and Midha's M_d, M_dd, M_vel, M_d,vel and M_acc (Kumar & Chandrakar,
eq. 1.57). The same code serves every engine: only the link matrices differ.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexmech.linear_system.link_map import LinkMap
from flexmech.linear_system.link_model import LinkModel
from flexmech.linear_system.link_place import LinkPlace, TurningPair
from flexmech.linkages import RigidMotion, Topology
from flexmech.types import FloatArray, IntArray

__all__ = ["LinkDamping", "LinkFrames", "RotationTerms", "SystemMatrices"]


@dataclass(frozen=True)
class RotationTerms:
    """Which inertial terms of the turning frames count.

    Parameters
    ----------
    coriolis : bool
        Velocity-proportional terms: ``2 M_d`` and ``2 M_vel``, and ``N'D Ndot``, which damped
        links add to the stiffness where a pin turns.
    centripetal : bool
        Terms in squares and products of angular velocities: ``M_acc``, ``M_dd``,
        ``2 M_d,vel``.
    tangential : bool
        Terms in angular accelerations of ``M_acc`` and ``M_dd``.
    """

    coriolis: bool = True
    centripetal: bool = True
    tangential: bool = True

    @classmethod
    def all_or_none(cls, wanted: bool) -> RotationTerms:
        """All terms, or the frozen inertial form."""
        return cls(wanted, wanted, wanted)

    @property
    def any(self) -> bool:
        """Whether one term at least counts."""
        return self.coriolis or self.centripetal or self.tangential


@dataclass(frozen=True)
class SystemMatrices:
    """Mass, damping and stiffness over a batch; each of shape (B, n, n)."""

    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray


@dataclass(frozen=True)
class LinkDamping:
    """Damping of one link in its state of stress.

    Parameters
    ----------
    matrix : ndarray, shape (n, n) or (B, n, n)
    ends : ndarray, shape (n, n) or (B, n, n)
        Forces from the rate of the joined ends alone; see
        :class:`flexmech.linear_system.link_model.EndMatrices`.
    """

    matrix: FloatArray
    ends: FloatArray


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
        For each link coordinate the coordinate of z that it takes; -1 where held.
    size : int
        Number of independent coordinates.
    end_count : int
        How many of them, the first ones, are displacements of link ends or turn a free shaft.
    """

    end_count: int

    def __init__(
        self,
        topology: Topology,
        links: Sequence[LinkModel],
        last: Sequence[NDArray[np.bool_]] | None = None,
    ) -> None:
        self.topology = topology
        self.links = tuple(links)
        self.targets = [np.full(link.size, -2, dtype=np.intp) for link in self.links]
        self._followers: list[list[tuple[IntArray, int]]] = [[] for _ in self.links]
        self._hold()
        pairs = self._mark_followers()
        self.size = self._number(
            [np.zeros(link.size, dtype=bool) for link in self.links] if last is None else last
        )
        for link, pair, leader, leader_pair in pairs:
            self.targets[link][pair] = self.targets[leader][leader_pair]
            held = self.targets[leader][leader_pair] < 0
            if not held.all():
                self._followers[link].append((pair, leader))

    def _hold(self) -> None:
        for clamp in self.topology.clamps:
            link = self.topology.index(clamp.held.link)
            model, end = self.links[link], clamp.held.end
            self.targets[link][model.end_displacement(end)] = -1
            self.targets[link][model.end_rotation_of(end)] = -1
        for pivot in self.topology.pivots:
            link = self.topology.index(pivot.held.link)
            self.targets[link][self.links[link].end_displacement(pivot.held.end)] = -1
        for place in self.topology.joined_ends:
            link = self.topology.index(place.link)
            self.targets[link][self.links[link].end_warping_of(place.end)] = -1

    def _mark_followers(self) -> list[tuple[int, IntArray, int, IntArray]]:
        pairs = []
        for pin in self.topology.pins:
            root = self.topology.leader_of(pin.leader)
            link, leader = self.topology.index(pin.follower.link), self.topology.index(root.link)
            pair = self.links[link].end_displacement(pin.follower.end)
            self.targets[link][pair] = -1
            pairs.append((link, pair, leader, self.links[leader].end_displacement(root.end)))
        return pairs

    def _number(self, last: Sequence[NDArray[np.bool_]]) -> int:
        """Number the free coordinates, those of the links' ends and of a free shaft first."""
        count = 0
        ends = [~late for late in last]
        for link, end in zip(self.links, ends, strict=True):
            elsewhere = np.ones(link.size, dtype=bool)
            elsewhere[link.start] = elsewhere[link.end] = elsewhere[link.shaft] = False
            end[elsewhere] = False
        inner = [~(end | late) for end, late in zip(ends, last, strict=True)]
        for group in (ends, inner, last):
            for target, chosen in zip(self.targets, group, strict=True):
                free = (target == -2) & chosen
                target[free] = np.arange(count, count + free.sum())
                count += int(free.sum())
            if group is ends:
                self.end_count = count
        return count

    def following(self, link: int) -> IntArray:
        """Coordinates of a link that follow another link's end."""
        pairs = [pair for pair, _ in self._followers[link]]
        return np.concatenate([np.zeros(0, dtype=np.intp), *pairs])

    def turning_pairs(self, motion: RigidMotion, link: int) -> list[TurningPair]:
        """Rotation of a link's following ends and its time derivatives over a batch."""
        pairs = []
        for pair, leader in self._followers[link]:
            angle = motion.angle[:, leader] - motion.angle[:, link]
            speed = motion.angular_velocity[:, leader] - motion.angular_velocity[:, link]
            change = motion.angular_acceleration[:, leader] - motion.angular_acceleration[:, link]
            cosine, sine = np.cos(angle), np.sin(angle)
            turn = np.stack([cosine, -sine, sine, cosine], axis=-1).reshape(-1, 2, 2)
            quarter = np.stack([-sine, -cosine, cosine, -sine], axis=-1).reshape(-1, 2, 2)
            pairs.append(
                TurningPair(
                    pair=pair,
                    turn=turn,
                    rate=speed[:, None, None] * quarter,
                    centripetal=-(speed[:, None, None] ** 2) * turn,
                    tangential=change[:, None, None] * quarter,
                )
            )
        return pairs

    def assemble(
        self,
        motion: RigidMotion,
        stiffness: Sequence[FloatArray],
        terms: RotationTerms,
        damping: Sequence[LinkDamping] | None = None,
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

        Returns
        -------
        SystemMatrices
        """
        batch = len(motion.crank_angle)
        if damping is None:
            damping = [LinkDamping(link.damping, link.ends.damping) for link in self.links]
        shape = (batch, self.size, self.size)
        # One block of memory: the allocator keeps it for the next batch.
        mass, total = np.empty((2, *shape))
        damps = terms.coriolis or any(own.matrix.any() for own in damping)
        rates = np.zeros(shape) if damps else np.broadcast_to(0.0, shape)
        tangents = [_tangent(self.links[n], motion, n, x, terms) for n, x in enumerate(stiffness)]
        factors = [m.turning_factors(self._turned(motion, n)) for n, m in enumerate(self._maps)]
        self._sum_steady(mass, {n: link.mass for n, link in enumerate(self.links)}, factors)
        self._sum_steady(total, {n: t for n, t in enumerate(tangents) if t.ndim == 2}, factors)
        for number, (link, tangent, own) in enumerate(
            zip(self.links, tangents, damping, strict=True)
        ):
            damped = bool(own.matrix.any())
            if tangent.ndim == 2 and not damped and not terms.any:
                continue
            place, pairs = self._places[number], self.turning_pairs(motion, number)
            speed = motion.angular_velocity[:, number, None, None]
            if tangent.ndim == 3:
                place.add(total, tangent, pairs)
            if damped:
                place.add(rates, own.matrix, pairs)
            turning = [p.rate for p in pairs]
            if terms.coriolis:
                place.add(rates, 2 * speed * link.gyroscopic, pairs)
                place.add_following(rates, 2 * link.ends.mass, pairs, turning)
                if damped:
                    place.add_following(total, own.ends, pairs, turning)
            if terms.centripetal:
                place.add_following(total, link.ends.mass, pairs, [p.centripetal for p in pairs])
                coriolis = [2 * speed * rate for rate in turning]
                place.add_following(total, link.ends.gyroscopic, pairs, coriolis)
            if terms.tangential:
                place.add_following(total, link.ends.mass, pairs, [p.tangential for p in pairs])
        return SystemMatrices(mass, rates, total)

    def _sum_steady(
        self,
        total: FloatArray,
        matrices: Mapping[int, FloatArray],
        factors: Sequence[FloatArray],
    ) -> None:
        """Write the sum of ``N'XN`` over symmetric matrices (n, n) of some links, by number."""
        # What turns has a row or a column of an end that leads, and those ends come first.
        led = [self.targets[n][pair] for n in matrices for pair, _ in self._followers[n]]
        ends = 1 + max((int(pair.max()) for pair in led), default=-1)
        resting = np.zeros((self.size, self.size))
        for number, matrix in matrices.items():
            self._places[number].add_resting(resting, matrix)
        total[:] = resting
        if not led:
            return
        terms = [self._maps[n].turning_terms(matrix, ends) for n, matrix in matrices.items()]
        weights = np.concatenate([factors[n] for n in matrices])
        turning = np.tensordot(weights, np.concatenate(terms), axes=(0, 0))
        total[:, :, :ends] += turning
        total[:, :ends, ends:] += np.swapaxes(turning[:, ends:], 1, 2)

    def _turned(self, motion: RigidMotion, link: int) -> FloatArray:
        """Angles by which a link's following ends turn, (k, B)."""
        leaders = [leader for _, leader in self._followers[link]]
        return np.asarray(motion.angle[:, leaders].T - motion.angle[:, link])

    @cached_property
    def _maps(self) -> list[LinkMap]:
        return [
            LinkMap.of(target, [pair for pair, _ in followers], self.size)
            for target, followers in zip(self.targets, self._followers, strict=True)
        ]

    @cached_property
    def _places(self) -> list[LinkPlace]:
        return [
            LinkPlace.of(target, [pair for pair, _ in followers])
            for target, followers in zip(self.targets, self._followers, strict=True)
        ]

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
        for number, link in enumerate(self.links):
            target = self.targets[number]
            free = target >= 0
            q = np.zeros((len(vectors), link.size, vectors.shape[2]), dtype=vectors.dtype)
            q[:, free] = vectors[:, target[free]]
            for turning in self.turning_pairs(motion, number):
                q[:, turning.pair] = turning.turn @ q[:, turning.pair]
            result.append(q)
        return result

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
        for number, link in enumerate(self.links):
            target = self.targets[number]
            free = target >= 0
            q, rate, change = np.zeros((3, len(position), link.size))
            for values, given in ((q, position), (rate, velocity), (change, acceleration)):
                values[:, free] = given[:, target[free]]
            for turning in self.turning_pairs(motion, number):
                z0, z1, z2 = (v[:, turning.pair, None] for v in (q, rate, change))
                twice = turning.centripetal + turning.tangential
                q[:, turning.pair] = (turning.turn @ z0)[..., 0]
                rate[:, turning.pair] = (turning.turn @ z1 + turning.rate @ z0)[..., 0]
                change[:, turning.pair] = (turning.turn @ z2 + 2 * turning.rate @ z1 + twice @ z0)[
                    ..., 0
                ]
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
        for number, load in enumerate(loads):
            turned = np.array(load, dtype=float)
            for turning in self.turning_pairs(motion, number):
                pair = turning.pair
                turned[:, pair] = np.einsum("bij,bi->bj", turning.turn, turned[:, pair])
            target = self.targets[number]
            free = np.flatnonzero(target >= 0)
            total[:, target[free]] += turned[:, free]
        return total


def _tangent(
    link: LinkModel, motion: RigidMotion, number: int, stiffness: FloatArray, terms: RotationTerms
) -> FloatArray:
    """Stiffness of a link with what its frame's turning adds; (n, n) or (B, n, n)."""
    if terms.centripetal:
        speed = motion.angular_velocity[:, number, None, None]
        stiffness = stiffness - speed**2 * link.translational_mass
    if terms.tangential:
        change = motion.angular_acceleration[:, number, None, None]
        stiffness = stiffness + change * link.gyroscopic
    return stiffness
