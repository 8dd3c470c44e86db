"""The trapezoidal rule along a driven linkage whose equations are linear."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.dynamical_systems import StepOperators, VibrationState, march, step_operators
from flexmech.time_domain.equations_of_motion import DrivenLinkage, Following
from flexmech.time_domain.integrators.position_table import PositionTable

# Steps whose operators are interpolated at once.
CACHED_STEPS = 64


@dataclass(frozen=True)
class StepRows:
    """What m instants need: the step that ends there, and what follows statically.

    Parameters
    ----------
    linear : StepOperators
    following : Following
    pushed : ndarray, shape (m, k, n), or None
        By how much a unit of each load at the step's end moves the next prediction.
    pushed_offset : ndarray, shape (m, k, size), or None
        What a unit of each load adds to coordinates that follow statically.
    """

    linear: StepOperators
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
        self._table = PositionTable(linkage, self._solve)

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
        rows = self._unpacked(self._table.at(time))
        if rows.pushed is None:
            return rows
        acting = self._linkage.connectors.histories(time)
        if self._load is not None:
            own = np.zeros(len(time)) if force is None else force
            acting = np.column_stack([acting, own])
        return rows.under(acting)

    def _solve(self, time: FloatArray) -> list[FloatArray]:
        linkage = self._linkage
        equations = linkage.equations(time, tables=False)
        linear, following = step_operators(equations, self._step), equations.following
        parts = [linear.advance, linear.forced]
        if linkage.is_condensed:
            parts += [following.expansion, following.offset]
        loaded = linkage.unit_equations(time, self._load)
        if loaded:
            pushed = [step_operators(one, self._step).forced for one in loaded]
            size = linkage.frames.size
            offsets = [np.broadcast_to(one.following.offset, (len(time), size)) for one in loaded]
            parts += [np.stack(pushed, axis=1), np.stack(offsets, axis=1)]
        return parts

    def _unpacked(self, parts: list[FloatArray]) -> StepRows:
        linkage = self._linkage
        linear = StepOperators(self._step, parts[0], parts[1])
        pushed = pushed_offset = None
        if self._load is not None or linkage.connectors.table_count:
            pushed, pushed_offset = parts[-2:]
        following = Following.of_all(linkage.size)
        if linkage.is_condensed:
            following = Following(parts[2].copy(), parts[3].copy())
        return StepRows(linear, following, pushed, pushed_offset)


class LinearMarch:
    """Marches a linkage with linear equations from state to state.

    Parameters
    ----------
    linkage : DrivenLinkage
    step : float
        In s.
    load : sequence of ndarray, shape (n_link,), optional
        As of :class:`StepTable`.

    Attributes
    ----------
    stride : int
        A run takes a multiple of so many steps.
    """

    stride = 1

    def __init__(
        self, linkage: DrivenLinkage, step: float, load: Sequence[FloatArray] | None = None
    ) -> None:
        self._linkage = linkage
        self._table = StepTable(linkage, step, load)

    def restart(self) -> None:
        """Forget the run before; there is nothing to forget."""

    def on(
        self, time: FloatArray, state: VibrationState, force: FloatArray | None = None
    ) -> tuple[VibrationState, Following]:
        """March from the first of some times to the others, in parts that stay in the cache.

        Parameters
        ----------
        time : ndarray, shape (m + 1,)
            In s, one step apart.
        state : VibrationState
            At the first of them, arrays of shape (n,).
        force : ndarray, shape (m + 1,), optional
            How much of the table's load acts at these times.

        Returns
        -------
        VibrationState
            Arrays of shape (m + 1, n).
        Following
            At the same times.
        """
        acting = np.zeros_like(time) if force is None else force
        histories, expansions, offsets = [], [], []
        for first in range(0, len(time) - 1, CACHED_STEPS):
            some = slice(first + 1, first + 1 + CACHED_STEPS)
            rows = self._table.rows(time[some], acting[some])
            history = march(rows.linear, state)
            state = history[-1]
            histories.append(history if first == 0 else history[1:])
            expansions.append(rows.following.expansion)
            offsets.append(rows.following.offset)
        whole = VibrationState(
            *(
                np.concatenate([getattr(h, name) for h in histories])
                for name in ("position", "velocity", "acceleration")
            )
        )
        if not self._linkage.is_condensed:
            return whole, Following.of_all(self._linkage.size)
        start = self._table.rows(time[:1], acting[:1]).following
        return whole, Following(
            np.concatenate([start.expansion, *expansions]),
            np.concatenate([start.offset, *offsets]),
        )
