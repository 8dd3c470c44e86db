"""The trapezoidal rule along a driven linkage whose equations are linear."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmech.time_domain.driven_linkage import DrivenLinkage
from flexmech.time_domain.equations import Following
from flexmech.time_domain.state import VibrationState
from flexmech.time_domain.step_table import StepTable
from flexmech.time_domain.trapezoidal import march
from flexmech.types import FloatArray

# Steps whose operators are interpolated at once.
CACHED_STEPS = 64


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
