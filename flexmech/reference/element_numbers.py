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
        return ElementNumbers(*(values[..., designs] for values in vars(self).values()))


def by_elements(matrix: FloatArray, turns: FloatArray) -> FloatArray:
    """Matrices (e, k, k) or (e, k, k, B) of elements times columns (e, k, B)."""
    if matrix.ndim == 3:
        return np.asarray(matrix @ turns)
    # Column by column: each step runs along memory.
    product = matrix[:, :, 0] * turns[:, None, 0]
    for column in range(1, turns.shape[1]):
        product += matrix[:, :, column] * turns[:, None, column]
    return np.asarray(product)


def over_positions(matrix: FloatArray) -> FloatArray:
    """Matrices (e, k, k) or (e, k, k, B) with a dimension for positions."""
    return matrix[..., None] if matrix.ndim == 3 else matrix
