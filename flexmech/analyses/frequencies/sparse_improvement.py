"""Eigenvalues that approximate ones are improved to, by sparse matrices of one position."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.linalg
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from flexmech.linear_system import SparseMatrices


def sparse_improved(
    matrices: SparseMatrices, eigenvalues: NDArray[np.complex128], shapes: NDArray[Any]
) -> NDArray[np.complex128]:
    """Eigenvalues after one step of inverse iteration, or of Newton's method with damping.

    Parameters
    ----------
    matrices : SparseMatrices
        Of n coordinates.
    eigenvalues : ndarray, shape (m,)
    shapes : ndarray, shape (n, m)

    Returns
    -------
    ndarray, shape (m,)
    """
    mass, damping, stiffness = matrices.mass, matrices.damping, matrices.stiffness
    if not damping.nnz:
        loads = mass @ shapes
        better = splu(stiffness).solve(loads)
        inertia, elastic = better.T @ (mass @ better), better.T @ loads
        squares = scipy.linalg.eigh(elastic, inertia, eigvals_only=True)
        return np.asarray(1j * np.sqrt(squares))
    improved = eigenvalues.copy()
    for mode, value in enumerate(eigenvalues):
        x = shapes[:, mode].astype(complex)
        inertia = mass @ x
        try:
            factors = splu((value**2 * mass + value * damping + stiffness).tocsc())
        except RuntimeError:
            # Where the matrix is singular the value is an eigenvalue.
            continue
        better = factors.solve(2 * value * inertia + damping @ x)
        improved[mode] -= np.vdot(inertia, x) / np.vdot(inertia, better)
    return improved
