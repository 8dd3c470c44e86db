"""Trapezoidal rule for a driven linkage with linear equations, interpolated between positions.

The matrices of a driven linkage are smooth functions of the crank angle. At a constant speed
what a step makes of them is solved at some hundred positions of a turn and interpolated from
there (Lagrange), which costs a step a fraction of its own solution; while the shaft speeds up,
every step is solved.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from itertools import pairwise

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.dynamical_systems import VibrationState, march, step_matrices
from flexmech.time_domain.equations_of_motion.driven_linkage import DrivenLinkage, StaticExpansion

# Greatest angle in rad by which a link turns, or turns from another, between two positions.
# Of the k-th harmonic of its angle the interpolation misses 0.00024 times the tenth power of k
# times this; that leaves 1e-7 of what the steps of the aluminium linkage are made of.
SPACING = 0.08
# A spring or load turns faster than the links where it is short: half of that, which is a thousand
# times less for the same harmonic.
CONNECTED_SPACING = 0.04
# For an arm alone, which turns evenly, but whose stress under weight is a cubic spline: fewer
# positions change its deflections by 3e-7 of their peak.
LEAST_POSITIONS = 96
# Of the Lagrange polynomials of degree nine, counted from the position before.
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
            some = np.arange(batch * BATCH, min((batch + 1) * BATCH, self._count))
            turned = some / self._count * self._drive.revolution_time
            values = self._solved_at(self._begins + turned)
            if not self._table.size:
                self._table = np.empty((self._count + len(STENCIL) - 1, values.shape[1]))
            self._table[some] = values
            self._solved[some] = True
            if not batch:
                self._table[self._count :] = values[: len(STENCIL) - 1]

    def _solved_at(self, time: FloatArray) -> FloatArray:
        """The arrays side by side in one."""
        parts = self._solve(time)
        self._shapes = [part.shape[1:] for part in parts]
        return np.concatenate([part.reshape(len(part), -1) for part in parts], axis=1)


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
            some = slice(first + 1, first + 1 + CACHED_STEPS)
            advance, forced, expansion = self._operators(time, acting, some)
            history = march(state, self._step, advance, forced)
            state = history[-1]
            histories.append(history if first == 0 else history[1:])
            expansions.append(expansion)
        parts = [(part.position, part.velocity, part.acceleration) for part in histories]
        whole = VibrationState(*map(np.concatenate, zip(*parts, strict=True)))
        if not self._linkage.is_condensed:
            return whole, expansions[0]
        return whole, StaticExpansion(
            np.concatenate([part.matrix for part in expansions]),
            np.concatenate([part.offset for part in expansions]),
        )

    def _operators(
        self, time: FloatArray, acting: FloatArray | None, some: slice
    ) -> tuple[FloatArray, FloatArray, StaticExpansion]:
        """Operators of the steps that end at some of the times; valid until the next call."""
        linkage, (advance, forced, *rest) = self._linkage, self._table.at(time[some])
        expansion = StaticExpansion.of_all(linkage.size)
        if linkage.is_condensed:
            matrix, offset, *rest = rest
            expansion = StaticExpansion(matrix.copy(), offset.copy())
        if acting is not None:
            response, flexibility = rest
            pushed, on_z = expansion.under(acting[some], flexibility, linkage.condensed)
            expansion = StaticExpansion(expansion.matrix, expansion.offset + pushed)
            forced = forced + (response @ on_z[..., None])[..., 0]
        return advance, forced, expansion


def _matrices(linkage: DrivenLinkage, step: float, time: FloatArray) -> list[FloatArray]:
    """What the steps of :class:`LinearMarch` are made of, at times of shape (m,)."""
    equations = linkage.equations(time, tables=False)
    advance, response = step_matrices(equations, step)
    parts = [advance, (response @ equations.force[..., None])[..., 0]]
    if linkage.is_condensed:
        parts += [equations.expansion.matrix, equations.expansion.offset]
    if linkage.connectors.has_tables:
        parts += [response, equations.flexibility]
    return parts
