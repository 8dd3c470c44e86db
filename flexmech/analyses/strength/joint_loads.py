"""What loads links and joints over the turn, and how fast links turn against each other."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flexmech.analyses.strength.forces import BESIDE, InternalForces
from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system import DisplacedLinks
from flexmech.linkages import InverseDynamics, LinkEnd, Topology
from flexmech.linkages.inverse_dynamics import LinkForces
from flexmech.linkages.motion import direction, normal


@dataclass(frozen=True)
class JointLoads:
    """Forces in the joints at A crank angles.

    Parameters
    ----------
    topology : Topology
    force : ndarray, shape (A, n_joints, 2)
        On the grounded or following link, ground axes, N.
    angle : ndarray, shape (A, n_links)
        Of the links in rad.
    rate : ndarray, shape (A, n_links, 2)
        Angular velocity of their starts and ends in rad/s.
    of_blocks : mapping of str to ndarray, shape (A, 2)
        Force of the block of each slider on its link, away from the link along its axis and across,
        N: what the line, the inertia of the block and loads at its pin make together.
    """

    topology: Topology
    force: FloatArray
    angle: FloatArray
    rate: FloatArray
    of_blocks: Mapping[str, FloatArray]

    @classmethod
    def of_links(cls, found: InverseDynamics | DisplacedLinks, topology: Topology) -> JointLoads:
        """Forces of rigid links, or of displaced ones, whose ends turn in a run by vibration too.

        Parameters
        ----------
        found : InverseDynamics or DisplacedLinks
            At A crank angles.
        topology : Topology

        Returns
        -------
        JointLoads
        """
        force = np.stack([found.joint_force[name] for name in topology.joint_names], axis=1)
        rate = np.repeat(found.motion.angular_velocity[..., None], 2, axis=-1)
        if isinstance(found, DisplacedLinks) and found.rate is not None:
            for number, (link, own) in enumerate(zip(found.links, found.rate, strict=True)):
                rate[:, number] += own @ link.readings.rotations_at(np.array([0.0, 1.0])).T
        return cls(topology, force, found.motion.angle, rate, _of_blocks(found, topology))

    def mapped(self, change: Callable[[FloatArray], FloatArray]) -> JointLoads:
        """With every history (A, ...) changed alike."""
        blocks = {name: change(force) for name, force in self.of_blocks.items()}
        force, angle, rate = (change(one) for one in (self.force, self.angle, self.rate))
        return JointLoads(self.topology, force, angle, rate, blocks)

    def vector(self, joint: str) -> FloatArray:
        """Force of a pin on the grounded or following link, N, (A, 2); of a block in link axes."""
        if joint in self.of_blocks:
            return self.of_blocks[joint]
        return np.asarray(self.force[:, self.topology.joint_names.index(joint)])

    def turning(self, joint: str) -> FloatArray:
        """Size of the angular velocity of what a pin joins against each other, (A,)."""
        follower, leader = self.topology.turning_ends[joint]
        guides = {slider.joint: slider.guide for slider in self.topology.sliders if slider.guide}
        if joint in guides:
            leader = LinkEnd(guides[joint], "start")  # a guide is rigid
        other = 0.0 if leader is None else self._rate(leader)
        return np.abs(self._rate(follower) - other)

    def on_eye(self, end: LinkEnd) -> FloatArray:
        """Force of all pins at the end of a link on it, away from the link and across, (A, 2)."""
        for slider in self.topology.sliders:
            if slider.link_end == end:
                return self.of_blocks[slider.joint]
        total = np.zeros((len(self.force), 2))
        for joint, (follower, leader) in self.topology.pinned_ends.items():
            # A link that leads feels the opposite; several may turn on one pin of it.
            sign = (follower == end) - (leader == end)
            total += sign * self.vector(joint)
        angle = self.angle[:, self.topology.index(end.link)]
        outward = 1.0 if end.end == "end" else -1.0
        along = outward * np.sum(total * direction(angle), axis=-1)
        return np.stack([along, np.sum(total * normal(angle), axis=-1)], axis=-1)

    def _rate(self, end: LinkEnd) -> FloatArray:
        return np.asarray(self.rate[:, self.topology.index(end.link), int(end.end == "end")])


def _of_blocks(found: LinkForces | DisplacedLinks, topology: Topology) -> dict[str, FloatArray]:
    """Forces of blocks of sliders: what the link carries beside them, inside of all at its end."""
    forces = {}
    for slider in topology.sliders:
        number, x = topology.end_place(slider.link_end)
        length = topology.links[number].length
        cut = np.clip(np.array([x]), BESIDE * length, (1 - BESIDE) * length)
        sign = 1.0 if slider.link_end.end == "end" else -1.0
        along, across = found.axial_force(number, cut), sign * found.shear_force(number, cut)
        forces[slider.joint] = np.concatenate([along, across], axis=-1)
    return forces


@dataclass(frozen=True)
class LoadsOfTurn:
    """All loads of one source.

    Parameters
    ----------
    links : mapping of str to InternalForces
        Of every link.
    joints : JointLoads
    moment_gap : ndarray, shape (n_links, 2), optional
        Of links that run: greatest difference of their bending moments from those of the curvature,
        and greatest moment, in N m.
    """

    links: Mapping[str, InternalForces]
    joints: JointLoads
    moment_gap: FloatArray | None = None

    def mapped(self, change: Callable[[FloatArray], FloatArray]) -> LoadsOfTurn:
        """With every history (A, ...) changed alike."""
        links = {
            name: InternalForces(own.place, change(own.loads)) for name, own in self.links.items()
        }
        return LoadsOfTurn(links, self.joints.mapped(change), self.moment_gap)

    def at(self, some: IntArray) -> LoadsOfTurn:
        """Those at some of the crank angles."""
        return self.mapped(lambda history: history[some])

    @classmethod
    def joined(cls, parts: Sequence[LoadsOfTurn]) -> LoadsOfTurn:
        """Loads at several batches of crank angles, one after the other.

        Parameters
        ----------
        parts : sequence of LoadsOfTurn
            Of one mechanism.

        Returns
        -------
        LoadsOfTurn
        """
        if len(parts) == 1:
            return parts[0]
        joints, first = [part.joints for part in parts], parts[0]
        links = {
            name: InternalForces(
                own.place, np.concatenate([part.links[name].loads for part in parts])
            )
            for name, own in first.links.items()
        }
        force, angle, rate = (
            np.concatenate([getattr(one, name) for one in joints])
            for name in ("force", "angle", "rate")
        )
        blocks = {
            name: np.concatenate([one.of_blocks[name] for one in joints])
            for name in first.joints.of_blocks
        }
        gaps = [part.moment_gap for part in parts if part.moment_gap is not None]
        gap = np.max(gaps, axis=0) if gaps else None
        return cls(links, JointLoads(first.joints.topology, force, angle, rate, blocks), gap)
