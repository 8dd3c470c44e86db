"""Forces of loads and springs on the links of a rigid linkage, and the line of a spring."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import SAME_PLACE, FloatArray
from flexmech.errors import InputError
from flexmech.linkages.attachments import AttachmentPoint, JointSpring, Load, Spring
from flexmech.linkages.body_motion import GROUND_AFTER_LINKS
from flexmech.linkages.motion import RigidMotion, cross
from flexmech.linkages.topology import Topology

Moved = Callable[[int, float], tuple[FloatArray, FloatArray]]
"""From a link's number and a place on it to its displacement from the rigid motion: along ground x
and y with the rotation of the section, (..., 3), and the rate of that."""


@dataclass(frozen=True)
class SpringLine:
    """Line, length and tension of a spring in given positions.

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
        topology: Topology,
        motion: RigidMotion,
        moved: Moved | None = None,
        *,
        needs_direction: bool = True,
    ) -> SpringLine:
        """Line of a spring in each position of its linkage.

        Parameters
        ----------
        spring : Spring
        topology : Topology
        motion : RigidMotion
        moved : callable, optional
            See :data:`Moved`; undisplaced links by default.
        needs_direction : bool
            Whether coincident ends are refused. The force of a spring without free length and
            damping is zero there.

        Returns
        -------
        SpringLine

        Raises
        ------
        InputError
            Where the ends meet; names the crank angle.
        """
        first, second = (
            _point_motion(topology, motion, end, moved) for end in (spring.first, spring.second)
        )
        line, relative_velocity = second[0] - first[0], second[1] - first[1]
        length = np.linalg.norm(line, axis=-1)
        size = max(spring.free_length, *(link.length for link in topology.links))
        met = length <= SAME_PLACE * size
        if needs_direction and np.any(met):
            angle = np.degrees(motion.crank_angle[met].flat[0])
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
    """A force and a torque that act on a link or on the ground.

    Parameters
    ----------
    link : int
        Number of the link in the topology; ``GROUND_AFTER_LINKS`` of the ground.
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
        """Moment about the link's start in N m; shape (...)."""
        return cross(motion.arm(self.link, self.x, self.y), self.force) + self.torque

    def power(self, motion: RigidMotion) -> FloatArray:
        """Power on the moving link in W; shape (...)."""
        velocity = motion.velocity(self.link, self.x, self.y)
        turning = self.torque * motion.angular_velocity[..., self.link]
        return np.asarray(np.sum(self.force * velocity, axis=-1) + turning)


def forces_of_loads(
    topology: Topology,
    motion: RigidMotion,
    loads: Sequence[Load],
    time: ArrayLike = 0.0,
    moved: Moved | None = None,
) -> Iterator[ForceOnLink]:
    """Force of each load on its link in each position.

    Parameters
    ----------
    topology : Topology
    motion : RigidMotion
    loads : sequence of Load
    time : array_like, shape (...)
        Of each position in s, for loads over time.
    moved : callable, optional
        See :data:`Moved`.

    Yields
    ------
    ForceOnLink
    """
    for load in loads:
        link, x = topology.index(load.point.link), load.point.x
        values, angle = load.values(motion.crank_angle, time), motion.angle[..., link]
        if moved is not None:
            angle = angle + moved(link, x)[0][..., 2]
        yield ForceOnLink(link, x, load.in_ground_axes(values, angle), values[..., 2])


def applied_forces(
    topology: Topology,
    motion: RigidMotion,
    loads: Sequence[Load],
    springs: Sequence[Spring],
    joint_springs: Sequence[JointSpring],
    angles: FloatArray,
    time: ArrayLike = 0.0,
    moved: Moved | None = None,
) -> Iterator[ForceOnLink]:
    """Forces of loads, of springs on both their ends, and torques of springs in joints.

    Parameters
    ----------
    topology : Topology
    motion : RigidMotion
    loads : sequence of Load
    springs : sequence of Spring
    joint_springs : sequence of JointSpring
        In pins and pivots; forces of radial springs are joint forces and not among these.
    angles : ndarray, shape (..., n_links)
        Of the links in rad, counted on continuously as the linkage turns.
    time : array_like, shape (...)
        Of each position in s, for loads over time.
    moved : callable, optional
        See :data:`Moved`; undisplaced links by default.

    Yields
    ------
    ForceOnLink

    Raises
    ------
    InputError
        Where the ends of a spring meet and its direction is not defined.
    """
    yield from forces_of_loads(topology, motion, loads, time, moved)
    for one in forces_of_springs(topology, motion, springs, joint_springs, angles, moved):
        if one.link != GROUND_AFTER_LINKS:
            yield one


def forces_of_springs(
    topology: Topology,
    motion: RigidMotion,
    springs: Sequence[Spring],
    joint_springs: Sequence[JointSpring],
    angles: FloatArray,
    moved: Moved | None = None,
) -> Iterator[ForceOnLink]:
    """Forces of springs on both their ends, and torques of springs in joints, on the ground too.

    Parameters
    ----------
    topology, motion, springs, joint_springs, angles, moved
        As in :func:`applied_forces`.

    Yields
    ------
    ForceOnLink

    Raises
    ------
    InputError
        Where the ends of a spring meet and its direction is not defined.
    """
    for spring in springs:
        needed = bool(spring.free_length or spring.damping)
        line = SpringLine.of(spring, topology, motion, moved, needs_direction=needed)
        pull = line.tension[..., None] * line.along
        for end, sign in ((spring.first, 1.0), (spring.second, -1.0)):
            link = GROUND_AFTER_LINKS if end.is_ground else topology.index(end.link)
            yield ForceOnLink(link, end.x, sign * pull, 0.0 * line.tension, end.y)
    for own in joint_springs:
        if own.torsional_stiffness or own.torsional_damping:
            gap, rate = joint_gap(topology, motion, own, angles, moved)
            torque = own.torque(gap[..., 2], rate[..., 2])
            for sign, link, x in _sides(topology, own):
                yield ForceOnLink(link, x, np.zeros((*torque.shape, 2)), sign * torque)


def joint_gap(
    topology: Topology,
    motion: RigidMotion,
    spring: JointSpring,
    angles: FloatArray,
    moved: Moved | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Deformation of the springs in a joint: follower's end against leader's, and its rate.

    Parameters
    ----------
    topology : Topology
    motion : RigidMotion
    spring : JointSpring
    angles : ndarray, shape (..., n_links)
        As in :func:`applied_forces`.
    moved : callable, optional
        See :data:`Moved`.

    Returns
    -------
    tuple of ndarray, shape (..., 3)
        Along ground x and y in m, and the angle between the links in rad; and their rates.
    """
    gap, rate = np.zeros((2, *motion.crank_angle.shape, 3))
    gap[..., 2] = topology.joint_angle(spring.joint, angles)
    rate[..., 2] = topology.joint_angle(spring.joint, motion.angular_velocity)
    if moved is not None:
        for sign, link, x in _sides(topology, spring):
            if link != GROUND_AFTER_LINKS:
                displacement, velocity = moved(link, x)
                gap, rate = gap + sign * displacement, rate + sign * velocity
    return gap, rate


def _sides(topology: Topology, spring: JointSpring) -> list[tuple[float, int, float]]:
    """Sign, link and place of the ends at a joint, the follower first."""
    ends = zip((1.0, -1.0), topology.pinned_ends[spring.joint], strict=True)
    ground = (GROUND_AFTER_LINKS, 0.0)
    return [(sign, *(topology.end_place(end) if end else ground)) for sign, end in ends]


def _point_motion(
    topology: Topology, motion: RigidMotion, point: AttachmentPoint, moved: Moved | None
) -> tuple[FloatArray, FloatArray]:
    """Position and velocity of a point in ground axes, each of shape (..., 2)."""
    if point.is_ground:
        place = np.broadcast_to((point.x, point.y), (*motion.crank_angle.shape, 2))
        return place, np.zeros_like(place)
    link = topology.index(point.link)
    place, velocity = motion.position(link, point.x), motion.velocity(link, point.x)
    if moved is None:
        return place, velocity
    displacement, rate = moved(link, point.x)
    return place + displacement[..., :2], velocity + rate[..., :2]
