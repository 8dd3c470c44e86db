"""Equations of the periodic motion of links with nonlinear internal forces.

A turn of the crank is sampled at evenly spaced crank angles, and the periodic motion z is
differentiated by its Fourier series (collocation): no time step is taken and no numerical
damping enters. At all samples together ::

    r(z) = M z'' + C z' + K z + N' f_int(q) + N' D(q) q' - f = 0,    q = N z

with M, C and K the inertia of the links in their turning frames (all rotation terms), f the
inertia forces of the rigid motion and the weight, f_int the engine's own internal forces at
large displacements and D its Kelvin-Voigt damping. Inertia is linear in the displacements, but for
bodies and rigid links, whose arms rotate by finite angles. That is exact for Exudyn's cables, whose
coordinates are vectors; sections have the inertia of small rotations against their link frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linear_system import (
    Engine,
    LinkDamping,
    LinkFrames,
    LinkMatrix,
    RotationTerms,
    StressedLinks,
    SystemMatrices,
    inertia_loads,
    whole,
)
from flexmech.linkages import RigidMotion


@dataclass(frozen=True)
class OrbitState:
    """A periodic motion and its residual in the equations of motion.

    Parameters
    ----------
    z : ndarray, shape (N, n)
        Independent coordinates of the unreduced links at the samples.
    displacement : list of ndarray, shape (N, n_link)
        Of each link in its frame.
    stressed : StressedLinks
        At these displacements.
    residual : ndarray, shape (N, n)
        Forces out of balance.
    error : float
        Their norm over that of the loads; see :meth:`OrbitEquations.error`.
    """

    z: FloatArray
    displacement: list[FloatArray]
    stressed: StressedLinks
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
        Inertia forces of the rigid motion, and weight.
    mass : ndarray, shape (N, n, n)
    """

    def __init__(self, engine: Engine, crank_speed: float, samples: int) -> None:
        linkage, links = engine.mechanism.linkage, engine.links
        self.engine, self.samples, self.crank_speed = engine, samples, crank_speed
        self.frames = LinkFrames(linkage.topology, links)
        self.motion: RigidMotion = linkage.motion(
            2 * np.pi / samples * np.arange(samples), np.full(samples, float(crank_speed))
        )
        self.first, self.second = derivatives(samples, crank_speed)
        nothing = [np.zeros((link.size, link.size)) for link in links]
        self._undamped = [LinkDamping(zero, zero) for zero in nothing]
        self._inertia = self.frames.assemble(self.motion, nothing, RotationTerms(), self._undamped)
        self.mass = self._inertia.mass
        loads = inertia_loads(links, self.motion, engine.mechanism.gravity)
        self.load = self.frames.gather(self.motion, loads)
        straight = self.elastic([link.stiffness for link in links])
        self._half = np.linalg.inv(np.linalg.cholesky(straight))
        self._load_norm = self._norm(self.load)

    def elastic(self, tangent: Sequence[LinkMatrix]) -> FloatArray:
        """Stiffness ``N'KN`` of the linkage from those of its links, (N, n, n)."""
        terms = RotationTerms.all_or_none(False)
        return self.frames.assemble(self.motion, tangent, terms, self._undamped).stiffness

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
        stressed = self.engine.running_links(self.motion, [q for q, _, _ in moving])
        assert stressed.internal_force is not None
        forces = [
            force + times(whole(own.matrix), rate)
            for force, own, (_, rate, _) in zip(
                stressed.internal_force, self._damping(stressed), moving, strict=True
            )
        ]
        gravity = self.engine.mechanism.gravity
        for number, (link, moved) in enumerate(zip(self.engine.links, moving, strict=True)):
            for body in link.bodies:
                q, rate, faster = (each @ body.rows.T for each in moved)
                beyond = body.nonlinear_inertia(self.motion, number, gravity, q, rate, faster)
                forces[number] += beyond @ body.rows
        own = self._inertia
        residual = (
            times(own.mass, acceleration + damping_rate * velocity)
            + times(own.damping, velocity)
            + times(own.stiffness, z)
            + self.frames.gather(self.motion, forces)
            - self.load
        )
        displacement = [q for q, _, _ in moving]
        return OrbitState(z, displacement, stressed, residual, self.error(residual))

    def linearized(self, stressed: StressedLinks, damping_rate: float = 0.0) -> SystemMatrices:
        """Matrices of small changes of the motion; each (N, n, n).

        What the change of the damping matrix and the elastic motion of bodies' arms would add is
        left out: Newton's method takes a pass more without it, and finds the same.
        """
        assert stressed.displacement is not None
        turns = [
            [q @ body.rows[2] for body in link.bodies]
            for link, q in zip(self.engine.links, stressed.displacement, strict=True)
        ]
        own = self.frames.assemble(
            self.motion, stressed.tangent, RotationTerms(), self._damping(stressed), turns=turns
        )
        if not damping_rate:
            return own
        return SystemMatrices(own.mass, own.damping + damping_rate * own.mass, own.stiffness)

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

    def _damping(self, stressed: StressedLinks) -> list[LinkDamping]:
        if stressed.damping is not None:
            return [LinkDamping(own, own) for own in stressed.damping]
        return [LinkDamping(link.damping, link.ends.damping) for link in self.engine.links]

    def _norm(self, force: FloatArray) -> float:
        return float(np.linalg.norm(times(self._half, force)))
