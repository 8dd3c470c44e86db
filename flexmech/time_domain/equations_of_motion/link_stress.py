"""Stress of one reduced link as a sum of few distributions with time histories."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from flexmech.arrays import FloatArray


@dataclass(frozen=True)
class StressShapes:
    """Distributions of stress in one reduced link, r of them.

    Parameters
    ----------
    stiffness : ndarray, shape (r, n, n)
    prestress : ndarray, shape (r, n)
    offset : ndarray, shape (r,)
        Energy that does not depend on the coordinates.
    damping : ndarray, shape (r, n, n), or (n, n) of damping that does not vary
    """

    stiffness: FloatArray
    prestress: FloatArray
    offset: FloatArray
    damping: FloatArray

    @classmethod
    def straight(cls, stiffness: FloatArray, damping: FloatArray) -> Self:
        """Single distribution of a straight, stress-free link; matrices of shape (n, n)."""
        return cls(stiffness[None], np.zeros((1, len(stiffness))), np.zeros(1), damping)

    @classmethod
    def unpacked(cls, values: FloatArray, size: int, damping: FloatArray) -> Self:
        """Distributions from rows of stiffness, prestress, offset and, where it varies, damping.

        Parameters
        ----------
        values : ndarray, shape (r, total)
        size : int
            Number n of coordinates.
        damping : ndarray, shape (n, n)
            Where it does not vary.
        """
        square, last = size * size, size * size + size
        shape, varying = (-1, size, size), values[:, last + 1 :]
        return cls(
            np.ascontiguousarray(values[:, :square]).reshape(shape),
            np.ascontiguousarray(values[:, square:last]),
            np.ascontiguousarray(values[:, last]),
            np.ascontiguousarray(varying).reshape(shape) if varying.shape[1] else damping,
        )


@dataclass(frozen=True)
class LinkStress:
    """Internal force ``prestress + stiffness @ p`` of one link at m instants, and its rate.

    Its potential is ``offset + prestress . p + p . stiffness p / 2``.

    Parameters
    ----------
    shapes : StressShapes
    share, share_rate : ndarray, shape (m, r)
        Amplitude of each distribution, and its time derivative.
    """

    shapes: StressShapes
    share: FloatArray
    share_rate: FloatArray

    @property
    def stiffness(self) -> FloatArray:
        """Stiffness matrix, (m, n, n)."""
        return np.tensordot(self.share, self.shapes.stiffness, 1)

    @property
    def prestress(self) -> FloatArray:
        """Internal force at zero coordinates, (m, n)."""
        return np.asarray(self.share @ self.shapes.prestress)

    @property
    def damping(self) -> FloatArray:
        """Damping matrix, (n, n), or (m, n, n) where it varies."""
        damping = self.shapes.damping
        return damping if damping.ndim == 2 else np.tensordot(self.share, damping, 1)

    def of(self, displacement: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Internal force, potential, and power by the change of the stress alone.

        Parameters
        ----------
        displacement : ndarray, shape (m, n)

        Returns
        -------
        tuple of ndarray, shape (m, n), (m,) and (m,)
        """
        shapes = self.shapes
        pulled = _times_each(displacement, shapes.stiffness)
        work = np.einsum("mrn,mn->mr", pulled, displacement) / 2
        work += displacement @ shapes.prestress.T + shapes.offset
        force = self.prestress + np.einsum("mr,mrn->mn", self.share, pulled)
        potential, power = (np.einsum("mr,mr->m", s, work) for s in (self.share, self.share_rate))
        return force, potential, power

    def damping_force(self, rate: FloatArray) -> FloatArray:
        """Force of damping at rates of shape (m, n), (m, n)."""
        damping = self.shapes.damping
        if damping.ndim == 2:
            return np.asarray(rate @ damping)
        return np.asarray(np.einsum("mr,mrn->mn", self.share, _times_each(rate, damping)))


def _times_each(vectors: FloatArray, matrices: FloatArray) -> FloatArray:
    """Vectors (m, n) times each of r symmetric matrices (r, n, n); (m, r, n)."""
    side_by_side = np.moveaxis(matrices, 0, 1).reshape(matrices.shape[1], -1)
    return np.asarray(vectors @ side_by_side).reshape(len(vectors), *matrices.shape[:2])
