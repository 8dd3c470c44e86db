"""Trapezoidal rule for a driven linkage with linear equations."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.dynamical_systems import StepOperators, VibrationState, march, step_operators
from flexmech.time_domain.equations_of_motion.driven_linkage import DrivenLinkage
from flexmech.time_domain.equations_of_motion.equations import StaticExpansion
from flexmech.time_domain.integrators.position_table import PositionTable

# Steps whose operators are interpolated at once. Speed alone: they stay in the processor's cache.
CACHED_STEPS = 64


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
        # Not by a method of its own: what refers to itself is kept until memory is searched for it.
        self._table = PositionTable(linkage, partial(_operators, linkage, step, load))

    def rows(
        self, time: FloatArray, force: FloatArray | None = None
    ) -> tuple[StepOperators, StaticExpansion]:
        """Operators of the steps that end at some times, valid until the next call.

        Parameters
        ----------
        time : ndarray, shape (m,)
            In s.
        force : ndarray, shape (m,), optional
            Amplitude of the table's load at these times; needed where it has one.

        Returns
        -------
        StepOperators
        StaticExpansion
        """
        advance, forced, pushed, *rest = self._table.at(time)
        acting = self._linkage.histories(time, force)
        expansion = StaticExpansion.of_all(self._linkage.size)
        if rest:
            matrix, offset, pushed_offset = rest
            expansion = StaticExpansion(matrix.copy(), offset + _under(acting, pushed_offset))
        return StepOperators(self._step, advance, forced + _under(acting, pushed)), expansion


def _operators(
    linkage: DrivenLinkage, step: float, load: Sequence[FloatArray] | None, time: FloatArray
) -> list[FloatArray]:
    """Arrays of :class:`StepTable` at times of shape (m,)."""
    equations = linkage.equations(time, tables=False)
    units = linkage.unit_equations(time, load)
    linear, expansion = step_operators(equations, step), equations.expansion
    pushed = [step_operators(one, step).forced for one in units]
    parts = [linear.advance, linear.forced, _side_by_side(pushed, linear.forced)]
    if linkage.is_condensed:
        offsets = [one.expansion.offset for one in units]
        parts += [expansion.matrix, expansion.offset]
        parts.append(_side_by_side(offsets, expansion.offset))
    return parts


def _side_by_side(units: list[FloatArray], like: FloatArray) -> FloatArray:
    """Responses to unit loads, (m, k, n), stacked from k arrays (m, n)."""
    return np.swapaxes(np.reshape(units, (len(units), *like.shape)), 0, 1)


def _under(force: FloatArray, units: FloatArray) -> FloatArray:
    """Response to loads of amplitudes (m, k), (m, n), from those to unit loads."""
    return np.asarray(np.einsum("mk,mkn->mn", force, units))


class LinearMarch:
    """Time stepping of a linkage with linear equations.

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
        """Prepare for another run; nothing is kept between runs."""

    def advance(
        self, time: FloatArray, state: VibrationState, force: FloatArray | None = None
    ) -> tuple[VibrationState, StaticExpansion]:
        """Advance from the first of some times to the others, in parts that fit the cache.

        Parameters
        ----------
        time : ndarray, shape (m + 1,)
            In s, one step apart.
        state : VibrationState
            At the first of them, arrays of shape (n,).
        force : ndarray, shape (m + 1,), optional
            Amplitude of the table's load at these times; needed where it has one.

        Returns
        -------
        VibrationState
            Arrays of shape (m + 1, n).
        StaticExpansion
            At the same times.
        """
        acting = np.zeros((len(time), 0)) if force is None else force
        histories, expansions, offsets = [], [], []
        for first in range(0, len(time) - 1, CACHED_STEPS):
            some = slice(first + 1, first + 1 + CACHED_STEPS)
            operators, expansion = self._table.rows(time[some], acting[some])
            history = march(operators, state)
            state = history[-1]
            histories.append(history if first == 0 else history[1:])
            expansions.append(expansion.matrix)
            offsets.append(expansion.offset)
        whole = VibrationState(
            *(
                np.concatenate([getattr(h, name) for h in histories])
                for name in ("position", "velocity", "acceleration")
            )
        )
        if not self._linkage.is_condensed:
            return whole, StaticExpansion.of_all(self._linkage.size)
        start = self._table.rows(time[:1], acting[:1])[1]
        return whole, StaticExpansion(
            np.concatenate([start.matrix, *expansions]),
            np.concatenate([start.offset, *offsets]),
        )
