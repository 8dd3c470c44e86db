"""Assignment of the modes of two positions, and positions between that make it clear.

Modes are alike by the mass-weighted modal assurance criterion.

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
# Of the angles over which two modes exchange shapes: where that takes less, they cross, since the
# crank passes it in a small part of a period at any speed below the first frequency.
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
        found: dict[int, FloatArray] = {}
        for place in (candidates[np.argsort(-beside[candidates], kind="stable")] + 1).tolist():
            if place - 1 in found or place + 1 in found:
                continue
            across = cross_amplitude(shapes[place - 1 : place], shapes[place + 1 : place + 2])
            if is_unambiguous(across, assign(across), angle[place + 1] - angle[place - 1]).all():
                found[place] = across[0]
        return found

    def divided(self, steps: Mask, between: Between) -> Chain:
        """The chain with one more position in each of some steps; shape (P - 1,)."""
        wanted = self.middles()[steps]
        found = _solved(wanted, between)
        added = [p.crank_angle for p in found]
        every = [self.positions, *found]
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
    return [found for angle in crank_angle for found in _solved(np.array([angle]), between)]
