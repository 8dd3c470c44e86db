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
from flexmech.linear_system import (
    AttachedPoint,
    ConnectedMatrices,
    Engine,
    LinkDamping,
    LinkFrames,
    LinkInertia,
    MovingLink,
    RotationTerms,
    StressedLinks,
    SystemMatrices,
    inertia_loads,
    with_rigid_links,
)
from flexmech.linkages import ConstantSpeed, RigidMotion
from flexmech.linkages.motion import direction, normal
from flexmech.time_domain.equations_of_motion.driven_connectors import DrivenConnectors

Moving = Sequence[tuple[FloatArray, FloatArray, FloatArray]]
"""Displacement of each link and its two time derivatives, (N, n_link) each."""


@dataclass(frozen=True)
class OrbitState:
    """A periodic motion and its residual in the equations of motion.

    Parameters
    ----------
    z : ndarray, shape (N, n)
        Independent coordinates of the unreduced links at the samples.
    displacement, rate : list of ndarray, shape (N, n_link)
        Of each link in its frame, and its time derivative.
    stressed : StressedLinks
        At these displacements.
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
    stressed: StressedLinks
    connected: ConnectedMatrices | None
    residual: FloatArray
    error: float


def derivatives(samples: int, crank_speed: float) -> tuple[FloatArray, FloatArray]:
    """First and second time derivative of a periodic motion from its samples.

    Parameters
    ----------
    samples : int
        Even number N of evenly spaced crank angles of a turn.
    crank_speed : float
        In rad/s.

    Returns
    -------
    ndarray, shape (N, N)
        First derivative; the fastest harmonic, of which samples show the cosine alone, has none.
    ndarray, shape (N, N)
        Second derivative.
    """
    harmonic = np.arange(samples // 2 + 1)
    unit = np.fft.rfft(np.eye(samples), axis=0)
    once = 1j * harmonic[:, None] * unit
    once[-1] = 0.0
    first = np.fft.irfft(once, samples, axis=0)
    second = np.fft.irfft(-(harmonic[:, None] ** 2) * unit, samples, axis=0)
    return crank_speed * first, crank_speed**2 * second


def at_angles(z: FloatArray, crank_angle: FloatArray) -> FloatArray:
    """Values of a periodic motion at other crank angles, by its Fourier series.

    Parameters
    ----------
    z : ndarray, shape (N, n)
        At an even number of evenly spaced crank angles from zero.
    crank_angle : ndarray, shape (A,)
        In rad.

    Returns
    -------
    ndarray, shape (A, n)
    """
    amplitude = np.fft.rfft(z, axis=0) / len(z)
    amplitude[1:-1] *= 2
    waves = np.exp(1j * np.outer(crank_angle, np.arange(len(amplitude))))
    return np.asarray((waves @ amplitude).real)


def times(matrix: FloatArray, vector: FloatArray) -> FloatArray:
    """Products of matrices (N, m, n) or (m, n) with vectors (N, n)."""
    return np.asarray((matrix @ vector[..., None])[..., 0])


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
        See :func:`derivatives`.
    load : ndarray, shape (N, n)
        Inertia forces of the rigid motion, weight, and loads and springs on the straight links.
    mass : ndarray, shape (N, n, n)

    Raises
    ------
    InputError
        If the frame is on springs, a load goes over time, or a spring is wound up turn by turn.
    """

    def __init__(self, engine: Engine, crank_speed: float, samples: int) -> None:
        linkage, links = engine.mechanism.linkage, engine.links
        engine.require_standing_frame("a periodic motion at large displacements")
        DrivenConnectors(engine, engine.frames, ConstantSpeed(crank_speed)).require_periodic()
        self.engine, self.samples, self.crank_speed = engine, samples, crank_speed
        self.frames = LinkFrames(linkage.topology, links)
        self.motion: RigidMotion = linkage.motion(
            2 * np.pi / samples * np.arange(samples), np.full(samples, float(crank_speed))
        )
        self.first, self.second = derivatives(samples, crank_speed)
        nothing = [np.zeros((link.size, link.size)) for link in links]
        self._undamped = [LinkDamping(zero, zero) for zero in nothing]
        own = self.frames.assemble(self.motion, nothing, RotationTerms(), self._undamped)
        self.mass = own.mass
        self._inertias = [LinkInertia.of(link, link, np.eye(link.size)) for link in links]
        loads = inertia_loads(links, self.motion, engine.mechanism.gravity)
        if engine.connectors.any:
            acting = engine.connectors.forces(self.motion)
            loads = [inertia + force for inertia, force in zip(loads, acting, strict=True)]
        self.load = self.frames.gather(self.motion, loads)
        still = [np.zeros((samples, link.size)) for link in links]
        straight = self.elastic(StressedLinks.unloaded(links), self._connected(still))
        self._half = np.linalg.inv(np.linalg.cholesky(straight))
        self._load_norm = self._norm(self.load)

    def elastic(
        self, stressed: StressedLinks, connected: ConnectedMatrices | None = None
    ) -> FloatArray:
        """Stiffness ``N'KN`` of the linkage from those of its links and springs, (N, n, n)."""
        if self.frames.rigid.size and stressed.displacement is not None:
            maps, total = self._maps(stressed.displacement), np.zeros_like(self.mass)
            for by_z, tangent in zip(maps, stressed.tangent, strict=True):
                total += np.swapaxes(by_z, 1, 2) @ tangent @ by_z
        else:
            terms = RotationTerms.all_or_none(False)
            links = stressed.tangent
            total = self.frames.assemble(self.motion, links, terms, self._undamped).stiffness
        return total if connected is None else total + connected.potential

    def error(self, residual: FloatArray) -> float:
        """Norm of forces (N, n) over that of the loads.

        The norm of forces f is the root of ``f' K^-1 f`` summed over the turn, with K of the
        straight links: the work that these do under f. No unit of a coordinate decides over it.
        """
        return self._norm(residual) / self._load_norm

    def state(self, z: FloatArray, damping_rate: float = 0.0) -> OrbitState:
        """Evaluate a periodic motion.

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
        for (q, rate, change), beyond in zip(moving, self.beyond_linear(z), strict=True):
            q += beyond
            rate += self.first @ beyond
            change += self.second @ beyond
        displacement = [q for q, _, _ in moving]
        stressed = self.engine.running_links(self.motion, displacement)
        forces, connected = self._forces(stressed, moving), self._connected(displacement)
        residual = times(self.mass, damping_rate * velocity)
        if self.frames.rigid.size:
            maps = self._maps(displacement)
            residual += sum(
                times(np.swapaxes(n, 1, 2), f) for n, f in zip(maps, forces, strict=True)
            )
            stressed = self._with_rigid_links(stressed, forces, moving)
        else:
            residual += self.frames.gather(self.motion, forces)
        velocities = [rate for _, rate, _ in moving]
        error = self.error(residual)
        return OrbitState(z, displacement, velocities, stressed, connected, residual, error)

    def beyond_linear(self, z: FloatArray) -> list[FloatArray]:
        """Displacement of each link beyond the linear one, by finite poses of rigid links.

        Parameters
        ----------
        z : ndarray, shape (N, n)

        Returns
        -------
        list of ndarray, shape (N, n_link)
        """
        rigid, linear = self.frames.rigid, self.frames.link_coordinates(self.motion, z[..., None])
        beyond = [np.zeros(q.shape[:2]) for q in linear]
        if not rigid.size:
            return beyond
        ties = self.frames.displaced_ties(self.motion, z[:, : len(rigid.independent_coordinates)])
        for found, q, of_link in zip(beyond, linear, ties.rows, strict=True):
            for own in of_link:
                if own.place is not None:
                    found[:, own.rows] = own.place - q[:, own.rows, 0]
        return beyond

    def linearized(self, state: OrbitState, damping_rate: float = 0.0) -> SystemMatrices:
        """Matrices of small changes of the motion; each (N, n, n).

        What the elastic motion of bodies' arms would add is left out: Newton's method takes a pass
        more without it, and finds the same. The change of the damping matrix counts near a
        critical speed, where little else holds the motion.
        """
        stressed, connected = self._with_changing_damping(state), state.connected
        turns = [
            [q @ body.rows[2] for body in link.bodies]
            for link, q in zip(self.engine.links, state.displacement, strict=True)
        ]
        if self.frames.rigid.size:
            own = self._displaced(stressed, turns)
        else:
            damping = self._damping(stressed)
            terms = RotationTerms()
            own = self.frames.assemble(self.motion, stressed.tangent, terms, damping, turns=turns)
        damped, stiffness = own.damping + damping_rate * own.mass, own.stiffness
        if connected is not None:
            damped = damped + connected.damping
            stiffness = stiffness + connected.stiffness + connected.rate_stiffness
        return SystemMatrices(own.mass, damped, stiffness)

    def _with_changing_damping(self, state: OrbitState) -> StressedLinks:
        """Stressed links whose tangents have the change of the damping forces."""
        more = self.engine.damping_stiffness(state.displacement, state.rate)
        if more is None:
            return state.stressed
        pairs = zip(state.stressed.tangent, more, strict=True)
        return replace(state.stressed, tangent=[own + other for own, other in pairs])

    def independent(self, displacement: Sequence[FloatArray]) -> FloatArray:
        """Independent coordinates z (N, n) of the displacement of each link, (N, n_link)."""
        columns = [q[..., None] for q in displacement]
        return np.asarray(self.frames.independent(self.motion, columns)[..., 0], dtype=float)

    def at_stations(self, displacement: Sequence[FloatArray]) -> FloatArray:
        """Displacements of all links at their stations, (N, s), in m."""
        moved = [
            np.einsum("scn,bn->bsc", link.shape, q).reshape(len(q), -1)
            for link, q in zip(self.engine.links, displacement, strict=True)
        ]
        return np.concatenate(moved, axis=1)

    def _maps(self, displacement: Sequence[FloatArray]) -> list[FloatArray]:
        """Derivative of each link's coordinates by the independent ones, (N, n_link, n)."""
        ties, maps = self.frames.displaced_ties_by(self.motion, displacement), []
        for number, (q, of_link) in enumerate(zip(displacement, ties.rows, strict=True)):
            own = self.frames.independent_coordinates(number)
            maps.append(np.zeros((*q.shape, self.frames.size)))
            maps[-1][:, own, self.frames.targets[number][own]] = 1.0
            for led in of_link:
                maps[-1][:, led.rows[:, None], led.columns] = led.turn
        return maps

    def _displaced(
        self, stressed: StressedLinks, turns: Sequence[Sequence[FloatArray]]
    ) -> SystemMatrices:
        """As :meth:`linearized`, of displaced rigid links and sliders."""
        assert stressed.displacement is not None
        mass, damping, stiffness = np.zeros((3, *self.mass.shape))
        own_damping = self._damping(stressed)
        for number, by_z in enumerate(self._maps(stressed.displacement)):
            link, back = self.engine.links[number], np.swapaxes(by_z, 1, 2)
            rate, change = (np.tensordot(own, by_z, 1) for own in (self.first, self.second))
            turned, own = link.inertia_change(turns[number]), link.whole()
            own = own if turned is None else own + turned
            omega = self.motion.angular_velocity[:, number, None, None]
            alpha = self.motion.angular_acceleration[:, number, None, None]
            by_rate = 2 * omega * own.gyroscopic + own_damping[number].matrix
            by_place = stressed.tangent[number] + alpha * own.gyroscopic
            by_place = by_place - omega**2 * own.centrifugal_mass
            mass += back @ own.mass @ by_z
            damping += back @ (2 * own.mass @ rate + by_rate @ by_z)
            stiffness += back @ (own.mass @ change + by_rate @ rate + by_place @ by_z)
        if stressed.guide_stiffness is not None:
            stiffness += self.frames.guide_matrix(self.motion, stressed.guide_stiffness)
        return SystemMatrices(mass, damping, stiffness)

    def _connected(self, displacement: Sequence[FloatArray]) -> ConnectedMatrices | None:
        """Stiffness and damping of loads and springs by z at displacements of the links."""
        connectors = self.engine.connectors
        if not connectors.any:
            return None
        maps = self._maps(displacement)
        stiffness, damping, rate_stiffness = np.zeros((3, *self.mass.shape))
        for tangent in connectors.tangents(self.motion, displacement):
            gap = np.zeros((self.samples, 3, self.frames.size))
            for point, sign in ((tangent.second, 1.0), (tangent.first, -1.0)):
                if point is not None:
                    gap += sign * self._place_by_z(point, displacement, maps)
            across = np.swapaxes(gap, 1, 2)
            stiffness += across @ (tangent.stiffness @ gap)
            damping += across @ (tangent.damping @ gap)
            rate_stiffness += across @ (tangent.damping @ np.tensordot(self.first, gap, 1))
        return ConnectedMatrices(stiffness, damping, rate_stiffness, connectors.is_conservative)

    def _place_by_z(
        self, point: AttachedPoint, displacement: Sequence[FloatArray], maps: Sequence[FloatArray]
    ) -> FloatArray:
        """Derivative of a point's place in ground axes, and its rotation, by z; (N, 3, n)."""
        own = point.finite_rows(displacement[point.link]) @ maps[point.link]
        angle = self.motion.angle[:, point.link]
        axes = np.stack([direction(angle), normal(angle)], axis=2)
        return np.concatenate([axes @ own[:, :2], own[:, 2:]], axis=1)

    def _connector_forces(self, moving: Moving) -> list[FloatArray]:
        """Forces (N, n_link) of loads and springs on the coordinates of each link."""
        displacement, rate = [q for q, _, _ in moving], [v for _, v, _ in moving]
        acting, motion = [np.zeros_like(q) for q in displacement], self.motion
        connectors = self.engine.connectors
        for push in (
            *connectors.point_forces(motion, displacement, rate=rate),
            *connectors.radial_forces(motion, displacement, rate),
        ):
            link = push.point.link
            acting[link] += push.point.finite_force(
                motion, push.force, push.torque, displacement[link]
            )
        return acting

    def _forces(self, stressed: StressedLinks, moving: Moving) -> list[FloatArray]:
        """Forces (N, n_link) that are out of balance on each link but for those of its joints."""
        forces, motion, gravity = [], self.motion, self.engine.mechanism.gravity
        assert stressed.internal_force is not None
        damping = self._damping(stressed)
        for number, link in enumerate(self.engine.links):
            elastic = moving[number]
            own = MovingLink.of(number, elastic, motion, motion, np.asarray(gravity))
            force = self._inertias[number].shape_forces(own)
            if not link.rigid:
                force += stressed.internal_force[number]
                force += times(damping[number].matrix, own.rate)
            for body in link.bodies:
                moved = (each @ body.rows.T for each in elastic)
                force += body.nonlinear_inertia(motion, number, gravity, *moved) @ body.rows
            forces.append(force)
        if self.engine.connectors.any:
            acting = self._connector_forces(moving)
            forces = [force - push for force, push in zip(forces, acting, strict=True)]
        return forces

    def _with_rigid_links(
        self, stressed: StressedLinks, forces: Sequence[FloatArray], moving: Moving
    ) -> StressedLinks:
        """Stressed links with the geometric stiffness of rigid ones by all forces on them."""
        assert stressed.displacement is not None
        ties = self.frames.displaced_ties_by(self.motion, stressed.displacement)
        gravity, by_rotation = self.engine.mechanism.gravity, {}
        for number in self.frames.rigid.links:
            body = self.engine.links[number].bodies[0]
            virial, _ = body.dead_moment(self.motion, number, gravity)
            square = self.motion.angular_velocity[:, number] ** 2
            by_rotation[number] = virial - square * body.central_inertia
        displacement, rate = [q for q, _, _ in moving], [v for _, v, _ in moving]
        connectors = self.engine.connectors
        for push in (
            connectors.point_forces(self.motion, displacement, rate=rate) if connectors.any else ()
        ):
            link = push.point.link
            if link in by_rotation:
                arm = push.point.x * direction(
                    self.motion.angle[:, link] + displacement[link][:, 2]
                )
                by_rotation[link] = by_rotation[link] + np.sum(arm * push.force, axis=1)
        found = ties.geometric_stiffness([-force for force in forces], by_rotation)
        tangent = {n: own for n, own in enumerate(stressed.tangent) if n not in by_rotation}
        rigid = with_rigid_links(self.frames, tangent, found)
        return replace(stressed, tangent=rigid.tangent, guide_stiffness=rigid.guide_stiffness)

    def _damping(self, stressed: StressedLinks) -> list[LinkDamping]:
        if stressed.damping is not None:
            return [LinkDamping(own, own) for own in stressed.damping]
        return [LinkDamping(link.damping, link.ends.damping) for link in self.engine.links]

    def _norm(self, force: FloatArray) -> float:
        return float(np.linalg.norm(times(self._half, force)))
