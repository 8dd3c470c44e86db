"""Forced periodic motion of the running linkage in its moving modes.

The transfer from a force at one point to a displacement at another takes both in the axes of their
links' rigid frames. The truncated modes, all
faster than the moving modes, respond statically (residual flexibility): by the flexibility of the
links at each crank angle less that of the moving modes.

The linear equations of :mod:`flexmech.mechanics.running.driven_linkage` are sought in
the moving modes of :mod:`flexmech.solvers.moving_modes`. The loads are the
inertia forces of the rigid motion, the weight, and forces of loads and springs that repeat
themselves every turn; the response beyond the moving modes is static. Damping enters link by link
in proportion to the damping of the model, so that other damping costs no new model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from flexmech.arrays import FloatArray, row_products
from flexmech.choices import LinkDirection
from flexmech.dynamical_systems import (
    ON_A_STEP,
    ForcedPeriodicSystem,
    FourierSeries,
    SampledPeriodicSystem,
    transition_matrices,
)
from flexmech.mechanics import (
    CarriedLinkage,
    Engine,
    LinkFrames,
    LinkPoint,
    Prestress,
    RotationTerms,
    StressedLinks,
    displacement_row,
    in_positions,
)
from flexmech.mechanics.running.driven_connectors import DrivenConnectors
from flexmech.solvers.moving_modes import (
    MovingModes,
    counts_of_modes,
    moving_modes,
)
from flexmech.solvers.sampled_turn import SampledTurn
from flexmech.solvers.shooting import CRITICAL

# Crank angles whose unreduced matrices are in memory at a time. Memory alone.
BATCH = 64


def forced_linkage(
    moving: MovingModes,
    stressed: StressedLinks,
    hit: LinkPoint,
    seen: LinkPoint,
    direction: LinkDirection = "transverse",
    connected: FloatArray | None = None,
) -> ForcedPeriodicSystem:
    """Periodic system of the linkage with a force as input and a displacement as output.

    Parameters
    ----------
    moving : MovingModes
    stressed : StressedLinks
        The unreduced links at the crank angles of its turn.
    hit, seen : LinkPoint
        Where the force acts, and where the displacement is read.
    direction : {"transverse", "axial"}
        Direction of both, in the axes of their links' frames.
    connected : ndarray, shape (N, size, size), optional
        Stiffness of loads and springs in the coordinates of the unreduced links.

    Returns
    -------
    ForcedPeriodicSystem
        From N to m. Phases count from crank angle 0. The residual flexibility is
        ``g' K^-1 f - (P' g)' (P' K P)^-1 P' f`` without rotation terms.

    Raises
    ------
    InputError
        If the linkage has no such link.
    """
    turn, size = moving.turn, moving.size
    into, out = (_row(moving, point, direction) for point in (hit, seen))
    force, reading = np.zeros((2, len(into), 2 * size))
    root = np.sqrt(moving.scale)
    force[:, size:] = into / root
    reading[:, :size] = out / root
    # Zero where the moving modes are all coordinates.
    frames, remainder = LinkFrames(turn.frames.topology, turn.unreduced), np.zeros(len(into))
    if size < frames.size + turn.size - turn.frames.size:
        modal_stiffness = np.swapaxes(moving.basis, 1, 2) @ _stiffness(turn) @ moving.basis
        remainder -= (out * np.linalg.solve(modal_stiffness, into[..., None])[..., 0]).sum(axis=1)
        remainder += _flexibility(turn, frames, stressed, (hit, seen), direction, connected)
    return ForcedPeriodicSystem(moving.system(), *map(turn.series, (force, reading, remainder)))


def _flexibility(
    turn: SampledTurn,
    frames: LinkFrames,
    stressed: StressedLinks,
    points: tuple[LinkPoint, LinkPoint],
    direction: LinkDirection,
    connected: FloatArray | None,
) -> FloatArray:
    """Displacement (N,) of the second point by a unit force on the first, of unreduced links."""
    places = [point.index(frames.topology) for point in points]
    force, row = (
        displacement_row(turn.unreduced[place], point.fraction, direction)
        for place, point in zip(places, points, strict=True)
    )
    flexibility = np.empty(len(turn.motion.crank_angle))
    carried = turn.carried
    if carried is not None:
        carried = CarriedLinkage.of(carried.mechanism, frames, turn.unreduced)
    for first in range(0, len(flexibility), BATCH):
        batch = slice(first, first + BATCH)
        motion = turn.displaced.at(batch)
        tangent = [in_positions(t, batch) for t in stressed.tangent]
        frozen = RotationTerms.all_or_none(False)
        matrices = frames.assemble(motion, tangent, frozen)
        if connected is not None:
            matrices = replace(matrices, stiffness=matrices.stiffness + connected[batch])
        loads, read = ([np.zeros(link.size) for link in turn.unreduced] for _ in range(2))
        loads[places[0]], read[places[1]] = force, row
        pushed = [np.tile(load, (len(matrices.mass), 1)) for load in loads]
        right = frames.gather(motion, pushed)
        if carried is not None:
            matrices = carried.added(motion, matrices, frozen)
            right = np.concatenate([right, carried.on_frame(motion, loads)], axis=1)
        moved = np.linalg.solve(matrices.stiffness, right[..., None])
        of_links, of_frame = moved[:, : frames.size], np.asarray(moved[:, frames.size :, 0])
        flexibility[batch] = frames.link_coordinates(motion, of_links)[places[1]][..., 0] @ row
        if carried is not None:
            flexibility[batch] += row_products(carried.on_frame(motion, read), of_frame)
    return flexibility


def _stiffness(turn: SampledTurn) -> FloatArray:
    """Stiffness of the reduced links, with that of forces without a potential, (N, n, n)."""
    if turn.connected is None:
        return turn.stiffness
    return turn.stiffness + turn.connected.circulatory


def _row(moving: MovingModes, point: LinkPoint, direction: LinkDirection) -> FloatArray:
    """Displacement of a point in the coordinates y of the moving modes, (N, m)."""
    turn = moving.turn
    number = point.index(turn.frames.topology)
    row = displacement_row(turn.unreduced[number], point.fraction, direction)
    rows = row @ turn.bases[number] @ turn.link_coordinates(moving.basis)[number]
    if turn.carried is not None:
        loads = [np.zeros(link.size) for link in turn.unreduced]
        loads[number] = row
        on_frame = turn.carried.on_frame(turn.motion, loads)[:, None]
        rows = rows + (on_frame @ moving.basis[:, turn.frames.size :])[:, 0]
    return np.asarray(rows)


Readings = Sequence[Sequence[FloatArray | None]]

# Crank angles of a turn, one every two degrees: motions are then those of the full equations to
# 2e-3, which the higher modes leave; with 31 they are not. An odd number leaves no harmonic whose
# phase is unknown.
SAMPLES = 181
# Steps of the transition matrices in a period of the fastest moving mode. Readings between them
# are those of a cubic spline: off by (2 pi / 12)^4 / 384 = 2e-4 of the fastest mode's part, which
# hardly moves.
STEPS_A_PERIOD = 12
# And of a turn: two a degree, which shows its loads up to the 60th harmonic as well.
LEAST_STEPS = 720
# Modes besides the requested ones, where links do not rotate against each other and any number is
# smooth. The truncated modes respond statically.
SPARE_MODES = 2


@dataclass(frozen=True)
class ForcedModes:
    """A running linkage of n_links links in m moving modes, with its loads and outputs.

    Parameters
    ----------
    moving : MovingModes
    damping : tuple of FourierSeries
        What each link's damping adds to the system's matrix (2 m, 2 m).
    force : FourierSeries
        Force of the loads in the states, (2 m,).
    rows : FourierSeries
        From the states to the readings, (r, 2 m).
    offset : FourierSeries
        Readings of what follows statically, (r,).
    """

    moving: MovingModes
    damping: tuple[FourierSeries, ...]
    force: FourierSeries
    rows: FourierSeries
    offset: FourierSeries

    def frequency_ranges(self) -> FloatArray:
        """Least and greatest frozen natural frequency of each moving mode in Hz, (m, 2)."""
        squares = np.maximum(self.moving.turn.frozen_squares[:, : self.moving.size], 0.0)
        hertz = np.sqrt(squares) / (2 * np.pi)
        return np.stack([hertz.min(axis=0), hertz.max(axis=0)], axis=1)

    def with_damping(self, factors: Sequence[float]) -> FreeAndForced:
        """Free and forced motion with each link's damping times a factor.

        Parameters
        ----------
        factors : sequence of float
            One for each link, in the topology's order.

        Returns
        -------
        FreeAndForced
        """
        matrix = self.moving.with_undamped_links
        for series, factor in zip(self.damping, factors, strict=True):
            matrix = matrix.plus(series, factor)
        n, turn = 2 * self.moving.size, self.moving.turn
        # A state that stays one carries the loads.
        harmonics = len(matrix.coefficients), len(self.force.coefficients)
        whole = np.zeros((max(harmonics), n + 1, n + 1), dtype=complex)
        whole[: harmonics[0], :n, :n] = matrix.coefficients
        whole[: harmonics[1], :n, n] = self.force.coefficients
        series = FourierSeries(whole)
        # Periods of the fastest moving mode in a turn.
        fastest = np.sqrt(turn.frozen_squares[:, self.moving.size - 1].max())
        periods = turn.period * float(fastest) / (2 * np.pi)
        steps = max(LEAST_STEPS, int(np.ceil(STEPS_A_PERIOD * periods)))
        return FreeAndForced(
            transitions=transition_matrices(SampledPeriodicSystem(series, turn.period), steps),
            rows=self.rows.samples(steps),
            offset=self.offset.samples(steps),
        )


@dataclass(frozen=True)
class FreeAndForced:
    """Motion of a running linkage from any crank angle on.

    Parameters
    ----------
    transitions : ndarray, shape (steps, n + 1, n + 1)
        Transitions of the states and a one, for each step of a turn.
    rows : ndarray, shape (steps, r, n)
        Readings of the states at the beginning of each step.
    offset : ndarray, shape (steps, r)
        What is read besides.
    """

    transitions: FloatArray
    rows: FloatArray
    offset: FloatArray

    def readings(self, phase: FloatArray, reading: int = 0) -> tuple[FloatArray, FloatArray]:
        """Readings at phases of the crank, of a motion that begins with the first of them.

        Parameters
        ----------
        phase : ndarray, shape (N,)
            Turns of the crank since crank angle zero in the order of time, increasing.
        reading : int

        Returns
        -------
        ndarray, shape (N,)
            Reading of the periodic motion.
        ndarray, shape (N, n)
            Readings of the free motions from a unit of each state at the beginning.
        """
        steps, size = len(self.transitions), self.transitions.shape[1]
        first = int(np.floor(phase[0] * steps + ON_A_STEP))
        order = (first + np.arange(steps + 1)) % steps
        states = np.empty((steps + 1, size, size))
        states[0] = np.eye(size)
        for index, step in enumerate(order[:-1]):
            np.matmul(self.transitions[step], states[index], out=states[index + 1])
        row, n = self.rows[order, reading], size - 1
        turn = states[-1]
        # Without damping a critical speed has no periodic motion, and any other motion is as good.
        start = np.linalg.lstsq(np.eye(n) - turn[:n, :n], turn[:n, n], rcond=CRITICAL)[0]
        forced_states = states[:, :n] @ np.append(start, 1.0)
        gap = forced_states[-1] - forced_states[0]
        free = np.einsum("kn,knj->kj", row, states[:, :n, :n])
        periodic = np.einsum("kn,kn->k", row, forced_states) + self.offset[order, reading]
        # A phase that round-off puts before its step begins with it.
        along = np.maximum(phase * steps - first, 0.0)
        turns = np.floor(along / steps).astype(int)
        within = along - turns * steps
        grid = np.arange(steps + 1.0)
        of_state = scipy.interpolate.CubicSpline(grid, free)(within)
        forced = scipy.interpolate.CubicSpline(grid, periodic)(within)
        motions = np.empty_like(of_state)
        power, drift = np.eye(n), np.zeros(n)
        for number in range(int(turns[-1]) + 1):
            now = turns == number
            motions[now] = of_state[now] @ power
            forced[now] += of_state[now] @ drift
            power = turn[:n, :n] @ power
            drift = turn[:n, :n] @ drift + gap
        return forced, motions

    def slowest(self, phase: float, count: int) -> FloatArray:
        """States in which alone the slowest frozen modes at a phase vibrate, (n, count).

        The states are amplitudes in a smooth basis, whose vectors are no modes one by one.

        Parameters
        ----------
        phase : float
            As of :meth:`readings`.
        count : int
            Twice the number of modes.
        """
        steps, n = len(self.transitions), self.transitions.shape[1] - 1
        first = int(np.floor(phase * steps + ON_A_STEP)) % steps
        # Those of a short step have the vectors of the system's matrix.
        values, vectors = np.linalg.eig(self.transitions[first, :n, :n])
        order = np.argsort(np.abs(np.log(values.astype(complex))), kind="stable")[:count]
        both = np.concatenate([vectors.real[:, order], vectors.imag[:, order]], axis=1)
        spanned, _, _ = np.linalg.svd(both, full_matrices=False)
        return np.asarray(spanned[:, :count])


def forced_modes(
    engine: Engine,
    crank_speed: float,
    readings: Readings,
    prestress: Prestress = "equilibrium",
    modes: int = 4,
) -> ForcedModes:
    """Project a running linkage and its loads onto its moving modes.

    Parameters
    ----------
    engine : Engine
        Engine of a mechanism whose links are damped as they shall be for the factor one.
    crank_speed : float
        In rad/s; not zero.
    readings : sequence of sequence of ndarray, shape (n_full,), or None
        What is read, r of them: a row for each link in its unreduced coordinates, None where
        nothing is read of a link.
    prestress : {"none", "axial", "equilibrium"}
        About which quasi-static state the equations are linear.
    modes : int
        Natural frequencies that count; a few more moving modes are taken, so that their
        subspace is smooth.

    Returns
    -------
    ForcedModes

    Raises
    ------
    InputError
        Where the linkage cannot be assembled or locks.
    ComputationError
        If there is no equilibrium.
    """
    order = np.arange(SAMPLES) if crank_speed > 0 else -np.arange(SAMPLES) % SAMPLES
    motion = engine.mechanism.linkage.motion(2 * np.pi / SAMPLES * order, crank_speed)
    stressed = engine.stressed_links(motion, prestress)
    DrivenConnectors(engine, engine.frames).require_periodic()
    turn = SampledTurn.of(engine, motion, stressed, prestress, modes)
    count = min(modes + SPARE_MODES, turn.size)
    if turn.has_relative_motion:
        count = counts_of_modes(turn, modes, 1)[0]
    moving = moving_modes(turn, count)
    force = turn.frames.gather(turn.displaced, _loads(engine, turn, stressed))
    if turn.carried is not None:
        force = np.concatenate([force, turn.carried.load(motion)], axis=1)
    force += _of_connectors(turn, stressed)
    modal = np.einsum("kni,kn->ki", moving.basis, force)
    shapes = np.concatenate([moving.basis, _rest(moving, force, modal)], axis=2)
    read = _read(turn, readings, shapes)
    root = np.sqrt(moving.scale)
    states = np.zeros((SAMPLES, 2 * count))
    states[:, count:] = modal / root
    rows = np.zeros((SAMPLES, len(readings), 2 * count))
    rows[..., :count] = read[..., :count] / root
    return ForcedModes(
        moving,
        _link_damping(moving),
        FourierSeries.through(states),
        FourierSeries.through(rows),
        FourierSeries.through(read[..., count]),
    )


def _link_damping(moving: MovingModes) -> tuple[FourierSeries, ...]:
    """Contribution of each link's damping to the system's matrix."""
    turn = moving.turn
    nothing = [np.zeros_like(matrix) for matrix in turn.damping]
    series = []
    for number, matrix in enumerate(turn.damping):
        alone = replace(turn, damping=[*nothing[:number], matrix, *nothing[number + 1 :]])
        series.append(moving_modes(alone, moving.size, moving).dissipative)
    return tuple(series)


def _loads(engine: Engine, turn: SampledTurn, stressed: StressedLinks) -> list[FloatArray]:
    """Loads (N, n_link) on each reduced link for displacements from the straight link.

    Near a stressed state they are what the tangents make of its displacement: internal forces
    balance the loads there, up to joint forces and to what a constant displacement adds to inertia.
    """
    displacement = stressed.displacement
    if displacement is None:
        forces = engine.connectors.with_inertia(engine.links, turn.motion)
    else:
        pairs = zip(stressed.tangent, displacement, strict=True)
        forces = [(tangent @ q[..., None])[..., 0] for tangent, q in pairs]
        if (inertia := engine.displaced_inertia(turn.motion)) is not None:
            moved = inertia.forces(displacement)
            forces = [force - more for force, more in zip(forces, moved, strict=True)]
    return [force @ basis for force, basis in zip(forces, turn.bases, strict=True)]


def _of_connectors(turn: SampledTurn, stressed: StressedLinks) -> FloatArray:
    """Forces of springs, guides and followers of the stressed state at no displacement, (N, n)."""
    place, connected = stressed.displacement, turn.connected
    if place is None or connected is None:
        return np.zeros((len(turn.motion.crank_angle), turn.size))
    reduced = []
    for link, basis, q in zip(turn.unreduced, turn.bases, place, strict=True):
        weighted = q if link.rigid else (link.mass @ q.T).T @ basis
        mass = np.eye(q.shape[1]) if link.rigid else basis.T @ (link.mass @ basis)
        reduced.append(np.linalg.solve(mass, weighted.T).T[..., None])
    z = turn.frames.independent(turn.displaced, reduced)
    count = z.shape[1]  # forces on a frame on springs are those of straight links
    forces = np.zeros((len(z), turn.size))
    forces[:, :count] = (connected.stiffness[:, :count, :count] @ z)[..., 0]
    return forces


def _rest(moving: MovingModes, force: FloatArray, modal: FloatArray) -> FloatArray:
    """Static response to the loads beyond the moving modes, (N, n, 1)."""
    stiffness, across = moving.turn.stiffness, np.swapaxes(moving.basis, 1, 2)
    amplitudes = np.linalg.solve(across @ stiffness @ moving.basis, modal[..., None])
    return np.asarray(np.linalg.solve(stiffness, force[..., None]) - moving.basis @ amplitudes)


def _read(turn: SampledTurn, readings: Readings, shapes: FloatArray) -> FloatArray:
    """Readings (N, r, k) of shapes (N, n, k) of the linkage."""
    moved = turn.link_coordinates(shapes)
    values = np.zeros((len(shapes), len(readings), shapes.shape[2]))
    for index, rows in enumerate(readings):
        for row, basis, shape in zip(rows, turn.bases, moved, strict=True):
            if row is not None:
                values[:, index] += np.einsum("n,knm->km", row @ basis, shape)
    return values
