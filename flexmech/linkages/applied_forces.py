"""Forces of loads and springs on the links of a rigid linkage, and the line of a spring."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import SAME_PLACE, FloatArray
from flexmech.errors import InputError
from flexmech.linkages.attachments import AttachmentPoint, JointSpring, Load, Spring
from flexmech.linkages.motion import RigidMotion, cross
from flexmech.linkages.topology import Topology


@dataclass(frozen=True)
class SpringLine:
    """A spring at its length.

    Parameters
    ----------
    along : ndarray, shape (..., 2)
        Unit vector from the first end to the second, in ground axes.
    length : ndarray, shape (...)
        In m.
    relative_velocity : ndarray, shape (..., 2)
        Velocity of the second end against the first in m/s.
    tension : ndarray, shape (...)
        In N.
    """

    along: FloatArray
    length: FloatArray
    relative_velocity: FloatArray
    tension: FloatArray

    @property
    def rate(self) -> FloatArray:
        """Rate of the length in m/s, (...)."""
        return np.asarray(np.sum(self.along * self.relative_velocity, axis=-1))

    @classmethod
    def of(
        cls,
        spring: Spring,
        crank_angle: FloatArray,
        places: Sequence[FloatArray],
        velocities: Sequence[FloatArray],
        size: float,
        *,
        needs_direction: bool = True,
    ) -> SpringLine:
        """Line of a spring whose ends are known.

        Parameters
        ----------
        spring : Spring
        crank_angle : ndarray, shape (...)
            In rad, for messages.
        places, velocities : sequence of ndarray, shape (..., 2)
            Of its first and its second end, in ground axes.
        size : float
            Of the linkage in m.
        needs_direction : bool
            Whether ends that meet are refused. The force alone of a spring without free
            length and damping is nothing there.

        Returns
        -------
        SpringLine

        Raises
        ------
        InputError
            Where the ends meet; names the crank angle.
        """
        line, relative_velocity = places[1] - places[0], velocities[1] - velocities[0]
        length = np.linalg.norm(line, axis=-1)
        met = length <= SAME_PLACE * size
        if needs_direction and np.any(met):
            angle = np.degrees(crank_angle[met].flat[0])
            raise InputError(
                f"spring {spring.name}: its ends meet at crank angle {angle:.6g} deg, where its "
                "force has no direction; move an end, or leave that crank angle out"
            )
        along = line / np.where(met, 1.0, length)[..., None]
        tension = spring.stiffness * (length - spring.free_length)
        tension = tension + spring.damping * np.sum(along * relative_velocity, axis=-1)
        return cls(along, length, relative_velocity, tension)


@dataclass(frozen=True)
class ForceOnLink:
    """A force and a torque that act on a link.

    Parameters
    ----------
    link : int
        Number of the link in the topology.
    x : float or ndarray, shape (...)
        Place along the link's frame in m; an array where it moves along the link.
    force : ndarray, shape (..., 2)
        Ground axes, N.
    torque : ndarray, shape (...)
        In N m.
    y : float or ndarray, shape (...)
        Place across the link's frame in m.
    """

    link: int
    x: float | FloatArray
    force: FloatArray
    torque: FloatArray
    y: float | FloatArray = 0.0

    def moment(self, motion: RigidMotion) -> FloatArray:
        """About the link's start in N m; shape (...)."""
        return cross(motion.arm(self.link, self.x, self.y), self.force) + self.torque

    def power(self, motion: RigidMotion) -> FloatArray:
        """What it does on the moving link in W; shape (...)."""
        velocity = motion.velocity(self.link, self.x, self.y)
        turning = self.torque * motion.angular_velocity[..., self.link]
        return np.asarray(np.sum(self.force * velocity, axis=-1) + turning)


def forces_of_loads(
    topology: Topology, motion: RigidMotion, loads: Sequence[Load], time: ArrayLike = 0.0
) -> Iterator[ForceOnLink]:
    """Each load as it acts in each position.

    Parameters
    ----------
    topology : Topology
    motion : RigidMotion
    loads : sequence of Load
    time : array_like, shape (...)
        Of each position in s, for loads over time.

    Yields
    ------
    ForceOnLink
    """
    for load in loads:
        link = topology.index(load.point.link)
        values = load.values(motion.crank_angle, time)
        force = load.in_ground_axes(values, motion.angle[..., link])
        yield ForceOnLink(link, load.point.x, force, values[..., 2])


def forces_of_springs(
    topology: Topology, motion: RigidMotion, springs: Sequence[Spring]
) -> Iterator[ForceOnLink]:
    """Both ends of each spring, by its length and the length's rate.

    Parameters
    ----------
    topology : Topology
    motion : RigidMotion
    springs : sequence of Spring

    Yields
    ------
    ForceOnLink

    Raises
    ------
    InputError
        Where the ends of a spring meet and its direction is not defined.
    """
    for spring in springs:
        ends = (spring.first, spring.second)
        places, rates = zip(*(_point_motion(topology, motion, end) for end in ends), strict=True)
        line = SpringLine.of(
            spring,
            motion.crank_angle,
            places,
            rates,
            max(spring.free_length, *(link.length for link in topology.links)),
            needs_direction=bool(spring.free_length or spring.damping),
        )
        for end, sign in zip(ends, (1.0, -1.0), strict=True):
            if not end.is_ground:
                force = sign * line.tension[..., None] * line.along
                nothing = np.zeros_like(line.tension)
                yield ForceOnLink(topology.index(end.link), end.x, force, nothing)


def forces_of_joint_springs(
    topology: Topology,
    motion: RigidMotion,
    springs: Sequence[JointSpring],
    angles: FloatArray,
) -> Iterator[ForceOnLink]:
    """Torques of the springs in pins and pivots on the links that meet there.

    Parameters
    ----------
    topology : Topology
    motion : RigidMotion
    springs : sequence of JointSpring
    angles : ndarray, shape (..., n_links)
        Of the links in rad, counted on continuously as the linkage turns.

    Yields
    ------
    ForceOnLink
    """
    ends = topology.pinned_ends
    for spring in springs:
        if not (spring.torsional_stiffness or spring.torsional_damping):
            continue
        sides = [
            (sign, place)
            for sign, place in zip((1.0, -1.0), ends[spring.joint], strict=True)
            if place is not None
        ]
        opening = topology.opening(spring.joint, angles)
        torque = spring.torque(opening, topology.opening(spring.joint, motion.angular_velocity))
        for sign, place in sides:
            link = topology.index(place.link)
            x = 0.0 if place.end == "start" else topology.links[link].length
            yield ForceOnLink(link, x, np.zeros((*torque.shape, 2)), sign * torque)


def _point_motion(
    topology: Topology, motion: RigidMotion, point: AttachmentPoint
) -> tuple[FloatArray, FloatArray]:
    """Position and velocity of a point in ground axes, each of shape (..., 2)."""
    if point.is_ground:
        place = np.broadcast_to((point.x, point.y), (*motion.crank_angle.shape, 2))
        return place, np.zeros_like(place)
    link = topology.index(point.link)
    return motion.position(link, point.x), motion.velocity(link, point.x)
