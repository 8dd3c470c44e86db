"""Shaking force of a linkage on its frame, and first moments of counterweights against it.

R. S. Berkof and G. G. Lowen, A New Method for Completely Force Balancing Simple Linkages, Journal
of Engineering for Industry 91 (1969) 21-26: with the loop closed, the first moment of all masses is
a sum of linearly independent vectors that rotate with crank and follower; it stands still where
their coefficients are zero.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages.applied_forces import JointSpring, Moved, Spring, forces_of_springs
from flexmech.linkages.body_motion import GROUND_AFTER_LINKS
from flexmech.linkages.link_mass import LinkMass
from flexmech.linkages.motion import RigidMotion, cross, direction
from flexmech.linkages.topology import Clamp, LinkEnd, Topology


@dataclass(frozen=True)
class ShakingForce:
    """Resultant of all that a linkage exerts on its frame.

    Parameters
    ----------
    force : ndarray, shape (..., 2)
        Ground axes, N.
    moment : ndarray, shape (...)
        About ``point``, N m.
    point : tuple of float
        In ground axes, m.
    """

    force: FloatArray
    moment: FloatArray
    point: tuple[float, float]


def shaking_force(
    topology: Topology,
    motion: RigidMotion,
    joint_force: FloatArray,
    drive_torque: FloatArray,
    point: tuple[float, float] | None = None,
    *,
    springs: Sequence[Spring] = (),
    joint_springs: Sequence[JointSpring] = (),
    angles: FloatArray | None = None,
    moved: Moved | None = None,
) -> ShakingForce:
    """Sum what joints, the drive and springs put on the frame.

    The reactions of all joints to the ground, that of the drive, which stands on the frame, and the
    forces of springs that end on it. What gravity, loads and inertia do to the links comes through
    these; whatever exerts the loads stands elsewhere. It is the rate of the momentum with the other
    sign, with weight and loads added (Berkof and Lowen 1969; Kumar & Chandrakar, eqs. 1.43 and
    1.44 summed over the links).

    Parameters
    ----------
    topology : Topology
    motion : RigidMotion
    joint_force : ndarray, shape (..., n_joints, 2)
        On the grounded or following link of each joint, in order, ground axes, N.
    drive_torque : ndarray, shape (...)
        Torque of the drive on shaft and crank about the shaft's axis, N m.
    point : tuple of float, optional
        About which the moment is taken, ground axes, m; the shaft's axis if left out.
    springs : sequence of Spring
    joint_springs : sequence of JointSpring
    angles : ndarray, shape (..., n_links), optional
        Angles of the links in rad, counted on continuously as the linkage turns, for springs in
        joints; those of ``motion`` if left out.
    moved : callable, optional
        See :data:`flexmech.linkages.applied_forces.Moved`; undisplaced links by default.

    Returns
    -------
    ShakingForce

    Raises
    ------
    InputError
        Where the ends of a spring meet and its direction is not defined.
    """
    about = np.asarray(shaft_axis(topology, motion) if point is None else point)
    names = topology.joint_names
    force = np.zeros((*motion.crank_angle.shape, 2))
    moment = -np.broadcast_to(drive_torque, force.shape[:-1])
    for joint, place in _bearings(topology, motion, moved):
        reaction = -joint_force[..., names.index(joint), :]
        force, moment = force + reaction, moment + cross(place - about, reaction)
    turned = motion.angle if angles is None else angles
    for one in forces_of_springs(topology, motion, springs, joint_springs, turned, moved):
        if one.link == GROUND_AFTER_LINKS:
            arm, couple = np.array([one.x, one.y]) - about, one.torque
            force, moment = force + one.force, moment + cross(arm, one.force) + couple
    return ShakingForce(force, moment, (float(about[0]), float(about[1])))


def shaft_axis(topology: Topology, motion: RigidMotion) -> tuple[float, float]:
    """Where the axis of the driven shaft is, in ground axes in m.

    Parameters
    ----------
    topology : Topology
    motion : RigidMotion

    Returns
    -------
    tuple of float
    """
    x, y = _axis(topology, motion, topology.clamps[0]).reshape(-1, 2)[0]
    return float(x), float(y)


def _axis(topology: Topology, motion: RigidMotion, clamp: Clamp) -> FloatArray:
    """Axis of a clamp's shaft, from which its end is a hub away; shape (..., 2)."""
    link, x = topology.end_place(clamp.link_end)
    return motion.position(link, x) - clamp.hub * direction(motion.angle[..., link])


def _bearings(
    topology: Topology, motion: RigidMotion, moved: Moved | None
) -> Iterator[tuple[str, FloatArray]]:
    """Joints to the ground, and where each exerts its reaction, (..., 2).

    The couple of a clamp is that of the drive.
    """
    for clamp in topology.clamps:
        yield clamp.joint, _axis(topology, motion, clamp)
    for pivot in topology.pivots:
        # Where its bearing is: a link's end on springs moves against that.
        yield pivot.joint, motion.position(*topology.end_place(pivot.link_end))
    for slider in topology.sliders:
        if not slider.guide:
            link, x = topology.end_place(slider.link_end)
            shift = 0.0 if moved is None else moved(link, x)[0][..., :2]
            yield slider.joint, motion.position(link, x) + shift


# Numbers of links, clamps, pins, pivots, sliders and welds.
_FOUR_BAR, _SLIDER_CRANK = (3, 1, 2, 1, 0, 0), (2, 1, 1, 0, 1, 0)
METHOD = "counterweights are found for a four-bar and a slider-crank"


@dataclass(frozen=True)
class TurningLink:
    """A link that rotates about a point of the ground and carries one end of the coupler.

    Parameters
    ----------
    number : int
        In the topology.
    name : str
    end : {"start", "end"}
        Its end at that point, or a hub away from it.
    pivot, pin : float
        Places along the link's frame, in m: of the point of the ground, and of the coupler's pin.
    """

    number: int
    name: str
    end: str
    pivot: float
    pin: float

    @property
    def arm(self) -> float:
        """From the point of the ground to the pin, along the link's frame, in m."""
        return self.pin - self.pivot

    def moment(self, mass: LinkMass) -> complex:
        """First moment of the link about the point of the ground, in its frame, kg m."""
        return complex(mass.moment(1) - mass.moment(0) * self.pivot, mass.moment_across)


@dataclass(frozen=True)
class OneCouplerLinkage:
    """A crank, one coupler, and a follower or a slider on the ground.

    Parameters
    ----------
    crank : TurningLink
    coupler : int
        Number of the coupler in the topology.
    first, second : float
        Places along the coupler's frame of its joints with the crank and with the follower or the
        line, in m.
    follower : TurningLink or None
        None of a slider-crank.
    """

    crank: TurningLink
    coupler: int
    first: float
    second: float
    follower: TurningLink | None

    @classmethod
    def of(cls, topology: Topology) -> Self:
        """Crank, coupler and follower of a linkage.

        Parameters
        ----------
        topology : Topology

        Returns
        -------
        OneCouplerLinkage

        Raises
        ------
        InputError
            If it is neither a four-bar nor a slider-crank; says what it has.
        """
        clamps, pivots, sliders = topology.clamps, topology.pivots, topology.sliders
        parts = {
            "link": topology.links,
            "clamp": clamps,
            "pin": topology.pins,
            "pivot": pivots,
            "slider": sliders,
            "weld": topology.welds,
        }
        counts = {name: len(links) for name, links in parts.items()}
        counted = (f"{n} {name}{'s' * (n > 1)}" for name, n in counts.items() if n)
        refusal = InputError(
            f"{METHOD}, whose loop has one coupler; this linkage has {', '.join(counted)}: "
            "other vectors would have to vanish"
        )
        if tuple(counts.values()) not in (_FOUR_BAR, _SLIDER_CRANK):
            raise refusal
        if any(slider.guide for slider in sliders):
            raise refusal
        joined = _joined(topology)
        fixed = clamps[0].link_end
        pin = _other(fixed)
        if pin not in joined:
            raise refusal
        crank = _turning(topology, fixed, clamps[0].hub)
        first = joined[pin]
        last = _other(first)
        if sliders:
            if sliders[0].link_end != last:
                raise refusal
            follower = None
        else:
            if last not in joined or joined[last] != _other(pivots[0].link_end):
                raise refusal
            follower = _turning(topology, pivots[0].link_end)
        coupler, place = topology.end_place(first)
        return cls(crank, coupler, place, topology.end_place(last)[1], follower)

    @property
    def turning(self) -> tuple[TurningLink, ...]:
        """Links that can carry a counterweight."""
        return (self.crank,) if self.follower is None else (self.crank, self.follower)

    def coupler_masses(self, masses: Sequence[LinkMass]) -> tuple[complex, complex]:
        """Masses at the coupler's two joints that have its mass and its first moment, in kg.

        Parameters
        ----------
        masses : sequence of LinkMass
            One a link, in order.

        Returns
        -------
        tuple of complex
            At the crank and at the follower or the line. Imaginary parts are those of a centre of
            mass off the line between the joints.
        """
        mass = masses[self.coupler]
        about = complex(mass.moment(1) - mass.moment(0) * self.first, mass.moment_across)
        second = about / (self.second - self.first)
        return mass.moment(0) - second, second

    def balancing_moments(
        self, masses: Sequence[LinkMass], share: float = 1.0
    ) -> tuple[complex, ...]:
        """First moments that counterweights must have, about the points of the ground.

        Parameters
        ----------
        masses : sequence of LinkMass
            One a link, in order.
        share : float
            Share of a slider-crank: part of the reciprocating mass that the crank's counterweight
            balances as if it rotated with the pin.

        Returns
        -------
        tuple of complex
            First moment of each turning link, along and across its frame, in kg m. With them a
            four-bar has no shaking force by inertia; a slider-crank keeps that of the reciprocating
            mass and of the counterweight's share against it.
        """
        first, second = self.coupler_masses(masses)
        loads = [first + share * second] if self.follower is None else [first, second]
        return tuple(
            -(link.moment(masses[link.number]) + load * link.arm)
            for link, load in zip(self.turning, loads, strict=True)
        )


def _other(end: LinkEnd) -> LinkEnd:
    return LinkEnd(end.link, "end" if end.end == "start" else "start")


def _joined(topology: Topology) -> dict[LinkEnd, LinkEnd]:
    """The end that each pinned end is pinned to."""
    pairs = [(pin.leader, pin.follower) for pin in topology.pins]
    return dict(pairs) | {second: first for first, second in pairs}


def _turning(topology: Topology, fixed: LinkEnd, hub: float = 0.0) -> TurningLink:
    number, place = topology.end_place(fixed)
    pin = topology.end_place(_other(fixed))[1]
    return TurningLink(number, fixed.link, fixed.end, place - hub, pin)
