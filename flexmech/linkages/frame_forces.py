"""Shaking force and shaking moment: what a linkage exerts on its frame."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linkages.applied_forces import Moved, forces_of_springs
from flexmech.linkages.attachments import JointSpring, Spring
from flexmech.linkages.body_motion import GROUND_AFTER_LINKS
from flexmech.linkages.motion import RigidMotion, cross, direction
from flexmech.linkages.topology import Clamp, Topology


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
