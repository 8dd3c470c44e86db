"""Eigenvalues of unreduced matrices, by Newton's method from those in component modes."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

from flexmech.analyses.frequencies.eigenproblem import solve_eigenvalues, solve_modes
from flexmech.analyses.frequencies.formulation import Systems
from flexmech.analyses.frequencies.reduction import UnreducedPositions
from flexmech.linear_system import SparseMatrices
from flexmech.types import FloatArray

# Of Newton's method, and the relative change below which it has ended.
MOST_STEPS, STILL = 8, 1e-10
# Relative difference of eigenvalues by which two modes have led to the same one.
SAME = 1e-8


def unreduced_eigenvalues(
    systems: Systems, crank_angle: FloatArray, crank_speed: float
) -> NDArray[np.complex128]:
    """Lowest eigenvalues without the error of component modes.

    Parameters
    ----------
    systems : Systems
        In component modes.
    crank_angle : ndarray, shape (A,)
        In rad.
    crank_speed : float
        In rad/s.

    Returns
    -------
    ndarray, shape (A, modes)
        In rad/s; of the modes asked for, in ascending order.
    """
    unreduced = replace(systems, engine=systems.engine.unreduced(), detail=1.0)
    frames, count = unreduced.engine.frames, systems.formulation.modes
    found = np.empty((len(crank_angle), count), dtype=complex)
    # One position at a time: unreduced matrices are large.
    for place in range(len(crank_angle)):
        angle = crank_angle[place : place + 1]
        stressed = systems.stressed(angle, crank_speed)
        reduced = systems.at(angle, crank_speed, stressed)
        modes = solve_modes(reduced, count)
        exact = UnreducedPositions(unreduced, angle, np.full(1, crank_speed), stressed)
        shapes = reduced.unreduced_vectors(modes.vectors, frames)[0]
        values = _newton(_sparse(exact), modes.eigenvalues[0], shapes)
        values = values[np.argsort(np.abs(values))]
        alike = np.abs(np.diff(values)) <= SAME * np.abs(values[1:])
        if np.any(alike) or not np.all(np.isfinite(values)):
            values = solve_eigenvalues(unreduced.at(angle, crank_speed, stressed), count)[0]
        found[place] = values
    return found


def _sparse(exact: UnreducedPositions) -> SparseMatrices:
    """Matrices of one position, which are sparse whatever they are kept as."""
    if exact.sparse is not None:
        return exact.sparse.at(0)
    _, full = next(exact.parts())
    return SparseMatrices(*(csc_array(m[0]) for m in (full.mass, full.damping, full.stiffness)))


def _newton(
    matrices: SparseMatrices, eigenvalues: NDArray[np.complex128], shapes: NDArray[Any]
) -> NDArray[np.complex128]:
    """Solve ``P(lambda) x = 0`` for each mode (Ruhe 1973, eq. 3.5).

    Parameters
    ----------
    matrices : SparseMatrices
        Of n coordinates.
    eigenvalues : ndarray, shape (m,)
        To begin with.
    shapes : ndarray, shape (n, m)
        To begin with.

    Returns
    -------
    ndarray, shape (m,)
    """
    mass, damping, stiffness = matrices.mass, matrices.damping, matrices.stiffness
    solved = eigenvalues.astype(complex)
    for mode in range(len(solved)):
        x = shapes[:, mode].astype(complex)
        for _ in range(MOST_STEPS):
            value = solved[mode]
            inertia = mass @ x
            try:
                factors = splu((value**2 * mass + value * damping + stiffness).tocsc())
            except RuntimeError:
                # Where the matrix is singular the value is an eigenvalue.
                break
            better = factors.solve(2 * value * inertia + damping @ x)
            change = np.vdot(inertia, x) / np.vdot(inertia, better)
            solved[mode], x = value - change, better / np.abs(better).max()
            if np.abs(change) <= STILL * np.abs(value):
                break
    return solved
