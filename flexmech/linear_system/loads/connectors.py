"""Loads on points of links and springs between them: forces, stiffness and damping.

A spring between two points carries ``T = k (L - L0) + c L'`` along the line n between them. When
its ends move by d against each other, in ground axes, its force changes by

    ``[n (k n + c (1 - n n') v / L)' + (T / L) (1 - n n')] d + c n n' d'``

with the velocity v of the ends in the rigid motion. With ``d = D(t) z`` that is stiffness
``D' K D + D' C D'`` (the last with a dot) and damping ``D' C D``. A force that turns with its link
follows the rotation phi of the section: ``F + phi J F``. A joint's torsional spring lies between
the rotations of two links, a radial one between the displacements of their ends.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.choices import Prestress
from flexmech.linear_system.joints.displaced_motion import DisplacedMotion
from flexmech.linear_system.joints.link_frames import LinkFrames
from flexmech.linear_system.links.link_model import LinkModel
from flexmech.linear_system.links.rotation_terms import RotationTerms, SystemMatrices
from flexmech.linear_system.loads.attached_points import AttachedPoint
from flexmech.linear_system.loads.connector_forces import (
    Answer,
    ConnectedMatrices,
    PointForce,
    SpringEnd,
    SpringState,
    acts_still,
    connected_matrices,
)
from flexmech.linkages import (
    GROUND,
    AttachmentPoint,
    JointSpring,
    LinkEnd,
    Load,
    RigidMotion,
    Spring,
    continuous_angles,
)
from flexmech.linkages.applied_forces import ForceOnLink, SpringLine
from flexmech.mechanism import Mechanism


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
        self.loads: tuple[Load, ...] = tuple(x for x in mechanism.loads if x.over != "time")

    @property
    def any(self) -> bool:
        """Whether there is one."""
        return acts_still(self._mechanism)

    @property
    def holds_shaft(self) -> bool:
        """Whether springs answer a turn of a free shaft."""
        springs = any(spring.stiffness for spring in self._mechanism.springs)
        return springs or any(own.torsional_stiffness for own in self._mechanism.joint_springs)

    @property
    def depend_on_displacement(self) -> bool:
        """Whether forces change as the links move."""
        turning = any(load.axes == "link" for load in self.loads)
        return bool(turning or self._mechanism.springs or self._mechanism.joint_springs)

    @property
    def follows(self) -> bool:
        """Whether forces depend on displacements as those of no potential do."""
        turning = any(load.axes == "link" for load in self.loads)
        return turning or any(spring.damping for spring in self._mechanism.springs)

    @property
    def is_conservative(self) -> bool:
        """Whether the forces have a potential at each crank angle: nothing damps or follows."""
        joints = self._mechanism.joint_springs
        damped = any(own.torsional_damping or own.radial_damping for own in joints)
        return not (damped or self.follows)

    def forces(
        self,
        motion: RigidMotion,
        displacement: Sequence[FloatArray] | None = None,
        time: FloatArray | None = None,
    ) -> list[FloatArray]:
        """Forces on the links in their frames.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        displacement : sequence of ndarray, shape (B, n_link), optional
            Of the links; they are straight where it is left out.
        time : ndarray, shape (B,), optional
            In s; loads over time are left out without it.

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

    def applied(self, motion: RigidMotion) -> tuple[ForceOnLink, ...]:
        """The same forces on straight links, each by itself, for a batch of shape (B,)."""
        return tuple(
            ForceOnLink(push.point.link, push.point.x, push.force, push.torque)
            for push in self.point_forces(motion)
        )

    def virial(
        self, motion: RigidMotion, displacement: Sequence[FloatArray] | None = None
    ) -> FloatArray:
        """Products of forces on rigid links with their places from the links' starts.

        As :meth:`forces`, in N m by link (B, n_links); zero of flexible ones. See
        :class:`flexmech.linear_system.links.dead_moments.DeadMoments`.
        """
        total = np.zeros(motion.angle.shape)
        rigid = any(link.rigid for link in self.links)
        for push in self.point_forces(motion, displacement) if rigid else ():
            point = push.point
            if point.rigid:
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
        """Matrices of the linkage with those of the connectors.

        Parameters
        ----------
        frames : LinkFrames
            Of these links, reduced or not.
        motion : RigidMotion
            Batch of shape (B,); its rigid links may be displaced.
        matrices : SystemMatrices
            Of the links.
        terms : RotationTerms
        prestress : {"none", "axial", "equilibrium"}
            ``none`` leaves out what comes from forces that connectors carry.
        displacement : sequence of ndarray, shape (B, n_link), optional
            Of the state that the system is about.
        time : ndarray, shape (B,), optional
            In s; loads over time are left out without it.

        Returns
        -------
        SystemMatrices
        """
        if not (self.any or self._acting(time)):
            return matrices
        own = self.matrices(frames, motion, prestress, displacement, time)
        stiffness = matrices.stiffness + own.stiffness
        if terms.coriolis:
            stiffness = stiffness + own.turning
        return SystemMatrices(matrices.mass, matrices.damping + own.damping, stiffness)

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
            Of these links, reduced or not.
        motion : RigidMotion
            Batch of shape (B,); its rigid links may be displaced.
        prestress : {"none", "axial", "equilibrium"}
            ``none`` leaves out what comes from forces that connectors carry.
        displacement : sequence of ndarray, shape (B, n_link), optional
            Of the unreduced links in the state that the matrices are about.
        time : ndarray, shape (B,), optional
            In s; loads over time are left out without it.

        Returns
        -------
        ConnectedMatrices
            In the coordinates of ``frames``.
        """
        drawn = motion.undisplaced if isinstance(motion, DisplacedMotion) else motion
        answers = self.answers(drawn, displacement, time, stressed=prestress != "none")
        return connected_matrices(frames, motion, answers, is_conservative=self.is_conservative)

    def point_forces(
        self,
        motion: RigidMotion,
        displacement: Sequence[FloatArray] | None = None,
        time: FloatArray | None = None,
    ) -> list[PointForce]:
        """Forces on points of the links, one by one.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        displacement : sequence of ndarray, shape (B, n_link), optional
            Of the links; they are straight where it is left out.
        time : ndarray, shape (B,), optional
            In s; loads over time are left out without it.

        Returns
        -------
        list of PointForce
            First those of loads, then those of springs.
        """
        point_forces = []
        for load in self._acting(time):
            at, values = self.point_of(load), self._values(load, motion, time)
            force = at.load_force(load, values, motion, displacement)
            point_forces.append(PointForce(at, force, values[:, 2]))
        for spring in self._mechanism.springs:
            state = self._spring_state(spring, motion, displacement)
            force = state.line.tension[:, None] * state.line.along
            for point, sign in ((state.first, 1.0), (state.second, -1.0)):
                if point is not None:
                    point_forces.append(PointForce(point, sign * force, np.zeros(len(force))))
        own_springs = self._mechanism.joint_springs
        angles = continuous_angles(self._mechanism.linkage, motion) if own_springs else motion.angle
        for own in own_springs:
            point_forces += self._joint_point_forces(own, motion, angles, displacement)
        return point_forces

    def answers(
        self,
        motion: RigidMotion,
        displacement: Sequence[FloatArray] | None = None,
        time: FloatArray | None = None,
        *,
        stressed: bool = True,
    ) -> list[Answer]:
        """How the forces change with displacements of their points.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (B,).
        displacement : sequence of ndarray, shape (B, n_link), optional
            Of the links in the state that this is about.
        time : ndarray, shape (B,), optional
            In s; loads over time are left out without it.
        stressed : bool
            Whether what comes from forces that connectors carry counts.

        Returns
        -------
        list of Answer
            Empty where loads in ground axes alone act.
        """
        answers = []
        for load in self._acting(time) if stressed else ():
            if load.axes == "link":
                point = self.point_of(load)
                values = self._values(load, motion, time)
                force = point.load_force(load, values, motion, displacement)
                answers.append(Answer.of_turning_force(point, force))
        for spring in self._mechanism.springs:
            state = self._spring_state(spring, motion, displacement)
            answers.append(state.answer(spring, stressed=stressed))
        for own in self._mechanism.joint_springs:
            second, first = self.joint_points(own)
            answers.append(Answer.of_joint(first, second, own, len(motion.crank_angle)))
        return answers

    def _acting(self, time: FloatArray | None) -> tuple[Load, ...]:
        return self.loads if time is None else self._mechanism.loads

    @staticmethod
    def _values(load: Load, motion: RigidMotion, time: FloatArray | None) -> FloatArray:
        """Force and torque of a load in its axes, (B, 3)."""
        return load.values(motion.crank_angle, 0.0 if time is None else time)

    def point_of(self, load: Load) -> AttachedPoint:
        """Where a load acts."""
        point = self.point(load.point)
        assert point is not None
        return point

    def _joint_point_forces(
        self,
        own: JointSpring,
        motion: RigidMotion,
        angles: FloatArray,
        displacement: Sequence[FloatArray] | None,
    ) -> list[PointForce]:
        """Torques of a joint's torsional spring; a radial one carries what the joint carries."""
        second, first = self.joint_points(own)
        sides = [(point, sign) for point, sign in ((second, 1.0), (first, -1.0)) if point]
        opening = self._topology.opening(own.joint, angles)
        rate = self._topology.opening(own.joint, motion.angular_velocity)
        if displacement is not None:
            opening = opening + sum(
                sign * (displacement[point.link] @ point.rows[2]) for point, sign in sides
            )
        torque = own.torque(np.asarray(opening), rate)
        nothing = np.zeros((len(torque), 2))
        return [PointForce(point, nothing, sign * torque) for point, sign in sides]

    def joint_points(self, own: JointSpring) -> tuple[AttachedPoint, AttachedPoint | None]:
        """Ends of the following and the leading link of a joint; None on the ground."""
        follower, leader = self._topology.pinned_ends[own.joint]
        first = None if leader is None else self._end(leader)
        return self._end(follower), first

    def _end(self, end: LinkEnd) -> AttachedPoint:
        number = self._topology.index(end.link)
        x = 0.0 if end.end == "start" else self._topology.links[number].length
        return self._at(number, x)

    def _at(self, number: int, x: float) -> AttachedPoint:
        length = self._topology.links[number].length
        return AttachedPoint.of(self.links, number, x / length, length)

    def point(self, point: AttachmentPoint) -> AttachedPoint | None:
        """Where a point of a link is attached; None on the ground."""
        if point.link == GROUND:
            return None
        return self._at(self._topology.index(point.link), point.x)

    def _spring_state(
        self, spring: Spring, motion: RigidMotion, displacement: Sequence[FloatArray] | None
    ) -> SpringState:
        size = max(link.length for link in self._topology.links)
        first, second = self.spring_ends(spring, motion, displacement)
        places, velocities = (first.place, second.place), (first.velocity, second.velocity)
        line = SpringLine.of(spring, motion.crank_angle, places, velocities, size)
        return SpringState(first.point, second.point, line)

    def spring_ends(
        self,
        spring: Spring,
        motion: RigidMotion,
        displacement: Sequence[FloatArray] | None = None,
    ) -> tuple[SpringEnd, SpringEnd]:
        """First and second end of a spring.

        Parameters
        ----------
        spring : Spring
        motion : RigidMotion
            Batch of shape (B,).
        displacement : sequence of ndarray, shape (B, n_link), optional
            Of the links; they are straight where it is left out.

        Returns
        -------
        tuple of SpringEnd
        """
        return (
            self._spring_end(spring.first, motion, displacement),
            self._spring_end(spring.second, motion, displacement),
        )

    def _spring_end(
        self, point: AttachmentPoint, motion: RigidMotion, displacement: Sequence[FloatArray] | None
    ) -> SpringEnd:
        found = self.point(point)
        if found is None:
            still = np.broadcast_to((point.x, point.y), (len(motion.crank_angle), 2))
            return SpringEnd(None, still, np.zeros_like(still))
        place = found.place(motion, None if displacement is None else displacement[found.link])
        return SpringEnd(found, place, motion.velocity(found.link, point.x))
