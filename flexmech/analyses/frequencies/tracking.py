"""Which mode at one crank angle is which at the next.

Modes are compared by the mass-weighted modal assurance criterion and assigned one to one;
nothing is re-sorted in silence: the score is kept, veering is flagged, and a branch that
is lost or does not return to itself after a full turn says so.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from flexmech.types import FloatArray, IntArray

__all__ = ["Branches", "Tracker", "assign", "cross_amplitude", "find_veering", "same_shapes"]


# Two shapes with a lower score share less than half of their kinetic energy.
BROKEN_MAC = 0.5
# Branches veer when they come this close (relative to their mean frequency) ...
VEERING_GAP = 0.25
# ... and their shapes turn into one another by an angle (rad) between these bounds on the
# way through. Two shapes that exchange turn by a quarter; more is a slow drift of both.
VEERING_ROTATION = (0.35, 1.6)


def cross_amplitude(first: NDArray[Any], second: NDArray[Any]) -> FloatArray:
    """``|x_i^H M x_j|`` between the modes of paired positions.

    Parameters
    ----------
    first, second : ndarray, shape (B, n, m)
        Mode shapes of unit mass, in coordinates of unit mass
        (:meth:`flexmech.linear_system.LinearSystem.inertial_shapes`).

    Returns
    -------
    ndarray, shape (B, m, m)
        Square root of the modal assurance criterion.
    """
    amplitude: FloatArray = np.abs(np.swapaxes(first.conj(), 1, 2) @ second)
    return amplitude


def assign(amplitude: FloatArray) -> IntArray:
    """One-to-one assignment of the greatest total MAC.

    Parameters
    ----------
    amplitude : ndarray, shape (B, m, m)

    Returns
    -------
    ndarray of int, shape (B, m)
        For each mode (column) of the second position its mode of the first.
    """
    best: IntArray = amplitude.argmax(axis=1)
    unclear = np.flatnonzero(np.any(np.sort(best, axis=1) != np.arange(best.shape[1]), axis=1))
    for number in unclear:
        rows, columns = linear_sum_assignment(amplitude[number] ** 2, maximize=True)
        best[number, columns] = rows
    return best


def same_shapes(known: NDArray[Any], shapes: NDArray[Any], numbering: IntArray | None) -> IntArray:
    """Branch numbers of modes by their likeness to modes with known numbers.

    For modes of different crank speeds, whose coordinates may differ: compared as
    displacements along the links.

    Parameters
    ----------
    known, shapes : ndarray, shape (m, n_links, n_stations, 2)
    numbering : ndarray of int, shape (m,), or None
        Branch of each known mode; in order by default.

    Returns
    -------
    ndarray of int, shape (m,)
    """
    a, b = (np.reshape(s, (len(s), -1)) for s in (known, shapes))
    a, b = (s / np.linalg.norm(s, axis=1, keepdims=True) for s in (a, b))
    source: IntArray = assign(np.abs(a.conj() @ b.T)[None])[0]
    return source if numbering is None else numbering[source]


@dataclass(frozen=True)
class Branches:
    """Tracked modes along the crank angles of one speed; m modes at A angles.

    Parameters
    ----------
    branch : ndarray of int, shape (A, m)
        Branch of each mode, counted from 0.
    mac : ndarray, shape (A, m)
        Score against the same branch at the previous angle; 1 at the first.
    veering : ndarray of bool, shape (A, m)
    whole : ndarray of bool, shape (m,)
        By branch: tracked without a break and, after a full turn, back to itself.
    """

    branch: IntArray
    mac: FloatArray
    veering: NDArray[np.bool_]
    whole: NDArray[np.bool_]


class Tracker:
    """Follows the modes of one crank speed as positions come in, batch by batch.

    Parameters
    ----------
    numbering : ndarray of int, shape (m,), optional
        Branch numbers at the first angle; in order of frequency by default.
    """

    def __init__(self, numbering: IntArray | None = None) -> None:
        self._numbering = numbering
        self._last: NDArray[Any] | None = None
        self._first: NDArray[Any] | None = None
        self._amplitude: list[FloatArray] = []

    def add(self, shapes: NDArray[Any]) -> None:
        """Take the next positions: mode shapes (B, n, m) in coordinates of unit mass."""
        if self._last is None:
            self._first = shapes[:1]
        else:
            shapes = np.concatenate([self._last, shapes])
        self._amplitude.append(cross_amplitude(shapes[:-1], shapes[1:]))
        self._last = shapes[-1:]

    def finish(self, frequency: FloatArray, full_turn: bool) -> Branches:
        """Number the branches.

        Parameters
        ----------
        frequency : ndarray, shape (A, m)
        full_turn : bool
            Whether the last angle leads back to the first.

        Returns
        -------
        Branches
        """
        assert self._first is not None
        assert self._last is not None
        amplitude = np.concatenate(self._amplitude)
        count = frequency.shape[1]
        origin = assign(amplitude)
        branch = np.empty((len(frequency), count), dtype=np.intp)
        branch[0] = np.arange(count) if self._numbering is None else self._numbering
        for step, source in enumerate(origin):
            branch[step + 1] = branch[step][source]
        mac = np.ones((len(frequency), count))
        mac[1:] = np.take_along_axis(amplitude, origin[:, None, :], axis=1)[:, 0] ** 2

        by_branch = np.argsort(branch, axis=1)
        whole = np.take_along_axis(mac, by_branch, axis=1).min(axis=0) >= BROKEN_MAC
        if full_turn:
            closing = cross_amplitude(self._last, self._first)[0]
            home = closing[by_branch[-1], by_branch[0]] ** 2
            whole &= home >= BROKEN_MAC
        steps = amplitude[
            np.arange(len(amplitude))[:, None, None],
            by_branch[:-1, :, None],
            by_branch[1:, None, :],
        ]
        veering = find_veering(np.take_along_axis(frequency, by_branch, axis=1), steps)
        return Branches(branch, mac, np.take_along_axis(veering, branch, axis=1), whole)


def find_veering(frequency: FloatArray, amplitude: FloatArray) -> NDArray[np.bool_]:
    """Where branches come close and exchange their shapes.

    Parameters
    ----------
    frequency : ndarray, shape (A, m)
        By branch.
    amplitude : ndarray, shape (A - 1, m, m)
        Cross amplitudes between neighbouring angles, by branch.

    Returns
    -------
    ndarray of bool, shape (A, m)
        True through the closest approach of two branches that veer: neighbours that come
        close, part again on both sides, and exchange their shapes in between.
    """
    veering = np.zeros(frequency.shape, dtype=bool)
    count = frequency.shape[1]
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
                    close = _window(gap, least, 1.25)
                    veering[close, a] = True
                    veering[close, b] = True
    return veering


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
