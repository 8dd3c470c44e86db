"""Vibration modes of a link with its joined ends held.

Of few elements all modes are found at once. Of many the lowest are found alone, by Lanczos' method
on the inverse of the stiffness (shift-invert, ARPACK), so that nothing grows with the square of
the number of elements.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.sparse.linalg import LinearOperator, eigsh

from flexmech.linear_system.chains import ChainMatrix, couples
from flexmech.linear_system.flexibility import Flexibility
from flexmech.linear_system.link_model import LinkModel
from flexmech.types import FloatArray, IntArray

# Of many elements so many modes are found first, twice as many where these are too few.
FIRST_MODES = 24
# All modes are found at once where the lowest are more than this part of them.
LARGE_PART = 1 / 4


class HeldModes:
    """Mass-normalized vibration modes in a space of shapes, as many as are asked for.

    Parameters
    ----------
    link : LinkModel
        Unreduced.
    which : ndarray of int, shape (m,)
        Coordinates that move, one in each shape.
    following : ndarray of int, shape (k,), optional
        Coordinates that follow statically.
    """

    def __init__(self, link: LinkModel, which: IntArray, following: IntArray | None = None) -> None:
        self._link, self._which = link, which
        self._following = which[:0] if following is None else following
        moves, follows = (np.isin(np.arange(link.size), x) for x in (which, self._following))
        self._couples = couples(link.stiffness, moves, follows)
        self._frequency, self._shapes = np.zeros(0), np.zeros((link.size, 0))

    def lowest(self, count: int) -> FloatArray:
        """Angular frequencies in rad/s of so many modes, or of all if there are fewer."""
        self._find(count)
        return self._frequency[:count]

    def below(self, frequency: float) -> int:
        """Number of modes up to an angular frequency in rad/s."""
        self._find(1)
        while len(self._frequency) < len(self._which) and self._frequency[-1] <= frequency:
            self._find(2 * len(self._frequency))
        return int(np.sum(self._frequency <= frequency))

    def shapes(self, first: int, last: int) -> FloatArray:
        """Modes from one number up to another, (n, last - first), or up to the last one."""
        self._find(last)
        return self._shapes[:, first:last]

    def _find(self, count: int) -> None:
        """Find so many modes at least, if there are so many."""
        size = len(self._which)
        if min(count, size) <= len(self._frequency):
            return
        many = isinstance(self._link.stiffness, ChainMatrix)
        count = max(count, FIRST_MODES)
        if many and count < LARGE_PART * size:
            self._frequency, self._shapes = self._lowest(count)
        else:
            self._frequency, self._shapes = self._all()

    def _all(self) -> tuple[FloatArray, FloatArray]:
        link = self._link
        shapes = self._moved(np.eye(len(self._which)))
        unit_mass = np.linalg.inv(np.linalg.cholesky(shapes.T @ (link.mass @ shapes))) @ shapes.T
        values, vectors = np.linalg.eigh(unit_mass @ (link.stiffness @ unit_mass.T))
        return np.sqrt(np.abs(values)), unit_mass.T @ vectors

    def _lowest(self, count: int) -> tuple[FloatArray, FloatArray]:
        link, which, size = self._link, self._which, len(self._which)
        free = np.union1d(which, self._following) if self._couples else which
        place, flexibility = np.searchsorted(free, which), Flexibility(link.stiffness, free)

        def inverse(load: FloatArray) -> FloatArray:
            forces = np.zeros((len(free), 1))
            forces[place, 0] = load.ravel()
            return np.asarray(flexibility.answers(forces)[place, 0])

        def inertia(amplitude: FloatArray) -> FloatArray:
            return self._load(link.mass @ self._moved(amplitude.reshape(size, -1)))[:, 0]

        def elastic(amplitude: FloatArray) -> FloatArray:
            return self._load(link.stiffness @ self._moved(amplitude.reshape(size, -1)))[:, 0]

        stiffness, mass, answer = (
            LinearOperator((size, size), matvec=product, dtype=float)
            for product in (elastic, inertia, inverse)
        )
        # A start that has a part of every mode, and is the same in each run.
        start = np.random.default_rng(0).standard_normal(size)
        squares, vectors = eigsh(stiffness, count, mass, sigma=0.0, OPinv=answer, v0=start)
        order = np.argsort(squares)
        return np.sqrt(np.abs(squares[order])), self._moved(vectors[:, order])

    def _moved(self, amplitudes: FloatArray) -> FloatArray:
        """Coordinates (n, k) of the link by amplitudes (m, k) of the shapes."""
        moved = _scattered(self._link.size, self._which, amplitudes)
        if self._couples:
            force = (self._link.stiffness @ moved)[self._following]
            moved[self._following] = -self._held.answers(force)
        return moved

    def _load(self, forces: FloatArray) -> FloatArray:
        """Loads (m, k) on the shapes of forces (n, k) on the coordinates."""
        load = forces[self._which]
        if self._couples:
            answer = _scattered(
                self._link.size, self._following, self._held.answers(forces[self._following])
            )
            load = load - (self._link.stiffness @ answer)[self._which]
        return load

    @cached_property
    def _held(self) -> Flexibility:
        """Of what follows."""
        return Flexibility(self._link.stiffness, self._following)


def _scattered(size: int, rows: IntArray, values: FloatArray) -> FloatArray:
    """Vectors (size, k) with values (r, k) in some rows."""
    whole = np.zeros((size, values.shape[1]))
    whole[rows] = values
    return whole
