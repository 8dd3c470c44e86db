"""The stress of the links along the motion, sampled and interpolated.

Tangent stiffness and prestress forces are smooth functions of the crank angle. They are
computed at a number of positions and interpolated by cubic splines: a step every few
hundredths of a degree then costs no equilibrium of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from flexmech.linear_system import Engine, Prestress, StressedLinks
from flexmech.linkages import CrankDrive
from flexmech.types import FloatArray

__all__ = ["LinkStress", "StressHistory", "times"]


# Positions a turn; halving the spacing moves deflections by less than 1e-4 of their peak.
SAMPLES_PER_TURN = 120
LEAST_SAMPLES = 24


@dataclass(frozen=True)
class LinkStress:
    """Internal force ``prestress + stiffness @ p`` of one reduced link, and its change.

    Its potential is ``offset + prestress . p + p . stiffness p / 2``.

    Parameters
    ----------
    stiffness, stiffness_rate : ndarray, shape (m, n, n), or (n, n) of straight links
    prestress, prestress_rate : ndarray, shape (m, n)
    offset, offset_rate : ndarray, shape (m,)
        Energy that does not depend on p.
    damping : ndarray, shape (n, n) or (m, n, n)
    """

    stiffness: FloatArray
    stiffness_rate: FloatArray
    prestress: FloatArray
    prestress_rate: FloatArray
    offset: FloatArray
    offset_rate: FloatArray
    damping: FloatArray

    def potential(self, displacement: FloatArray) -> FloatArray:
        """Strain energy at displacements p of shape (m, n); (m,)."""
        return _potential(self.stiffness, self.prestress, self.offset, displacement)

    def power(self, displacement: FloatArray) -> FloatArray:
        """What the change of the stress alone adds to the potential a second; (m,)."""
        return _potential(self.stiffness_rate, self.prestress_rate, self.offset_rate, displacement)


class StressHistory:
    """Stress of reduced links over the time of a run.

    Parameters
    ----------
    engine : Engine
    bases : sequence of ndarray, shape (n_full, n)
        From each reduced link's coordinates to its full ones.
    drive : CrankDrive
    prestress : {"none", "axial", "equilibrium"}
    with_energy : bool
        Whether the potential's part that does not depend on the links' coordinates is
        wanted; an engine must tell its internal forces for that.

    Attributes
    ----------
    tells_forces : bool
        Whether ``prestress`` contains the internal forces of the stressed state. If not it
        is ``-stiffness @ displacement`` alone, and the loads that they balance must be left
        out with them.

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
        bases: Sequence[FloatArray],
        drive: CrankDrive,
        prestress: Prestress,
        *,
        with_energy: bool = True,
    ) -> None:
        self._engine = engine
        self._bases = tuple(bases)
        self._drive = drive
        self._prestress = prestress
        self._with_energy = with_energy
        self.tells_forces = True
        self._sizes = [basis.shape[1] for basis in bases]
        # Damping changes with the stress only where links are bowed.
        damped = any(link.damping.any() for link in engine.links)
        self._damping_varies = damped and prestress == "equilibrium"
        self._damping = [
            basis.T @ link.damping @ basis for link, basis in zip(engine.links, bases, strict=True)
        ]
        self._turn: Callable[..., FloatArray] | None = None
        self._rise: Callable[..., FloatArray] | None = None
        if prestress == "none" and not engine.mechanism.is_free_strained:
            self._straight = [
                basis.T @ link.stiffness @ basis
                for link, basis in zip(engine.links, bases, strict=True)
            ]
            return
        angles = drive.start_angle + np.linspace(0.0, 2 * np.pi, SAMPLES_PER_TURN + 1)
        self._turn = self._spline(angles, angles, drive.speed, 0.0, closed=True)
        if not drive.is_constant:
            time = self._run_up_times()
            self._rise = self._spline(
                time,
                drive.crank_angle(time),
                drive.crank_speed(time),
                drive.crank_acceleration(time),
                closed=False,
            )

    def at(self, time: FloatArray) -> list[LinkStress]:
        """Stress of each link at times of shape (m,)."""
        if self._turn is None:
            return [
                _unstressed(stiffness, damping, len(time))
                for stiffness, damping in zip(self._straight, self._damping, strict=True)
            ]
        drive = self._drive
        turned = drive.crank_angle(time) - drive.start_angle
        phase = drive.start_angle + np.mod(turned, 2 * np.pi)
        values, rates = self._turn(phase), drive.speed * self._turn(phase, 1)
        rising = time < drive.run_up_time
        if self._rise is not None and rising.any():
            values[rising] = self._rise(time[rising])
            rates[rising] = self._rise(time[rising], 1)
        result, start = [], 0
        for size, damping in zip(self._sizes, self._damping, strict=True):
            part = slice(start, start + self._width(size))
            stress = _unpacked(values[:, part], rates[:, part], size, damping)
            result.append(stress)
            start = part.stop
        return result

    def _width(self, size: int) -> int:
        """Columns of one link: stiffness, prestress, offset and perhaps damping."""
        square = size * size
        return square + size + 1 + (square if self._damping_varies else 0)

    def _run_up_times(self) -> FloatArray:
        drive = self._drive
        turns = abs(drive.crank_angle(drive.run_up_time) - drive.start_angle) / (2 * np.pi)
        count = max(LEAST_SAMPLES, SAMPLES_PER_TURN, int(np.ceil(SAMPLES_PER_TURN * turns)))
        return np.linspace(0.0, drive.run_up_time, count + 1)

    def _spline(
        self,
        where: FloatArray,
        angle: FloatArray,
        speed: float | FloatArray,
        acceleration: float | FloatArray,
        *,
        closed: bool,
    ) -> CubicSpline:
        """Spline over ``where``, batch by batch; the last position of a turn is the first."""
        linkage = self._engine.mechanism.linkage
        motion_of = [np.broadcast_to(v, angle.shape) for v in (angle, speed, acceleration)]
        packed, forces, places = [], [], []
        for start in range(0, len(angle), self._engine.batch_size):
            batch = slice(start, start + self._engine.batch_size)
            motion = linkage.motion(*(v[batch] for v in motion_of))
            stressed = self._engine.stressed_links(motion, self._prestress)
            packed.append(self._packed(stressed, len(motion.crank_angle)))
            if stressed.displacement is not None and stressed.internal_force is None:
                self.tells_forces = False
            if self._with_energy and stressed.internal_force is not None:
                forces.append(np.concatenate(stressed.internal_force, axis=1))
                places.append(np.concatenate(stressed.displacement or [], axis=1))
        values = np.concatenate(packed)
        if forces:
            self._add_bending_work(values, where, np.concatenate(forces), np.concatenate(places))
        if closed:
            values[-1] = values[0]
        return CubicSpline(where, values, bc_type="periodic" if closed else "not-a-knot")

    def _packed(self, stressed: StressedLinks, batch: int) -> FloatArray:
        """Stiffness, prestress and offset of all links side by side, (B, total)."""
        columns = []
        for number, basis in enumerate(self._bases):
            tangent = stressed.tangent[number]
            prestress, offset = np.zeros((batch, basis.shape[1])), np.zeros((batch, 1))
            if stressed.displacement is not None:
                q = stressed.displacement[number]
                held = (tangent @ q[..., None])[..., 0]
                force = stressed.internal_force
                prestress = ((0.0 if force is None else force[number]) - held) @ basis
                offset = np.sum(q * held, axis=1, keepdims=True) / 2
                if force is not None:
                    offset -= np.sum(q * force[number], axis=1, keepdims=True)
            stiffness = np.broadcast_to(basis.T @ tangent @ basis, (batch, *2 * basis.shape[1:]))
            columns += [stiffness.reshape(batch, -1), prestress, offset]
            if self._damping_varies:
                damping = self._damping[number]
                if stressed.damping is not None:
                    damping = basis.T @ stressed.damping[number] @ basis
                columns.append(np.broadcast_to(damping, stiffness.shape).reshape(batch, -1))
        return np.concatenate(columns, axis=1)

    def _add_bending_work(
        self, values: FloatArray, where: FloatArray, force: FloatArray, place: FloatArray
    ) -> None:
        """Add the strain energy of the stressed states, the work that led from one to the next."""
        start, first = 0, 0
        for size, basis in zip(self._sizes, self._bases, strict=True):
            own = slice(first, first + len(basis))
            path = CubicSpline(where, place[:, own])
            power = CubicSpline(where, np.sum(force[:, own] * path(where, 1), axis=1))
            energy = power.antiderivative()(where) + force[0, own] @ place[0, own] / 2
            values[:, start + size * size + size] += energy
            start += self._width(size)
            first = own.stop


def _unstressed(stiffness: FloatArray, damping: FloatArray, count: int) -> LinkStress:
    """Straight links without stress, at any number of instants."""
    nothing = np.zeros((count, len(stiffness)))
    return LinkStress(
        stiffness=stiffness,
        stiffness_rate=np.zeros_like(stiffness),
        prestress=nothing,
        prestress_rate=nothing,
        offset=nothing[:, 0],
        offset_rate=nothing[:, 0],
        damping=damping,
    )


def _unpacked(values: FloatArray, rates: FloatArray, size: int, damping: FloatArray) -> LinkStress:
    """Stress of one link; ``damping`` is that of the straight link, where it does not vary."""
    square, last = size * size, size * size + size
    shape = (-1, size, size)
    varying = values[:, last + 1 :]
    return LinkStress(
        stiffness=values[:, :square].reshape(shape),
        stiffness_rate=rates[:, :square].reshape(shape),
        prestress=values[:, square:last],
        prestress_rate=rates[:, square:last],
        offset=values[:, last],
        offset_rate=rates[:, last],
        damping=varying.reshape(shape) if varying.shape[1] else damping,
    )


def times(matrix: FloatArray, vectors: FloatArray) -> FloatArray:
    """A symmetric matrix (n, n), or one for each of m (m, n, n), times vectors (m, n)."""
    if matrix.ndim == 2:
        return np.asarray(vectors @ matrix)
    return np.asarray((matrix @ vectors[..., None])[..., 0])


def _potential(
    stiffness: FloatArray, prestress: FloatArray, offset: FloatArray, p: FloatArray
) -> FloatArray:
    force = prestress + times(stiffness, p) / 2
    return np.asarray(offset + np.einsum("mi,mi->m", force, p))
