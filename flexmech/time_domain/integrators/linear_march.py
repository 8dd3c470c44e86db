"""Trapezoidal rule for a driven linkage with linear equations."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.dynamical_systems import StepOperators, VibrationState, march, step_matrices
from flexmech.time_domain.equations_of_motion.driven_linkage import DrivenLinkage
from flexmech.time_domain.equations_of_motion.equations import StaticExpansion
from flexmech.time_domain.integrators.position_table import PositionTable

# Steps whose matrices are interpolated at once. Speed alone: they stay in the processor's cache.
CACHED_STEPS = 64


class LinearMarch:
    """Time stepping of a linkage with linear equations.

    Parameters
    ----------
    linkage : DrivenLinkage
    step : float
        In s.
    load : sequence of ndarray, shape (n_full,), optional
        Forces on the unreduced links in their frames, of which a run can take any part at any time.

    Attributes
    ----------
    stride : int
        A run takes a multiple of so many steps.
    """

    stride = 1

    def __init__(
        self, linkage: DrivenLinkage, step: float, load: Sequence[FloatArray] | None = None
    ) -> None:
        self._linkage, self._step, self._load = linkage, step, load
        # Not by a method of its own: what refers to itself is kept until memory is searched for it.
        self._table = PositionTable(linkage, partial(_matrices, linkage, step, load is not None))

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
            At the first of them, arrays of shape (n,), or (n, k) for k motions at once.
        force : ndarray, shape (m + 1,), optional
            Amplitude of the load at these times.

        Returns
        -------
        VibrationState
            Arrays of shape (m + 1, n) or (m + 1, n, k).
        StaticExpansion
            At the same times.
        """
        acting = step_forces(self._linkage, time, self._load, force)
        histories, expansions = [], []
        if self._linkage.is_condensed:
            expansions.append(self._operators(time, acting, slice(1))[1])
        for first in range(0, len(time) - 1, CACHED_STEPS):
            some = slice(first + 1, first + 1 + CACHED_STEPS)
            operators, expansion = self._operators(time, acting, some)
            history = march(operators, state)
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
    ) -> tuple[StepOperators, StaticExpansion]:
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
        return StepOperators(self._step, advance, forced), expansion


def _matrices(
    linkage: DrivenLinkage, step: float, has_load: bool, time: FloatArray
) -> list[FloatArray]:
    """What the steps of :class:`LinearMarch` are made of, at times of shape (m,)."""
    equations = linkage.equations(time, tables=False)
    advance, response = step_matrices(equations, step)
    parts = [advance, (response @ equations.force[..., None])[..., 0]]
    if linkage.is_condensed:
        parts += [equations.expansion.matrix, equations.expansion.offset]
    if has_load or linkage.connectors.has_tables:
        parts += [response, equations.flexibility]
    return parts


def step_forces(
    linkage: DrivenLinkage,
    time: FloatArray,
    load: Sequence[FloatArray] | None,
    amplitude: FloatArray | None,
) -> FloatArray | None:
    """Forces that are not interpolated, with those of a load that a run takes part of.

    Parameters
    ----------
    linkage : DrivenLinkage
    time : ndarray, shape (m,)
        In s.
    load : sequence of ndarray, shape (n_full,), optional
        Forces on the unreduced links in their frames.
    amplitude : ndarray, shape (m,), optional
        What is taken of these.

    Returns
    -------
    ndarray, shape (m, size), or None
    """
    if load is None or amplitude is None:
        return linkage.step_forces(time)
    return linkage.step_forces(time, [np.outer(amplitude, own) for own in load])
