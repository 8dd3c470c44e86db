"""Stress of the links along the motion, sampled and interpolated.

Tangent stiffness and prestress forces are smooth functions of the crank angle. They are
computed at a number of positions and interpolated by cubic splines: a time step every few
hundredths of a degree then needs no equilibrium.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from flexmech.arrays import FloatArray, row_products
from flexmech.linkages import Drive, RigidMotion
from flexmech.mechanics import (
    Engine,
    LinkModel,
    Prestress,
    StressedLinks,
)

# Positions a turn; halving the spacing moves deflections by less than 1e-4 of their peak.
SAMPLES_PER_TURN = 120
# Fewest positions from one corner of a law to the next.
LEAST_OF_A_PIECE = 30


@dataclass(frozen=True)
class LinkStress:
    """Internal force ``prestress + stiffness @ p`` of one link at m instants.

    Parameters
    ----------
    stiffness : ndarray, shape (m, n, n), or (n, n) of straight links
    prestress : ndarray, shape (m, n)
        Internal force at zero coordinates.
    offset : ndarray, shape (m,)
        Energy that does not depend on the coordinates.
    damping : ndarray, shape (m, n, n), or (n, n) of damping that does not vary
    """

    stiffness: FloatArray
    prestress: FloatArray
    offset: FloatArray
    damping: FloatArray

    def force(self, displacement: FloatArray) -> FloatArray:
        """Internal force (m, n) at displacements of shape (m, n)."""
        return self.prestress + _products(self.stiffness, displacement)

    def potential(self, displacement: FloatArray) -> FloatArray:
        """Potential ``offset + prestress . p + p . stiffness p / 2`` at displacements, (m,)."""
        mean = self.prestress + _products(self.stiffness, displacement) / 2
        return self.offset + row_products(mean, displacement)

    def damping_force(self, rate: FloatArray) -> FloatArray:
        """Force of damping at rates of shape (m, n), (m, n)."""
        return _products(self.damping, rate)


def _products(matrices: FloatArray, vectors: FloatArray) -> FloatArray:
    """Symmetric matrices (m, n, n) or (n, n) times vectors (m, n)."""
    if matrices.ndim == 2:
        return np.asarray(vectors @ matrices)
    return np.asarray((matrices @ vectors[..., None])[..., 0])


class _Interpolated:
    """A quantity along the motion by cubic splines through samples.

    Parameters
    ----------
    drive : Drive
    angles : ndarray, shape (a,)
        Crank angles of a turn at which it is sampled; empty where the crank does not turn on.
    times : sequence of ndarray, shape (k,)
        Times of the samples along a law, from each corner to the next.
    values : ndarray, shape (a + b, ...)
        Samples along the turn and those along the law.
    """

    def __init__(
        self, drive: Drive, angles: FloatArray, times: Sequence[FloatArray], values: FloatArray
    ) -> None:
        self._drive = drive
        turn, law = np.split(values, [len(angles)])
        self._turn = self._law = None
        if len(turn):
            # The last position of a turn is the first.
            turn[-1] = turn[0]
            self._turn = scipy.interpolate.CubicSpline(angles, turn, bc_type="periodic")
        if times:
            self._law = _joined(times, law)

    def at(self, time: FloatArray, order: int = 0) -> FloatArray:
        """Values (m, ...) at times of shape (m,), or their derivatives by time."""
        drive, on_law = self._drive, np.ones(len(time), dtype=bool)
        values = None
        if self._turn is not None:
            turned = drive.crank_angle(time) - drive.start_angle
            phase = drive.start_angle + np.mod(turned, 2 * np.pi)
            values = drive.speed**order * self._turn(phase, order)
            on_law = time < drive.law_time
        if self._law is not None and on_law.any():
            # A crank that does not turn on stands after the law, or has come to its end.
            along = self._law(np.minimum(time[on_law], drive.law_time), order)
            if order:
                along[time[on_law] >= drive.law_time] = 0.0
            if values is None:
                return np.asarray(along)
            values[on_law] = along
        return np.asarray(values)


class StressHistory:
    """Stress of reduced links over the time of a run.

    Parameters
    ----------
    engine : Engine
    links : sequence of LinkModel
        Unreduced links of the run.
    bases : sequence of ndarray, shape (n_full, n)
        From each reduced link's coordinates to its full ones.
    drive : Drive
    prestress : {"none", "axial", "equilibrium"}
    equilibrium_of : sequence of ndarray, shape (n_engine, n), optional
        Basis of each link's coordinates in the engine's, of links with second-order stretch: the
        stress is the internal force at the equilibrium less that of the stretch.

    Raises
    ------
    InputError
        Where the linkage locks or cannot be assembled in the course of a turn.
    ComputationError
        Where an equilibrium does not converge.
    """

    def __init__(
        self,
        engine: Engine,
        links: Sequence[LinkModel],
        bases: Sequence[FloatArray],
        drive: Drive,
        prestress: Prestress,
        *,
        equilibrium_of: Sequence[FloatArray] | None = None,
    ) -> None:
        self._engine, self._links = engine, tuple(links)
        self._equilibrium_of = equilibrium_of
        self._bases = tuple(bases)
        self._drive = drive
        self._prestress = prestress
        # Damping changes with the stress only where links are bowed.
        bowed = prestress == "equilibrium" and equilibrium_of is None
        self._damping_varies = engine.has_damped_links and bowed
        self._damping = [
            basis.T @ link.damping @ basis for link, basis in zip(links, bases, strict=True)
        ]
        self._straight, self._histories = None, []
        if prestress == "none" and not engine.mechanism.is_free_strained:
            pairs = zip(links, bases, strict=True)
            self._straight = [basis.T @ link.stiffness @ basis for link, basis in pairs]
            return
        sampled, angles = [], np.zeros(0)
        if drive.turns_on:
            angles = drive.start_angle + np.linspace(0.0, 2 * np.pi, SAMPLES_PER_TURN + 1)
            sampled.append(self._sampled(angles, angles, drive.speed, 0.0))
        times = [] if drive.is_constant and drive.turns_on else _sampled_times(drive)
        if times:
            time = np.concatenate([*(piece[:-1] for piece in times), times[-1][-1:]])
            motion = (
                drive.crank_angle(time),
                drive.crank_speed(time),
                drive.crank_acceleration(time),
            )
            sampled.append(self._sampled(time, *motion))
        values = (np.concatenate(parts) for parts in zip(*sampled, strict=True))
        self._histories = [_Interpolated(drive, angles, times, x) for x in values]

    def at(self, time: FloatArray) -> list[LinkStress]:
        """Stress of each link at times of shape (m,)."""
        return self._of_links(time, order=0)

    def rate(self, time: FloatArray) -> list[LinkStress]:
        """Time derivative of the stress of each link, whose potential is the power by it alone."""
        return self._of_links(time, order=1)

    def _of_links(self, time: FloatArray, order: int) -> list[LinkStress]:
        if self._straight is not None:
            none = np.zeros(len(time))
            return [
                LinkStress(0.0**order * k, np.zeros((len(time), len(k))), none, damping)
                for k, damping in zip(self._straight, self._damping, strict=True)
            ]
        values = [history.at(time, order) for history in self._histories[:-1]]
        count = len(values) // len(self._links)
        return [
            LinkStress(*(*values[count * number :][:count], damping)[:4])
            for number, damping in enumerate(self._damping)
        ]

    def guide_stiffness(self, time: FloatArray) -> FloatArray | None:
        """Geometric stiffness between guides and slides at times of shape (m,), (m, n_sliders)."""
        return None if self._straight is not None else self._histories[-1].at(time)

    def _sampled(
        self,
        where: FloatArray,
        angle: FloatArray,
        speed: float | FloatArray,
        acceleration: float | FloatArray,
    ) -> list[FloatArray]:
        """Stress of all links at k positions, in the order of ``where``; see :meth:`_stresses`."""
        linkage = self._engine.mechanism.linkage
        motion_of = [np.broadcast_to(v, angle.shape) for v in (angle, speed, acceleration)]
        stresses, forces, places = [], [], []
        for batch in self._engine.batches(len(angle)):
            motion = linkage.motion(*(v[batch] for v in motion_of))
            stressed = self._engine.stressed_links(motion, self._prestress)
            if self._equilibrium_of is not None:
                stresses.append(self._equilibrium_correction(stressed, self._equilibrium_of))
                continue
            if (displacement := stressed.displacement) is not None:
                force = self._balanced_forces(motion, stressed)
                stressed = replace(stressed, internal_force=force)
                forces.append(np.concatenate(force, axis=1))
                places.append(np.concatenate(displacement, axis=1))
            stresses.append(self._stresses(stressed))
        values = [np.concatenate(x) for x in zip(*stresses, strict=True)]
        if forces:
            self._add_bending_work(values, where, np.concatenate(forces), np.concatenate(places))
        return values

    def _balanced_forces(self, motion: RigidMotion, stressed: StressedLinks) -> list[FloatArray]:
        """Internal forces at the equilibrium that balance its loads on straight links.

        The engine's balance the loads on arms that are displaced and turned, and the equations of
        a run have those on straight links. The difference, of second order in the displacement, is
        added where it is least, so that the equilibrium has no residual. The rotation of a free
        shaft has one: its torque is that which the motion takes.
        """
        engine, frames = self._engine, self._engine.clamped_frames
        displacement, inner = stressed.displacement, stressed.internal_force
        assert displacement is not None
        assert inner is not None
        loads = engine.equilibrium_forces(motion, displacement)
        missing = [load - force for load, force in zip(loads, inner, strict=True)]
        eye = np.eye(frames.size)
        moved = frames.link_coordinates(motion, np.broadcast_to(eye, (len(loads[0]), *eye.shape)))
        normal = np.sum([np.swapaxes(rows, 1, 2) @ rows for rows in moved], axis=0)
        least = np.linalg.solve(normal, frames.gather(motion, missing)[..., None])
        pairs = zip(inner, moved, strict=True)
        return [force + (rows @ least)[..., 0] for force, rows in pairs]

    def _equilibrium_correction(
        self, stressed: StressedLinks, bases: Sequence[FloatArray]
    ) -> list[FloatArray]:
        """As :meth:`_stresses`: equilibrium forces less those of straight, stretching links.

        What is off the axis of an elastic link, and rigid links, are in natural coordinates.
        """
        places, forces = stressed.displacement, stressed.internal_force
        stretches, parts = self._engine.stretches, []
        assert places is not None
        assert forces is not None
        assert stretches is not None
        for number, link in enumerate(self._engine.links):
            basis, batch = self._bases[number], len(places[number])
            stiffness = basis.T @ self._links[number].stiffness @ basis
            correction = np.zeros((batch, basis.shape[1]))
            off_axis = any(body.is_off_axis for body in link.bodies)
            if not (link.rigid or off_axis or stretches[number].neutral_axis):
                q = places[number].copy()
                sections = np.setdiff1d(np.flatnonzero(link.fields.tangential), link.vectors)
                q[:, sections] = np.sin(q[:, sections])
                straight, _ = stretches[number].nonlinear_forces(q, np.zeros_like(q))
                straight += (link.stiffness @ q.T).T
                correction = (forces[number] - straight) @ bases[number]
            stiff = np.broadcast_to(stiffness, (batch, *stiffness.shape))
            parts += [stiff, correction, np.zeros(batch)]
        return [*parts, np.zeros((batch, 0))]

    def _stresses(self, stressed: StressedLinks) -> list[FloatArray]:
        """Stiffness, prestress, offset and varying damping of all links, of guides the stiffness.

        Each of shape (B, ...).
        """
        assert stressed.motion is not None
        parts, batch = [], len(stressed.motion.crank_angle)
        for number, basis in enumerate(self._bases):
            tangent = stressed.tangent[number]
            prestress, offset = np.zeros((batch, basis.shape[1])), np.zeros(batch)
            if stressed.displacement is not None:
                assert stressed.internal_force is not None
                q, force = stressed.displacement[number], stressed.internal_force[number]
                elastic = (tangent @ q[..., None])[..., 0]
                prestress = (force - elastic) @ basis
                offset = np.sum(q * (elastic / 2 - force), axis=1)
            stiffness = np.broadcast_to(basis.T @ tangent @ basis, (batch, *2 * basis.shape[1:]))
            parts += [stiffness, prestress, offset]
            if self._damping_varies:
                damping = self._damping[number]
                if stressed.damping is not None:
                    damping = basis.T @ stressed.damping[number] @ basis
                parts.append(np.broadcast_to(damping, stiffness.shape))
        guides = stressed.guide_stiffness
        return [*parts, np.zeros((batch, 0)) if guides is None else guides]

    def _add_bending_work(
        self,
        values: list[FloatArray],
        where: FloatArray,
        force: FloatArray,
        place: FloatArray,
    ) -> None:
        """Add the strain energy of the stressed states, the work that led from one to the next."""
        first, count = 0, len(values) // len(self._bases)
        for number, basis in enumerate(self._bases):
            columns = slice(first, first + len(basis))
            path = scipy.interpolate.CubicSpline(where, place[:, columns])
            power = scipy.interpolate.CubicSpline(
                where, np.sum(force[:, columns] * path(where, 1), axis=1)
            )
            energy = power.antiderivative()(where) + force[0, columns] @ place[0, columns] / 2
            values[count * number + 2] += energy
            first = columns.stop


def _sampled_times(drive: Drive) -> list[FloatArray]:
    """Times at which the stress is sampled along a law, from each corner to the next.

    At corners a spline would ring. A rest has two samples.
    """
    if drive.is_constant:
        return [np.array([0.0, 1.0])]
    corners, times = drive.corners, []
    least = max(LEAST_OF_A_PIECE, SAMPLES_PER_TURN // (len(corners) - 1))
    for first, last in itertools.pairwise(corners.tolist()):
        angle = drive.crank_angle(np.linspace(first, last, SAMPLES_PER_TURN + 1))
        turns = float(np.abs(np.diff(angle)).sum()) / (2 * np.pi)
        count = max(least, int(np.ceil(SAMPLES_PER_TURN * turns))) if turns else 1
        times.append(np.linspace(first, last, count + 1))
    return times


def _joined(times: Sequence[FloatArray], values: FloatArray) -> scipy.interpolate.PPoly:
    """Cubic splines through values at times, of which each part begins where the last one ends."""
    splines, first = [], 0
    for time in times:
        splines.append(scipy.interpolate.CubicSpline(time, values[first : first + len(time)]))
        first += len(time) - 1
    places = [spline.x[:-1] for spline in splines]
    coefficients = np.concatenate([spline.c for spline in splines], axis=1)
    return scipy.interpolate.PPoly(coefficients, np.concatenate([*places, splines[-1].x[-1:]]))
