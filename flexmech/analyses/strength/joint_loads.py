"""Internal and joint forces over the turn, at crank angles to which further ones can be added.

Tension, shear force and bending moment at places along every link, forces in the joints, and how
fast links turn against each other: of rigid links, of equilibria and of runs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from scipy.interpolate import CubicSpline

from flexmech.arrays import SAME_PLACE, FloatArray, IntArray
from flexmech.linkages import InverseDynamics, LinkEnd, Topology
from flexmech.linkages.inverse_dynamics import LinkForces
from flexmech.linkages.motion import direction, normal
from flexmech.mechanics import DisplacedLinks, kinks_of
from flexmech.mechanism import Mechanism

# Off the ends of a link and off masses, loads and springs, where internal forces jump.
BESIDE = 2 * SAME_PLACE


@dataclass(frozen=True)
class InternalForces:
    """Internal forces of a link.

    Parameters
    ----------
    place : ndarray, shape (k,)
        From the link's start in m; twice where they jump.
    loads : ndarray, shape (A, k, 3)
        Axial force along the pins' axis in N, bending moment in N m that stretches the side of
        lower y, shear force in N along y on the face towards higher x.
    """

    place: FloatArray
    loads: FloatArray


@dataclass(frozen=True)
class Cuts:
    """Where a link is cut to see its internal forces.

    Parameters
    ----------
    place : ndarray, shape (k,)
        From the link's start in m, ascending; twice where internal forces jump.
    cut : ndarray, shape (k,)
        The same, off the ends and on one or the other side of jumps.
    """

    place: FloatArray
    cut: FloatArray

    @property
    def kinks(self) -> list[float]:
        """Where internal forces jump, from the link's start in m."""
        return sorted(set(self.place[:-1][np.diff(self.place) == 0].tolist()))


def cuts_of(mechanism: Mechanism, link: str, elements: int, further: Sequence[float] = ()) -> Cuts:
    """Where internal forces of a link are looked at.

    Parameters
    ----------
    mechanism : Mechanism
    link : str
    elements : int
        Parts of equal length.
    further : sequence of float
        Places from the link's start in m.

    Returns
    -------
    Cuts
        At the ends of the parts, at further places, and at both sides of all that acts on the link
        between its ends.
    """
    length = mechanism.link_mass(link).length
    beside = BESIDE * length
    jumps = np.unique([x for x in kinks_of(mechanism, link) if beside < x < length - beside])
    even = np.linspace(0.0, length, elements + 1)
    # Searches meet at a place but for round-off.
    more = np.unique(np.asarray(further, dtype=float))
    more = more[np.diff(more, prepend=-np.inf) > SAME_PLACE * length]
    new = np.abs(even[:, None] - more).min(axis=0) > SAME_PLACE * length
    even = np.union1d(even, more[new])
    # A part's end at a jump is there already, on both of its sides.
    apart = np.abs(even[:, None] - jumps).min(axis=1, initial=np.inf) > SAME_PLACE * length
    place = np.concatenate([even[apart], jumps, jumps])
    cut = np.concatenate([even[apart], jumps - beside, jumps + beside])
    order = np.argsort(cut)
    return Cuts(place[order], np.clip(cut[order], beside, length - beside))


def internal_forces(forces: LinkForces | DisplacedLinks, link: int, cuts: Cuts) -> InternalForces:
    """Internal forces of a link.

    Parameters
    ----------
    forces : LinkForces or DisplacedLinks
        At A crank angles.
    link : int
    cuts : Cuts

    Returns
    -------
    InternalForces
    """
    if isinstance(forces, DisplacedLinks):
        return InternalForces(cuts.place, forces.section_forces(link, cuts.cut))
    found = (forces.axial_force, forces.bending_moment, forces.shear_force)
    return InternalForces(cuts.place, np.stack([of(link, cuts.cut) for of in found], axis=-1))


def forces_over_the_turn(
    mechanism: Mechanism, crank_angles: FloatArray, speed: float
) -> InverseDynamics:
    """Forces of the rigid linkage in its steady motion, with all that acts on it.

    Parameters
    ----------
    mechanism : Mechanism
    crank_angles : ndarray, shape (A,)
        In rad.
    speed : float
        In rad/s.

    Returns
    -------
    InverseDynamics
    """
    motion = mechanism.linkage.motion(crank_angles, speed, 0.0)
    time = crank_angles / speed if speed else np.zeros_like(crank_angles)
    return mechanism.inverse_dynamics(motion, time)


@dataclass(frozen=True)
class JointLoads:
    """Forces in the joints at A crank angles.

    Parameters
    ----------
    topology : Topology
    force : ndarray, shape (A, n_joints, 2)
        On the grounded or following link, ground axes, N.
    angle : ndarray, shape (A, n_links)
        Angle of the links in rad.
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
        Links of every link.
    joints : JointLoads
    moment_gap : ndarray, shape (n_links, 2), optional
        For links that run: greatest difference of their bending moments from those of the
        curvature, and greatest moment, in N m.
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
        """Loads at some of the crank angles."""
        return self.mapped(lambda history: history[some])

    @classmethod
    def joined(cls, parts: Sequence[LoadsOfTurn]) -> LoadsOfTurn:
        """Loads at several batches of crank angles, one after the other.

        Parameters
        ----------
        parts : sequence of LoadsOfTurn
            Parts of one mechanism.

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


Found = DisplacedLinks | InverseDynamics
"""Source of internal and joint forces, at a batch of crank angles."""


class SampledLoads(Protocol):
    """Loads at crank angles.

    Attributes
    ----------
    crank_angles : ndarray, shape (A,)
        In rad, increasing.
    """

    crank_angles: FloatArray

    def add(self, crank_angles: FloatArray) -> None:
        """Know the loads at further crank angles too.

        Parameters
        ----------
        crank_angles : ndarray, shape (m,)
            In rad.
        """

    def loads(self, cuts: Mapping[str, Cuts]) -> LoadsOfTurn:
        """Loads at all crank angles.

        Parameters
        ----------
        cuts : mapping of str to Cuts
            Cuts of every link.

        Returns
        -------
        LoadsOfTurn
        """


@dataclass
class LoadsAtAngles:
    """Loads of links that are at rest in their frames at every crank angle.

    Parameters
    ----------
    mechanism : Mechanism
    compute : callable
        From crank angles (m,) in rad to the links there, batch by batch.
    crank_angles : ndarray, shape (A,)
        In rad, increasing; begins without any.
    """

    mechanism: Mechanism
    compute: Callable[[FloatArray], Sequence[Found]]
    crank_angles: FloatArray = field(default_factory=lambda: np.empty(0))
    _found: list[Found] = field(default_factory=list, repr=False)
    _order: FloatArray = field(default_factory=lambda: np.empty(0), repr=False)

    @classmethod
    def of_rigid_links(cls, mechanism: Mechanism, speed: float) -> LoadsAtAngles:
        """Loads of links that are taken as rigid, at a crank speed in rad/s."""
        return cls(mechanism, lambda angles: [forces_over_the_turn(mechanism, angles, speed)])

    def add(self, crank_angles: FloatArray) -> None:
        """Know the loads at further crank angles too.

        Parameters
        ----------
        crank_angles : ndarray, shape (m,)
            In rad.
        """
        new = np.setdiff1d(crank_angles, self.crank_angles)
        if new.size:
            self._found += self.compute(new)
            self._order = np.concatenate([self._order, new])
            self.crank_angles = np.sort(self._order)

    def loads(self, cuts: Mapping[str, Cuts]) -> LoadsOfTurn:
        """Loads at all crank angles.

        Parameters
        ----------
        cuts : mapping of str to Cuts
            Cuts of every link.

        Returns
        -------
        LoadsOfTurn
        """
        topology = self.mechanism.linkage.topology
        parts = []
        for found in self._found:
            inside = {
                name: internal_forces(found, number, cuts[name])
                for number, name in enumerate(topology.link_names)
            }
            parts.append(LoadsOfTurn(inside, JointLoads.of_links(found, topology)))
        return LoadsOfTurn.joined(parts).at(np.argsort(self._order))


@dataclass
class LoadsOfRun:
    """Loads of a run at its samples, and between them by cubic splines.

    Parameters
    ----------
    angles_of_samples : ndarray, shape (A,)
        In rad, increasing.
    at_samples : callable
        From the cuts of every link to the loads at the samples.
    """

    angles_of_samples: FloatArray
    at_samples: Callable[[Mapping[str, Cuts]], LoadsOfTurn]
    crank_angles: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        self.crank_angles = self.angles_of_samples

    def add(self, crank_angles: FloatArray) -> None:
        """Know the loads at further crank angles too.

        Parameters
        ----------
        crank_angles : ndarray, shape (m,)
            In rad.
        """
        self.crank_angles = np.union1d(self.crank_angles, crank_angles)

    def loads(self, cuts: Mapping[str, Cuts]) -> LoadsOfTurn:
        """Loads at all crank angles.

        Parameters
        ----------
        cuts : mapping of str to Cuts
            Cuts of every link.

        Returns
        -------
        LoadsOfTurn
        """
        found, samples = self.at_samples(cuts), self.angles_of_samples
        between = np.setdiff1d(self.crank_angles, samples)
        if not between.size:
            return found
        more = found.mapped(lambda values: CubicSpline(samples, values)(between))
        order = np.argsort(np.concatenate([samples, between]))
        return LoadsOfTurn.joined([found, more]).at(order)
