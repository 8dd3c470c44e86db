"""Forces of loads and springs on the links of a rigid linkage."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flexmech.linkages.attachments import JointSpring, LinkPoint, Load, Spring
from flexmech.linkages.motion import RigidMotion, direction, normal
from flexmech.linkages.spring_line import SpringLine
from flexmech.linkages.topology import Topology
from flexmech.types import FloatArray


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

    def arm(self, motion: RigidMotion) -> FloatArray:
        """From the link's start to its place, ground axes; shape (..., 2), in m."""
        angle = motion.angle[..., self.link]
        along = np.asarray(self.x)[..., None] * direction(angle)
        return np.asarray(along + np.asarray(self.y)[..., None] * normal(angle))

    def moment(self, motion: RigidMotion) -> FloatArray:
        """About the link's start in N m; shape (...)."""
        arm = self.arm(motion)
        lever = arm[..., 0] * self.force[..., 1] - arm[..., 1] * self.force[..., 0]
        return np.asarray(lever + self.torque)

    def power(self, motion: RigidMotion) -> FloatArray:
        """What it does on the moving link in W; shape (...)."""
        arm, rate = self.arm(motion), motion.angular_velocity[..., self.link]
        turning = rate[..., None] * np.stack([-arm[..., 1], arm[..., 0]], axis=-1)
        velocity = motion.origin_velocity[..., self.link, :] + turning
        return np.asarray(np.sum(self.force * velocity, axis=-1) + self.torque * rate)


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
    topology: Topology, motion: RigidMotion, point: LinkPoint
) -> tuple[FloatArray, FloatArray]:
    """Position and velocity of a point in ground axes, each of shape (..., 2)."""
    if point.is_ground:
        place = np.broadcast_to((point.x, point.y), (*motion.crank_angle.shape, 2))
        return place, np.zeros_like(place)
    link = topology.index(point.link)
    return motion.position(link, point.x), motion.velocity(link, point.x)
