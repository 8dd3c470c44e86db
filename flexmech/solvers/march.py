"""Steps in time of a driven linkage: the trapezoidal rule, and a rule of fourth order.

The matrices of a driven linkage are smooth functions of the crank angle. At a constant speed
what a step makes of them is solved at some hundred positions of a turn and interpolated from
there (Lagrange), which costs a step a fraction of its own solution; while the shaft speeds up,
every step is solved.

Links that stretch by the square of their slopes take Lobatto's method of fourth order. The
equations of both stages of a double step are solved for all forces at once, at positions of a turn
between which the solutions are interpolated. The nonlinear forces are iterated by a modified
Newton's method with the tangent of the straight links. Within a pass the links first relax the
stretch by their slopes, which is most of the solution; the remaining tension then acts on the
slopes (block Gauss-Seidel). Slopes are small, so that a pass gains about two digits; where it does
not, Newton's method takes the tangent of the bowed links.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from functools import partial
from itertools import pairwise

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.dynamical_systems import VibrationState, march, step_matrices
from flexmech.dynamical_systems.lobatto import (
    MARCH_ON,
    POSITION,
    PREDICTION,
    RATE,
    RATE_BY_POSITION,
    STAGES,
)
from flexmech.errors import ComputationError
from flexmech.mechanics.running.driven_linkage import DrivenLinkage, StaticExpansion
from flexmech.mechanics.running.linkage_stretch import LinkageStretch, StretchForces

# Greatest angle in rad by which a link turns, or turns from another, between two positions.
# The interpolation misses of the k-th harmonic of an angle 0.00024 times the tenth power of k times
# this; that leaves 1e-7 of what the steps of the aluminium linkage are made of.
SPACING = 0.08
# A spring or load turns faster than the links where it is short: half of that, which is a thousand
# times less for the same harmonic.
CONNECTED_SPACING = 0.04
# For an arm alone, which turns evenly, but whose stress under weight is a cubic spline: fewer
# positions change its deflections by 3e-7 of their peak.
LEAST_POSITIONS = 96
# Stencil of the Lagrange polynomials of degree nine, counted from the position before.
STENCIL = np.arange(-4, 6)
# Coefficients of their powers, one polynomial a column.
POLYNOMIALS = np.linalg.inv(np.vander(STENCIL.astype(float), increasing=True))
# Positions solved at once. Speed alone, but no fewer than the stencil has.
BATCH = 32
# Steps whose matrices are interpolated at once. Speed alone: they stay in the processor's cache.
CACHED_STEPS = 64


class PositionTable:
    """Arrays that depend on the position of a linkage, at any time of a run.

    Parameters
    ----------
    linkage : DrivenLinkage
    solve : callable
        Takes times of shape (m,) in s; gives arrays of shape (m, ...).
    reach : float
        How far before a time, in s, the motion counts there.
    """

    def __init__(
        self,
        linkage: DrivenLinkage,
        solve: Callable[[FloatArray], Sequence[FloatArray]],
        reach: float = 0.0,
    ) -> None:
        self._solve = solve
        self._drive = drive = linkage.drive
        # From some time on the crank turns evenly, or stands.
        repeats = linkage.connectors.is_interpolated and (drive.turns_on or not drive.speed)
        self._begins = drive.law_time + reach if repeats else np.inf
        # Without turns at a constant speed nothing is interpolated.
        period = drive.revolution_time if drive.turns_on else 0.0
        motion = linkage.motion(drive.law_time + period * np.linspace(0.0, 1.0, 361))
        speeds = motion.angular_velocity
        relative = np.abs(speeds[:, :, None] - speeds[:, None, :])
        fastest = max(float(np.abs(speeds).max()), float(relative.max()))
        spacing = CONNECTED_SPACING if linkage.connectors.any else SPACING
        self._count = max(LEAST_POSITIONS, int(np.ceil(fastest * period / spacing)))
        # The first positions follow once more after the last one.
        self._table = self._values = np.empty((0, 0))
        self._solved = np.zeros(self._count, dtype=bool)
        self._shapes: list[tuple[int, ...]] = []

    def at(self, time: FloatArray) -> list[FloatArray]:
        """Arrays of shape (m, ...) at increasing times of shape (m,), valid until the next call."""
        first = int(np.searchsorted(time, self._begins))
        parts = []
        if first:
            parts.append(self._solved_at(time[:first]))
        if first < len(time):
            parts.append(self._repeated(time[first:]))
        values = parts[0] if len(parts) == 1 else np.concatenate(parts)
        stops = np.cumsum([int(np.prod(shape)) for shape in self._shapes])[:-1]
        pieces = np.split(values, stops, axis=1)
        return [p.reshape(len(values), *s) for p, s in zip(pieces, self._shapes, strict=True)]

    def _repeated(self, time: FloatArray) -> FloatArray:
        """Arrays side by side at times at which the crank turns evenly, or stands."""
        if self._drive.turns_on:
            place = (time - self._begins) / self._drive.revolution_time * self._count
            return self._interpolated(place)
        if not self._table.size:
            self._table = self._solved_at(np.array([self._begins]))
        return np.repeat(self._table, len(time), axis=0)

    def _interpolated(self, place: FloatArray) -> FloatArray:
        before = np.floor(place).astype(np.intp)
        weights = np.vander(place - before, len(STENCIL), increasing=True) @ POLYNOMIALS
        first, last = int(before[0]), int(before[-1])
        self._ensure(np.arange(first + STENCIL[0], last + STENCIL[-1] + 1) % self._count)
        # Memory that is used again: that of the system costs more than to fill it.
        if len(self._values) < len(place):
            self._values = np.empty((len(place), self._table.shape[1]))
        values = self._values[: len(place)]
        edges = np.searchsorted(before, np.arange(first, last + 2))
        for number, (start, stop) in enumerate(pairwise(edges), first + int(STENCIL[0])):
            around = self._table[number % self._count :][: len(STENCIL)]
            np.dot(weights[start:stop], around, out=values[start:stop])
        return values

    def _ensure(self, needed: IntArray) -> None:
        """Solve positions on first use, with the others of their batch."""
        for batch in np.unique(needed[~self._solved[needed]] // BATCH):
            numbers = np.arange(batch * BATCH, min((batch + 1) * BATCH, self._count))
            turned = numbers / self._count * self._drive.revolution_time
            values = self._solved_at(self._begins + turned)
            if not self._table.size:
                self._table = np.empty((self._count + len(STENCIL) - 1, values.shape[1]))
            self._table[numbers] = values
            self._solved[numbers] = True
            if not batch:
                self._table[self._count :] = values[: len(STENCIL) - 1]

    def _solved_at(self, time: FloatArray) -> FloatArray:
        """The arrays side by side in one."""
        parts = self._solve(time)
        self._shapes = [table.shape[1:] for table in parts]
        return np.concatenate([table.reshape(len(table), -1) for table in parts], axis=1)


class LinearMarch:
    """Time stepping of a linkage with linear equations.

    Parameters
    ----------
    linkage : DrivenLinkage
    step : float
        In s.

    Attributes
    ----------
    stride : int
        A run takes a multiple of so many steps.
    """

    stride = 1

    def __init__(self, linkage: DrivenLinkage, step: float) -> None:
        self._linkage, self._step = linkage, step
        # Not by a method of its own: what refers to itself is kept until memory is searched for it.
        self._table = PositionTable(linkage, partial(_matrices, linkage, step))

    def advance(
        self, time: FloatArray, state: VibrationState
    ) -> tuple[VibrationState, StaticExpansion]:
        """Advance from the first of some times to the others, in parts that fit the cache.

        Parameters
        ----------
        time : ndarray, shape (m + 1,)
            In s, one step apart.
        state : VibrationState
            At the first of them, arrays of shape (n,), or (n, k) for k motions at once.

        Returns
        -------
        VibrationState
            Arrays of shape (m + 1, n) or (m + 1, n, k).
        StaticExpansion
            At the same times.
        """
        acting = self._linkage.step_forces(time)
        histories, expansions = [], []
        if self._linkage.is_condensed:
            expansions.append(self._operators(time, acting, slice(1))[-1])
        for first in range(0, len(time) - 1, CACHED_STEPS):
            steps = slice(first + 1, first + 1 + CACHED_STEPS)
            advance, forced, expansion = self._operators(time, acting, steps)
            history = march(state, self._step, advance, forced)
            state = history[-1]
            histories.append(history if first == 0 else history[1:])
            expansions.append(expansion)
        parts = [(known.position, known.velocity, known.acceleration) for known in histories]
        whole = VibrationState(*map(np.concatenate, zip(*parts, strict=True)))
        if not self._linkage.is_condensed:
            return whole, expansions[0]
        return whole, StaticExpansion(
            np.concatenate([known.matrix for known in expansions]),
            np.concatenate([known.offset for known in expansions]),
        )

    def _operators(
        self, time: FloatArray, acting: FloatArray | None, steps: slice
    ) -> tuple[FloatArray, FloatArray, StaticExpansion]:
        """Operators of the steps that end at some of the times; valid until the next call."""
        linkage, (advance, forced, *rest) = self._linkage, self._table.at(time[steps])
        expansion = StaticExpansion.of_all(linkage.size)
        if linkage.is_condensed:
            matrix, offset, *rest = rest
            expansion = StaticExpansion(matrix.copy(), offset.copy())
        if acting is not None:
            response, flexibility = rest
            pushed, on_z = expansion.under(acting[steps], flexibility, linkage.condensed)
            expansion = StaticExpansion(expansion.matrix, expansion.offset + pushed)
            forced = forced + (response @ on_z[..., None])[..., 0]
        return advance, forced, expansion


def _matrices(linkage: DrivenLinkage, step: float, time: FloatArray) -> list[FloatArray]:
    """Matrices and forces of the steps of :class:`LinearMarch`, at times of shape (m,)."""
    equations = linkage.equations(time, tables=False)
    advance, response = step_matrices(equations, step)
    parts = [advance, (response @ equations.force[..., None])[..., 0]]
    if linkage.is_condensed:
        parts += [equations.expansion.matrix, equations.expansion.offset]
    if linkage.connectors.has_tables:
        parts += [response, equations.flexibility]
    return parts


logger = logging.getLogger(__name__)


# Passes of the modified Newton's method in every double step of a block; more where the last of
# them changes the positions by more than this part of the greatest H^2 z''. Over a turn of the
# aluminium linkage at 20 rad/s two passes change them by 3e-4 and leave an error of 2e-5. Where a
# pass gains less, what it leaves builds up from step to step: of links that bow deeply, changes of
# 1e-2 cost the energy balance.
PASSES = (2, 3, 4, 6)
LAST_CHANGE = 1e-3
# A pass gains about two digits: after a change that is smaller by this, the next block begins
# with the fewest passes again.
AMPLE = 30
# Newton's method with the tangent of the bowed links. Five or six passes lead to a change whose
# square is less than round-off; a step that takes twice as many is too long.
NEWTON_PASSES = 12
NEWTON_CHANGE = 1e-9
# Links at rest in their frames have no H^2 z'' to measure changes by: then this part of z is taken
# in its place, in a pass and in Newton's method. Both leave 1e-9 to 1e-12 of z, above round-off.
STILL, NEWTON_STILL = 1e-6, 1e-3
# Double steps whose operators are interpolated at once. Speed alone: they stay in the cache.
CACHED_DOUBLE_STEPS = 32
# Taylor's polynomial at the stages, from z, H z' and H^2 z'' at the start.
TAYLOR = np.array([[1.0, 1 / 2, 1 / 8], [1.0, 1.0, 1 / 2]])
# The line through the last two stages at the next two.
EXTRAPOLATE = np.array([[-1.0, 2.0], [-2.0, 3.0]])


class UnbalancedStepError(ComputationError):
    """Newton's method fails in a step of this length; a shorter step may converge."""


class StretchMarch:
    """Time stepping of a linkage with second-order stretch.

    Parameters
    ----------
    linkage : DrivenLinkage
    step : float
        h in s, half a double step.

    Attributes
    ----------
    stride : int
        A run takes a multiple of so many steps.
    """

    stride = STAGES

    def __init__(self, linkage: DrivenLinkage, step: float) -> None:
        assert linkage.stretch is not None
        self._linkage, self._step = linkage, step
        # Not by a method of its own: what refers to itself is kept until memory is searched for it.
        solve = partial(_double_steps, linkage, step)
        self._table = PositionTable(linkage, solve, reach=step)
        self._stages = _Stages(linkage.stretch, linkage.size, 2 * step)
        self._passes = 0
        self._last: FloatArray | None = None

    def advance(
        self, time: FloatArray, state: VibrationState
    ) -> tuple[VibrationState, StaticExpansion]:
        """Advance from the first of some times to the others.

        Parameters
        ----------
        time : ndarray, shape (2 m + 1,)
            In s, one step apart.
        state : VibrationState
            At the first of them, arrays of shape (n,).

        Returns
        -------
        VibrationState
            Arrays of shape (2 m + 1, n).
        StaticExpansion
            At the same times.

        Raises
        ------
        UnbalancedStepError
            If Newton's method does not converge in a step.
        """
        double = 2 * self._step
        acting = self._linkage.step_forces(time)
        history = np.empty((3, len(time), len(state.position)))
        history[:, 0] = state.position, double * state.velocity, double**2 * state.acceleration
        for first in range(0, len(time) - 1, STAGES * CACHED_DOUBLE_STEPS):
            steps = slice(first + 1, min(first + 1 + STAGES * CACHED_DOUBLE_STEPS, len(time)))
            rows = self._table.at(time[steps][1::STAGES])
            if acting is not None:
                rows[0] = rows[0] + acting[steps].reshape(rows[0].shape)
            history[:, steps] = self._block(rows, history[:, first])
        whole = VibrationState(history[0], history[1] / double, history[2] / double**2)
        return whole, StaticExpansion.of_all(self._linkage.size)

    def _block(self, rows: list[FloatArray], start: FloatArray) -> FloatArray:
        """Positions, rates and their rates, times H, of all stages from those at the start.

        Parameters
        ----------
        rows : list of ndarray
            Rows of m double steps, with all forces; see :func:`_double_steps`.
        start : ndarray, shape (3, n)

        Returns
        -------
        ndarray, shape (3, 2 m, n)
        """
        # z, H z' and H^2 z'' at the start of each double step, and z at both its stages.
        known = np.empty((len(rows[0]) + 1, 3 + STAGES, start.shape[1]))
        known[0, :3] = start
        for passes in PASSES:
            if passes < self._passes:
                continue
            self._passes = passes
            change, history = self._fixed_passes(rows, known, passes), _at_stages(known)
            bent = max(_greatest(history[2]), STILL * _greatest(history[0]))
            if change <= LAST_CHANGE * bent < np.inf:
                if AMPLE * change <= LAST_CHANGE * bent:
                    self._passes = 0
                return history
            logger.info("modified Newton's method: %d passes do not do", passes)
        self._last = None
        self._newton(rows, known)
        return _at_stages(known)

    def _fixed_passes(self, rows: list[FloatArray], known: FloatArray, passes: int) -> float:
        """Fill in ``known`` of :meth:`_block`; greatest change of positions by the last pass."""
        stages, forces = self._stages, self._stages.forces
        before = np.empty((len(known) - 1, STAGES, known.shape[2]))
        # Forces and second-order tensions at all stages, those of the step before first.
        taken = np.empty((len(known), STAGES, stages.width + forces.second.shape[1]))
        taken[0] = stages.forces_at(rows[4][0, 0], known[0]) if self._last is None else self._last
        balance, placed, load = stages.balance, stages.placed, np.empty_like(stages.placed)
        moved = np.empty_like(load)
        flat_load, flat_moved = load.reshape(-1), moved.reshape(-1)
        march_on, add, subtract = MARCH_ON[-1], np.add, np.subtract
        for number, (acting, resistance, compliance, relaxation, turn, by_ends) in enumerate(
            zip(*rows, strict=True)
        ):
            now, guess = known[number], taken[number + 1]
            stages.predict(now[:3], resistance, acting, turn)
            EXTRAPOLATE.dot(taken[number], guess)
            force, second = guess[:, : stages.width], guess[:, stages.width :]
            for left in range(passes, -1, -1):
                subtract(balance, force, load)
                compliance.dot(flat_load, flat_moved)
                add(moved, placed, forces.place)
                if not left:
                    break
                if left == 1:
                    before[number] = stages.position
                stages.find_rates(by_ends)
                force = forces.evaluate(relaxation, second)
                second[:] = forces.second
            guess[:, : stages.width] = force
            now[3:] = stages.position
            march_on.dot(now, known[number + 1, :3])
        self._last = taken[-1]
        return _greatest(known[:-1, 3:] - before)

    def _newton(self, rows: list[FloatArray], known: FloatArray) -> None:
        """Fill in ``known`` of :meth:`_block` by Newton's method in every double step."""
        stages, forces, width = self._stages, self._stages.forces, self._stages.width
        size, unit = known.shape[2], np.eye(STAGES * width)
        # Rates of augmented coordinates by the positions of both stages.
        rate = np.zeros((STAGES, width, STAGES, width))
        rate[:, :size, :, :size] = np.einsum("ij,qr->iqjr", RATE_BY_POSITION, np.eye(size))
        for number, (acting, resistance, compliance, _, turn, by_ends) in enumerate(
            zip(*rows, strict=True)
        ):
            now, ends = known[number], turn.shape[1]
            stages.predict(now[:3], resistance, acting, turn)
            rate[:, size:, :, :ends] = by_ends.reshape(STAGES, turn.shape[2], STAGES, ends)
            stages.position[:] = TAYLOR @ now[:3]
            forces.place[:, size:] = (stages.position[:, None, :ends] @ turn)[:, 0]
            for _ in range(NEWTON_PASSES):
                stages.find_rates(by_ends)
                pulled = stages.balance - forces.evaluate()
                gap = (forces.place - stages.placed).reshape(-1) - compliance @ pulled.reshape(-1)
                elastic, damped = forces.tangents()
                tangent = np.einsum("iqp,ipjr->iqjr", damped, rate)
                for stage in range(STAGES):
                    tangent[stage, :, stage] += elastic[stage]
                whole = unit + compliance @ tangent.reshape(STAGES * width, -1)
                change = np.linalg.solve(whole, gap).reshape(STAGES, width)
                forces.place[:] -= change
                now[3:] = stages.position
                bent = np.abs(now[4] - 2 * now[3] + now[0]).max()
                least = max(bent, NEWTON_STILL * np.abs(now).max())
                if np.abs(change[:, :size]).max() <= NEWTON_CHANGE * least:
                    break
            else:
                raise UnbalancedStepError(
                    "links that bow deeply have no balance in a time step of "
                    f"{self._step:.4g} s; choose a smaller --step"
                )
            known[number + 1, :3] = MARCH_ON[-1] @ now


class _Stages:
    """Both stages of a double step: places and rates of the augmented coordinates, and forces.

    Arrays are allocated before, and filled in by their methods, which is fastest.

    Parameters
    ----------
    stretch : LinkageStretch
    size : int
        Number n of coordinates z.
    double : float
        H in s.

    Attributes
    ----------
    width : int
        Number p of augmented coordinates.
    forces : StretchForces
        Whose ``place`` and ``rate`` are those at the stages.
    position : ndarray, shape (2, n)
        z among the places.
    balance : ndarray, shape (2, p)
        Forces, but for the nonlinear ones, that do not balance the motion by the start alone.
    placed : ndarray, shape (2, p)
        Places by the start alone.
    """

    def __init__(self, stretch: LinkageStretch, size: int, double: float) -> None:
        self.width, self._size, self._ends = stretch.size, size, stretch.end_count
        self.forces = StretchForces(stretch.strain, STAGES, double)
        self.position = self.forces.place[:, :size]
        self.balance, self.placed = np.zeros((2, STAGES, self.width))
        # z and H z' at the stages as the start alone makes them, and the dependent ends with these.
        predicted = np.empty((STAGES, 2, size))
        self._dependent = np.empty((STAGES, 2, self.width - size))
        self._predicted, self._stages = predicted.reshape(-1, size), predicted.reshape(STAGES, -1)
        self._ahead, self._ahead_rate = predicted[:, 0], predicted[:, 1]
        self._ends_ahead = predicted[:, :, : self._ends]
        self._resisted, self._by_position = np.empty((2, STAGES, size))
        self._by_ends = np.empty((STAGES, self.width - size))
        self._flat_by_ends = self._by_ends.reshape(-1)
        rate = self.forces.rate
        self._rate, self._dependent_rate = rate[:, :size], rate[:, size:]

    def forces_at(self, turn: FloatArray, start: FloatArray) -> FloatArray:
        """Forces and second-order tensions at a start of shape (3, n) or more, (p + s,)."""
        for values, moved in zip((self.forces.place, self.forces.rate), start, strict=False):
            values[:, : self._size], values[:, self._size :] = moved, moved[: self._ends] @ turn
        force = self.forces.evaluate()
        return np.concatenate([force[0], self.forces.second[0]])

    def predict(
        self, start: FloatArray, resistance: FloatArray, acting: FloatArray, turn: FloatArray
    ) -> None:
        """Move the stages as the start (3, n) of the double step alone does."""
        PREDICTION.dot(start, self._predicted)
        resistance[0].dot(self._stages[0], self._resisted[0])
        resistance[1].dot(self._stages[1], self._resisted[1])
        np.subtract(acting, self._resisted, self.balance[:, : self._size])
        if self.forces.is_damped:
            RATE_BY_POSITION.dot(self._ahead, self._by_position)
            np.subtract(self._ahead_rate, self._by_position, self._ahead_rate)
        np.matmul(self._ends_ahead, turn, self._dependent)
        self.placed[:, : self._size] = self._ahead
        self.placed[:, self._size :] = self._dependent[:, 0]

    def find_rates(self, by_ends: FloatArray) -> None:
        """Find the rates at the places, which count where stretching is damped."""
        if self.forces.is_damped:
            RATE_BY_POSITION.dot(self.position, self._by_position)
            np.add(self._ahead_rate, self._by_position, self._rate)
            by_ends.dot(self.position[:, : self._ends].ravel(), self._flat_by_ends)
            np.add(self._by_ends, self._dependent[:, 1], self._dependent_rate)


def _double_steps(linkage: DrivenLinkage, step: float, end: FloatArray) -> list[FloatArray]:
    """Equations of motion at both stages of double steps, solved for all forces at once.

    Double steps of twice ``step`` that end at m times in s.

    Returns
    -------
    ndarray, shape (m, 2, n)
        Forces, but for those that are not interpolated.
    ndarray, shape (m, 2, n, 2 n)
        Stiffness and, beside it, damping over H, at each stage.
    ndarray, shape (m, 2 p, 2 p)
        Displacements of augmented coordinates at the stages by unit forces on them.
    ndarray, shape (m, 2 s, 2 s)
        Decrease of the tensions at the stages by unit tensions.
    ndarray, shape (m, 2, k, f)
        Dependent coordinates from the displacements of link ends.
    ndarray, shape (m, 2 f, 2 k)
        Rates times H of dependent coordinates at both stages by displacements of link ends there,
        but for what the start alone makes of the rates of these.
    """
    stretch, count, double = linkage.stretch, len(end), 2 * step
    assert stretch is not None
    time = np.column_stack([end - step, end]).reshape(-1)
    equations = linkage.equations(time, tables=False)
    size, strains, total = linkage.size, len(stretch.strain.gradient), STAGES * stretch.size
    mass, damping, stiffness = (
        matrix.reshape(-1, STAGES, size, size)
        for matrix in (equations.mass, equations.damping, equations.stiffness)
    )
    effective = _coupled(double * RATE, damping) + _coupled(double**2 * POSITION, stiffness)
    turn, rate = (
        matrix.reshape(count, STAGES, *matrix.shape[1:])
        for matrix in stretch.pin_rotations(equations.motion)
    )
    gathered = np.zeros((count, STAGES, size, STAGES, stretch.size))
    by_ends = RATE_BY_POSITION[:, None, :, None] * turn[:, :, :, None]
    for stage in range(STAGES):
        effective[:, stage, :, stage] += mass[:, stage]
        gathered[:, stage, :, stage] = np.swapaxes(stretch.augmentation(turn[:, stage]), 1, 2)
        by_ends[:, stage, :, stage] += double * rate[:, stage]
    solved = np.linalg.solve(
        effective.reshape(count, STAGES * size, -1), gathered.reshape(count, STAGES * size, -1)
    ).reshape(count, STAGES, -1)
    moved = (double**2 * POSITION @ solved).reshape(count, STAGES, size, total)
    compliance = stretch.augmented(turn, moved)
    # Strains by unit tensions, which act and are seen by the linear part of the strain.
    gradient = stretch.strain.gradient
    strain = (gradient @ compliance).reshape(count, STAGES, strains, STAGES, -1) @ gradient.T
    by_rate = np.einsum("ik,mksjt->misjt", RATE_BY_POSITION, strain)
    relaxation = strain + (stretch.strain.damping_time / double)[:, None, None] * by_rate
    return [
        equations.force.reshape(count, STAGES, size),
        np.concatenate([stiffness, damping / double], axis=-1),
        compliance.reshape(count, total, total),
        relaxation.reshape(count, STAGES * strains, -1),
        np.swapaxes(turn, 2, 3),
        by_ends.reshape(count, STAGES * turn.shape[2], STAGES * turn.shape[3]),
    ]


def _coupled(weights: FloatArray, matrices: FloatArray) -> FloatArray:
    """Blocks ``weights[i, j] * matrices[i]``, (m, 2, n, 2, n)."""
    return np.asarray(weights[:, None, :, None] * matrices[:, :, :, None, :])


def _greatest(vectors: FloatArray) -> float:
    """Greatest length of vectors of shape (..., n); not finite where passes diverge."""
    with np.errstate(over="ignore", invalid="ignore"):
        return float(np.sqrt(np.einsum("...n,...n->...", vectors, vectors).max()))


def _at_stages(known: FloatArray) -> FloatArray:
    """Positions, rates and their rates at both stages, (3, 2 m, n); see ``_block``."""
    marched = MARCH_ON.reshape(-1, known.shape[1]) @ known[:-1]
    return np.asarray(np.moveaxis(marched.reshape(-1, 3, known.shape[2]), 1, 0))
