"""Batched LDL^T factorization of symmetric band matrices.

The stiffness of links joined in a chain has a narrow band once its coordinates are well
ordered. Elimination runs column by column, each step over the whole batch: the cost grows
linearly with the number of elements.
"""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from flexmech.arrays import FloatArray


def factorize(band: FloatArray) -> FloatArray:
    """LDL^T factors of symmetric band matrices, in place.

    Parameters
    ----------
    band : ndarray, shape (n, width + 1, B)
        ``band[j, k]`` holds entry (j + k, j) of each matrix; overwritten.

    Returns
    -------
    ndarray, shape (n, width + 1, B)
        The pivots D in ``[:, 0]``, the columns of L below. A pivot that is not positive
        says that the matrix is not positive definite.
    """
    size, columns, batch = band.shape
    width = columns - 1
    # Row k of the matrix to take off in a step begins k entries further down the column.
    column = np.zeros((2 * width, batch))
    shifted = sliding_window_view(column, width, axis=0)[:width].transpose(0, 2, 1)
    for j in range(size - 1):
        reach = min(width, size - 1 - j)
        column[:reach], column[reach:width] = band[j, 1 : reach + 1], 0.0
        band[j, 1 : reach + 1] /= band[j, 0]
        band[j + 1 : j + 1 + reach, :width] -= band[j, 1 : reach + 1, None] * shifted[:reach]
    return band


def solve(factors: FloatArray, right: FloatArray) -> FloatArray:
    """Solve with the factors of :func:`factorize`.

    Parameters
    ----------
    factors : ndarray, shape (n, width + 1, B)
    right : ndarray, shape (n, B)

    Returns
    -------
    ndarray, shape (n, B)
    """
    size, columns = factors.shape[:2]
    x = right.copy()
    for j in range(size):
        reach = min(columns - 1, size - 1 - j)
        x[j + 1 : j + 1 + reach] -= factors[j, 1 : reach + 1] * x[j]
    x /= factors[:, 0]
    for j in range(size - 1, -1, -1):
        reach = min(columns - 1, size - 1 - j)
        x[j] -= (factors[j, 1 : reach + 1] * x[j + 1 : j + 1 + reach]).sum(axis=0)
    return x
