"""The error of component modes, and how many of them are enough.

The unreduced links give the error: inverse iteration improves the reduced eigenvalues with
their sparse matrices.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, diags_array
from scipy.sparse.linalg import splu

from flexmech.arrays import FloatArray, IntArray
from flexmech.mechanics import (
    GREAT_DETAIL,
    LinearSystem,
    LinkFrames,
    StressedLinks,
)
from flexmech.solvers.eigenproblem import Modes, solve_eigenvalues, solve_modes
from flexmech.solvers.formulation import Systems

# Relative difference of eigenvalues below which they are one: the root of round-off. A step of
# Newton's method that changes an eigenvalue by less has found it, since the next one squares that.
SAME = 1e-8
# Speed alone: coordinates are numbered along the links, and to order them anew takes longer than
# what the factors are then smaller by.
ORDER = "NATURAL"
# Most entries of matrices that are factorized at a time. Memory alone.
MOST_ENTRIES = 40_000


@dataclass(frozen=True)
class Pencil:
    """Sparse matrices M, C and K of one position in one pattern, and sums of them.

    Parameters
    ----------
    rows : ndarray of int, shape (k,)
        Rows of the entries, column by column.
    starts : ndarray of int, shape (n + 1,)
        Where each column begins among the entries.
    entries : ndarray, shape (3, k)
        Entries of M, C and K.
    """

    rows: NDArray[np.intc]
    starts: NDArray[np.intc]
    entries: FloatArray

    @classmethod
    def of_positions(cls, system: LinearSystem) -> list[Pencil]:
        """Matrices of each position of an unreduced system, most of whose entries are zero."""
        dense = system.mass, system.damping, system.stiffness
        taken = np.any([matrix.any(axis=0) for matrix in dense], axis=0)
        columns, rows = np.nonzero(taken.T)
        pattern = _pattern(columns, rows, system.size)
        entries = np.stack([matrix[:, rows, columns] for matrix in dense], axis=1)
        return [cls(*pattern, values) for values in entries]

    @classmethod
    def block_diagonal(cls, pencils: Sequence[Pencil]) -> Pencil:
        """Matrices of several positions, of one size, as one."""
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
        Pencils of B positions, n coordinates each.
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
    lower = np.linalg.inv(np.linalg.cholesky(inertia))
    squares = np.linalg.eigvalsh(lower @ strain @ np.swapaxes(lower, 1, 2))
    # Round-off of lengths or stiffnesses beyond all proportion: of such a mode nothing is known.
    return np.asarray(1j * np.sqrt(np.where(squares < 0, np.nan, squares)))


def _product(matrix: csc_array, columns: FloatArray) -> FloatArray:
    """Block diagonal matrix times columns (B, n, m) of its blocks."""
    return np.asarray(matrix @ columns.reshape(-1, columns.shape[-1])).reshape(columns.shape)


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
        Pencils of B positions, n coordinates each.
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
    for places in np.split(np.arange(len(values)), ends):
        moving = places
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
        parts = [_newton_step(pencils[half], values[half], x[half]) for half in halves]
        stepped, shapes = (np.concatenate(halves) for halves in zip(*parts, strict=True))
        return stepped, shapes
    inertia = blocks.total(1, 0, 0) @ x.ravel()
    loads = 2 * np.repeat(values, size) * inertia + blocks.total(0, 1, 0) @ x.ravel()
    better, inertia = factors.solve(loads).reshape(x.shape), inertia.reshape(x.shape)
    change = (inertia.conj() * x).sum(axis=1) / (inertia.conj() * better).sum(axis=1)
    return change, better


logger = logging.getLogger(__name__)


# A reduction with a greater relative error in a frequency asked for is made finer; of damped
# links also one with a greater error in a damping ratio, relative to the ratio or, where that
# is about zero, absolute. Without damping, ratios are an effect of the frames alone.
REDUCTION_TOLERANCE = 2e-5
RATIO_TOLERANCE = 1e-3
RATIO_FLOOR = 1e-7
# Checked positions are some 30 deg apart. Beside those beyond this error the angles between are
# checked too: a link of neat resin was within 2e-5 at 0 and 30 deg and 1.3e-4 off at 5 deg.
SUSPICIOUS = REDUCTION_TOLERANCE / 2
# The first are tried in small steps, since most links need little more than the usual detail.
# Speed alone: where none is enough, the unreduced matrices are solved.
DETAILS = (1.0, 1.25, 2.0, GREAT_DETAIL, 2 * GREAT_DETAIL, 4 * GREAT_DETAIL)
# Steps of Newton's method to an unreduced eigenvalue: it converges in three or four.
MOST_STEPS = 8
# Bytes of dense unreduced matrices of one kind in memory at a time. Memory alone.
MATRIX_BYTES = 4_000_000


@dataclass(frozen=True)
class ModeErrors:
    """How far the lowest modes are off, by component modes or by the mesh; positive, (B, m) each.

    Parameters
    ----------
    frequency : ndarray
        Relative.
    damping_ratio : ndarray
        Absolute.
    """

    frequency: FloatArray
    damping_ratio: FloatArray

    def at(self, positions: slice) -> ModeErrors:
        """The errors at some of the positions."""
        return ModeErrors(self.frequency[positions], self.damping_ratio[positions])

    def small(self, modes: Modes, *, damped: bool) -> NDArray[np.bool_]:
        """Where the reduction will do for modes, and their damping ratios, if ``damped``; (B,)."""
        accurate = np.asarray(np.all(self.frequency <= REDUCTION_TOLERANCE, axis=1))
        if not damped:
            return accurate
        ratio = np.abs(modes.damping_ratio[:, : self.damping_ratio.shape[1]])
        allowed = np.maximum(RATIO_TOLERANCE * ratio, RATIO_FLOOR)
        return np.asarray(accurate & np.all(self.damping_ratio <= allowed, axis=1))


@dataclass(frozen=True)
class CheckedModes:
    """Modes of some positions and how far the reduction may be off.

    Parameters
    ----------
    systems : Systems
        With as many component modes as are accurate enough, or without any.
    system : LinearSystem
        Batch of B positions.
    modes : Modes
        The modes asked for and spare ones.
    reduction_error : ModeErrors
        Error of the modes asked for by the reduction.
    """

    systems: Systems
    system: LinearSystem
    modes: Modes
    reduction_error: ModeErrors


def converged_modes(
    systems: Systems,
    crank_angle: FloatArray,
    crank_speed: FloatArray | float,
    spare: int = 0,
    stressed: StressedLinks | None = None,
) -> CheckedModes:
    """Modes with as many component modes as they need.

    Parameters
    ----------
    systems : Systems
        With the least ``detail`` to try.
    crank_angle : ndarray, shape (B,)
        Positions to check, in rad.
    crank_speed : ndarray, shape (B,), or float
        In rad/s.
    spare : int
        Modes to solve for besides those that must be accurate.
    stressed : StressedLinks, optional
        In these positions; it is sought if left out.

    Returns
    -------
    CheckedModes
        Within the tolerances of the unreduced matrices.
    """
    count = systems.formulation.modes
    speed = np.broadcast_to(crank_speed, crank_angle.shape)
    # The stress is the same in whatever modes, and costs more than they do.
    if stressed is None:
        stressed = systems.stressed(crank_angle, speed)
    pencils: list[Pencil] = []
    for detail in (finer for finer in DETAILS if finer >= systems.detail):
        detailed = replace(systems, detail=detail)
        system = detailed.at(crank_angle, crank_speed, stressed)
        modes = solve_modes(system, count, max(0, min(spare, system.size - count)))
        if not systems.engine.component_modes:
            none = np.zeros((len(modes.frequency), count))
            return CheckedModes(detailed, system, modes, ModeErrors(none, none))
        pencils = pencils or unreduced_pencils(systems, crank_angle, speed, stressed)
        error = reduction_error(pencils, systems.engine.frames, system, modes.lowest(count))
        small = error.small(modes, damped=bool(systems.damped_by))
        if small.all():
            return CheckedModes(detailed, system, modes, error)
        logger.info(
            "component modes with detail %g are off by %.1e of a frequency and %.1e in a ratio",
            detail,
            error.frequency.max(),
            error.damping_ratio.max(),
        )
    unreduced = _without_component_modes(systems)
    return converged_modes(unreduced, crank_angle, crank_speed, spare, stressed)


def converged_along(
    systems: Systems,
    crank_angle: FloatArray,
    crank_speed: FloatArray | float,
    checks: IntArray,
    *,
    spare: int = 0,
    stressed: StressedLinks | None = None,
    full_turn: bool = False,
) -> CheckedModes:
    """Modes at some of many positions, with as many component modes as all of these need.

    Parameters
    ----------
    systems : Systems
    crank_angle : ndarray, shape (B,)
        In rad.
    crank_speed : ndarray, shape (B,), or float
        In rad/s.
    checks : ndarray of int, shape (c,)
        Numbers of the positions that are checked, ascending.
    spare : int
        As of :func:`converged_modes`.
    stressed : StressedLinks, optional
        In the checked positions; it is sought if left out.
    full_turn : bool
        Whether the first position comes after the last one.

    Returns
    -------
    CheckedModes
        Modes at the checked positions.
    """
    speed = np.broadcast_to(crank_speed, crank_angle.shape)
    if stressed is None:
        stressed = systems.stressed(crank_angle[checks], speed[checks])
    while True:
        checked = converged_modes(systems, crank_angle[checks], speed[checks], spare, stressed)
        error = checked.reduction_error.frequency
        suspicious = np.flatnonzero(error.max(axis=1) > SUSPICIOUS)
        beside = _beside(checks, suspicious, len(crank_angle), full_turn=full_turn)
        if not len(beside):
            return checked
        systems = checked.systems
        closer = converged_modes(systems, crank_angle[beside], speed[beside]).systems
        if closer.engine is systems.engine and closer.detail == systems.detail:
            return checked
        systems = closer


def _beside(checks: IntArray, which: IntArray, count: int, *, full_turn: bool) -> IntArray:
    """Up to two positions on each side of some checked ones, before the next that is checked."""
    ends = [checks[-1:] - count, checks[:1] + count] if full_turn else [checks[:1], checks[-1:]]
    around = np.concatenate([ends[0], checks, ends[1]])
    before, here, after = (around[which + shift] for shift in range(3))
    numbers = np.concatenate([np.linspace(before, here, 4), np.linspace(here, after, 4)])
    return np.setdiff1d(np.round(numbers).astype(np.intp) % count, checks)


def _without_component_modes(systems: Systems) -> Systems:
    return replace(systems, engine=systems.engine.unreduced(), detail=DETAILS[0])


def unreduced_pencils(
    systems: Systems, crank_angle: FloatArray, crank_speed: FloatArray, stressed: StressedLinks
) -> list[Pencil]:
    """Sparse matrices of all coordinates, made of few dense ones at a time: these are large.

    Parameters
    ----------
    systems : Systems
        Systems of the engine, which may reduce its links.
    crank_angle, crank_speed : ndarray, shape (B,)
    stressed : StressedLinks
        In these positions.

    Returns
    -------
    list of Pencil
        Sparse matrices of each position.
    """
    unreduced = _without_component_modes(systems)
    at_a_time = max(1, MATRIX_BYTES // (8 * systems.engine.frames.size**2))
    pencils = []
    for start in range(0, len(crank_angle), at_a_time):
        rows = slice(start, start + at_a_time)
        at = crank_angle[rows], crank_speed[rows], stressed.at(rows)
        pencils += Pencil.of_positions(unreduced.at(*at))
    return pencils


def reduction_error(
    pencils: Sequence[Pencil], frames: LinkFrames, reduced: LinearSystem, modes: Modes
) -> ModeErrors:
    """Error of reduced modes against the unreduced matrices.

    The reduced modes are improved by one step of inverse iteration on the unreduced
    matrices; what frequency and damping ratio still move by is the reduction's error.

    Parameters
    ----------
    pencils : sequence of Pencil
        Unreduced matrices of B positions.
    frames : LinkFrames
        Frames of the unreduced links.
    reduced : LinearSystem
        In these positions.
    modes : Modes
        Modes of ``reduced``; m of them.

    Returns
    -------
    ModeErrors
    """
    shapes = reduced.unreduced_vectors(modes.vectors, frames)
    if reduced.is_conservative:
        improved = ritz_values(pencils, shapes, rigid=reduced.rigid_modes > 0)
    else:
        improved = newton_values(pencils, modes.eigenvalues, shapes)
    better = Modes(improved, modes.vectors)
    return ModeErrors(
        frequency=np.abs(modes.frequency / better.frequency - 1),
        damping_ratio=np.abs(modes.damping_ratio - better.damping_ratio),
    )


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
    unreduced = _without_component_modes(systems)
    frames, count = unreduced.engine.frames, systems.formulation.modes
    eigenvalues = np.empty((len(crank_angle), count), dtype=complex)
    # One position at a time: unreduced matrices are large.
    for place in range(len(crank_angle)):
        angle = crank_angle[place : place + 1]
        stressed = systems.stressed(angle, crank_speed)
        reduced = systems.at(angle, crank_speed, stressed)
        modes = solve_modes(reduced, count)
        pencils = unreduced_pencils(systems, angle, np.full(1, crank_speed), stressed)
        shapes = reduced.unreduced_vectors(modes.vectors, frames)
        [values] = newton_values(pencils, modes.eigenvalues, shapes, steps=MOST_STEPS)
        values = values[np.argsort(np.abs(values))]
        # Two modes may have led to the same eigenvalue.
        alike = np.abs(np.diff(values)) <= SAME * np.abs(values[1:])
        if np.any(alike) or not np.all(np.isfinite(values)):
            values = solve_eigenvalues(unreduced.at(angle, crank_speed, stressed), count)[0]
        eigenvalues[place] = values
    return eigenvalues
