"""Stress of the links along the motion, sampled and interpolated.

Tangent stiffness and prestress forces are smooth functions of the crank angle. They are
computed at a number of positions and interpolated by cubic splines: a time step every few
hundredths of a degree then needs no equilibrium. They are sums of few distributions
(:class:`LinkStress`), of which only the amplitudes are interpolated.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from flexmech.arrays import FloatArray
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
# What the distributions of stress leave out, relative to the greatest: some fifty times the unit
# round-off of the values that they are made of. At 1e-6 deflections change by 1e-5 of their peak.
LEFT_OUT = 1e-14


@dataclass(frozen=True)
class StressShapes:
    """Distributions of stress in one reduced link, r of them.

    Parameters
    ----------
    stiffness : ndarray, shape (r, n, n)
    prestress : ndarray, shape (r, n)
    offset : ndarray, shape (r,)
        Energy that does not depend on the coordinates.
    damping : ndarray, shape (r, n, n), or (n, n) of damping that does not vary
    """

    stiffness: FloatArray
    prestress: FloatArray
    offset: FloatArray
    damping: FloatArray


@dataclass(frozen=True)
class LinkStress:
    """Internal force ``prestress + stiffness @ p`` of one link at m instants, and its rate.

    Its potential is ``offset + prestress . p + p . stiffness p / 2``.

    Parameters
    ----------
    shapes : StressShapes
    share, share_rate : ndarray, shape (m, r)
        Amplitude of each distribution, and its time derivative.
    """

    shapes: StressShapes
    share: FloatArray
    share_rate: FloatArray

    @property
    def stiffness(self) -> FloatArray:
        """Stiffness matrix, (m, n, n)."""
        return np.tensordot(self.share, self.shapes.stiffness, 1)

    @property
    def prestress(self) -> FloatArray:
        """Internal force at zero coordinates, (m, n)."""
        return np.asarray(self.share @ self.shapes.prestress)

    @property
    def damping(self) -> FloatArray:
        """Damping matrix, (n, n), or (m, n, n) where it varies."""
        damping = self.shapes.damping
        return damping if damping.ndim == 2 else np.tensordot(self.share, damping, 1)

    def of(self, displacement: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Internal force, potential, and power by the change of the stress alone.

        Parameters
        ----------
        displacement : ndarray, shape (m, n)

        Returns
        -------
        tuple of ndarray, shape (m, n), (m,) and (m,)
        """
        shapes = self.shapes
        pulled = _times_each(displacement, shapes.stiffness)
        work = np.einsum("mrn,mn->mr", pulled, displacement) / 2
        work += displacement @ shapes.prestress.T + shapes.offset
        force = self.prestress + np.einsum("mr,mrn->mn", self.share, pulled)
        potential, power = (np.einsum("mr,mr->m", s, work) for s in (self.share, self.share_rate))
        return force, potential, power

    def damping_force(self, rate: FloatArray) -> FloatArray:
        """Force of damping at rates of shape (m, n), (m, n)."""
        damping = self.shapes.damping
        if damping.ndim == 2:
            return np.asarray(rate @ damping)
        return np.asarray(np.einsum("mr,mrn->mn", self.share, _times_each(rate, damping)))


def _times_each(vectors: FloatArray, matrices: FloatArray) -> FloatArray:
    """Vectors (m, n) times each of r symmetric matrices (r, n, n); (m, r, n)."""
    side_by_side = np.moveaxis(matrices, 0, 1).reshape(matrices.shape[1], -1)
    return np.asarray(vectors @ side_by_side).reshape(len(vectors), *matrices.shape[:2])


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
        damped = any(link.damping.any() for link in links)
        self._damping_varies = damped and prestress == "equilibrium" and equilibrium_of is None
        self._damping = [
            basis.T @ link.damping @ basis for link, basis in zip(links, bases, strict=True)
        ]
        self._guide_stiffness: FloatArray | None = None
        self._turn: scipy.interpolate.CubicSpline | None = None
        self._rise: scipy.interpolate.PPoly | None = None
        if prestress == "none" and not engine.mechanism.is_free_strained:
            pairs = zip(links, bases, strict=True)
            straight = [basis.T @ link.stiffness @ basis for link, basis in pairs]
            self._shapes = [
                StressShapes(k[None], np.zeros((1, len(k))), np.zeros(1), damping)
                for k, damping in zip(straight, self._damping, strict=True)
            ]
            return
        sampled = []
        angles = drive.start_angle + np.linspace(0.0, 2 * np.pi, SAMPLES_PER_TURN + 1)
        if drive.turns_on:
            sampled.append(self._sampled(angles, angles, drive.speed, 0.0))
        rises = [] if drive.is_constant and drive.turns_on else _sampled_times(drive)
        if rises:
            time = np.concatenate([*(rise[:-1] for rise in rises), rises[-1][-1:]])
            motion = (
                drive.crank_angle(time),
                drive.crank_speed(time),
                drive.crank_acceleration(time),
            )
            sampled.append(self._sampled(time, *motion))
        share, shapes = _low_rank_factors([np.concatenate(x) for x in zip(*sampled, strict=True)])
        *of_links, self._guide_stiffness = shapes
        count = len(of_links) // len(links)
        self._shapes = [
            StressShapes(*(*of_links[count * number :][:count], damping)[:4])
            for number, damping in enumerate(self._damping)
        ]
        if drive.turns_on:
            turn = share[: len(angles)]
            # The last position of a turn is the first.
            turn[-1] = turn[0]
            self._turn = scipy.interpolate.CubicSpline(angles, turn, bc_type="periodic")
            share = share[len(angles) :]
        if rises:
            self._rise = _joined(rises, share)

    def at(self, time: FloatArray) -> list[LinkStress]:
        """Stress of each link at times of shape (m,)."""
        share, rate = self._shares(time)
        return [LinkStress(shapes, share, rate) for shapes in self._shapes]

    def guide_stiffness(self, time: FloatArray) -> FloatArray | None:
        """Geometric stiffness between guides and slides at times of shape (m,), (m, n_sliders)."""
        if self._guide_stiffness is None or not self._guide_stiffness.any():
            return None
        return np.asarray(self._shares(time)[0] @ self._guide_stiffness)

    def _shares(self, time: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Amplitudes of the distributions of stress, and their rates, (m, r)."""
        drive = self._drive
        if self._turn is None and self._rise is None:
            return np.ones((len(time), 1)), np.zeros((len(time), 1))
        rising = np.ones(len(time), dtype=bool)
        if self._turn is not None:
            turned = drive.crank_angle(time) - drive.start_angle
            phase = drive.start_angle + np.mod(turned, 2 * np.pi)
            share, rate = self._turn(phase), drive.speed * self._turn(phase, 1)
            rising = time < drive.law_time
        if self._rise is not None and rising.any():
            # A crank that does not turn on stands after the law, or has come to its end.
            inside = np.minimum(time[rising], drive.law_time)
            own, own_rate = self._rise(inside), self._rise(inside, 1)
            own_rate[time[rising] >= drive.law_time] = 0.0
            if self._turn is None:
                return own, own_rate
            share[rising], rate[rising] = own, own_rate
        return share, rate

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
            own, batch = self._bases[number], len(places[number])
            stiffness = own.T @ self._links[number].stiffness @ own
            correction = np.zeros((batch, own.shape[1]))
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
            own = slice(first, first + len(basis))
            path = scipy.interpolate.CubicSpline(where, place[:, own])
            power = scipy.interpolate.CubicSpline(
                where, np.sum(force[:, own] * path(where, 1), axis=1)
            )
            energy = power.antiderivative()(where) + force[0, own] @ place[0, own] / 2
            values[count * number + 2] += energy
            first = own.stop


def _sampled_times(drive: Drive) -> list[FloatArray]:
    """Times at which the stress is sampled along a law, from each corner to the next.

    At corners a spline would ring. A rest has two samples.
    """
    if drive.is_constant:
        return [np.array([0.0, 1.0])]
    corners, found = drive.corners, []
    least = max(LEAST_OF_A_PIECE, SAMPLES_PER_TURN // (len(corners) - 1))
    for first, last in itertools.pairwise(corners.tolist()):
        angle = drive.crank_angle(np.linspace(first, last, SAMPLES_PER_TURN + 1))
        turns = float(np.abs(np.diff(angle)).sum()) / (2 * np.pi)
        count = max(least, int(np.ceil(SAMPLES_PER_TURN * turns))) if turns else 1
        found.append(np.linspace(first, last, count + 1))
    return found


def _joined(times: Sequence[FloatArray], values: FloatArray) -> scipy.interpolate.PPoly:
    """Cubic splines through values at times, of which each part begins where the last one ends."""
    splines, first = [], 0
    for time in times:
        splines.append(scipy.interpolate.CubicSpline(time, values[first : first + len(time)]))
        first += len(time) - 1
    places = [spline.x[:-1] for spline in splines]
    coefficients = np.concatenate([spline.c for spline in splines], axis=1)
    return scipy.interpolate.PPoly(coefficients, np.concatenate([*places, splines[-1].x[-1:]]))


def _low_rank_factors(values: Sequence[FloatArray]) -> tuple[FloatArray, list[FloatArray]]:
    """Low-rank factors of arrays (k, ...): amplitudes (k, r) and distributions (r, ...).

    Gram-Schmidt orthogonalization that takes the greatest remainder first, each array measured by
    its greatest value.
    """
    flat = [part.reshape(len(part), -1) for part in values]
    widths = [part.shape[1] for part in flat]
    scale = np.repeat([np.abs(part).max(initial=0.0) or 1.0 for part in flat], widths)
    rest, shares, shapes = np.concatenate(flat, axis=1) / scale, [], []
    least = LEFT_OUT * np.linalg.norm(rest, axis=1).max()
    while (size := np.linalg.norm(rest, axis=1)).max() > least:
        shape = rest[size.argmax()] / size.max()
        share = rest @ shape
        rest -= share[:, None] * shape
        shares.append(share)
        shapes.append(shape * scale)
    parts = np.split(np.array(shapes), np.cumsum(widths)[:-1], axis=1)
    pairs = zip(parts, values, strict=True)
    shaped = [np.ascontiguousarray(x).reshape(len(x), *whole.shape[1:]) for x, whole in pairs]
    return np.stack(shares, axis=1), shaped
