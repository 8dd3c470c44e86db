"""Where two modes come close, exchange their shapes and part again, each in its order."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flexmech.types import FloatArray, IntArray

# Branches veer when they come this close (relative to their mean frequency) ...
VEERING_GAP = 0.25
# ... and their shapes turn into one another by an angle (rad) between these bounds on the
# way through. Two shapes that exchange turn by a quarter; more is a slow drift of both.
VEERING_ROTATION = (0.35, 1.6)


def find_veering(
    frequency: FloatArray,
    amplitude: FloatArray,
    crank_angles: FloatArray,
    asked: NDArray[np.bool_],
) -> NDArray[np.bool_]:
    """Where branches come close and exchange their shapes.

    Parameters
    ----------
    frequency : ndarray, shape (P, m)
        By branch.
    amplitude : ndarray, shape (P - 1, m, m)
        Cross amplitudes between neighbouring angles, by branch.
    crank_angles : ndarray, shape (P,)
    asked : ndarray of bool, shape (P,)
        Angles to flag, A of them; the others help to see what happens between.

    Returns
    -------
    ndarray of bool, shape (A, m)
        True through the closest approach of two branches that veer: neighbours that come
        close, part again on both sides, and exchange their shapes in between. At the nearest
        angle asked for, where that lies between two of them.
    """
    veering = np.zeros(frequency.shape, dtype=bool)
    count, nearest = frequency.shape[1], np.flatnonzero(asked)
    for a in range(count):
        for b in range(a + 1, count):
            gap = np.abs(frequency[:, a] - frequency[:, b])
            gap = gap / ((frequency[:, a] + frequency[:, b]) / 2)
            if gap.min() > VEERING_GAP:
                continue
            turned = np.arcsin(np.minimum(np.maximum(amplitude[:, a, b], amplitude[:, b, a]), 1))
            for least in _minima(gap):
                near = _window(gap, least, 2.0)
                apart_on_both_sides = near.start > 0 and near.stop < len(gap)
                rotation = turned[near.start : near.stop - 1].sum()
                exchange = VEERING_ROTATION[0] <= rotation <= VEERING_ROTATION[1]
                if apart_on_both_sides and exchange and _neighbours(frequency[least], a, b):
                    close = np.zeros(len(gap), dtype=bool)
                    close[_window(gap, least, 1.25)] = True
                    if not np.any(close & asked):
                        close[
                            nearest[np.abs(crank_angles[nearest] - crank_angles[least]).argmin()]
                        ] = True
                    veering[close, a] = veering[close, b] = True
    return veering[asked]


def _neighbours(frequency: FloatArray, a: int, b: int) -> bool:
    """Whether no other branch lies between two."""
    low, high = sorted((frequency[a], frequency[b]))
    return not np.any((frequency > low) & (frequency < high))


def _minima(gap: FloatArray) -> IntArray:
    """Local minima inside the range that are close enough to be veering."""
    inner = (gap[1:-1] <= gap[:-2]) & (gap[1:-1] < gap[2:]) & (gap[1:-1] <= VEERING_GAP)
    return np.flatnonzero(inner) + 1


def _window(gap: FloatArray, centre: int, ratio: float) -> slice:
    """Contiguous angles around a minimum where the gap is below ``ratio`` times its least."""
    outside = np.flatnonzero(gap > ratio * gap[centre])
    before = outside[outside < centre]
    after = outside[outside > centre]
    start = int(before[-1]) + 1 if len(before) else 0
    stop = int(after[0]) if len(after) else len(gap)
    return slice(start, stop)
