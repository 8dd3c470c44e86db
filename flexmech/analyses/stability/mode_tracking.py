"""Which Floquet mode belongs to which branch of natural modes, speed after speed.

Branches are numbered by frequency at a low crank speed and tracked by the shapes of the modes.
The phase of a mode along the turn changes fast with the crank speed, its shape at a crank angle
does not: shapes are compared angle by angle. Where two modes meet and one of them grows, both are
mixtures; the last unmixed shape of each branch stays the one to compare with.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.optimize
from numpy.typing import NDArray

from flexmech.analyses.stability.selected_modes import GROWS, SelectedModes, wrapped
from flexmech.arrays import FloatArray, IntArray

# What the likeness of a mode that turns the other way round counts for: less than that of any mode
# of the same frequency, and more than that of a stranger.
OTHER_SENSE = 0.3
# From one speed to the next a frequency changes by a small part of this part of itself: modes that
# are mixtures alike are told by it, and those farther off by their shapes alone.
FREQUENCY_CHANGE = 0.05
# A mode at least so much like the shape of its branch takes its place; an even mixture of two has
# 0.7, and one that is less alike belongs elsewhere.
CLEAR = 0.5
# The Krein signature goes to zero where a mode is about to meet another one, or has met it; far
# from others those of the shipped linkages are 0.9 or more.
LEAST_SIGNATURE = 0.6


@dataclass(frozen=True)
class BranchShapes:
    """Shapes of the branches' modes where they were last clear.

    Parameters
    ----------
    shape : ndarray of complex, shape (angles, N, k)
        Two modes a branch: that which turns forward, and its conjugate.
    frequency : ndarray, shape (k,)
        Of the largest harmonic in Hz, negative of those that turn backward.
    """

    shape: NDArray[np.complex64]
    frequency: FloatArray

    def order_of(self, modes: SelectedModes) -> tuple[IntArray, FloatArray]:
        """Place of each branch's modes among others, and how alike they are, both (k,)."""
        alike = likeness(self.shape, modes.shape)
        same_sense = np.sign(self.frequency)[:, None] * np.sign(modes.exponent.imag) >= 0
        size = np.abs(self.frequency)[:, None]
        change = np.abs(np.abs(modes.exponent.imag) / (2 * np.pi) - size)
        # Modes that creep have no frequency.
        most = np.maximum(FREQUENCY_CHANGE * size, np.finfo(float).eps)
        near = np.maximum(0.0, 1 - change / most)
        score = (alike**2 + 2 * near) * np.where(same_sense, 1.0, OTHER_SENSE)
        pairs = conjugate_pairs(modes)
        straight, turned = (
            score[::2, one] + score[1::2, other] for one, other in (pairs.T, pairs.T[::-1])
        )
        branch, pair = scipy.optimize.linear_sum_assignment(-np.maximum(straight, turned))
        is_turned = (turned > straight)[branch, pair]
        places = np.where(is_turned[:, None], pairs[pair, ::-1], pairs[pair]).ravel()
        return places, alike[np.arange(len(places)), places]

    def updated(self, modes: SelectedModes, alike: FloatArray) -> BranchShapes:
        """Take over the modes of branches that neither grow nor are mixtures."""
        clear = (modes.log_modulus < GROWS) & (alike > CLEAR)
        clear &= np.abs(modes.signature) > LEAST_SIGNATURE
        clear = np.repeat(clear.reshape(-1, 2).all(axis=1), 2)
        return BranchShapes(
            np.where(clear, modes.shape, self.shape).astype(np.complex64),
            np.where(clear, modes.exponent.imag / (2 * np.pi), self.frequency),
        )

    def taken(self, order: IntArray) -> BranchShapes:
        """The branches in another order."""
        return BranchShapes(self.shape[..., order], self.frequency[order])


@dataclass(frozen=True)
class TrackedModes:
    """Modes of all speeds in the order of their branches.

    Parameters
    ----------
    modes : list of SelectedModes
    likeness : list of ndarray, shape (k,)
        How alike modes are to the last unmixed shapes of their branches.
    shapes : list of BranchShapes
        Last clear ones up to each speed.
    usual_frequency : ndarray, shape (k / 2,)
        In Hz; see :func:`usual_frequencies`.
    """

    modes: list[SelectedModes]
    likeness: list[FloatArray]
    shapes: list[BranchShapes]
    usual_frequency: FloatArray

    def last(self, count: int) -> TrackedModes:
        """The last speeds alone."""
        first = len(self.modes) - count
        return TrackedModes(
            self.modes[first:], self.likeness[first:], self.shapes[first:], self.usual_frequency
        )


def track_modes(solved: Sequence[SelectedModes]) -> TrackedModes:
    """Track the branches from the first speed on.

    Parameters
    ----------
    solved : sequence of SelectedModes
        By increasing size of the speed.

    Returns
    -------
    TrackedModes
    """
    first = solved[0].taken(_by_frequency(solved[0]))
    shapes = [BranchShapes(first.shape.astype(np.complex64), first.exponent.imag / (2 * np.pi))]
    every, alike = [first], [np.ones(len(first.exponent))]
    for modes in solved[1:]:
        order, same = shapes[-1].order_of(modes)
        every.append(modes.taken(order))
        alike.append(same)
        shapes.append(shapes[-1].updated(every[-1], same))
    # Modes that are mixtures at the first speed may stand in each other's place there.
    frequency = np.abs([modes.exponent.imag[::2] for modes in every]) / (2 * np.pi)
    pairs = np.argsort(np.median(frequency, axis=0))
    order = (2 * pairs[:, None] + np.arange(2)).ravel()
    return TrackedModes(
        [modes.taken(order) for modes in every],
        [same[order] for same in alike],
        [each.taken(order) for each in shapes],
        usual_frequencies(frequency),
    )


def usual_frequencies(frequency: FloatArray) -> FloatArray:
    """Usual frequencies (m,) of m branches, by which modes are numbered.

    The median of the lowest frequency at a speed, of the next one, and so on: free of what branch
    a mixture was taken for. The faster half of the speeds counts. At slow ones the families
    ``f + n f_crank`` are dense, and which member carries the largest harmonic changes often.

    Parameters
    ----------
    frequency : ndarray, shape (speeds, m)
        In Hz, by increasing size of the speed.

    Returns
    -------
    ndarray, shape (m,)
    """
    fast = np.sort(frequency[len(frequency) // 2 :], axis=1)
    return np.asarray(np.median(fast, axis=0))


def likeness(first: NDArray[np.complex64], second: NDArray[np.complex128]) -> FloatArray:
    """How alike shapes (angles, N, k) and (angles, N, l) are, from 0 to 1, (k, l)."""
    products = np.abs(np.swapaxes(first.conj(), 1, 2) @ second)
    return np.asarray(products.sum(axis=0), dtype=float)


def conjugate_pairs(modes: SelectedModes) -> IntArray:
    """Pairs of modes that make a branch each: a mode and its complex conjugate, (m, 2).

    Real multipliers have no conjugate: two that lie on the same side of zero make a branch.
    """
    size = np.abs(modes.log_modulus[:, None] - modes.log_modulus)
    gap = size + np.abs(wrapped(modes.angle[:, None] + modes.angle))
    gap[np.tril_indices(len(gap))] = np.inf
    pairs = []
    for _ in range(len(gap) // 2):
        pair = np.array(np.unravel_index(gap.argmin(), gap.shape))
        pairs.append(pair)
        gap[pair], gap[:, pair] = np.inf, np.inf
    return np.array(pairs, dtype=np.intp)


def _by_frequency(modes: SelectedModes) -> IntArray:
    """Branches by frequency, the mode that turns forward before its conjugate."""
    pairs = conjugate_pairs(modes)
    turning = modes.exponent.imag[pairs]
    forward = np.take_along_axis(pairs, np.argsort(-turning, axis=1), axis=1)
    order = np.argsort(np.abs(turning).min(axis=1), kind="stable")
    return np.asarray(forward[order].ravel(), dtype=np.intp)
