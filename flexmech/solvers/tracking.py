"""Following modes from one crank angle to the next.

Modes are compared by the mass-weighted modal assurance criterion and assigned one to one;
nothing is re-sorted in silence: the score is kept, veering is flagged, and a branch that
is lost or does not return to itself after a full turn says so. Where the score is not clear the
step is divided.
Two modes veer where they come close, exchange their shapes and part again, each in its order.

Two modes whose frequencies come close exchange their shapes. Near there they are two lines that
are coupled: with the least gap g of the frequencies, and the rate s at which they part farther
away, the shapes have turned by ``atan2(g, s (theta - theta_0)) / 2``. They exchange over the width
``w = g / s`` of the crank angle, and a step h over all of it sees them exchanged with a modal
assurance of at most ``1 / (1 + (2 w / h)^2)``.

So the score of a step bounds the width, and the width decides which of two things happened. Below
``CROSSING_WIDTH`` it is a crossing: the crank passes it in a small part of a period, and what
vibrates keeps its shape. Above it is veering: the modes keep their order. A step that can be
read both ways is divided until it cannot.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from flexmech.arrays import SAME_PLACE, FloatArray, IntArray
from flexmech.errors import FlexmechError


def cross_amplitude(first: NDArray[Any], second: NDArray[Any]) -> FloatArray:
    """``|x_i^H M x_j|`` between the modes of paired positions.

    Parameters
    ----------
    first, second : ndarray, shape (B, n, m)
        Mode shapes of unit mass, in coordinates of unit mass
        (:meth:`flexmech.mechanics.LinearSystem.inertial_shapes`).

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
        rows, columns = scipy.optimize.linear_sum_assignment(amplitude[number] ** 2, maximize=True)
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
    a, b = (s / _lengths(s) for s in (a, b))
    source: IntArray = assign(np.abs(a.conj() @ b.T)[None])[0]
    return source if numbering is None else numbering[source]


def _lengths(shapes: NDArray[Any]) -> FloatArray:
    """Norm of each shape (m, 1); one where nothing moves but sections turn, at stations of none."""
    length = np.linalg.norm(shapes, axis=1, keepdims=True)
    return np.where(length > 0, length, 1.0)


logger = logging.getLogger(__name__)

Mask = NDArray[np.bool_]

# A mode that keeps this part of its kinetic energy in one shape is that shape: what is left for any
# other one is a fifth.
UNAMBIGUOUS_MAC = 0.8
# Width of the angles over which two modes exchange shapes: where that takes less, they
# cross, since the crank passes it in a small part of a period at any speed below the first
# frequency.
CROSSING_WIDTH = np.radians(0.25)
# Steps are divided at whole degrees, so that coarse maps track the modes along the positions of
# the map of one degree; and below where modes exchange over about as much, to the least step.
USUAL_STEP, LEAST_STEP = np.radians(1.0), np.radians(1 / 16)
# A shape of which no mode of the other position has more than this was not there: of the modes that
# stay, neighbouring positions have four fifths.
NEW_SHAPE = 0.2


class Positions(NamedTuple):
    """Modes at crank angles.

    Parameters
    ----------
    crank_angle : ndarray, shape (P,)
        Increasing, rad.
    frequency : ndarray, shape (P, m)
        Ascending.
    shapes : ndarray, shape (P, N, m)
        In coordinates of unit mass.
    """

    crank_angle: FloatArray
    frequency: FloatArray
    shapes: NDArray[Any]


# Solves for the modes at crank angles, shape (B,).
Between = Callable[[FloatArray], Positions]


@dataclass(frozen=True)
class Chain:
    """Positions along which modes are tracked.

    Parameters
    ----------
    positions : Positions
        P of them.
    asked : ndarray of bool, shape (P,)
        Those that were asked for.
    unsolved : ndarray
        Crank angles that would have divided a step, and where there are no modes.
    """

    positions: Positions
    asked: Mask
    unsolved: FloatArray

    @property
    def step(self) -> FloatArray:
        """Differences of the crank angles in rad, shape (P - 1,)."""
        return np.diff(self.positions.crank_angle)

    def amplitude(self) -> FloatArray:
        """Square root of the modal assurance criterion between neighbours, (P - 1, m, m)."""
        return cross_amplitude(self.positions.shapes[:-1], self.positions.shapes[1:])

    def passed_over(self, unclear: Mask) -> dict[int, FloatArray]:
        """Positions in the middle of a crossing.

        Their modes are mixtures, like neither those before nor those after, which are like each
        other: the modes are tracked from before to after.

        Parameters
        ----------
        unclear : ndarray of bool, shape (P - 1, m)
            Modes that a step leaves unclear.

        Returns
        -------
        dict of int to ndarray, shape (m, m)
            Amplitudes from the position before to the one after, by the number of the position.
        """
        angle, shapes = self.positions.crank_angle, self.positions.shapes
        narrow = self.step <= USUAL_STEP + SAME_PLACE
        doubtful = unclear.any(axis=1) & narrow
        beside = doubtful[:-1].astype(int) + doubtful[1:]
        # First those that both steps leave unclear.
        candidates = np.flatnonzero((beside > 0) & narrow[:-1] & narrow[1:])
        restored: dict[int, FloatArray] = {}
        for place in (candidates[np.argsort(-beside[candidates], kind="stable")] + 1).tolist():
            if place - 1 in restored or place + 1 in restored:
                continue
            across = cross_amplitude(shapes[place - 1 : place], shapes[place + 1 : place + 2])
            if is_unambiguous(across, assign(across), angle[place + 1] - angle[place - 1]).all():
                restored[place] = across[0]
        return restored

    def divided(self, steps: Mask, between: Between) -> Chain:
        """The chain with one more position in each of some steps; shape (P - 1,)."""
        wanted = self.middles()[steps]
        solved = _solved(wanted, between)
        added = [p.crank_angle for p in solved]
        every = [self.positions, *solved]
        angle = np.concatenate([p.crank_angle for p in every])
        order = np.argsort(angle, kind="stable")
        merged = Positions(*(np.concatenate(parts)[order] for parts in zip(*every, strict=True)))
        asked = np.concatenate([self.asked, np.zeros(len(angle) - len(self.asked), dtype=bool)])
        missing = np.setdiff1d(wanted, np.concatenate(added)) if added else wanted
        return Chain(merged, asked[order], np.concatenate([self.unsolved, missing]))

    def middles(self) -> FloatArray:
        """Where each step is divided: at a whole degree, if there is one inside."""
        start, end = (
            np.degrees(self.positions.crank_angle[:-1]),
            np.degrees(self.positions.crank_angle[1:]),
        )
        middle = (start + end) / 2
        whole = np.round(middle)
        inside = (whole > start + SAME_PLACE) & (whole < end - SAME_PLACE)
        return np.radians(np.where(inside, whole, middle))


def is_unambiguous(amplitude: FloatArray, origin: IntArray, step: FloatArray) -> Mask:
    """Whether it is clear which mode at the start of a step each one at its end is.

    Parameters
    ----------
    amplitude : ndarray, shape (B, m, m)
    origin : ndarray of int, shape (B, m)
        For each mode at the end the one at the start.
    step : ndarray, shape (B,)
        In rad.

    Returns
    -------
    ndarray of bool, shape (B, m)
    """
    score = np.take_along_axis(amplitude, origin[:, None, :], axis=1)[:, 0] ** 2
    square = np.square(step)[..., None]
    # A mode that has changed its place in the order may have crossed another or veered from it.
    crossing = square / (square + (2 * CROSSING_WIDTH) ** 2)
    moved = origin != np.arange(origin.shape[1])
    needed = np.where(moved, np.maximum(crossing, UNAMBIGUOUS_MAC), UNAMBIGUOUS_MAC)
    return np.asarray(score >= needed)


def ambiguous_modes(amplitude: FloatArray, step: FloatArray) -> tuple[Mask, Mask]:
    """Modes at the end of each step that are not clearly one of those at its start.

    Parameters
    ----------
    amplitude : ndarray, shape (B, m, m)
    step : ndarray, shape (B,)

    Returns
    -------
    unclear, replaced : ndarray of bool, shape (B, m)
        And those of them whose shape was not there, in place of one that is there no longer:
        among m modes the highest comes and goes.
    """
    origin = assign(amplitude)
    unclear = ~is_unambiguous(amplitude, origin, step)
    alike = amplitude**2
    lost = np.take_along_axis(alike.max(axis=2), origin, axis=1) < NEW_SHAPE
    return unclear, unclear & lost & (alike.max(axis=1) < NEW_SHAPE)


def refined(chain: Chain, between: Between) -> Chain:
    """Divide steps until they are clear, or as short as can be.

    Parameters
    ----------
    chain : Chain
    between : callable

    Returns
    -------
    Chain
    """
    while True:
        unclear, replaced = ambiguous_modes(chain.amplitude(), chain.step)
        possible = ~np.isin(chain.middles(), chain.unsolved)
        wide = (chain.step > USUAL_STEP + SAME_PLACE) & possible
        steps = wide & unclear.any(axis=1)
        if not steps.any():
            narrow = _narrow_to_divide(chain, unclear, replaced)
            # Beside them usual steps, lest one end lies inside a crossing.
            steps = wide & (np.append(narrow[1:], False) | np.append(False, narrow[:-1]))
            if not steps.any():
                steps = narrow & possible & (chain.step > LEAST_STEP + SAME_PLACE)
        if not steps.any():
            return chain
        chain = chain.divided(steps, between)


def _narrow_to_divide(chain: Chain, unclear: Mask, replaced: Mask) -> Mask:
    """Steps of the usual length and below that are unclear, and not by an end in a crossing."""
    doubtful: Mask = np.any(unclear & ~replaced, axis=1)
    narrow: Mask = np.logical_and(doubtful, chain.step <= USUAL_STEP + SAME_PLACE)
    for place in chain.passed_over(unclear):
        narrow[place - 1 : place + 1] = False
    return narrow


def _solved(crank_angle: FloatArray, between: Between) -> list[Positions]:
    """Modes at crank angles, without those where the linkage cannot be or is unstable."""
    try:
        return [between(crank_angle)]
    except FlexmechError as error:
        logger.info("no modes to follow at every one of %d angles: %s", len(crank_angle), error)
        if len(crank_angle) == 1:
            return []
    return [position for angle in crank_angle for position in _solved(np.array([angle]), between)]


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
                *(np.concatenate([values, values[:1]]) for values in positions[1:]),
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
    tracked = _tracked(chain, amplitude, numbering)
    order = np.argsort(tracked.branch, axis=1)
    frequency = np.take_along_axis(chain.positions.frequency, order, axis=1)
    score = np.take_along_axis(tracked.score, order, axis=1)
    torn = np.take_along_axis(tracked.unclear, order, axis=1)
    # A mixture by which nothing was tracked is no low score, unless it was asked for.
    score[[place for place in tracked.passed_over if not asked[place]]] = 1.0
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
        return np.take_along_axis(values, tracked.branch[asked], axis=1)

    return Branches(
        branch=tracked.branch[asked],
        mac=by_mode(np.minimum.reduceat(score[:last], since)),
        veering=by_mode(veering),
        unclear=by_mode(np.logical_or.reduceat(torn[:last], since)),
        whole=whole,
    )
