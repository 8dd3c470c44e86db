"""Eigenvalues of sparse matrices, improved from approximate ones by inverse iteration."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, diags_array
from scipy.sparse.linalg import splu

from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system import (
    LinearSystem,
    LinkPencil,
    StaticResponse,
)

# Relative difference of eigenvalues below which they are one: the root of round-off. A step of
# Newton's method that changes an eigenvalue by less has found it, since the next one squares that.
SAME = 1e-8
# Speed alone: coordinates are numbered along the links, and to order them anew takes longer than
# what the factors are then smaller by.
ORDER = "NATURAL"
# Of matrices that are factorized at a time. Memory alone.
MOST_ENTRIES = 40_000


@dataclass(frozen=True)
class Pencil:
    """Sparse matrices M, C and K of one position in one pattern, and sums of them.

    Parameters
    ----------
    rows : ndarray of int, shape (k,)
        Of the entries, column by column.
    starts : ndarray of int, shape (n + 1,)
        Where each column begins among the entries.
    entries : ndarray, shape (3, k)
        Of M, C and K.
    """

    rows: NDArray[np.intc]
    starts: NDArray[np.intc]
    entries: FloatArray

    @classmethod
    def of_positions(cls, system: LinearSystem) -> list[Pencil]:
        """Those of each position of an unreduced system, most of whose entries are zero."""
        dense = system.mass, system.damping, system.stiffness
        taken = np.any([matrix.any(axis=0) for matrix in dense], axis=0)
        columns, rows = np.nonzero(taken.T)
        pattern = _pattern(columns, rows, system.size)
        entries = np.stack([matrix[:, rows, columns] for matrix in dense], axis=1)
        return [cls(*pattern, own) for own in entries]

    @classmethod
    def block_diagonal(cls, pencils: Sequence[Pencil]) -> Pencil:
        """Those of several positions, of one size, as one."""
        rows, starts, taken = [], [np.zeros(1, dtype=np.intc)], 0
        for number, pencil in enumerate(pencils):
            rows.append(pencil.rows + number * (len(pencil.starts) - 1))
            starts.append(pencil.starts[1:] + taken)
            taken += len(pencil.rows)
        entries = np.concatenate([pencil.entries for pencil in pencils], axis=1)
        return cls(
            np.concatenate(rows, dtype=np.intc), np.concatenate(starts, dtype=np.intc), entries
        )

    def total(self, *factors: complex) -> csc_array:
        """Sum of M, C and K times factors."""
        size = len(self.starts) - 1
        return csc_array((factors @ self.entries, self.rows, self.starts), (size, size))


def _pattern(
    columns: IntArray, rows: IntArray, size: int
) -> tuple[NDArray[np.intc], NDArray[np.intc]]:
    """Rows and starts of the columns of entries that stand column by column."""
    starts = np.searchsorted(columns, np.arange(size + 1))
    return rows.astype(np.intc), starts.astype(np.intc)


def ritz_values(
    pencils: Sequence[Pencil], shapes: FloatArray, *, rigid: bool = False
) -> NDArray[np.complex128]:
    """Eigenvalues of symmetric undamped matrices after one step of inverse iteration.

    The step is taken in the space of all shapes of a position, whose Ritz values are the result
    (Bathe, *Finite Element Procedures*, sec. 11.6: subspace iteration).

    Parameters
    ----------
    pencils : sequence of Pencil
        Of B positions, n coordinates each.
    shapes : ndarray, shape (B, n, m)
        To begin with, by ascending frequency.
    rigid : bool
        Whether the stiffness may have no inverse because of rigid modes; the matrices are then
        shifted by the square of the lowest frequency.

    Returns
    -------
    ndarray, shape (B, m)
        In rad/s; not a number where a squared frequency is negative by round-off.
    """
    # All positions at once: the factors of a block diagonal matrix are those of its blocks.
    every, shift = Pencil.block_diagonal(pencils), np.zeros(len(pencils))
    mass, stiffness = every.total(1, 0, 0), every.total(0, 0, 1)
    loads = _product(mass, shapes)
    if rigid:
        first = shapes[:, :, :1]
        forces = _product(stiffness, first)
        shift = np.sum(first * forces, axis=(1, 2)) / np.sum(first * loads[:, :, :1], axis=(1, 2))
        stiffness = stiffness + diags_array(np.repeat(shift, shapes.shape[1])) @ mass
    factors = splu(stiffness.tocsc(), permc_spec=ORDER)
    better = factors.solve(loads.reshape(-1, loads.shape[-1])).reshape(loads.shape)
    inertia = np.swapaxes(better, 1, 2) @ _product(mass, better)
    strain = np.swapaxes(better, 1, 2) @ loads - shift[:, None, None] * inertia
    return _ritz_values(inertia, strain)


def responding_values(
    response: StaticResponse, masses: Sequence[FloatArray], shapes: Sequence[FloatArray]
) -> NDArray[np.complex128]:
    """As :func:`ritz_values`, of elastic links without a matrix of the whole linkage.

    Parameters
    ----------
    response : StaticResponse
        In B positions.
    masses : sequence of ndarray, shape (..., n_link, n_link)
        Of the links.
    shapes : sequence of ndarray, shape (B, n_link, m)
        To begin with, in the links' coordinates.

    Returns
    -------
    ndarray, shape (B, m)
        In rad/s; not a number where a squared frequency is negative by round-off.
    """
    loads = [mass @ shape for mass, shape in zip(masses, shapes, strict=True)]
    better = response.displacements(loads)
    across = [np.swapaxes(moved, 1, 2) for moved in better]
    parts = zip(across, masses, better, strict=True)
    inertia = np.asarray(sum(by @ (mass @ moved) for by, mass, moved in parts))
    strain = np.asarray(sum(by @ load for by, load in zip(across, loads, strict=True)))
    return _ritz_values(inertia, strain)


def _ritz_values(inertia: FloatArray, strain: FloatArray) -> NDArray[np.complex128]:
    """Eigenvalues of projected matrices (B, m, m)."""
    lower = np.linalg.inv(np.linalg.cholesky(inertia))
    squares = np.linalg.eigvalsh(lower @ strain @ np.swapaxes(lower, 1, 2))
    # Round-off of lengths or stiffnesses beyond all proportion: of such a mode nothing is known.
    return np.asarray(1j * np.sqrt(np.where(squares < 0, np.nan, squares)))


def _product(matrix: csc_array, columns: FloatArray) -> FloatArray:
    """Block diagonal matrix times columns (B, n, m) of its blocks."""
    return np.asarray(matrix @ columns.reshape(-1, columns.shape[-1])).reshape(columns.shape)


def projected_values(
    pencil: LinkPencil,
    response: StaticResponse,
    eigenvalues: NDArray[np.complex128],
    shapes: NDArray[Any],
) -> NDArray[np.complex128]:
    """Eigenvalues near approximate ones after a step of Newton's method in a few shapes.

    These are the approximate ones and the static responses of straight links to what their
    equations leave over, which is all that modes far above them miss (Davidson's method with one
    step; the static response in the place of the inverse). No matrix of the linkage is made.

    Parameters
    ----------
    pencil : LinkPencil
        In B positions.
    response : StaticResponse
        Of straight links in these positions.
    eigenvalues : ndarray, shape (B, m)
        To begin with, in rad/s.
    shapes : ndarray, shape (B, size, m)
        To begin with, in independent coordinates.

    Returns
    -------
    ndarray, shape (B, m)
        In rad/s.
    """
    value, count = eigenvalues[:, None, :], eigenvalues.shape[1]
    by_shapes = pencil.forces(shapes)
    left = [
        value * (value * inertia + damping) + stiffness
        for inertia, damping, stiffness in zip(*by_shapes, strict=True)
    ]
    missed = pencil.frames.independent(pencil.motion, response.displacements(left))
    size = np.linalg.norm(missed, axis=1, keepdims=True)
    # Of a shape that misses nothing the response is zero, and stays without effect.
    missed = missed / np.where(size > 0, size, 1.0)
    # What forces the shapes ask for is known.
    forces = [
        [np.concatenate(pair, axis=2) for pair in zip(*own, strict=True)]
        for own in zip(by_shapes, pencil.forces(missed), strict=True)
    ]
    mass, damping, stiffness = pencil.projected(np.concatenate([shapes, missed], axis=2), forces)
    none, ways = np.zeros((len(size), count)), np.arange(2 * count)
    stiffness[:, ways, ways] += np.append(none, size[:, 0] == 0, axis=1)
    at = eigenvalues[:, :, None, None]
    matrices = at * (at * mass[:, None] + damping[:, None]) + stiffness[:, None]
    inertia = np.swapaxes(mass[:, :, :count], 1, 2)
    loads = 2 * eigenvalues[:, :, None] * inertia + np.swapaxes(damping[:, :, :count], 1, 2)
    own = np.einsum("bjj->bj", inertia[:, :, :count].conj())
    try:
        better = np.linalg.solve(matrices, loads[..., None])[..., 0]
    except np.linalg.LinAlgError:
        # Where a matrix is singular the value is an eigenvalue: its change is zero.
        better = _solved_one_by_one(matrices, loads)
    return np.asarray(eigenvalues - own / (inertia.conj() * better).sum(axis=2))


def _solved_one_by_one(
    matrices: NDArray[np.complex128], loads: NDArray[np.complex128]
) -> NDArray[np.complex128]:
    """Solutions (b, m, n) of matrices (b, m, n, n); of a singular one those of a nearby matrix.

    That is the matrix with its least singular value at round-off, as where it is singular but for
    round-off.
    """
    better = np.empty_like(loads)
    for place in np.ndindex(loads.shape[:2]):
        try:
            better[place] = np.linalg.solve(matrices[place], loads[place])
        except np.linalg.LinAlgError:
            left, sizes, right = np.linalg.svd(matrices[place])
            sizes = np.maximum(sizes, np.finfo(float).eps * sizes[0])
            better[place] = right.conj().T @ ((left.conj().T @ loads[place]) / sizes)
    return better


def newton_values(
    pencils: Sequence[Pencil],
    eigenvalues: NDArray[np.complex128],
    shapes: NDArray[Any],
    steps: int = 1,
) -> NDArray[np.complex128]:
    """Eigenvalues of ``(lambda^2 M + lambda C + K) x = 0`` near approximate ones.

    Each mode is improved by itself, by Newton's method (Ruhe 1973, eq. 3.5), whose linear system
    is that of inverse iteration about the eigenvalue.

    Parameters
    ----------
    pencils : sequence of Pencil
        Of B positions, n coordinates each.
    eigenvalues : ndarray, shape (B, m)
        To begin with, in rad/s.
    shapes : ndarray, shape (B, n, m)
        To begin with.
    steps : int
        At most; the last one is that after which an eigenvalue stays where it is.

    Returns
    -------
    ndarray, shape (B, m)
        In rad/s.
    """
    count = eigenvalues.shape[1]
    of_modes = [pencil for pencil in pencils for _ in range(count)]
    values = eigenvalues.astype(complex).ravel()
    x = np.swapaxes(shapes, 1, 2).astype(complex).reshape(len(values), -1)
    entries = np.cumsum([len(pencil.rows) for pencil in of_modes])
    ends = np.flatnonzero(np.diff(entries // MOST_ENTRIES)) + 1
    for part in np.split(np.arange(len(values)), ends):
        moving = part
        for _ in range(steps):
            change, better = _newton_step([of_modes[n] for n in moving], values[moving], x[moving])
            values[moving] -= change
            x[moving] = better / np.abs(better).max(axis=1)[:, None]
            moving = moving[np.abs(change) > SAME * np.abs(values[moving])]
            if not len(moving):
                break
    return values.reshape(eigenvalues.shape)


def _newton_step(
    pencils: Sequence[Pencil], values: NDArray[np.complex128], x: NDArray[np.complex128]
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """By how much k eigenvalues are too great, and better shapes than x, (k, n)."""
    blocks, size = Pencil.block_diagonal(pencils), len(x[0])
    value = np.repeat(values, [len(pencil.rows) for pencil in pencils])
    mass, damping, stiffness = blocks.entries
    entries = value * (value * mass + damping) + stiffness
    matrix = csc_array((entries, blocks.rows, blocks.starts), (x.size, x.size))
    try:
        factors = splu(matrix, permc_spec=ORDER)
    except RuntimeError:
        # Where a matrix is singular the value is an eigenvalue: it is looked for among the blocks.
        if len(values) == 1:
            return np.zeros(1, dtype=complex), x
        halves = slice(len(values) // 2), slice(len(values) // 2, None)
        parts = [_newton_step(pencils[own], values[own], x[own]) for own in halves]
        return np.concatenate([own[0] for own in parts]), np.concatenate([own[1] for own in parts])
    inertia = blocks.total(1, 0, 0) @ x.ravel()
    loads = 2 * np.repeat(values, size) * inertia + blocks.total(0, 1, 0) @ x.ravel()
    better, inertia = factors.solve(loads).reshape(x.shape), inertia.reshape(x.shape)
    change = (inertia.conj() * x).sum(axis=1) / (inertia.conj() * better).sum(axis=1)
    return change, better
