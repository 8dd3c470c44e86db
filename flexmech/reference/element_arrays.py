"""Arrays of elements that end with the batch of positions."""

from __future__ import annotations

import numpy as np

from flexmech.arrays import FloatArray, IntArray


def in_positions(values: FloatArray, which: IntArray) -> FloatArray:
    """Values (..., B) in some positions, which stay along memory: by an index they would not."""
    return np.take(values, which, axis=-1)


def by_elements(matrix: FloatArray, turns: FloatArray) -> FloatArray:
    """Matrices (e, k, k) or (e, k, k, B) of elements times columns (e, k, B)."""
    if matrix.ndim == 3:
        return np.asarray(matrix @ turns)
    return np.asarray(np.einsum("eijb,ejb->eib", matrix, turns))
