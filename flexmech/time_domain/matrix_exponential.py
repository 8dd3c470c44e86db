"""Exponentials of many small matrices at once.

The Taylor polynomial of degree 16 of a matrix that is halved until its norm is small, squared as
often (N. J. Higham, Functions of Matrices, SIAM 2008, section 10.3). All of it is products of
stacked matrices, six of them and one a squaring. For small matrices that is several times faster
than one call of a general routine for each.
"""

from __future__ import annotations

from math import factorial

import numpy as np

from flexmech.types import FloatArray

# Norm up to which the polynomial of this degree is exact to double precision (A. H. Al-Mohy &
# N. J. Higham, SIAM Journal on Scientific Computing 33 (2011) 488-511, eq. 3.3 and table 3.1).
LARGEST_NORM = 0.78
# Row j: coefficients of A^(4 j) to A^(4 j + 3).
COEFFICIENTS = np.array([[1 / factorial(4 * j + k) for k in range(4)] for j in range(4)])
LAST = 1 / factorial(16)
# Bytes of matrices taken at a time: a dozen arrays of them fit into a processor's cache.
BLOCK = 2**17


def matrix_exponentials(matrices: FloatArray) -> FloatArray:
    """Exponentials of square matrices.

    Parameters
    ----------
    matrices : ndarray, shape (N, n, n)

    Returns
    -------
    ndarray, shape (N, n, n)
        Not finite where the exponential is beyond all numbers.
    """
    result = np.empty(matrices.shape)
    for block in cache_blocks(matrices):
        result[block] = _of_block(matrices[block])
    return result


def cache_blocks(matrices: FloatArray) -> list[slice]:
    """Parts of a stack (N, n, n) so short that a dozen arrays like each stay in the cache."""
    count = max(1, BLOCK // max(1, matrices[:1].nbytes))
    return [slice(first, first + count) for first in range(0, len(matrices), count)]


def _of_block(matrices: FloatArray) -> FloatArray:
    norm = float(np.abs(matrices).sum(axis=1).max(initial=0.0))
    if not np.isfinite(norm):
        return np.full(matrices.shape, np.nan)
    halvings = max(0, int(np.ceil(np.log2(max(norm, LARGEST_NORM) / LARGEST_NORM))))
    powers = np.empty((4, *matrices.shape))
    powers[0] = np.eye(matrices.shape[-1])
    powers[1] = matrices * 0.5**halvings
    powers[2] = powers[1] @ powers[1]
    powers[3] = powers[2] @ powers[1]
    fourth = powers[2] @ powers[2]
    parts = np.tensordot(COEFFICIENTS, powers, axes=1)
    result: FloatArray = parts[3] + LAST * fourth
    with np.errstate(over="ignore", invalid="ignore"):
        for part in parts[2::-1]:
            result = result @ fourth + part
        for _ in range(halvings):
            result = result @ result
    return result
