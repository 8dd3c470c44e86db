"""Pieces of failure surfaces in the space of a ply's stresses.

Each criterion is a surface about the stress-free state, made of pieces: each piece is a quadric
``s Q s + q s = c`` in the stresses ``s`` = (1, 2, 12) of the ply's axes, and holds in a part of the
space of stresses, such as where the fibres are in tension. Along a ray ``residual + factor *
mechanical`` every piece is a quadratic equation in the factor; the smallest positive root that lies
on its piece is the load factor. So stresses that do not grow with the loads, such as those of
cure, heat and moisture, are exact in all criteria.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import ROUND_OFF, FloatArray

Margin = Callable[[FloatArray], FloatArray]
"""From stresses (3, ...) to a number that is not negative where a piece holds, (...)."""


@dataclass(frozen=True)
class FailureMode:
    """A piece of a failure surface: ``s square s + linear s = level``.

    Parameters
    ----------
    name : str
        How the ply fails there.
    square : ndarray, shape (3, 3)
        Symmetric, in 1/Pa^2.
    linear : ndarray, shape (3,)
        In 1/Pa.
    holds : callable, optional
        From stresses (3, ...) to a margin, in units of strengths, not negative where it holds;
        everywhere if left out.
    level : float
    jump : int, optional
        Number of the stress whose change of sign makes the piece hold at once beyond its surface:
        the criterion is not continuous there.
    """

    name: str
    square: FloatArray
    linear: FloatArray
    holds: Margin | None = None
    level: float = 1.0
    jump: int | None = None

    def value(self, stress: FloatArray) -> FloatArray:
        """Left side of the equation at stresses (3, ...), shape (...)."""
        return self._product(stress, stress) + self._sum(stress)

    def includes(self, stress: FloatArray) -> NDArray[np.bool_]:
        """Whether the piece holds at stresses (3, ...), shape (...); both do where two meet."""
        if self.holds is None:
            return np.ones(stress.shape[1:], dtype=bool)
        return np.asarray(self.holds(stress) >= -ROUND_OFF)

    def load_factor(self, mechanical: FloatArray, residual: FloatArray) -> FloatArray:
        """Smallest factor at which the growing stress meets the piece; infinite where never.

        Parameters
        ----------
        mechanical, residual : ndarray, shape (3, ...)
            In Pa; they broadcast.

        Returns
        -------
        ndarray, shape (...)
            Zero where the residual stress alone is beyond it.
        """
        first = 2 * self._product(mechanical, residual) + self._sum(mechanical)
        start = self.value(residual) - self.level
        found = np.full(first.shape, np.inf)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            if not self.square.any():
                roots = [-start / first]
            else:
                second = self._product(mechanical, mechanical)
                root = np.sqrt(first**2 - 4 * second * start)
                # Without a difference of numbers that are nearly alike.
                larger = -(first + np.copysign(root, first)) / 2
                roots = [larger / second, start / larger]
            if self.jump is not None:
                roots.append(-residual[self.jump] / mechanical[self.jump])
            for number, factor in enumerate(roots):
                there = np.isfinite(factor) & (factor > 0)
                if self.holds is not None:
                    met = residual + np.where(there, factor, 0.0) * mechanical
                    there &= self.includes(met)
                    if number == 2:
                        there &= self.value(met) >= self.level
                np.minimum(found, factor, out=found, where=there)
        return np.where((start >= 0) & self.includes(residual), 0.0, found)

    def _product(self, one: FloatArray, other: FloatArray) -> FloatArray:
        """Stress (3, ...) times ``square`` times another; most of its entries are zero."""
        terms = (
            self.square[i, j] * one[i] * other[j]
            for i, j in np.argwhere(self.square[: len(one), : len(one)]).tolist()
        )
        return np.asarray(sum(terms, np.zeros(np.broadcast_shapes(one[0].shape, other[0].shape))))

    def _sum(self, stress: FloatArray) -> FloatArray:
        terms = (self.linear[i] * stress[i] for i in np.flatnonzero(self.linear).tolist())
        return np.asarray(sum(terms, np.zeros(stress[0].shape)))
