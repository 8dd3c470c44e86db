"""Functions of the crank angle, interpolated between positions of a turn.

The matrices of a driven linkage are smooth functions of the crank angle. At a constant speed
what a step makes of them is solved at some hundred positions of a turn and interpolated from
there (Lagrange), which costs a step a fraction of its own solution; while the shaft speeds up,
every step is solved.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.time_domain.equations_of_motion.driven_linkage import DrivenLinkage

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
