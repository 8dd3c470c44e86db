"""Which Floquet mode belongs to which branch of natural modes, speed after speed.

Branches are numbered by frequency at a low crank speed and followed by the shapes of the modes.
The phase of a mode along the turn changes fast with the crank speed, its shape at a crank angle
does not: shapes are compared angle by angle. Where two modes meet and one of them grows, both are
mixtures; the last clear shape of each branch stays the one to compare with.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.optimize
from numpy.typing import NDArray

from flexmech.analyses.stability.kept_modes import KeptModes
from flexmech.types import FloatArray, IntArray

__all__ = ["BranchShapes", "Follower", "likeness"]

# Modes that turn the other way round are taken for a branch only where no other is left.
OTHER_SENSE = 0.3
# From one speed to the next a frequency changes by a small part of this part of itself.
FREQUENCY_CHANGE = 0.1
# Logarithm of a modulus that is growth and not round-off.
GROWS = 1e-7


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

    def order_of(self, modes: KeptModes) -> tuple[IntArray, FloatArray]:
        """Place of each branch's modes among others, and how alike they are, both (k,)."""
        alike = likeness(self.shape, modes.shape)
        same_sense = np.sign(self.frequency)[:, None] * np.sign(modes.exponent.imag) >= 0
        size = np.abs(self.frequency)[:, None]
        change = np.abs(np.abs(modes.exponent.imag) / (2 * np.pi) - size)
        near = np.maximum(0.0, 1 - change / (FREQUENCY_CHANGE * size))
        score = (alike**2 + near) * np.where(same_sense, 1.0, OTHER_SENSE)
        places = scipy.optimize.linear_sum_assignment(-score)[1]
        return places, alike[np.arange(len(places)), places]


@dataclass
class Follower:
    """Numbers the modes of one speed after the other, by increasing size of the speed."""

    shapes: BranchShapes | None = None

    def follow(self, modes: KeptModes) -> tuple[KeptModes, FloatArray]:
        """Modes in the order of their branches, and how alike they are to these, (k,)."""
        if self.shapes is None:
            ordered = modes.taken(_by_frequency(modes))
            frequency = ordered.exponent.imag / (2 * np.pi)
            self.shapes = BranchShapes(ordered.shape.astype(np.complex64), frequency)
            return ordered, np.ones(len(frequency))
        order, alike = self.shapes.order_of(modes)
        ordered = modes.taken(order)
        clear = _clear_branches(ordered)
        frequency = ordered.exponent.imag / (2 * np.pi)
        self.shapes = replace(
            self.shapes,
            shape=np.where(clear, ordered.shape, self.shapes.shape).astype(np.complex64),
            frequency=np.where(clear, frequency, self.shapes.frequency),
        )
        return ordered, alike


def likeness(first: NDArray[np.complex64], second: NDArray[np.complex128]) -> FloatArray:
    """How alike shapes (angles, N, k) and (angles, N, l) are, from 0 to 1, (k, l)."""
    products = np.abs(np.swapaxes(first.conj(), 1, 2) @ second)
    return np.asarray(products.sum(axis=0), dtype=float)


def _clear_branches(modes: KeptModes) -> NDArray[np.bool_]:
    """Modes of branches neither of whose modes grows, (k,)."""
    pairs = (modes.log_modulus.reshape(-1, 2) < GROWS).all(axis=1)
    return np.repeat(pairs, 2)


def _by_frequency(modes: KeptModes) -> IntArray:
    """Branches by frequency, the mode that turns forward before its conjugate."""
    order = np.argsort(np.abs(np.round(modes.exponent.imag, 6)), kind="stable")
    pairs = order.reshape(-1, 2)
    backward = modes.exponent.imag[pairs[:, 0]] < modes.exponent.imag[pairs[:, 1]]
    pairs[backward] = pairs[backward][:, ::-1]
    return np.asarray(pairs.ravel(), dtype=np.intp)
