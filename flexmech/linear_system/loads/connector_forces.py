"""Forces of connectors on points of links, with their stiffness and damping."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linear_system.loads.attached_points import AttachedPoint, PointJacobian
from flexmech.linkages import JointSpring, RigidMotion, Spring, continuous_angles
from flexmech.linkages.applied_forces import Moved, SpringLine, joint_gap
from flexmech.mechanism import Mechanism


def acts_at_rest(mechanism: Mechanism) -> bool:
    """Whether loads or springs act on the linkage at rest."""
    loads = any(load.over != "time" for load in mechanism.loads)
    return bool(loads or mechanism.springs or mechanism.joint_springs)


def has_dampers(mechanism: Mechanism) -> bool:
    """Whether a spring, one in a joint or one of the frame has a damper."""
    joints = any(s.torsional_damping or s.radial_damping for s in mechanism.joint_springs)
    framed = mechanism.frame is not None and mechanism.frame.damping.any()
    return bool(joints or framed or any(spring.damping for spring in mechanism.springs))


def kinks_of(mechanism: Mechanism, link: str) -> list[float]:
    """Where masses, bodies, loads and springs act on a link, m from its start."""
    mass = mechanism.link_mass(link)
    bodies = (body.position for body in mass.bodies)
    return [*mass.point_positions, *bodies, *mechanism.acting_at(link)]


@dataclass(frozen=True)
class PointForce:
    """Force of a connector on a point in ground axes, (B, 2), and torque (B,)."""

    point: AttachedPoint
    force: FloatArray
    torque: FloatArray


@dataclass(frozen=True)
class ConnectorTangent:
    """Tangent stiffness and damping of a connector between two points or a point and the ground.

    Parameters
    ----------
    first, second : AttachedPoint or None
    stiffness, damping : ndarray, shape (B, 3, 3)
        By the displacement (ground axes) and rotation of the second against the first.
    in_joint : bool
        Whether it belongs to springs in a joint, whose radial force is the joint force.
    """

    first: AttachedPoint | None
    second: AttachedPoint | None
    stiffness: FloatArray
    damping: FloatArray
    in_joint: bool = False


def follower_tangent(point: AttachedPoint, force: FloatArray) -> ConnectorTangent:
    """Stiffness of a follower force (B, 2) in ground axes, which rotates with its section."""
    turned = np.zeros((len(force), 3, 3))
    turned[:, 0, 2], turned[:, 1, 2] = force[:, 1], -force[:, 0]
    return ConnectorTangent(None, point, turned, np.zeros_like(turned))


def spring_tangent(
    first: AttachedPoint | None,
    second: AttachedPoint | None,
    spring: Spring,
    line: SpringLine,
    *,
    stressed: bool,
) -> ConnectorTangent:
    """Stiffness and damping of a spring at its length.

    Parameters
    ----------
    first, second : AttachedPoint or None
        Its ends; None on the ground.
    spring : Spring
    line : SpringLine
        Of shape (B,); its relative velocity is that of the rigid motion.
    stressed : bool
        Whether the parts by its tension and by the rigid motion are included.

    Returns
    -------
    ConnectorTangent
    """
    along = line.along
    stiffness, damping = np.zeros((2, len(along), 3, 3))
    lengthwise = along[:, :, None] * along[:, None]
    across = np.eye(2) - lengthwise
    stiffness[:, :2, :2] = spring.stiffness * lengthwise
    damping[:, :2, :2] = spring.damping * lengthwise
    if stressed:
        stiffness[:, :2, :2] += (line.tension / line.length)[:, None, None] * across
        swing = (across @ line.relative_velocity[..., None])[..., 0] / line.length[:, None]
        stiffness[:, :2, :2] += spring.damping * along[:, :, None] * swing[:, None]
    return ConnectorTangent(first, second, stiffness, damping)


def joint_tangent(
    first: AttachedPoint | None, second: AttachedPoint, spring: JointSpring, batch: int
) -> ConnectorTangent:
    """Stiffness and damping of the springs and dampers in a joint.

    Parameters
    ----------
    first, second : AttachedPoint or None
        Ends of the leading and the following link.
    spring : JointSpring
    batch : int
        Number of positions.

    Returns
    -------
    ConnectorTangent
    """
    stiffness, damping = np.zeros((2, batch, 3, 3))
    stiffness[:] = np.diag([spring.radial_stiffness or 0.0] * 2 + [spring.torsional_stiffness])
    damping[:] = np.diag([spring.radial_damping] * 2 + [spring.torsional_damping])
    return ConnectorTangent(first, second, stiffness, damping, in_joint=True)


@dataclass(frozen=True)
class ConnectedMatrices:
    """Stiffness and damping of connectors on points displaced by ``D(t) z``.

    Parameters
    ----------
    stiffness : ndarray, shape (B, n, n)
        ``D' K D``; not symmetric with follower forces.
    damping : ndarray, shape (B, n, n)
        ``D' C D``.
    rate_stiffness : ndarray, shape (B, n, n)
        ``D' C D'`` with the rate of D: stiffness by dampers, since the frames rotate. It is added
        to the stiffness.
    is_conservative : bool
        Whether there is a potential: no dampers and no follower forces.
    """

    stiffness: FloatArray
    damping: FloatArray
    rate_stiffness: FloatArray
    is_conservative: bool

    @property
    def potential(self) -> FloatArray:
        """Symmetric part of the stiffness, which has a potential, (B, n, n)."""
        return (self.stiffness + np.swapaxes(self.stiffness, 1, 2)) / 2

    @property
    def circulatory(self) -> FloatArray:
        """Skew part of the stiffness, (B, n, n): circulatory forces, without a potential."""
        return (self.stiffness - np.swapaxes(self.stiffness, 1, 2)) / 2


def connected_matrices(
    tangents: Sequence[ConnectorTangent],
    jacobian: Callable[[AttachedPoint], PointJacobian],
    shape: tuple[int, ...],
    *,
    is_conservative: bool,
) -> ConnectedMatrices:
    """Assemble stiffness and damping of connectors.

    Parameters
    ----------
    tangents : sequence of ConnectorTangent
    jacobian : callable
        Derivative of the displacement of a point by the coordinates, with its rate.
    shape : tuple of int
        Of the matrices, (B, n, n).
    is_conservative : bool

    Returns
    -------
    ConnectedMatrices
    """
    known: dict[tuple[int, float], PointJacobian] = {}
    stiffness, damping, rate_stiffness = np.zeros((3, *shape))
    for tangent in tangents:
        value, rate = np.zeros((2, shape[0], 3, shape[2]))
        for point, sign in ((tangent.second, 1.0), (tangent.first, -1.0)):
            if point is not None:
                key = (point.link, point.x)
                moved = known[key] = known[key] if key in known else jacobian(point)
                value += sign * moved.value
                rate += sign * moved.rate
        across = np.swapaxes(value, 1, 2)
        stiffness += across @ (tangent.stiffness @ value)
        if tangent.damping.any():
            damping += across @ (tangent.damping @ value)
            rate_stiffness += across @ (tangent.damping @ rate)
    return ConnectedMatrices(stiffness, damping, rate_stiffness, is_conservative)


def deformations(
    mechanism: Mechanism, motion: RigidMotion, moved: Moved
) -> Iterator[tuple[float, FloatArray, float, FloatArray]]:
    """Deformations of springs and of dampers beside them, each with the constants of both.

    Parameters
    ----------
    mechanism : Mechanism
    motion : RigidMotion
        Batch of shape (B,).
    moved : callable
        See :data:`flexmech.linkages.applied_forces.Moved`.

    Yields
    ------
    tuple of float, ndarray, float, ndarray
        Stiffness, deformation (B,), damping and rate of the deformation (B,).
    """
    topology = mechanism.linkage.topology
    for spring in mechanism.springs:
        line = SpringLine.of(spring, topology, motion, moved, needs_direction=False)
        yield spring.stiffness, line.length - spring.free_length, spring.damping, line.rate
    if not mechanism.joint_springs:
        return
    angles = continuous_angles(mechanism.linkage, motion)
    for joint in mechanism.joint_springs:
        gap, rate = joint_gap(topology, motion, joint, angles, moved)
        turned = gap[:, 2] - joint.free_angle
        yield joint.torsional_stiffness, turned, joint.torsional_damping, rate[:, 2]
        if joint.radial_stiffness is not None:
            for way in range(2):
                yield joint.radial_stiffness, gap[:, way], joint.radial_damping, rate[:, way]
