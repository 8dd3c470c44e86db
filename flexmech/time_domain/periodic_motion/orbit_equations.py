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
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.dynamical_systems import differentiation_matrices
from flexmech.linear_system import (
    AttachedPoint,
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
from flexmech.linear_system.links.chains import with_entries
from flexmech.linkages import RigidMotion
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


class RunningForces:
    """Forces on the displaced links of a running linkage, at any instants of its rigid motion.

    Parameters
    ----------
    engine : Engine
    motion : RigidMotion
        Batch of shape (N,).

    Attributes
    ----------
    frames : LinkFrames
        Of the unreduced links.
    """

    def __init__(self, engine: Engine, motion: RigidMotion) -> None:
        self._engine, self.motion = engine, motion
        self.frames = LinkFrames(engine.topology, engine.links)
        self._inertias = [LinkInertia.of(link, link, np.eye(link.size)) for link in engine.links]

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
        engine, displacement = self._engine, [q for q, _, _ in moving]
        z = self.frames.independent(self.motion, [q[..., None] for q in displacement])[..., 0]
        stressed, pushes = engine.running_links(self.motion, displacement), self.pushes(moving)
        forces = self.out_of_balance(stressed, moving, pushes)
        stressed = self.with_bodies(stressed, moving, self.ties(z), forces, pushes)
        more = engine.damping_stiffness(self.motion, displacement, [rate for _, rate, _ in moving])
        return replace(stressed, damping_stiffness=more)

    def pushes(self, moving: LinkMotion) -> list[PointForce]:
        """Forces of loads and springs on points of the displaced links."""
        if not self._engine.connectors.any:
            return []
        displacement, rate = [q for q, _, _ in moving], [v for _, v, _ in moving]
        connectors, at = self._engine.connectors, (self.motion, displacement)
        return [*connectors.point_forces(*at, rate=rate), *connectors.radial_forces(*at, rate)]

    def out_of_balance(
        self, stressed: StressedLinks, moving: LinkMotion, pushes: Sequence[PointForce]
    ) -> list[FloatArray]:
        """Forces (N, n_link) that are out of balance on each link but for those of its joints."""
        forces, motion, gravity = [], self.motion, self._engine.mechanism.gravity
        assert stressed.internal_force is not None
        damping = stressed.damping or [link.damping for link in self._engine.links]
        for number, model in enumerate(self._engine.links):
            elastic = moving[number]
            link_motion = MovingLink.of(number, elastic, motion, motion, np.asarray(gravity))
            force = self._inertias[number].shape_forces(link_motion)
            if not model.rigid:
                force += stressed.internal_force[number]
                force += times(damping[number], link_motion.rate)
            for body in model.bodies:
                moved = (x @ body.rows.T for x in elastic)
                force += body.nonlinear_inertia(motion, number, gravity, *moved) @ body.rows
            forces.append(force)
        for push in pushes:
            link = push.point.link
            forces[link] -= push.on_link(motion, moving[link][0])
        return forces

    def with_bodies(
        self,
        stressed: StressedLinks,
        moving: LinkMotion,
        ties: DisplacedTies,
        forces: Sequence[FloatArray],
        pushes: Sequence[PointForce],
    ) -> StressedLinks:
        """Stressed links with the geometric stiffness of bodies and rigid links by all forces."""
        by_rotation, tangent = {}, dict(enumerate(stressed.tangent))
        gravity = self._engine.mechanism.gravity
        for number, link in enumerate(self._engine.links):
            for body in link.bodies:
                moved = (x @ body.rows.T for x in moving[number])
                stiffness = body.rotation_stiffness(self.motion, number, gravity, *moved)
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
        Independent coordinates of the unreduced links at the samples.
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
        If the frame is on springs, a load goes over time, or a spring is wound up turn by turn.
    """
    engine.require_standing_frame("a periodic motion at large displacements")
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
    motion : RigidMotion
        Batch of shape (N,).
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
        self._running = RunningForces(engine, self.motion)
        self.frames = self._running.frames
        self.first, self.second = differentiation_matrices(samples, crank_speed)
        self._zero = [np.zeros((link.size, link.size)) for link in links]
        self.mass = self.frames.assemble(self.motion, self._zero, FROZEN, self._zero).mass
        loads = engine.connectors.with_inertia(links, self.motion)
        self.load = self.frames.gather(self.motion, loads)
        still = [np.zeros((samples, link.size)) for link in links]
        frames = self._frames_at(self._running.ties(np.zeros((samples, self.frames.size))))
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
        return total if connected is None else total + connected.potential

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
        moving = self.frames.link_motion(self.motion, z, velocity, acceleration)
        ties, beyond = self._running.ties(z), []
        for link, (q, rate, change) in enumerate(moving):
            linear = q.copy()
            ties.put_places(link, q)
            beyond.append(q - linear)
            rate += self.first @ beyond[-1]
            change += self.second @ beyond[-1]
        displacement, frames = [q for q, _, _ in moving], self._frames_at(ties)
        stressed = self.engine.running_links(self.motion, displacement)
        pushes, connected = self._running.pushes(moving), self._connected(displacement, frames)
        forces = self._running.out_of_balance(stressed, moving, pushes)
        residual = times(self.mass, damping_rate * velocity) + frames.gather(self.motion, forces)
        stressed = self._running.with_bodies(stressed, moving, ties, forces, pushes)
        rates = [rate for _, rate, _ in moving]
        error = self.error(residual)
        return OrbitState(
            z, displacement, rates, beyond, frames, stressed, connected, residual, error
        )

    def _frames_at(self, ties: DisplacedTies) -> LinkFrames:
        """Link frames with dependent rows of displaced links, whose rates are those of the turn."""

        def differentiated(by: FloatArray, turn: FloatArray) -> FloatArray:
            return (by @ turn.reshape(len(turn), -1)).reshape(turn.shape)

        rows = [
            [
                DependentRows(
                    *dependent,
                    turn,
                    differentiated(self.first, turn),
                    differentiated(self.second, turn),
                    np.zeros_like(turn),
                )
                for dependent, turn in zip(self.frames.dependencies(link), turns, strict=True)
            ]
            for link, turns in enumerate(ties.rows)
        ]
        return DisplacedFrames(self.frames, rows)

    def linearized(self, state: OrbitState, damping_rate: float = 0.0) -> SystemMatrices:
        """Matrices of small changes of the motion; each (N, n, n).

        The change of the damping matrix counts near a critical speed, where little else holds the
        motion.
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
        damped, stiffness = links.damping + damping_rate * links.mass, links.stiffness
        if connected is not None:
            damped = damped + connected.damping
            stiffness = stiffness + connected.stiffness + connected.rate_stiffness
        return SystemMatrices(links.mass, damped, stiffness)

    def _with_changing_damping(self, state: OrbitState) -> StressedLinks:
        """Stressed links whose tangents have the change of the damping forces."""
        more = self.engine.damping_stiffness(self.motion, state.displacement, state.rate)
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

        def moved(point: AttachedPoint) -> PointJacobian:
            link = point.link
            finite = replace(point, rows=point.rows_at(displacement[link]))
            value = PointJacobian.of(finite, frames, self.motion).value
            return PointJacobian(value, np.tensordot(self.first, value, 1))

        tangents = connectors.tangents(self.motion, displacement)
        shape = self.mass.shape
        return connected_matrices(
            tangents, moved, shape, is_conservative=connectors.is_conservative
        )

    def _norm(self, force: FloatArray) -> float:
        return float(np.linalg.norm(times(self._half, force)))
