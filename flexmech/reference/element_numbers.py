"""Constants of corotational elements, of one design or of several."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray, IntArray


@dataclass(frozen=True)
class ElementNumbers:
    """Constants of e elements, by which their forces are computed.

    Those of one design are the same in all positions; those of several are given in each of B.

    Parameters
    ----------
    length : ndarray, shape (e, 1) or (e, B)
        In m.
    axial_stiffness : ndarray, shape () or (B,)
        EA in N.
    bending, arch : ndarray, shape (e, k, k) or (e, k, k, B)
        Stiffness against what turns and bends an element, and mean of the squared slope.
    """

    length: FloatArray
    axial_stiffness: FloatArray
    bending: FloatArray
    arch: FloatArray

    def at(self, designs: IntArray) -> ElementNumbers:
        """Numbers of D designs (..., D) in positions (B,)."""
        return ElementNumbers(*(in_positions(values, designs) for values in vars(self).values()))


def in_positions(values: FloatArray, which: IntArray) -> FloatArray:
    """Values (..., B) in some positions, which stay along memory: by an index they would not."""
    return np.take(values, which, axis=-1)


def by_elements(matrix: FloatArray, turns: FloatArray) -> FloatArray:
    """Matrices (e, k, k) or (e, k, k, B) of elements times columns (e, k, B)."""
    if matrix.ndim == 3:
        return np.asarray(matrix @ turns)
    return np.asarray(np.einsum("eijb,ejb->eib", matrix, turns))


def over_positions(matrix: FloatArray) -> FloatArray:
    """Matrices (e, k, k) or (e, k, k, B) with a dimension for positions."""
    return matrix[..., None] if matrix.ndim == 3 else matrix
