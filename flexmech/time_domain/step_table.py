"""What the steps of a run need, interpolated between positions of the linkage.

The matrices of a driven linkage are smooth functions of the crank angle. At a constant speed
they are solved at a few hundred positions of a turn and interpolated from there (Lagrange,
degree five), which costs a step a fraction of its own solution; while the shaft speeds up,
every step is solved.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from flexmech.time_domain.driven_linkage import DrivenLinkage
from flexmech.time_domain.equations import Following
from flexmech.time_domain.linkage_stretch import PinTurns
from flexmech.time_domain.stretch_march import StretchOperators
from flexmech.time_domain.trapezoidal import StepOperators, step_operators
from flexmech.types import FloatArray, IntArray

__all__ = ["StepRows", "StepTable"]


# Greatest angle in rad by which a link turns, or turns from another, between two positions.
# Of the k-th harmonic of its angle the interpolation misses 0.005 times the sixth power of k
# times this; that leaves 1e-7 of what the steps of the aluminium linkage are made of.
SPACING = 0.04
LEAST_POSITIONS = 96
# Of the Lagrange polynomials, counted from the position before.
STENCIL = np.arange(-2, 4)
# Coefficients of their powers, one polynomial a column.
POLYNOMIALS = np.linalg.inv(np.vander(STENCIL.astype(float), increasing=True))
# Positions solved at once.
BATCH = 64


@dataclass(frozen=True)
class StepRows:
    """What m instants need: the step that ends there, and what follows statically.

    Parameters
    ----------
    linear : StepOperators
    stretch : StretchOperators or None
    following : Following
    pushed : ndarray, shape (m, k, n), or None
        By how much a unit of each load at the step's end moves the next prediction.
    pushed_offset : ndarray, shape (m, k, size), or None
        What a unit of each load adds to coordinates that follow statically.
    """

    linear: StepOperators
    stretch: StretchOperators | None
    following: Following
    pushed: FloatArray | None = None
    pushed_offset: FloatArray | None = None

    def under(self, force: FloatArray) -> StepRows:
        """The same instants with so much of each load, (m, k), besides all other forces."""
        if self.pushed is None or self.pushed_offset is None or not force.any():
            return self
        forced = self.linear.forced + np.einsum("mk,mkn->mn", force, self.pushed)
        following = self.following
        if following.expansion.shape[1] != following.expansion.shape[2]:
            offset = following.offset + np.einsum("mk,mkn->mn", force, self.pushed_offset)
            following = replace(following, offset=offset)
        return replace(self, linear=replace(self.linear, forced=forced), following=following)


class StepTable:
    """Operators of the trapezoidal rule at any time of a run.

    Parameters
    ----------
    linkage : DrivenLinkage
    step : float
        In s.
    load : sequence of ndarray, shape (n_link,), optional
        Forces on the reduced links in their frames, of which a run can take any part at any
        time: see :meth:`rows`. The loads of the mechanism over tables act besides.
    """

    def __init__(
        self, linkage: DrivenLinkage, step: float, load: Sequence[FloatArray] | None = None
    ) -> None:
        self._linkage = linkage
        self._step = step
        self._load = load
        drive = linkage.drive
        period = drive.revolution_time
        motion = linkage.motion(drive.run_up_time + period * np.linspace(0.0, 1.0, 361))
        speeds = motion.angular_velocity
        relative = np.abs(speeds[:, :, None] - speeds[:, None, :])
        fastest = max(float(np.abs(speeds).max()), float(relative.max()))
        self._count = max(LEAST_POSITIONS, int(np.ceil(fastest * period / SPACING)))
        # The first positions follow once more after the last one.
        self._table: FloatArray | None = None
        self._values = np.empty((0, 0))
        self._solved = np.zeros(self._count, dtype=bool)
        self._parts = _Parts()

    def rows(self, time: FloatArray, force: FloatArray | None = None) -> StepRows:
        """Operators and what follows at some times; the operators until the next call.

        Parameters
        ----------
        time : ndarray, shape (m,)
            In s.
        force : ndarray, shape (m,), optional
            How much of the table's load acts at these times.

        Returns
        -------
        StepRows
        """
        rows = self._unpacked(self._packed(time))
        if rows.pushed is None:
            return rows
        acting = self._linkage.connectors.histories(time)
        if self._load is not None:
            own = np.zeros(len(time)) if force is None else force
            acting = np.column_stack([acting, own])
        return rows.under(acting)

    def _packed(self, time: FloatArray) -> FloatArray:
        if not self._linkage.connectors.is_interpolated:
            return self._solve(time)
        drive = self._linkage.drive
        steady = time >= drive.run_up_time
        place = (time - drive.run_up_time) / drive.revolution_time * self._count
        if steady.all():
            return self._interpolated(place)
        direct = self._solve(time[~steady])
        values = np.empty((len(time), direct.shape[1]))
        values[~steady] = direct
        if steady.any():
            values[steady] = self._interpolated(place[steady])
        return values

    def _interpolated(self, place: FloatArray) -> FloatArray:
        before = np.floor(place).astype(np.intp)
        weights = _lagrange(place - before)
        first, last = int(before[0]), int(before[-1])
        self._ensure(np.arange(first + STENCIL[0], last + STENCIL[-1] + 1) % self._count)
        assert self._table is not None
        values = self._room(len(place))
        edges = np.searchsorted(before, np.arange(first, last + 2))
        for number, (start, stop) in enumerate(pairwise(edges), first + int(STENCIL[0])):
            around = self._table[number % self._count :][: len(STENCIL)]
            np.dot(weights[start:stop], around, out=values[start:stop])
        return values

    def _room(self, count: int) -> FloatArray:
        """Memory for some instants, used again: that of the system costs more than to fill it."""
        assert self._table is not None
        if len(self._values) < count:
            self._values = np.empty((count, self._table.shape[1]))
        return self._values[:count]

    def _ensure(self, needed: IntArray) -> None:
        """Solve the positions that are asked for the first time, and those of their batch."""
        drive = self._linkage.drive
        for batch in np.unique(needed[~self._solved[needed]] // BATCH):
            some = np.arange(batch * BATCH, min((batch + 1) * BATCH, self._count))
            time = drive.run_up_time + some / self._count * drive.revolution_time
            values = self._solve(time)
            if self._table is None:
                self._table = np.empty((self._count + len(STENCIL) - 1, values.shape[1]))
            self._table[some] = values
            self._solved[some] = True
            if not batch:
                self._table[self._count :] = values[: len(STENCIL) - 1]

    def _solve(self, time: FloatArray) -> FloatArray:
        linkage = self._linkage
        equations = linkage.equations(time, tables=False)
        following = equations.following
        linear, answer = step_operators(equations, self._step, forces=linkage.stretch is not None)
        parts = [linear.advance, linear.forced]
        if linkage.is_condensed:
            parts += [following.expansion, following.offset]
        if linkage.stretch is not None:
            turns = linkage.stretch.pin_turns(equations.motion)
            answer = linkage.stretch.gathered(turns, answer)
            yielding = linkage.stretch.yielding(turns, answer, self._step)
            parts += [answer, yielding, turns.turn, turns.rate]
        loaded = linkage.unit_equations(time)
        if self._load is not None:
            loaded.append(linkage.equations(time, load=self._load))
        if loaded:
            pushed = [step_operators(one, self._step)[0].forced for one in loaded]
            size = linkage.frames.size
            offsets = [np.broadcast_to(one.following.offset, (len(time), size)) for one in loaded]
            parts += [np.stack(pushed, axis=1), np.stack(offsets, axis=1)]
        return self._parts.packed(parts)

    def _unpacked(self, values: FloatArray) -> StepRows:
        linkage, parts = self._linkage, self._parts.taken_apart(values)
        linear = StepOperators(self._step, parts[0], parts[1])
        pushed = pushed_offset = None
        if self._load is not None or linkage.connectors.table_count:
            pushed, pushed_offset = parts[-2:]
            parts = parts[:-2]
        following = Following.of_all(linkage.size)
        if linkage.is_condensed:
            following = Following(parts[2].copy(), parts[3].copy())
        stretch = None
        if linkage.stretch is not None:
            answer, yielding, turn, rate = parts[-4:]
            stretch = StretchOperators(answer, yielding, PinTurns(turn, rate))
        return StepRows(linear, stretch, following, pushed, pushed_offset)


class _Parts:
    """Arrays over instants, side by side in one."""

    def __init__(self) -> None:
        self._shapes: list[tuple[int, ...]] = []

    def packed(self, parts: Sequence[FloatArray]) -> FloatArray:
        self._shapes = [part.shape[1:] for part in parts]
        return np.concatenate([part.reshape(len(part), -1) for part in parts], axis=1)

    def taken_apart(self, values: FloatArray) -> list[FloatArray]:
        stops = np.cumsum([int(np.prod(shape)) for shape in self._shapes])[:-1]
        pieces = np.split(values, stops, axis=1)
        return [p.reshape(len(values), *s) for p, s in zip(pieces, self._shapes, strict=True)]


def _lagrange(fraction: FloatArray) -> FloatArray:
    """Weights (m, 6) of the positions of the stencil."""
    return np.asarray(np.vander(fraction, len(STENCIL), increasing=True) @ POLYNOMIALS)
