"""Shaking force and shaking moment: what a linkage exerts on its frame."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linkages.applied_forces import Moved, SpringLine, joint_gap
from flexmech.linkages.attachments import JointSpring, Spring
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
        Of the drive on shaft and crank about the shaft's axis, N m.
    point : tuple of float, optional
        About which the moment is taken, ground axes, m; the shaft's axis if left out.
    springs : sequence of Spring
    joint_springs : sequence of JointSpring
    angles : ndarray, shape (..., n_links), optional
        Of the links in rad, counted on continuously as the linkage turns, for springs in joints;
        those of ``motion`` if left out.
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
    about = shaft_axis(topology, motion) if point is None else point
    batch = motion.crank_angle.shape
    force, moment = np.zeros((*batch, 2)), -np.broadcast_to(drive_torque, batch)
    turned = motion.angle if angles is None else angles
    for place, one, couple in (
        *_of_joints(topology, motion, joint_force, moved),
        *_of_springs(topology, motion, springs, moved),
        *_of_joint_springs(topology, motion, joint_springs, turned, moved),
    ):
        force = force + one
        moment = moment + cross(place - np.asarray(about), one) + couple
    return ShakingForce(force, moment, about)


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


_OnFrame = tuple[FloatArray, FloatArray, FloatArray]
"""Place (..., 2), force (..., 2) on the frame there, and couple (...)."""


def _axis(topology: Topology, motion: RigidMotion, clamp: Clamp) -> FloatArray:
    """Axis of a clamp's shaft, from which its end is a hub away; shape (..., 2)."""
    link, x = topology.end_place(clamp.link_end)
    return motion.position(link, x) - clamp.hub * direction(motion.angle[..., link])


def _of_joints(
    topology: Topology, motion: RigidMotion, joint_force: FloatArray, moved: Moved | None
) -> Iterator[_OnFrame]:
    """Reactions of clamps, whose couple is that of the drive, of pivots, and of sliders."""
    nothing = np.zeros(motion.crank_angle.shape)

    def reaction(joint: str) -> FloatArray:
        return np.asarray(-joint_force[..., topology.joint_names.index(joint), :])

    for clamp in topology.clamps:
        yield _axis(topology, motion, clamp), reaction(clamp.joint), nothing
    for pivot in topology.pivots:
        # Where its bearing is: a link's end on springs moves against that.
        place = motion.position(*topology.end_place(pivot.link_end))
        yield place, reaction(pivot.joint), nothing
    for slider in topology.sliders:
        if not slider.guide:
            yield (
                _sliding(topology, motion, slider.link_end, moved),
                reaction(slider.joint),
                nothing,
            )


def _sliding(
    topology: Topology, motion: RigidMotion, end: LinkEnd, moved: Moved | None
) -> FloatArray:
    """Place of a sliding end, (..., 2)."""
    link, x = topology.end_place(end)
    place = motion.position(link, x)
    return place if moved is None else place + moved(link, x)[0][..., :2]


def _of_springs(
    topology: Topology, motion: RigidMotion, springs: Sequence[Spring], moved: Moved | None
) -> Iterator[_OnFrame]:
    """Springs with an end on the ground."""
    for spring in springs:
        for end, sign in ((spring.first, 1.0), (spring.second, -1.0)):
            if end.is_ground:
                needed = bool(spring.free_length or spring.damping)
                line = SpringLine.of(spring, topology, motion, moved, needs_direction=needed)
                place = np.array([end.x, end.y])
                yield place, sign * line.tension[..., None] * line.along, 0.0 * line.tension


def _of_joint_springs(
    topology: Topology,
    motion: RigidMotion,
    springs: Sequence[JointSpring],
    angles: FloatArray,
    moved: Moved | None,
) -> Iterator[_OnFrame]:
    """Torsional springs in pivots."""
    pivots = {pivot.joint for pivot in topology.pivots}
    for own in springs:
        if own.joint in pivots and (own.torsional_stiffness or own.torsional_damping):
            gap, rate = joint_gap(topology, motion, own, angles, moved)
            couple = -own.torque(gap[..., 2], rate[..., 2])
            yield np.zeros(2), np.zeros((*couple.shape, 2)), couple
