"""The last turn of a run, over crank angle, with as many samples as a screen shows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.plots import reading

# In degrees: round-off must not lose the sample a full turn before the last one.
ROUND_OFF = 1e-6
FULL = 360.0
MOST_POINTS = 400
"""Points of a line over a turn: a screen shows no more of it in a plot of that width."""


@dataclass(frozen=True)
class LastTurn:
    """Samples of a run in its last turn.

    Parameters
    ----------
    angle : ndarray, shape (n,)
        Crank angle in degrees, increasing; of a whole turn from 0 to 360.
    kept : ndarray of int, shape (n,)
        Numbers of the run's samples at these angles.
    samples : int
        Of the turn before it was thinned.
    """

    angle: FloatArray
    kept: IntArray
    samples: int

    @property
    def left_out(self) -> int:
        """How many samples are not kept."""
        return max(0, self.samples - len(self.kept))

    def of(self, values: FloatArray) -> FloatArray:
        """Values of the run at these angles; shape (time, ...) -> (n, ...)."""
        return np.asarray(values[self.kept])


def over_a_turn(angle: FloatArray, *, thin: bool = True) -> LastTurn:
    """The last turn of samples at crank angles in rad, which may turn either way.

    Parameters
    ----------
    angle : ndarray, shape (N,)
    thin : bool
        Whether to leave out what a screen does not show.

    Returns
    -------
    LastTurn
    """
    degrees = reading.degrees(angle)
    inside = np.flatnonzero(np.abs(degrees[-1] - degrees) <= FULL + ROUND_OFF)
    kept = inside[thinning(len(inside))] if thin else inside
    shown = degrees[kept]
    whole = abs(abs(shown[-1] - shown[0]) - FULL) <= ROUND_OFF
    if whole:
        # The first sample of the turn is its last one: one of them stands at 0 and at 360.
        turned = np.round(np.mod(shown[1:], FULL), 9) % FULL
        order = np.argsort(turned)
        turned, kept = turned[order], kept[1:][order]
        if turned[0] == 0.0:
            return LastTurn(np.append(turned, FULL), np.append(kept, kept[0]), len(inside))
        # No sample stands at 0: neighbours across it close the turn.
        around = np.concatenate([[turned[-1] - FULL], turned, [turned[0] + FULL]])
        return LastTurn(around, np.concatenate([kept[-1:], kept, kept[:1]]), len(inside))
    order = np.argsort(shown)
    start = FULL * np.floor((shown.min() + ROUND_OFF) / FULL)
    return LastTurn(shown[order] - start, kept[order], len(inside))


def thinning(size: int, most: int = MOST_POINTS) -> IntArray:
    """Which of evenly spaced samples are kept: every n-th, and the last one.

    Parameters
    ----------
    size : int
    most : int

    Returns
    -------
    ndarray of int
    """
    step = max(1, -(-(size - 1) // most))
    kept = np.arange(0, size, step)
    return kept if kept.size and kept[-1] == size - 1 else np.append(kept, size - 1)
