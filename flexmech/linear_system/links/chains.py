"""Matrices of links of consecutive elements, in many positions and of several designs.

Designs of one mechanism are computed together along a leading dimension, as far as they are alike.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from flexmech.arrays import FloatArray, IntArray

Result = TypeVar("Result")

# Links of more elements are computed design by design: memory, and speed, which is then as great.
MOST_STACKED = 16


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


def times(matrix: FloatArray, columns: NDArray[Any]) -> NDArray[Any]:
    """Product of a link's matrix with vectors in all positions.

    Parameters
    ----------
    matrix : ndarray, shape (r, n), (D, r, n) or (B, r, n)
        The same in all positions, in those of each design, or different in every one.
    columns : ndarray, shape (B, n, m)

    Returns
    -------
    ndarray, shape (B, r, m)
    """
    batch, size, count = columns.shape
    if matrix.ndim == 3 and len(matrix) == batch:
        return np.asarray(matrix @ columns)
    *designs, rows, _ = matrix.shape
    each = batch // (designs or [1])[0]
    product = matrix[..., None, :, :] @ columns.reshape(*designs, each, size, count)
    return np.asarray(product.reshape(batch, rows, count))


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


class UnlikeDesignsError(Exception):
    """Designs of a stack that cannot be computed together: their matrices differ in size.

    Parameters
    ----------
    kind : ndarray of int, shape (D,)
        Designs of the same number can be computed together.
    """

    def __init__(self, kind: IntArray) -> None:
        super().__init__("designs that differ in more than numbers are not computed together")
        self.kind = kind


def same_of_all(values: ArrayLike) -> int:
    """The number or truth that all designs have in common.

    Parameters
    ----------
    values : array_like, shape () or (D,)

    Returns
    -------
    int

    Raises
    ------
    UnlikeDesignsError
        If there is none.
    """
    of_designs = np.ravel(values)
    if (of_designs != of_designs[0]).any():
        raise UnlikeDesignsError(np.unique(of_designs, return_inverse=True)[1])
    return int(of_designs[0])


def among_alike(numbers: IntArray, compute: Callable[[IntArray], Sequence[Result]]) -> list[Result]:
    """Compute designs at once, or those that are alike where they are not all.

    Parameters
    ----------
    numbers : ndarray of int, shape (D,)
    compute : callable
        From the numbers of designs to a result of each.

    Returns
    -------
    list
        The result of each design.
    """
    try:
        return [*compute(numbers)]
    except UnlikeDesignsError as unlike:
        kind = unlike.kind
    results: dict[int, Result] = {}
    for one in np.unique(kind):
        alike = numbers[kind == one]
        results |= dict(zip(alike.tolist(), among_alike(alike, compute), strict=True))
    return [results[number] for number in numbers.tolist()]
