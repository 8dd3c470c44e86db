"""Equations of the periodic motion of links with nonlinear internal forces.

A turn of the crank is sampled at evenly spaced crank angles, and the periodic motion z is
differentiated by its Fourier series (collocation): no time step is taken and no numerical
damping enters. At all samples together ::

    r(z) = N' (M q'' + G q' + (alpha S - omega^2 M_t) q + f_int(q) + D(q) q' - f(q, q')) = 0,
    q = q(z)

with the inertia of the links in their turning frames (all rotation terms), f the inertia forces of
the rigid motion, the weight, and the forces of loads, springs and dampers at the displaced links,
f_int the engine's own internal forces at large displacements and D its Kelvin-Voigt damping.
Inertia is linear in displacements and slope vectors, but for bodies and rigid links, whose arms
rotate by finite angles. That is exact for Exudyn's cables. Where the length and the angle of a
slope are coordinates in place of its vector, x(q), the inertia forces F of these vectors are
``J' F(x, x', x'')`` with ``J = dx/dq``, and F times the second derivative of x belongs to the
stiffness (:class:`flexmech.mechanics.links.link_model.VectorMap`). Sections have the inertia of
small rotations against their link frame. N is the derivative of the links' coordinates q by the
independent ones z. Both are linear, but for rigid links and sliders, whose constraints hold at
finite displacements.

A frame on springs has three coordinates more at the end of z. The frames of the links move with it
by any displacement and rotation: their inertia, weight and loads are those of the motion in ground
axes. Its own rows balance its inertia, springs, dampers and weight with the resultants of inertia
and loads of all links, all where they are displaced to. The moment of a link's inertia is that of
the forces on its nodes, exact but for what shape functions bend between them. In Newton's matrices,
and there alone, the coupling of the links with the frame is that of straight links and small
rotations (:class:`flexmech.mechanics.CarriedLinkage`).
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.dynamical_systems import differentiation_matrices
from flexmech.linkages import RigidMotion, carried_motion
from flexmech.linkages.motion import cross, direction, normal
from flexmech.mechanics import (
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
from flexmech.mechanics.links.link_model import with_entries
from flexmech.mechanics.running.driven_connectors import DrivenConnectors, LinkMotion

FROZEN = RotationTerms.all_or_none(False)


class DisplacedFrames(LinkFrames):
    """Link frames whose dependent rows are those at displaced rigid links and sliders.

    Parameters
    ----------
    frames : LinkFrames
    rows : list of DependentRows
        Rows of each link, at the positions for which the frames are used.
    """

    def __init__(self, frames: LinkFrames, rows: list[DependentRows]) -> None:
        vars(self).update(vars(frames))  # the same coordinates, and sums of constant matrices
        self._rows = rows

    def dependent_rows(self, motion: RigidMotion) -> list[DependentRows]:
        """Dependent rows of each link at the displaced rigid links and sliders."""
        del motion
        return self._rows


class RunningForces:
    """Forces on the displaced links of a running linkage, at any instants of its rigid motion.

    Parameters
    ----------
    engine : Engine
    motion : RigidMotion
        Batch of shape (N,), on a frame that stands.

    Attributes
    ----------
    frames : LinkFrames
        Frames of the unreduced links.
    whole : RigidMotion
        The motion in ground axes, with that of a frame on springs; see :meth:`on_frame`.
    """

    def __init__(self, engine: Engine, motion: RigidMotion) -> None:
        self._engine, self.motion, self.whole = engine, motion, motion
        self.frames = LinkFrames(engine.topology, engine.links)
        self._inertias = [LinkInertia.of(link, link, np.eye(link.size)) for link in engine.links]

    def on_frame(self, places: Sequence[FloatArray]) -> Self:
        """These forces on a frame on springs that moves.

        Parameters
        ----------
        places : sequence of ndarray, shape (N, 3)
            Displacement and rotation of the frame and their first two time derivatives; empty of
            one that stands.
        """
        moved = copy(self)
        if places:
            frame = self._engine.mechanism.frame
            assert frame is not None
            moved.whole = carried_motion(frame.centre, self.motion, *places)
        return moved

    def ties(self, z: FloatArray) -> DisplacedTies:
        """Constraints at finite displacements of rigid links and sliders, by coordinates (N, n)."""
        first = len(self.frames.rigid.independent_coordinates)
        return self.frames.displaced_ties(self.motion, z[:, :first])

    def stressed(self, moving: LinkMotion) -> StressedLinks:
        """Links about a motion: stiffness of their stress and damping, of rigid ones as well.

        Parameters
        ----------
        moving : list of tuple of ndarray, shape (N, n_link)
            Displacement of each link in its frame and its first two time derivatives.

        Returns
        -------
        StressedLinks
            With the derivative of the damping forces by the displacement.
        """
        displacement, rate = [q for q, _, _ in moving], [v for _, v, _ in moving]
        z = self.frames.independent(self.motion, [q[..., None] for q in displacement])[..., 0]
        engine, more = self._engine, None
        stressed = engine.running_links(self.whole, displacement)
        if engine.has_damped_links:
            whole = engine.running_links(self.whole, displacement, rate).tangent
            more = [of_both - k for of_both, k in zip(whole, stressed.tangent, strict=True)]
        loads, springs = self.pushes(moving)
        forces = self.inertia_and_loads(moving, loads)
        forces = self.out_of_balance(stressed, moving, forces, springs)
        stressed = self.with_bodies(stressed, moving, self.ties(z), forces, [*loads, *springs])
        return replace(stressed, damping_stiffness=more, motion=self.motion)

    def pushes(self, moving: LinkMotion) -> tuple[list[PointForce], list[PointForce]]:
        """Forces of loads and of springs on points of the displaced links.

        In axes that have rotated with a frame on springs, against which dead loads rotate back.

        Parameters
        ----------
        moving : list of tuple of ndarray, shape (N, n_link)
            As of :meth:`stressed`.
        """
        if not self._engine.connectors.any:
            return [], []
        displacement, rate = [q for q, _, _ in moving], [v for _, v, _ in moving]
        connectors, at = self._engine.connectors, (self.motion, displacement)
        turn = self.whole.angle[:, 0] - self.motion.angle[:, 0]
        pushes = connectors.point_forces(*at, rate=rate, turn=turn)
        loads = len(self._engine.mechanism.loads)
        return pushes[:loads], [*pushes[loads:], *connectors.radial_forces(*at, rate)]

    def inertia_and_loads(
        self, moving: LinkMotion, loads: Sequence[PointForce]
    ) -> list[FloatArray]:
        """Inertia forces (N, n_link) less weight and loads on each link.

        Parameters
        ----------
        moving : list of tuple of ndarray, shape (N, n_link)
            As of :meth:`stressed`.
        loads : sequence of PointForce
        """
        forces, given = [], (self.whole, self._engine.mechanism.gravity)
        for number, link in enumerate(self._engine.links):
            force = self._distributed_inertia(number, moving)
            if link.vector_map is not None:
                force = link.vector_map.force(moving[number][0], force)
            for body in link.bodies:
                moved = (x @ body.rows.T for x in moving[number])
                force += body.inertia_in_motion(given[0], number, given[1], *moved)[0] @ body.rows
            forces.append(force)
        self._subtract(loads, forces, moving)
        return forces

    def _distributed_inertia(self, number: int, moving: LinkMotion) -> FloatArray:
        """Inertia forces (N, n_link) less weight on a link without its bodies.

        On its vector coordinates, by which they are linear.
        """
        link, (q, rate, change) = self._engine.links[number], moving[number]
        motion, gravity = self.whole, self._engine.mechanism.gravity
        if (vectors := link.vector_map) is not None:
            change = vectors.acceleration_to_nodes(q, rate, change)
            q, rate = vectors.to_nodes(q), vectors.rate_to_nodes(q, rate)
        elastic = q, rate, change
        link_motion = MovingLink.of(number, elastic, motion, motion, np.asarray(gravity))
        force = self._inertias[number].shape_forces(link_motion)
        for body in link.bodies:
            moved = (x @ body.rows.T for x in elastic)
            force -= body.linear_inertia(motion, number, gravity, *moved) @ body.rows
        return force

    def out_of_balance(
        self,
        stressed: StressedLinks,
        moving: LinkMotion,
        forces: Sequence[FloatArray],
        springs: Sequence[PointForce],
    ) -> list[FloatArray]:
        """Forces (N, n_link) that are out of balance on each link but for those of its joints.

        Parameters
        ----------
        stressed : StressedLinks
            Elastic links as they are displaced.
        moving : list of tuple of ndarray, shape (N, n_link)
            As of :meth:`stressed`.
        forces : sequence of ndarray, shape (N, n_link)
            See :meth:`inertia_and_loads`.
        springs : sequence of PointForce
        """
        assert stressed.internal_force is not None
        damping = stressed.damping or [link.damping for link in self._engine.links]
        whole = [
            force
            if link.rigid
            else force + stressed.internal_force[number] + times(damping[number], moving[number][1])
            for number, (link, force) in enumerate(zip(self._engine.links, forces, strict=True))
        ]
        self._subtract(springs, whole, moving)
        return whole

    def _subtract(
        self, pushes: Sequence[PointForce], forces: list[FloatArray], moving: LinkMotion
    ) -> None:
        """Take forces on points of the displaced links from those on the links, in place."""
        for push in pushes:
            link = push.point.link
            forces[link] -= push.on_link(self.motion, moving[link][0])

    def with_bodies(
        self,
        stressed: StressedLinks,
        moving: LinkMotion,
        ties: DisplacedTies,
        forces: Sequence[FloatArray],
        pushes: Sequence[PointForce],
    ) -> StressedLinks:
        """Stressed links with the geometric stiffness of bodies and rigid links by all forces.

        Parameters
        ----------
        stressed : StressedLinks
            Elastic links as they are displaced.
        moving : list of tuple of ndarray, shape (N, n_link)
            As of :meth:`stressed`.
        ties : DisplacedTies
        forces : sequence of ndarray, shape (N, n_link)
            See :meth:`out_of_balance`.
        pushes : sequence of PointForce
            Loads and springs.
        """
        by_rotation, tangent = {}, dict(enumerate(stressed.tangent))
        gravity = self._engine.mechanism.gravity
        for number, link in enumerate(self._engine.links):
            if link.vector_map is not None:
                turning = self._distributed_inertia(number, moving)
                turned = link.vector_map.geometric_stiffness(moving[number][0], turning)
                tangent[number] = tangent[number] + turned
            for body in link.bodies:
                moved = (x @ body.rows.T for x in moving[number])
                stiffness = body.rotation_stiffness(self.whole, number, gravity, *moved)
                if link.rigid:
                    by_rotation[number] = stiffness
                else:
                    row = np.array([body.row])
                    tangent[number] = with_entries(tangent[number], row, row, stiffness[:, None])
        if not self.frames.rigid.are_finite:
            return replace(stressed, tangent=list(tangent.values()))
        for push in pushes:
            if (number := push.point.link) in by_rotation:
                more = push.rotation_stiffness(self.motion, moving[number][0])
                by_rotation[number] = by_rotation[number] + more
        geometric = ties.geometric_stiffness([-force for force in forces], by_rotation)
        rigid = with_rigid_links(self.frames, tangent, geometric)
        return replace(stressed, tangent=rigid.tangent, guide_stiffness=rigid.guide_stiffness)


@dataclass(frozen=True)
class OrbitState:
    """A periodic motion and its residual in the equations of motion.

    Parameters
    ----------
    z : ndarray, shape (N, n)
        Independent coordinates of the unreduced links at the samples, and of a frame on springs.
    displacement, rate : list of ndarray, shape (N, n_link)
        Displacement of each link in its frame, in m and rad, and its time derivative.
    beyond_linear : list of ndarray, shape (N, n_link)
        Part of the displacement that is not linear in z, by finite poses of rigid links.
    frames : LinkFrames
        Whose rows are derivatives of the links' coordinates by z at these displacements.
    stressed : StressedLinks
        With the change of the damping forces by the displacement in its tangents: it counts near a
        critical speed, where little else holds the motion.
    connected : ConnectedMatrices or None
        Matrices of loads and springs there, by z; None without them.
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
        Frames of the unreduced links.
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
        self.motion: RigidMotion = linkage.motion(
            2 * np.pi / samples * np.arange(samples), np.full(samples, float(crank_speed))
        )
        self._standing = RunningForces(engine, self.motion)
        self.frames = self._standing.frames
        self.first, self.second = differentiation_matrices(samples, crank_speed)
        self._zero = [np.zeros((link.size, link.size)) for link in links]
        self.carried = CarriedLinkage.of(engine.mechanism, self.frames, links)
        still_links = self.frames.assemble(self.motion, self._zero, FROZEN, self._zero)
        self.mass = self._carried(self.frames, still_links, FROZEN).mass
        self.size = self.mass.shape[1]
        loads = engine.connectors.with_inertia(links, self.motion)
        self.load = self.frames.gather(self.motion, loads)
        if self.carried is not None:
            self.load = np.concatenate([self.load, self.carried.load(self.motion)], axis=1)
        still = [np.zeros((samples, link.size)) for link in links]
        frames = self._frames_at(self._standing.ties(np.zeros((samples, self.frames.size))))
        straight = self._stiffness(
            frames, [link.stiffness for link in links], self._connected(still, frames)
        )
        self._half = np.linalg.inv(np.linalg.cholesky(straight))
        self._load_norm = self._norm(self.load)

    def stiffness(self, state: OrbitState) -> FloatArray:
        """Stiffness ``N'KN`` of the linkage by those of its links and springs, (N, n, n).

        Without the inertia of motion.
        """
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
        parts, count = (z, velocity, acceleration), self.frames.size
        moving = self.frames.link_motion(self.motion, *(values[:, :count] for values in parts))
        places = [] if self.carried is None else [values[:, count:] for values in parts]
        running = self._standing.on_frame(places)
        ties, beyond = running.ties(z), []
        for link, (q, rate, change) in enumerate(moving):
            linear = q.copy()
            ties.put_places(link, q)
            beyond.append(q - linear)
            rate += self.first @ beyond[-1]
            change += self.second @ beyond[-1]
        displacement, frames = [q for q, _, _ in moving], self._frames_at(ties)
        rates = [rate for _, rate, _ in moving]
        stressed = self.engine.running_links(running.whole, displacement, rates)
        connected = self._connected(displacement, frames)
        loads, springs = running.pushes(moving)
        forces, rows = running.inertia_and_loads(moving, loads), []
        if self.carried is not None:
            rows = [self._on_frame(forces, moving, running.whole, places)]
        forces = running.out_of_balance(stressed, moving, forces, springs)
        rows.insert(0, frames.gather(self.motion, forces))
        residual = times(self.mass, damping_rate * velocity) + np.concatenate(rows, axis=1)
        stressed = running.with_bodies(stressed, moving, ties, forces, [*loads, *springs])
        error = self.error(residual)
        return OrbitState(
            z, displacement, rates, beyond, frames, stressed, connected, residual, error
        )

    def _frames_at(self, ties: DisplacedTies) -> LinkFrames:
        """Link frames with dependent rows of displaced links, whose rates are those of the turn."""

        def differentiated(by: FloatArray, turn: FloatArray) -> FloatArray:
            return (by @ turn.reshape(len(turn), -1)).reshape(turn.shape)

        rows = [
            DependentRows(
                *dependent,
                turn,
                differentiated(self.first, turn),
                differentiated(self.second, turn),
                np.zeros_like(turn),
            )
            for dependent, turn in zip(self.frames.dependencies, ties.rows, strict=True)
        ]
        return DisplacedFrames(self.frames, rows)

    def linearized(self, state: OrbitState, damping_rate: float = 0.0) -> SystemMatrices:
        """Matrices of small changes of the motion; each (N, n, n)."""
        stressed, connected = state.stressed, state.connected
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

    def _connected(
        self, displacement: Sequence[FloatArray], frames: LinkFrames
    ) -> ConnectedMatrices | None:
        """Stiffness and damping of loads and springs by z at displacements of the links."""
        connectors = self.engine.connectors
        if not connectors.any:
            return None

        def moved(point: AttachedPoint) -> PointJacobian:
            link = point.link
            finite = replace(point, rows=point.rows_at(displacement[link]))
            value = PointJacobian.of(finite, frames, self.motion).value
            return PointJacobian(value, np.tensordot(self.first, value, 1))

        tangents = connectors.tangents(self.motion, displacement)
        shape = self.samples, self.frames.size, self.frames.size
        return connected_matrices(
            tangents, moved, shape, is_conservative=connectors.is_conservative
        )

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
            Forces of inertia and loads on each link.
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

    def _norm(self, force: FloatArray) -> float:
        return float(np.linalg.norm(times(self._half, force)))
