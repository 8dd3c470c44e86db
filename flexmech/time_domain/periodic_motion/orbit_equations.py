"""Equations of the periodic motion of links with nonlinear internal forces.

A turn of the crank is sampled at evenly spaced crank angles, and the periodic motion z is
differentiated by its Fourier series (collocation): no time step is taken and no numerical
damping enters. At all samples together ::

    r(z) = N' (M q'' + G q' + (alpha S - omega^2 M_t) q + f_int(q) + D(q) q' - f(q, q')) = 0,
    q = q(z)

with the inertia of the links in their turning frames (all rotation terms), f the inertia forces of
the rigid motion, the weight, and the forces of loads, springs and dampers at the displaced links,
f_int the engine's own internal forces at large displacements and D its Kelvin-Voigt damping.
Inertia is linear in the displacements, but for bodies and rigid links, whose arms rotate by finite
angles. That is exact for Exudyn's cables, whose coordinates are vectors; sections have the inertia
of small rotations against their link frame. N is the derivative of the links' coordinates q by the
independent ones z. Both are linear, but for rigid links and sliders, whose constraints hold at
finite displacements.

A frame on springs has three coordinates more at the end of z. The frames of the links move with it
by any displacement and rotation: their inertia, weight and loads are those of the motion in ground
axes. Its own rows balance its inertia, springs, dampers and weight with the resultants of inertia
and loads of all links, all where they are displaced to. The moment of a link's inertia is that of
the forces on its nodes, exact but for what shape functions bend between them. In Newton's matrices,
and there alone, the coupling of the links with the frame is that of straight links and small
rotations (:class:`flexmech.linear_system.CarriedLinkage`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.dynamical_systems import differentiation_matrices
from flexmech.linear_system import (
    AttachedPoint,
    CarriedLinkage,
    ConnectedMatrices,
    DependentRows,
    DisplacedTies,
    Engine,
    LinkFrames,
    LinkInertia,
    MovingLink,
    PointForce,
    PointJacobian,
    RotationTerms,
    StressedLinks,
    SystemMatrices,
    body_turns,
    connected_matrices,
    with_rigid_links,
)
from flexmech.linkages import RigidMotion, carried_motion, turned
from flexmech.linkages.motion import cross, direction, normal
from flexmech.time_domain.equations_of_motion.driven_connectors import DrivenConnectors, LinkMotion

FROZEN = RotationTerms.all_or_none(False)


class DisplacedFrames(LinkFrames):
    """Link frames whose dependent rows are those at displaced rigid links and sliders.

    Parameters
    ----------
    frames : LinkFrames
    rows : list of list of DependentRows
        Of each link, at the positions for which the frames are used.
    """

    def __init__(self, frames: LinkFrames, rows: list[list[DependentRows]]) -> None:
        vars(self).update(vars(frames))  # the same coordinates, and sums of constant matrices
        self._rows = rows

    def dependent_rows(self, motion: RigidMotion) -> list[list[DependentRows]]:
        """Dependent rows of each link at the displaced rigid links and sliders."""
        del motion
        return self._rows


@dataclass(frozen=True)
class OrbitState:
    """A periodic motion and its residual in the equations of motion.

    Parameters
    ----------
    z : ndarray, shape (N, n)
        Independent coordinates of the unreduced links at the samples, and of a frame on springs.
    displacement, rate : list of ndarray, shape (N, n_link)
        Of each link in its frame, and its time derivative.
    beyond_linear : list of ndarray, shape (N, n_link)
        Part of the displacement that is not linear in z, by finite poses of rigid links.
    frames : LinkFrames
        Whose rows are derivatives of the links' coordinates by z at these displacements.
    stressed : StressedLinks
    connected : ConnectedMatrices or None
        Of loads and springs there, by z; None without them.
    residual : ndarray, shape (N, n)
        Forces out of balance.
    error : float
        Their norm over that of the loads; see :meth:`OrbitEquations.error`.
    """

    z: FloatArray
    displacement: list[FloatArray]
    rate: list[FloatArray]
    beyond_linear: list[FloatArray]
    frames: LinkFrames
    stressed: StressedLinks
    connected: ConnectedMatrices | None
    residual: FloatArray
    error: float


def times(matrix: FloatArray, vector: FloatArray) -> FloatArray:
    """Products of matrices (N, m, n) or (m, n) with vectors (N, n)."""
    return np.asarray((matrix @ vector[..., None])[..., 0])


def require_periodic_motion(engine: Engine) -> None:
    """Refuse links on which something acts that leaves no motion that repeats itself every turn.

    Parameters
    ----------
    engine : Engine

    Raises
    ------
    InputError
        If a load goes over time, or a spring is wound up turn by turn.
    """
    DrivenConnectors(engine, engine.frames).require_periodic()


class OrbitEquations:
    """Equations of motion of an engine's links at all samples of a turn.

    Parameters
    ----------
    engine : Engine
        Its :meth:`Engine.running_links` give internal forces.
    crank_speed : float
        In rad/s, not zero.
    samples : int
        Even number N of evenly spaced crank angles.

    Attributes
    ----------
    frames : LinkFrames
        Of the unreduced links.
    carried : CarriedLinkage or None
        With the frame on springs that carries the links.
    size : int
        Number n of coordinates.
    motion : RigidMotion
        Batch of shape (N,), on a frame that stands.
    first, second : ndarray, shape (N, N)
        See :func:`flexmech.dynamical_systems.differentiation_matrices`.
    load : ndarray, shape (N, n)
        Inertia forces of the rigid motion, weight, and loads and springs on the straight links.
    mass : ndarray, shape (N, n, n)

    Raises
    ------
    InputError
        As of :func:`require_periodic_motion`.
    """

    def __init__(self, engine: Engine, crank_speed: float, samples: int) -> None:
        linkage, links = engine.mechanism.linkage, engine.links
        require_periodic_motion(engine)
        self.engine, self.samples, self.crank_speed = engine, samples, crank_speed
        self.frames = LinkFrames(linkage.topology, links)
        self.motion: RigidMotion = linkage.motion(
            2 * np.pi / samples * np.arange(samples), np.full(samples, float(crank_speed))
        )
        self.first, self.second = differentiation_matrices(samples, crank_speed)
        self._zero = [np.zeros((link.size, link.size)) for link in links]
        self.carried = CarriedLinkage.of(engine.mechanism, self.frames, links)
        still_links = self.frames.assemble(self.motion, self._zero, FROZEN, self._zero)
        self.mass = self._carried(self.frames, still_links, FROZEN).mass
        self.size = self.mass.shape[1]
        self._inertias = [LinkInertia.of(link, link, np.eye(link.size)) for link in links]
        loads = engine.connectors.with_inertia(links, self.motion)
        self.load = self.frames.gather(self.motion, loads)
        if self.carried is not None:
            self.load = np.concatenate([self.load, self.carried.load(self.motion)], axis=1)
        still = [np.zeros((samples, link.size)) for link in links]
        frames = self._frames_at(self._ties(np.zeros((samples, self.frames.size))))
        straight = self._stiffness(
            frames, [link.stiffness for link in links], self._connected(still, frames)
        )
        self._half = np.linalg.inv(np.linalg.cholesky(straight))
        self._load_norm = self._norm(self.load)

    def elastic(self, state: OrbitState) -> FloatArray:
        """Stiffness ``N'KN`` of the linkage by those of its links and springs, (N, n, n)."""
        return self._stiffness(state.frames, state.stressed.tangent, state.connected)

    def _stiffness(
        self,
        frames: LinkFrames,
        tangent: Sequence[FloatArray],
        connected: ConnectedMatrices | None,
    ) -> FloatArray:
        total = frames.assemble(self.motion, tangent, FROZEN, self._zero).stiffness
        if connected is not None:
            total = total + connected.potential
        if self.carried is None:
            return total
        more = self.size - total.shape[1]
        total = np.pad(total, ((0, 0), (0, more), (0, more)))
        total[:, -more:, -more:] = self.carried.frame.stiffness
        return total

    def _carried(
        self, frames: LinkFrames, matrices: SystemMatrices, terms: RotationTerms
    ) -> SystemMatrices:
        """Matrices of the linkage with those of a frame on springs, if that carries it."""
        if self.carried is None:
            return matrices
        return replace(self.carried, frames=frames).added(self.motion, matrices, terms)

    def error(self, residual: FloatArray) -> float:
        """Norm of forces (N, n) over that of the loads.

        The norm of forces f is the root of ``f' K^-1 f`` summed over the turn, with K of the
        straight links: the work that these do under f. No unit of a coordinate decides over it.
        """
        return self._norm(residual) / self._load_norm

    def state(self, z: FloatArray, damping_rate: float = 0.0) -> OrbitState:
        """Residual and linearized forces of a periodic motion.

        Parameters
        ----------
        z : ndarray, shape (N, n)
        damping_rate : float
            Forces ``damping_rate * M z'`` act besides, in 1/s.

        Returns
        -------
        OrbitState
        """
        velocity, acceleration = self.first @ z, self.second @ z
        parts, motion = (z, velocity, acceleration), self.motion
        moving = self.frames.link_motion(motion, *(part[:, : self.frames.size] for part in parts))
        if self.carried is not None:
            places = [part[:, self.frames.size :] for part in parts]
            motion = carried_motion(self.carried.frame.centre, motion, *places)
        ties, beyond = self._ties(z), [np.zeros_like(q) for q, _, _ in moving]
        for more, (q, rate, change), of_link in zip(beyond, moving, ties.rows, strict=True):
            for tie in of_link:
                if tie.place is not None:
                    more[:, tie.rows] = tie.place - q[:, tie.rows]
            q += more
            rate += self.first @ more
            change += self.second @ more
        displacement, frames = [q for q, _, _ in moving], self._frames_at(ties)
        stressed = self.engine.running_links(self.motion, displacement)
        connected = self._connected(displacement, frames)
        loads, springs = self._pushes(moving, motion)
        forces = self._inertia_and_loads(moving, motion, loads)
        rows = [] if self.carried is None else [self._on_frame(forces, moving, motion, places)]
        forces = self._forces(stressed, moving, forces, springs)
        rows.insert(0, frames.gather(self.motion, forces))
        residual = times(self.mass, damping_rate * velocity) + np.concatenate(rows, axis=1)
        if self.frames.rigid.are_finite:
            stressed = self._with_rigid_links(stressed, ties, motion, forces, [*loads, *springs])
        rates = [rate for _, rate, _ in moving]
        error = self.error(residual)
        return OrbitState(
            z, displacement, rates, beyond, frames, stressed, connected, residual, error
        )

    def _ties(self, z: FloatArray) -> DisplacedTies:
        """Constraints at finite displacements of rigid links and sliders."""
        first = len(self.frames.rigid.independent_coordinates)
        return self.frames.displaced_ties(self.motion, z[:, :first])

    def _frames_at(self, ties: DisplacedTies) -> LinkFrames:
        """Link frames with dependent rows of displaced links, whose rates are those of the turn."""

        def differentiated(by: FloatArray, turn: FloatArray) -> FloatArray:
            return (by @ turn.reshape(len(turn), -1)).reshape(turn.shape)

        rows = [
            [
                DependentRows(
                    tie.rows,
                    tie.columns,
                    tie.turn,
                    differentiated(self.first, tie.turn),
                    differentiated(self.second, tie.turn),
                    np.zeros_like(tie.turn),
                )
                for tie in of_link
            ]
            for of_link in ties.rows
        ]
        return DisplacedFrames(self.frames, rows)

    def linearized(self, state: OrbitState, damping_rate: float = 0.0) -> SystemMatrices:
        """Matrices of small changes of the motion; each (N, n, n).

        What the elastic motion of bodies' arms would add is left out: Newton's method takes a pass
        more without it, and finds the same. The change of the damping matrix counts near a
        critical speed, where little else holds the motion.
        """
        stressed, connected = self._with_changing_damping(state), state.connected
        links = state.frames.assemble(
            self.motion,
            stressed.tangent,
            RotationTerms(),
            stressed.damping,
            stressed.guide_stiffness,
            body_turns(self.engine.links, state.displacement),
        )
        if connected is not None:
            stiffness = links.stiffness + connected.stiffness + connected.rate_stiffness
            links = SystemMatrices(links.mass, links.damping + connected.damping, stiffness)
        whole = self._carried(state.frames, links, RotationTerms())
        return replace(whole, damping=whole.damping + damping_rate * whole.mass)

    def _with_changing_damping(self, state: OrbitState) -> StressedLinks:
        """Stressed links whose tangents have the change of the damping forces."""
        more = self.engine.damping_stiffness(state.displacement, state.rate)
        if more is None:
            return state.stressed
        pairs = zip(state.stressed.tangent, more, strict=True)
        return replace(state.stressed, tangent=[tangent + change for tangent, change in pairs])

    def _connected(
        self, displacement: Sequence[FloatArray], frames: LinkFrames
    ) -> ConnectedMatrices | None:
        """Stiffness and damping of loads and springs by z at displacements of the links."""
        connectors = self.engine.connectors
        if not connectors.any:
            return None
        rows = frames.dependent_rows(self.motion)

        def moved(point: AttachedPoint) -> PointJacobian:
            link = point.link
            finite = replace(point, rows=point.rows_at(displacement[link]))
            value = PointJacobian.of(finite, frames, self.motion, rows[link]).value
            return PointJacobian(value, np.tensordot(self.first, value, 1))

        tangents = connectors.tangents(self.motion, displacement)
        shape = self.samples, self.frames.size, self.frames.size
        return connected_matrices(
            tangents, moved, shape, is_conservative=connectors.is_conservative
        )

    def _pushes(
        self, moving: LinkMotion, motion: RigidMotion
    ) -> tuple[list[PointForce], list[PointForce]]:
        """Forces of loads and of springs on points of the displaced links.

        In axes that have turned with a frame on springs, against which loads turn back.
        """
        if not self.engine.connectors.any:
            return [], []
        displacement, rate = [q for q, _, _ in moving], [v for _, v, _ in moving]
        point_forces = self.engine.connectors.point_forces
        pushes = point_forces(self.motion, displacement, rate=rate, radial=True)
        loads, back = len(self.engine.mechanism.loads), self.motion.angle - motion.angle
        turned_back = [
            replace(push, force=turned(push.force, back[:, push.point.link]))
            for push in pushes[:loads]
        ]
        return turned_back, pushes[loads:]

    def _inertia_and_loads(
        self, moving: LinkMotion, motion: RigidMotion, loads: Sequence[PointForce]
    ) -> list[FloatArray]:
        """Inertia forces (N, n_link) less weight and loads on each link, in ground axes' motion."""
        forces, gravity = [], self.engine.mechanism.gravity
        for number, link in enumerate(self.engine.links):
            elastic = moving[number]
            link_motion = MovingLink.of(number, elastic, motion, motion, np.asarray(gravity))
            force = self._inertias[number].shape_forces(link_motion)
            for body in link.bodies:
                moved = (x @ body.rows.T for x in elastic)
                force += body.nonlinear_inertia(motion, number, gravity, *moved) @ body.rows
            forces.append(force)
        self._subtract(loads, forces, moving)
        return forces

    def _forces(
        self,
        stressed: StressedLinks,
        moving: LinkMotion,
        forces: Sequence[FloatArray],
        springs: Sequence[PointForce],
    ) -> list[FloatArray]:
        """Forces (N, n_link) that are out of balance on each link but for those of its joints."""
        assert stressed.internal_force is not None
        damping = stressed.damping or [link.damping for link in self.engine.links]
        whole = [
            force
            if link.rigid
            else force + stressed.internal_force[number] + times(damping[number], moving[number][1])
            for number, (link, force) in enumerate(zip(self.engine.links, forces, strict=True))
        ]
        self._subtract(springs, whole, moving)
        return whole

    def _subtract(
        self, pushes: Sequence[PointForce], forces: list[FloatArray], moving: LinkMotion
    ) -> None:
        """Take forces on points of the displaced links from those on the links, in place."""
        for push in pushes:
            place, q = push.point, moving[push.point.link][0]
            forces[place.link] -= place.force(self.motion, push.force, push.torque, q, finite=True)

    def _on_frame(
        self,
        forces: Sequence[FloatArray],
        moving: LinkMotion,
        motion: RigidMotion,
        places: Sequence[FloatArray],
    ) -> FloatArray:
        """Forces and moment (N, 3) that are out of balance on a frame on springs.

        Parameters
        ----------
        forces : sequence of ndarray, shape (N, n_link)
            Of inertia and loads on each link.
        moving : LinkMotion
        motion : RigidMotion
            In ground axes.
        places : sequence of ndarray, shape (N, 3)
            Displacement and rotation of the frame and their time derivatives.
        """
        assert self.carried is not None
        frame, (place, rate, change) = self.carried.frame, places
        total = frame.spring_forces(place, rate) + change @ frame.inertia_matrix
        total[:, :2] -= frame.mass * np.asarray(self.carried.gravity)
        for number, (link, force) in enumerate(zip(self.engine.links, forces, strict=True)):
            (x, y), q, angle = link.vectors, moving[number][0], motion.angle[:, number]
            along, across = force @ link.fields.along, force @ link.fields.across
            push = along[:, None] * direction(angle) + across[:, None] * normal(angle)
            arm = motion.origin[:, number] - np.asarray(frame.centre) - place[:, :2]
            displaced = np.sum(q[:, x] * force[:, y] - q[:, y] * force[:, x], axis=1)
            total[:, :2] += push
            total[:, 2] += force @ link.fields.tangential + displaced + cross(arm, push)
        return total

    def _with_rigid_links(
        self,
        stressed: StressedLinks,
        ties: DisplacedTies,
        motion: RigidMotion,
        forces: Sequence[FloatArray],
        pushes: Sequence[PointForce],
    ) -> StressedLinks:
        """Stressed links with the geometric stiffness of rigid ones by all forces on them."""
        by_rotation = {}
        for number in self.frames.rigid.links:
            body = self.engine.links[number].bodies[0]
            virial, _ = body.dead_moment(motion, number, self.engine.mechanism.gravity)
            square = motion.angular_velocity[:, number] ** 2
            by_rotation[number] = virial - square * body.central_inertia
        for push in pushes:
            if (link := push.point.link) in by_rotation:
                turned = self.motion.angle[:, link] + ties.pose.displaced.turn[:, link]
                along = np.sum(direction(turned) * push.force, axis=1)
                by_rotation[link] = by_rotation[link] + push.point.x * along
        geometric = ties.geometric_stiffness([-force for force in forces], by_rotation)
        tangent = {n: matrix for n, matrix in enumerate(stressed.tangent) if n not in by_rotation}
        rigid = with_rigid_links(self.frames, tangent, geometric)
        return replace(stressed, tangent=rigid.tangent, guide_stiffness=rigid.guide_stiffness)

    def _norm(self, force: FloatArray) -> float:
        return float(np.linalg.norm(times(self._half, force)))
