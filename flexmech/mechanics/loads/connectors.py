"""Loads on points of links and springs between them: forces, stiffness and damping.

A spring between two points carries ``T = k (L - L0) + c L'`` along the line n between them. When
its ends move by d against each other, in ground axes, its force changes by

    ``[n (k n + c (1 - n n') v / L)' + (T / L) (1 - n n')] d + c n n' d'``

with the velocity v of the ends in the rigid motion. With ``d = D(t) z`` that is stiffness
``D' K D + D' C D'`` (the last with a dot) and damping ``D' C D``. A follower force
rotates with its section by phi: ``F + phi J F``. A joint's torsional spring lies between
the rotations of two links, a radial one between the displacements of their ends.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.choices import Prestress
from flexmech.linkages import (
    AttachmentPoint,
    JointSpring,
    Load,
    RigidMotion,
    continuous_angles,
    turned,
)
from flexmech.linkages.applied_forces import (
    ForceOnLink,
    Moved,
    SpringLine,
    applied_forces,
    forces_of_loads,
    joint_gap,
)
from flexmech.linkages.motion import direction
from flexmech.mechanics.joints.joint_coordinates import DisplacedMotion
from flexmech.mechanics.joints.link_frames import LinkFrames
from flexmech.mechanics.links.link_inertia import inertia_loads
from flexmech.mechanics.links.link_model import LinkModel
from flexmech.mechanics.links.rotation_terms import RotationTerms, SystemMatrices
from flexmech.mechanics.loads.attached_points import AttachedPoint, PointJacobian
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

    def on_link(self, motion: RigidMotion, q: FloatArray) -> FloatArray:
        """Generalized force (B, n_link) on the link where that is displaced by q (B, n_link)."""
        return self.point.force(motion, self.force, self.torque, q, finite=True)

    def rotation_stiffness(self, motion: RigidMotion, q: FloatArray) -> FloatArray:
        """Geometric stiffness in N m/rad of the force on a rigid link at a rotation, (B,)."""
        turned = motion.angle[:, self.point.link] + q[:, 2]
        return np.asarray(self.point.x * np.sum(direction(turned) * self.force, axis=1))


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
        Shape of the matrices, (B, n, n).
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


class Connectors:
    """Loads and springs of a mechanism on its links.

    Parameters
    ----------
    mechanism : Mechanism
    links : sequence of LinkModel
        In the topology's order, unreduced.
    """

    def __init__(self, mechanism: Mechanism, links: Sequence[LinkModel]) -> None:
        self._mechanism = mechanism
        self.links = links
        self._topology = mechanism.linkage.topology
        self._points: dict[tuple[int, float], AttachedPoint] = {}
        self.joint_springs = mechanism.joint_springs
        self.loads: tuple[Load, ...] = tuple(x for x in mechanism.loads if x.over != "time")

    @property
    def any(self) -> bool:
        """Whether there is a load or a spring."""
        return acts_at_rest(self._mechanism)

    @property
    def restrains_shaft(self) -> bool:
        """Whether springs restrain the rotation of a free shaft."""
        springs = any(spring.stiffness for spring in self._mechanism.springs)
        return springs or any(s.torsional_stiffness for s in self.joint_springs)

    @property
    def depend_on_displacement(self) -> bool:
        """Whether forces depend on the displacements of the links."""
        return bool(self.follow or self._mechanism.springs or self.joint_springs)

    @property
    def follow(self) -> bool:
        """Whether there are follower forces."""
        return any(load.axes == "link" for load in self.loads)

    @property
    def circulates(self) -> bool:
        """Whether there are circulatory forces: follower forces, or dampers of springs."""
        return self.follow or any(spring.damping for spring in self._mechanism.springs)

    @property
    def is_conservative(self) -> bool:
        """Whether the forces have a potential at each crank angle."""
        joints = self.joint_springs
        return not (self.circulates or any(s.torsional_damping or s.radial_damping for s in joints))

    def forces(
        self,
        motion: RigidMotion,
        displacement: Sequence[FloatArray] | None = None,
        time: FloatArray | None = None,
    ) -> list[FloatArray]:
        """Generalized forces on the links in their frames.

        Parameters
        ----------
        motion, displacement, time
            As of :meth:`point_forces`.

        Returns
        -------
        list of ndarray, shape (B, n_link)
        """
        total = [np.zeros((len(motion.crank_angle), link.size)) for link in self.links]
        for push in self.point_forces(motion, displacement, time):
            link = push.point.link
            q = None if displacement is None else displacement[link]
            total[link] += push.point.force(motion, push.force, push.torque, q)
        return total

    def with_inertia(
        self,
        links: Sequence[LinkModel],
        motion: RigidMotion,
        displacement: Sequence[FloatArray] | None = None,
    ) -> list[FloatArray]:
        """Inertia forces of the rigid motion and weight, and :meth:`forces` besides.

        Parameters
        ----------
        links : sequence of LinkModel
            With the coordinates of these links; their inertia may be without that of a free shaft.
        motion, displacement
            As of :meth:`forces`.

        Returns
        -------
        list of ndarray, shape (B, n_link)
        """
        inertia = inertia_loads(links, motion, self._mechanism.gravity)
        if not self.any:
            return inertia
        acting = self.forces(motion, displacement)
        return [load + force for load, force in zip(inertia, acting, strict=True)]

    def virial(
        self, motion: RigidMotion, displacement: Sequence[FloatArray] | None = None
    ) -> FloatArray:
        """Virial of the forces on rigid links about the links' starts.

        As :meth:`forces`, in N m by link (B, n_links); zero of flexible ones. See
        :class:`flexmech.mechanics.links.body_forces.DeadMoments`.
        """
        total = np.zeros(motion.angle.shape)
        for push in self.point_forces(motion, displacement):
            if (point := push.point).rigid:
                q = None if displacement is None else displacement[point.link]
                total[:, point.link] += point.virial(motion, push.force, push.torque, q)
        return total

    def added(
        self,
        frames: LinkFrames,
        motion: RigidMotion,
        matrices: SystemMatrices,
        terms: RotationTerms,
        prestress: Prestress,
        displacement: Sequence[FloatArray] | None = None,
        time: FloatArray | None = None,
    ) -> SystemMatrices:
        """Matrices of the linkage with those of the connectors added.

        Parameters
        ----------
        frames : LinkFrames
        motion : RigidMotion
        matrices : SystemMatrices
            Matrices of the links.
        terms : RotationTerms
        prestress, displacement, time
            As of :meth:`matrices`.

        Returns
        -------
        SystemMatrices
        """
        if not (self.any or self._acting(time)):
            return matrices
        connected = self.matrices(frames, motion, prestress, displacement, time)
        stiffness = matrices.stiffness + connected.stiffness
        if terms.coriolis:
            stiffness = stiffness + connected.rate_stiffness
        return SystemMatrices(matrices.mass, matrices.damping + connected.damping, stiffness)

    def matrices(
        self,
        frames: LinkFrames,
        motion: RigidMotion,
        prestress: Prestress,
        displacement: Sequence[FloatArray] | None = None,
        time: FloatArray | None = None,
    ) -> ConnectedMatrices:
        """Stiffness and damping of the connectors.

        Parameters
        ----------
        frames : LinkFrames
            Frames of these links, reduced or not.
        motion : RigidMotion
            Batch of shape (B,); its rigid links may be displaced.
        prestress : {"none", "axial", "equilibrium"}
            ``none`` leaves out the geometric stiffness by forces in connectors.
        displacement : sequence of ndarray, shape (B, n_link), optional
            Displacement of the unreduced links in the state about which to linearize.
        time : ndarray, shape (B,), optional
            In s; loads over time are left out without it.

        Returns
        -------
        ConnectedMatrices
            In the coordinates of ``frames``.
        """
        drawn = motion.undisplaced if isinstance(motion, DisplacedMotion) else motion
        tangents = self.tangents(drawn, displacement, time, stressed=prestress != "none")
        of_frames = Connectors(self._mechanism, frames.links)

        def jacobian(point: AttachedPoint) -> PointJacobian:
            place = of_frames.at(point.link, point.x)
            return PointJacobian.of(place, frames, motion)

        shape = (len(motion.crank_angle), frames.size, frames.size)
        return connected_matrices(tangents, jacobian, shape, is_conservative=self.is_conservative)

    def point_forces(
        self,
        motion: RigidMotion,
        displacement: Sequence[FloatArray] | None = None,
        time: FloatArray | None = None,
        rate: Sequence[FloatArray] | None = None,
        *,
        turn: FloatArray | None = None,
    ) -> list[PointForce]:
        """Forces on points of the links, one by one, but those in joints.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        displacement : sequence of ndarray, shape (B, n_link), optional
            Displacement of the links; they are straight where it is left out.
        time : ndarray, shape (B,), optional
            In s; loads over time are left out without it.
        rate : sequence of ndarray, shape (B, n_link), optional
            Time derivative of the displacement, which dampers resist; zero where it is left out.
        turn : ndarray, shape (B,), optional
            By which a frame on springs and the axes of ``motion`` have rotated, in rad: against
            them dead loads rotate back, and follower forces do not.

        Returns
        -------
        list of PointForce
            First those of loads, then those of springs.
        """
        pushes = [
            PointForce(self.at(push.link, float(push.x)), push.force, push.torque)
            for push in self.applied(motion, displacement, time, rate)
        ]
        if turn is not None:
            for number, load in enumerate(self._acting(time)):
                if load.axes == "ground":
                    push = pushes[number]
                    pushes[number] = replace(push, force=turned(push.force, -turn))
        return pushes

    def radial_forces(
        self,
        motion: RigidMotion,
        displacement: Sequence[FloatArray],
        rate: Sequence[FloatArray] | None = None,
    ) -> list[PointForce]:
        """Forces of radial springs in joints on the ends there, which are joint forces.

        Parameters
        ----------
        motion, displacement, rate
            As of :meth:`point_forces`.

        Returns
        -------
        list of PointForce
        """
        forces, moved = [], self.moved(motion, displacement, rate)
        for joint in self.joint_springs:
            if joint.radial_stiffness is None:
                continue
            gap, opening = joint_gap(self._topology, motion, joint, motion.angle, moved)
            force = joint.radial_stiffness * gap[:, :2] + joint.radial_damping * opening[:, :2]
            for point, sign in zip(self.joint_points(joint), (-1.0, 1.0), strict=True):
                if point is not None:
                    forces.append(PointForce(point, sign * force, np.zeros(len(force))))
        return forces

    def applied(
        self,
        motion: RigidMotion,
        displacement: Sequence[FloatArray] | None = None,
        time: FloatArray | None = None,
        rate: Sequence[FloatArray] | None = None,
    ) -> Iterator[ForceOnLink]:
        """Forces on links, one by one, by the number of the link.

        Parameters
        ----------
        motion, displacement, time, rate
            As of :meth:`point_forces`.
        """
        mechanism, joints = self._mechanism, self.joint_springs
        return applied_forces(
            self._topology,
            motion,
            self._acting(time),
            mechanism.springs,
            joints,
            continuous_angles(mechanism.linkage, motion) if joints else motion.angle,
            0.0 if time is None else time,
            None if displacement is None else self.moved(motion, displacement, rate),
        )

    def moved(
        self,
        motion: RigidMotion,
        displacement: Sequence[FloatArray],
        rate: Sequence[FloatArray] | None = None,
        *,
        finite: bool = True,
    ) -> Moved:
        """Displacements of points of links and their rates, in ground axes with the rotation.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        displacement, rate : sequence of ndarray, shape (B, n_link)
            Of the links; points are at rest in the ground axes without a rate.
        finite : bool
            Whether rigid links turn by finite angles.
        """

        def moved(link: int, x: float) -> tuple[FloatArray, FloatArray]:
            point, q = self.at(link, x), displacement[link]
            place = point.displacement(motion, q, finite=finite)
            if rate is None:
                return place, np.zeros_like(place)
            return place, point.displacement_rate(motion, q, rate[link], finite=finite)

        return moved

    def tangents(
        self,
        motion: RigidMotion,
        displacement: Sequence[FloatArray] | None = None,
        time: FloatArray | None = None,
        *,
        stressed: bool = True,
    ) -> list[ConnectorTangent]:
        """Tangent stiffness and damping of each connector.

        Parameters
        ----------
        motion, displacement, time
            As of :meth:`matrices`.
        stressed : bool
            Whether the geometric stiffness by forces in connectors is included.

        Returns
        -------
        list of ConnectorTangent
            Empty where loads in ground axes alone act.
        """
        topology, batch = self._topology, len(motion.crank_angle)
        moved = None if displacement is None else self.moved(motion, displacement)
        following = [load for load in self._acting(time) if stressed and load.axes == "link"]
        instant, tangents = 0.0 if time is None else time, []
        for push in forces_of_loads(topology, motion, following, instant, moved):
            turned, point = np.zeros((batch, 3, 3)), self.at(push.link, float(push.x))
            turned[:, 0, 2], turned[:, 1, 2] = push.force[:, 1], -push.force[:, 0]
            tangents.append(ConnectorTangent(None, point, turned, np.zeros_like(turned)))
        for spring in self._mechanism.springs:
            line = SpringLine.of(spring, topology, motion, moved)
            stiffness, damping = np.zeros((2, batch, 3, 3))
            lengthwise = line.along[:, :, None] * line.along[:, None]
            stiffness[:, :2, :2] = spring.stiffness * lengthwise
            damping[:, :2, :2] = spring.damping * lengthwise
            if stressed:  # by its tension, and as the rigid motion turns its damper
                across = np.eye(2) - lengthwise
                stiffness[:, :2, :2] += (line.tension / line.length)[:, None, None] * across
                swing = (across @ line.relative_velocity[..., None])[..., 0] / line.length[:, None]
                stiffness[:, :2, :2] += spring.damping * line.along[:, :, None] * swing[:, None]
            ends = self.point(spring.first), self.point(spring.second)
            tangents.append(ConnectorTangent(*ends, stiffness, damping))
        for joint in self.joint_springs:
            second, first = self.joint_points(joint)
            stiffness, damping = np.zeros((2, batch, 3, 3))
            stiffness[:] = np.diag(
                [joint.radial_stiffness or 0.0] * 2 + [joint.torsional_stiffness]
            )
            damping[:] = np.diag([joint.radial_damping] * 2 + [joint.torsional_damping])
            tangents.append(ConnectorTangent(first, second, stiffness, damping, in_joint=True))
        return tangents

    def _acting(self, time: FloatArray | None) -> tuple[Load, ...]:
        return self.loads if time is None else self._mechanism.loads

    def joint_points(self, spring: JointSpring) -> tuple[AttachedPoint, AttachedPoint | None]:
        """Ends of the following and the leading link of a joint; None on the ground."""
        follower, leader = self._topology.pinned_ends[spring.joint]
        first = None if leader is None else self.at(*self._topology.end_place(leader))
        return self.at(*self._topology.end_place(follower)), first

    def at(self, link: int, x: float) -> AttachedPoint:
        """Point of a link, by its number, at a distance from its start in m."""
        if (link, x) not in self._points:
            length = self._topology.links[link].length
            self._points[link, x] = AttachedPoint.of(self.links, link, x / length, length)
        return self._points[link, x]

    def point(self, point: AttachmentPoint) -> AttachedPoint | None:
        """Attachment point of a load or spring on its link; None on the ground."""
        return None if point.is_ground else self.at(self._topology.index(point.link), point.x)

    def end_forces(self) -> list[FloatArray]:
        """Unit couples and forces of springs and dampers on elastic links, for component modes.

        On every link k in its coordinates, (n_link, k): of springs and dampers in joints a couple,
        of others a force along and one across.
        """
        forces: list[list[FloatArray]] = [[] for _ in self.links]
        for joint in self.joint_springs:
            if joint.torsional_stiffness or joint.torsional_damping:
                for point in self.joint_points(joint):
                    if point is not None and not point.rigid:
                        forces[point.link].append(point.rows[2])
        for spring in self._mechanism.springs:
            for point in (self.point(spring.first), self.point(spring.second)):
                if point is not None and not point.rigid:
                    forces[point.link] += [*point.rows[:2]]
        return [
            np.stack(rows, axis=1) if rows else np.zeros((link.size, 0))
            for link, rows in zip(self.links, forces, strict=True)
        ]
