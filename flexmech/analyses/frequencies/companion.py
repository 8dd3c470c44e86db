"""The quadratic eigenproblem as one of matrices of twice the size.

A shaft that turns freely adds a mode that deforms nothing: at rest its two eigenvalues are zero,
and the stiffness has no inverse. It is solved about a real number instead, which is no eigenvalue,
and the two eigenvalues whose shapes are most alike to the rigid motion are taken out.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexmech.linear_system import LinearSystem, inverse_mass_root
from flexmech.types import FloatArray


def inverse_companion(system: LinearSystem) -> tuple[FloatArray, FloatArray]:
    """Matrices whose eigenvalues are a unit over those of the system.

    The lowest modes are their largest eigenvalues. In units of time of the slowest mode both
    blocks are of order one.

    Parameters
    ----------
    system : LinearSystem
        Batch of B positions, n coordinates.

    Returns
    -------
    ndarray, shape (B, 2 n, 2 n)
        Eigenvalues ``unit / lambda``.
    ndarray, shape (B, 1)
        The units.
    """
    return _companion(system.mass, system.damping, system.stiffness)


def without_rigid_modes(
    system: LinearSystem,
) -> tuple[NDArray[Any], NDArray[Any], FloatArray, NDArray[np.complex128]]:
    """Eigenvalues and states of a system with rigid modes; those of these are set to zero.

    Parameters
    ----------
    system : LinearSystem
        Batch of B positions, n coordinates, r rigid modes.

    Returns
    -------
    ndarray of complex, shape (B, 2 n)
        ``unit / lambda``; zero of the rigid modes.
    ndarray of complex, shape (B, 2 n, 2 n)
        States; their first halves are the shapes.
    ndarray, shape (B, 1)
        The units.
    ndarray of complex, shape (B, 2 r)
        Eigenvalues of the rigid modes in rad/s.
    """
    shapes, about = _rigid_shapes(system)
    shift, count = about[:, None, None], 2 * system.rigid_modes
    damping = system.damping + 2 * shift * system.mass
    stiffness = system.stiffness + shift * system.damping + shift**2 * system.mass
    companion, unit = _companion(system.mass, damping, stiffness)
    inverse, states = np.linalg.eig(companion)
    eigenvalues = about[:, None] + unit / inverse.astype(complex)
    moved = states[:, : system.size]
    inertia = system.mass @ shapes
    alike = (np.abs(np.swapaxes(inertia, 1, 2) @ moved) ** 2).sum(axis=1)
    alike /= np.einsum("bim,bij,bjm->bm", moved.conj(), system.mass, moved).real
    rigid = np.argsort(-alike, axis=1)[:, :count]
    found = np.take_along_axis(eigenvalues, rigid, axis=1)
    np.put_along_axis(eigenvalues, rigid, np.inf, axis=1)
    return unit / eigenvalues, states, unit, found


def _companion(
    mass: FloatArray, damping: FloatArray, stiffness: FloatArray
) -> tuple[FloatArray, FloatArray]:
    size = mass.shape[1]
    flexible = np.linalg.solve(stiffness, np.concatenate([damping, mass], axis=2))
    unit = 1 / np.sqrt(np.abs(flexible[:, :, size:]).sum(axis=2).max(axis=1))[:, None]
    companion = np.zeros((len(flexible), 2 * size, 2 * size))
    companion[:, :size, :size] = -flexible[:, :, :size] * unit[:, None]
    companion[:, :size, size:] = -flexible[:, :, size:] * unit[:, None] ** 2
    companion[:, np.arange(size, 2 * size), np.arange(size)] = 1.0
    return companion, unit


def _rigid_shapes(system: LinearSystem) -> tuple[FloatArray, FloatArray]:
    """Rigid shapes (B, n, r) of unit mass, and the lowest frequency (B,) of the others in rad/s.

    Of the symmetric part of the stiffness the rigid motion is the softest.
    """
    half = inverse_mass_root(system.mass)
    across = np.swapaxes(half, 1, 2)
    symmetric = (system.stiffness + np.swapaxes(system.stiffness, 1, 2)) / 2
    squares, vectors = np.linalg.eigh(half @ symmetric @ across)
    count = system.rigid_modes
    return across @ vectors[:, :, :count], np.sqrt(np.abs(squares[:, count]))
