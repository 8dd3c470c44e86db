"""Which mode at one crank angle is which at the next.

Modes are compared by the mass-weighted modal assurance criterion and assigned one to one;
nothing is re-sorted in silence: the score is kept, veering is flagged, and a branch that
is lost or does not return to itself after a full turn says so. Where the score is not clear the
step is divided; see :mod:`flexmech.analyses.frequencies.refinement`.
Two modes veer where they come close, exchange their shapes and part again, each in its order.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from flexmech.analyses.frequencies.refinement import (
    Between,
    Chain,
    Positions,
    ambiguous_modes,
    assign,
    refined,
)
from flexmech.arrays import FloatArray, IntArray

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


@dataclass(frozen=True)
class Branches:
    """Tracked modes along the crank angles of one speed; m modes at A angles.

    Parameters
    ----------
    branch : ndarray of int, shape (A, m)
        Branch of each mode, counted from 0.
    mac : ndarray, shape (A, m)
        Least score along the same branch since the previous angle; 1 at the first.
    veering : ndarray of bool, shape (A, m)
    unclear : ndarray of bool, shape (A, m)
        Whether the least step since the previous angle leaves open which mode it is.
    whole : ndarray of bool, shape (m,)
        By branch: tracked without a break and, after a full turn, back to itself.
    """

    branch: IntArray
    mac: FloatArray
    veering: NDArray[np.bool_]
    unclear: NDArray[np.bool_]
    whole: NDArray[np.bool_]


class Tracker:
    """Follows the modes of one crank speed.

    Parameters
    ----------
    numbering : ndarray of int, shape (m,), optional
        Branch numbers at the first angle; in order of frequency by default.
    """

    def __init__(self, numbering: IntArray | None = None) -> None:
        self._numbering = numbering
        self._shapes: list[NDArray[Any]] = []

    def add(self, shapes: NDArray[Any]) -> None:
        """Take the next positions: mode shapes (B, n, m) in coordinates of unit mass."""
        self._shapes.append(shapes)

    def finish(
        self,
        frequency: FloatArray,
        crank_angles: FloatArray,
        *,
        full_turn: bool = False,
        between: Between | None = None,
    ) -> Branches:
        """Number the branches.

        Parameters
        ----------
        frequency : ndarray, shape (A, m)
        crank_angles : ndarray, shape (A,)
            Increasing, rad.
        full_turn : bool
            Whether the last angle leads back to the first.
        between : callable, optional
            Solves for the modes at other angles, where the modes asked for are too far apart to
            be tracked.

        Returns
        -------
        Branches
        """
        asked = np.ones(len(crank_angles) + full_turn, dtype=bool)
        positions = Positions(crank_angles, frequency, np.concatenate(self._shapes))
        if full_turn:
            # The first angle again; not a step where the last one is the same position.
            first = positions.crank_angle[0] + 2 * np.pi
            last = max(first, positions.crank_angle[-1])
            asked[-1] = False
            positions = Positions(
                np.append(positions.crank_angle, last),
                *(np.concatenate([part, part[:1]]) for part in positions[1:]),
            )
        chain = Chain(positions, asked, np.empty(0))
        if between is not None:
            chain = refined(chain, between)
        return _branches(chain, self._numbering, full_turn)


class _Tracked(NamedTuple):
    """Modes along a chain of P positions: numbers (P, m), scores and doubts about them."""

    branch: IntArray
    score: FloatArray
    unclear: NDArray[np.bool_]
    passed_over: list[int]


def _tracked(chain: Chain, amplitude: FloatArray, numbering: IntArray | None) -> _Tracked:
    """Number the modes, each position by the one before, or by that before a mixed one."""
    places, count = chain.positions.frequency.shape
    branch, score = np.empty((places, count), dtype=np.intp), np.ones((places, count))
    unclear = np.zeros((places, count), dtype=bool)
    unclear[1:] = ambiguous_modes(amplitude, chain.step)[0]
    passed = chain.passed_over(unclear[1:])
    before, likeness = np.arange(places) - 1, amplitude.copy()
    for place, across in passed.items():
        before[place + 1], likeness[place] = place - 1, across
        unclear[place : place + 2] = False
    origin = assign(likeness)
    branch[0] = np.arange(count) if numbering is None else numbering
    for place, source in enumerate(origin, start=1):
        branch[place] = branch[before[place]][source]
    score[1:] = np.take_along_axis(likeness, origin[:, None, :], axis=1)[:, 0] ** 2
    return _Tracked(branch, score, unclear, list(passed))


def _branches(chain: Chain, numbering: IntArray | None, full_turn: bool) -> Branches:
    """Branches at the angles asked for, from what was tracked along all of a chain."""
    amplitude, asked = chain.amplitude(), chain.asked
    found = _tracked(chain, amplitude, numbering)
    order = np.argsort(found.branch, axis=1)
    frequency = np.take_along_axis(chain.positions.frequency, order, axis=1)
    score = np.take_along_axis(found.score, order, axis=1)
    torn = np.take_along_axis(found.unclear, order, axis=1)
    # A mixture by which nothing was tracked is no low score, unless it was asked for.
    score[[place for place in found.passed_over if not asked[place]]] = 1.0
    steps = np.arange(len(amplitude))[:, None, None]
    turned = amplitude[steps, order[:-1, :, None], order[1:, None, :]]
    veering = find_veering(frequency, turned, chain.positions.crank_angle, asked)
    # From behind one angle asked for to the next one.
    places = np.flatnonzero(asked)
    since, last = np.append(0, places[:-1] + 1), places[-1] + 1
    whole = np.all(~torn, axis=0)
    if full_turn:
        whole &= order[-1] == order[0]

    def by_mode(values: NDArray[Any]) -> NDArray[Any]:
        return np.take_along_axis(values, found.branch[asked], axis=1)

    return Branches(
        branch=found.branch[asked],
        mac=by_mode(np.minimum.reduceat(score[:last], since)),
        veering=by_mode(veering),
        unclear=by_mode(np.logical_or.reduceat(torn[:last], since)),
        whole=whole,
    )
