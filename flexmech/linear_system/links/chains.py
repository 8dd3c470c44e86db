"""Matrices of links of consecutive elements, in many positions."""

from __future__ import annotations

import numpy as np

from flexmech.arrays import FloatArray, IntArray


def chain_matrix(elements: FloatArray) -> FloatArray:
    """Sum of the matrices of consecutive elements, as a full matrix.

    Parameters
    ----------
    elements : ndarray, shape (..., e, 2 p, 2 p)
        Of p coordinates a node.

    Returns
    -------
    ndarray, shape (..., n, n)
        n = p (e + 1).
    """
    *batch, count, both, _ = elements.shape
    size = both // 2
    first, second = slice(0, size), slice(size, None)
    total = np.zeros((*batch, count + 1, size, count + 1, size))
    of_nodes = _along_diagonal(total)
    of_nodes[..., :-1, :, :] = elements[..., first, first]
    of_nodes[..., 1:, :, :] += elements[..., second, second]
    _along_diagonal(total[..., :-1, :, 1:, :])[:] = elements[..., first, second]
    _along_diagonal(total[..., 1:, :, :-1, :])[:] = elements[..., second, first]
    return total.reshape(*batch, size * (count + 1), size * (count + 1))


def _along_diagonal(blocks: FloatArray) -> FloatArray:
    """View of the blocks (..., i, p, i, p) of a matrix by blocks; (..., i, p, p)."""
    return np.asarray(np.einsum("...iaib->...iab", blocks))


def in_positions(matrix: FloatArray, which: slice | IntArray) -> FloatArray:
    """A link matrix in some positions; a constant one stays."""
    return matrix[which] if matrix.ndim == 3 else matrix


def with_entries(
    matrix: FloatArray, rows: IntArray, columns: IntArray, values: FloatArray
) -> FloatArray:
    """Matrix of a link with values added to some of its entries.

    Parameters
    ----------
    matrix : ndarray, shape (n, n) or (B, n, n)
    rows, columns : ndarray of int, shape (k,)
        Each pair once.
    values : ndarray, shape (k,) or (B, k)

    Returns
    -------
    ndarray
        Of a batch, where the values are.
    """
    batch = np.broadcast_shapes(matrix.shape[:-2], values.shape[:-1])
    total = np.array(np.broadcast_to(matrix, (*batch, *matrix.shape[-2:])))
    total[..., rows, columns] += values
    return total
