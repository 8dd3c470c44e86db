"""Floquet multipliers and modes of a periodic linear system, however far apart they are.

A mode is a solution ``phi(t) exp(lambda t)`` whose shape phi repeats itself after a period T; its
multiplier is ``exp(lambda T)``. Multiplied together, the transition matrices of a whole period
lose what decays fast beside what does not: of a multiplier of ``exp(-24 * 2 pi)`` beside one of 1
nothing is left. So they stay short, and are brought to triangular form one after the other::

    G_k Q_(k-1) = Q_k R_k

Where the multipliers come in groups that are far apart, the columns of Q_k tend to the subspaces
of these groups as the turns go by, the strongest group first (orthogonal iteration; this is the
periodic Schur form of A. Bojanczyk, G. H. Golub & P. Van Dooren, SPIE 1770 (1992) 31-42, in blocks
of comparable size). The multipliers of a group are the eigenvalues of the product of its blocks on
the diagonals of R_k alone. The modes follow backwards in time, where what is weak is not lost
beside what is strong.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import gcd
from typing import Protocol

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from flexmech.errors import ComputationError
from flexmech.time_domain.matrix_exponential import matrix_exponentials
from flexmech.time_domain.periodic_system import PeriodicSystem, SampledPeriodicSystem, exponents
from flexmech.types import FloatArray

# Logarithm of how far apart the multipliers, and singular values, of one short transition matrix
# may be: twelve digits of the weakest remain.
SHORT = 8.0
# Groups part where the logarithms of neighbouring moduli are this far apart, and where they are
# less far apart if a group would be wider than that from its strongest to its weakest mode: of
# the weakest, ten digits remain.
GROUPS_APART = 4.0
WIDEST = 12.0
PARTED = 1e-11
# Turns that groups take to show, and how many times what their distance asks for they may take.
FIRST_TURNS = 20
PATIENCE = 3.0
# Of a step, to which damping ratios far above one lead.
MOST_PARTS = 1024


@dataclass(frozen=True)
class FloquetModes:
    """All n modes of a periodic system, the one that grows most first.

    Parameters
    ----------
    period : float
        T in s.
    exponent : ndarray of complex, shape (n,)
        ``lambda`` in 1/s; the imaginary part is known but for multiples of ``2 pi / T`` and taken
        between ``-pi / T`` and ``pi / T``.
    trace_integral : float
        Integral of the trace of A over a period.
    """

    period: float
    exponent: NDArray[np.complex128]
    trace_integral: float
    _propagated: _Shapes

    @property
    def log_modulus(self) -> FloatArray:
        """Logarithm of the multipliers' moduli, (n,)."""
        return np.asarray(self.exponent.real * self.period)

    @property
    def angle(self) -> FloatArray:
        """Angles of the multipliers between -pi and pi, (n,)."""
        return np.asarray(self.exponent.imag * self.period)

    @property
    def liouville_defect(self) -> float:
        """Sum of the logarithms of all moduli against the integral of the trace.

        Relative to the sum of the logarithms' sizes, or absolute where that is below one. The
        phases of a constant system count as well: its eigenvalues are rounded off as a whole,
        and a slow crank lets them turn millions of times in a period.
        """
        defect = abs(float(self.log_modulus.sum()) - self.trace_integral)
        size = float(np.abs(self.log_modulus).sum())
        if self.whole_turns is not None:
            size += 2 * np.pi * float(np.abs(self.whole_turns).sum())
        return defect / max(1.0, size)

    @property
    def whole_turns(self) -> FloatArray | None:
        """Whole turns a period of each shape of a constant system, (n,); None of other systems.

        Such a shape is one harmonic: eigenvectors whose phase turns.
        """
        return self._propagated.turns if isinstance(self._propagated, _Turning) else None

    def shapes(self, every: int = 1) -> NDArray[np.complex128]:
        """Shapes ``phi`` at the starts of the N steps, (N, n, n): (step, state, mode).

        Parameters
        ----------
        every : int
            A divisor of N: at the start of every so many steps alone, (N / every, n, n).
        """
        return self._propagated.shapes(every)


def floquet_modes(system: PeriodicSystem, steps: int) -> FloquetModes:
    """Floquet modes of a periodic system.

    Parameters
    ----------
    system : PeriodicSystem
    steps : int
        Steps of the propagator (:mod:`flexmech.time_domain.magnus`) a period.

    Returns
    -------
    FloquetModes

    Raises
    ------
    ComputationError
        If the steps are so few that their transition matrices overflow, or if the multipliers
        do not part into groups.
    """
    if isinstance(system, SampledPeriodicSystem) and system.is_constant:
        return _constant_modes(system.matrices(1, 0.0)[0], system.period, steps)
    trace = system.traces(2 * steps)
    integral = float(trace.mean() * system.period)
    exponent = exponents(system, steps)
    if not np.ptp(exponent, axis=0).any():
        return _constant_modes(exponent[0] * (steps / system.period), system.period, steps)
    spread = float(np.abs(trace).mean() * system.period)
    chunks, products = _short_products(exponent, spread)
    triangular = _triangular_form(products)
    log, vectors = _block_eigenvalues(triangular)
    order = np.argsort(-log.real, kind="stable")
    propagated = _Propagated(steps, chunks, triangular, log, vectors, order)
    return FloquetModes(system.period, log[order] / system.period, integral, propagated)


class _Shapes(Protocol):
    """What the shapes of the modes are made from."""

    def shapes(self, every: int) -> NDArray[np.complex128]:
        """At the starts of every so many of the N steps, (N / every, n, n)."""


@dataclass(frozen=True)
class _Turning:
    """Shapes of a constant system's modes, which turn by whole angles in a period."""

    steps: int
    vectors: NDArray[np.complex128]
    turns: FloatArray

    def shapes(self, every: int) -> NDArray[np.complex128]:
        phase = 2j * np.pi * np.arange(0, self.steps, every)[:, None] / self.steps
        return np.asarray(self.vectors * np.exp(phase * self.turns)[:, None])


def _constant_modes(matrix: FloatArray, period: float, steps: int) -> FloquetModes:
    """Modes of a constant system, by its eigenvalues: some may die out within any step."""
    values, vectors = np.linalg.eig(matrix)
    order = np.argsort(-values.real, kind="stable")
    log = period * values[order].astype(complex)
    turns = np.round(log.imag / (2 * np.pi))
    shapes = _Turning(steps, vectors[:, order].astype(complex), turns)
    trace = period * float(np.trace(matrix))
    exponent = ((log - 2j * np.pi * turns) / period).astype(np.complex128)
    return FloquetModes(period, exponent, trace, shapes)


@dataclass(frozen=True)
class _Propagated:
    """What the shapes of the modes are made from; ``order`` is that in which they stand."""

    steps: int
    chunks: FloatArray
    triangular: _TriangularForm
    log: NDArray[np.complex128]
    vectors: NDArray[np.complex128]
    order: NDArray[np.intp]

    def shapes(self, every: int) -> NDArray[np.complex128]:
        starts = _modes_backwards(self.triangular, self.log, self.vectors)
        count, length, size, _ = self.chunks.shape
        parts = count * length // self.steps
        # Nothing is wanted in the middle of so many transition matrices.
        joined = gcd(every * parts, length)
        length //= joined
        chunks = _products(self.chunks.reshape(-1, joined, size, size))
        chunks = chunks.reshape(count, length, size, size)
        shapes = np.empty((count, length, size, size), dtype=complex)
        back = np.exp(-self.log[self.order] / (count * length))
        now = np.ascontiguousarray(starts[..., self.order])
        for step in range(length):
            shapes[:, step] = now
            # Real matrices move real and imaginary parts by themselves.
            moved = chunks[:, step] @ now.view(float)
            now = back * moved.view(complex)
        return shapes.reshape(-1, size, size)[:: every * parts // joined]


def _short_products(exponent: FloatArray, spread: float) -> tuple[FloatArray, FloatArray]:
    """Transition matrices (K, m, n, n) in rows whose products (K, n, n) lose no weak multiplier.

    ``spread`` is what the damping alone asks for; where others grow, rows are halved on. A step
    that is too long for itself is taken in parts: its matrix is the power of another one.
    """
    steps = len(exponent)
    matrices = matrix_exponentials(exponent)
    divisors = [n for n in range(1, steps + 1) if steps % n == 0]
    wanted, count = max(1, int(np.ceil(spread / SHORT))), 0
    while count < steps:
        count = next((n for n in divisors if n >= wanted), steps)
        chunks = matrices.reshape(count, steps // count, *matrices.shape[1:])
        # Steps far longer than a vibration's period can let it grow beyond all numbers.
        with np.errstate(over="ignore", invalid="ignore"):
            products = _products(chunks)
        if _log_condition(products) <= SHORT:
            return chunks, products
        wanted = 2 * count
    parts = 1
    while parts < MOST_PARTS:
        parts *= 2
        split = matrix_exponentials(exponent / parts)
        if _log_condition(split) <= SHORT:
            products = np.repeat(split, parts, axis=0)
            return products[:, None], products
    raise ComputationError(
        f"modes grow or die out too far within one of {steps} steps a turn; take more steps"
    )


def _log_condition(matrices: FloatArray) -> float:
    """Logarithm of the greatest ratio of a matrix's singular values."""
    if not np.isfinite(matrices).all():
        return np.inf
    with np.errstate(divide="ignore"):
        return float(np.log(np.linalg.cond(matrices).max()))


def _products(chunks: FloatArray) -> FloatArray:
    """Product of each row of matrices (K, m, n, n), the first rightmost; (K, n, n)."""
    while chunks.shape[1] > 1:
        even = chunks.shape[1] // 2 * 2
        paired = chunks[:, 1:even:2] @ chunks[:, 0:even:2]
        chunks = np.concatenate([paired, chunks[:, even:]], axis=1)
    return np.asarray(chunks[:, 0])


@dataclass(frozen=True)
class _TriangularForm:
    """``G_k Q_(k-1) = Q_k R_k`` over a period after which the groups of columns return.

    Parameters
    ----------
    bases : ndarray, shape (K + 1, n, n)
        Q_0 to Q_K.
    factors : ndarray, shape (K, n, n)
        R_1 to R_K.
    seam : ndarray, shape (n, n)
        ``Q_0' Q_K``, block diagonal.
    groups : list of slice
    apart : float
        By how much the logarithms of the moduli of neighbouring groups differ at the least.
    """

    bases: FloatArray
    factors: FloatArray
    seam: FloatArray
    groups: list[slice]
    apart: float


def _triangular_form(matrices: FloatArray) -> _TriangularForm:
    size = matrices.shape[1]
    # A general start: an invariant subspace of weak modes would stay before the strong ones.
    start = scipy.linalg.qr(np.random.default_rng(0).normal(size=(size, size)))[0]
    growth: list[FloatArray] = []
    turns, most_turns = 0, 1.0 * FIRST_TURNS
    while turns < most_turns:
        turns += 1
        bases, factors = _iterated(matrices, start)
        seam = bases[0].T @ bases[-1]
        growth.append(np.log(np.abs(np.einsum("kii->ki", factors))).sum(axis=0))
        # Over one turn columns of a group grow and shrink; on the average they do as its modes.
        logs = np.mean(growth[turns // 2 :], axis=0)
        groups = _groups(logs)
        edges = [group.start for group in groups[1:]]
        apart = min((_fall(logs, edge) for edge in edges), default=np.inf)
        closed = all(np.abs(seam[edge:, :edge]).max() <= PARTED for edge in edges)
        if closed and all(np.ptp(logs[group]) <= WIDEST for group in groups):
            return _TriangularForm(bases, factors, seam, groups, apart)
        most_turns = FIRST_TURNS - PATIENCE * np.log(PARTED) / apart
        start = bases[-1]
    raise ComputationError(
        "the Floquet multipliers do not part into groups; take more steps, or less damping"
    )


def _iterated(matrices: FloatArray, start: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Bases Q_0 to Q_K and factors R_1 to R_K of one turn."""
    count, size, _ = matrices.shape
    bases, factors = np.empty((count + 1, size, size)), np.empty((count, size, size))
    bases[0] = start
    # The routines behind scipy.linalg.qr, whose checks take longer than small matrices do.
    for k, matrix in enumerate(matrices):
        packed, reflectors, _, _ = scipy.linalg.lapack.dgeqrf(matrix @ bases[k])
        factors[k] = packed
        bases[k + 1] = scipy.linalg.lapack.dorgqr(packed, reflectors)[0]
    return bases, np.triu(factors)


def _fall(logs: FloatArray, edge: int) -> float:
    """By how much all columns before a place have grown more than all after it."""
    return float(logs[:edge].min() - logs[edge:].max())


def _groups(logs: FloatArray) -> list[slice]:
    """Columns in groups that part far enough, or as far as they do where a group is wide."""
    size = len(logs)
    falls = np.array([np.inf, *(_fall(logs, edge) for edge in range(1, size))])
    pending = [slice(a, b) for a, b in pairwise([*np.flatnonzero(falls > GROUPS_APART), size])]
    groups: list[slice] = []
    while pending:
        group = pending.pop(0)
        inner = falls[group.start + 1 : group.stop]
        if np.ptp(logs[group]) <= WIDEST or inner.max() <= 0:
            groups.append(group)
        else:
            edge = group.start + 1 + int(inner.argmax())
            pending[:0] = [slice(group.start, edge), slice(edge, group.stop)]
    return groups


def _block_eigenvalues(
    form: _TriangularForm,
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Logarithms of the multipliers (n,), and eigenvectors of their groups' blocks (n, n)."""
    size = len(form.seam)
    logs = np.zeros(size, dtype=complex)
    vectors = np.zeros((size, size), dtype=complex)
    for group in form.groups:
        product, scale = np.eye(group.stop - group.start), 0.0
        for factor in form.factors:
            product = factor[group, group] @ product
            largest = np.abs(product).max()
            product, scale = product / largest, scale + np.log(largest)
        values, vectors[group, group] = np.linalg.eig(form.seam[group, group] @ product)
        logs[group] = np.log(values.astype(complex)) + scale
    return logs, vectors


def _modes_backwards(
    form: _TriangularForm, log: NDArray[np.complex128], vectors: NDArray[np.complex128]
) -> NDArray[np.complex128]:
    """Shapes of the modes at the starts of the short matrices, (K, n, n).

    Backwards a mode outgrows those that are stronger than it, to which its own group's columns
    and those before them are open; after some turns its share in them is what it must be.
    """
    count = len(form.factors)
    back = np.exp(log / count)
    # Round-off would put strong modes into weaker columns, which grow most backwards.
    seam, stronger = np.zeros_like(form.seam), np.zeros(vectors.shape, dtype=bool)
    for group in form.groups:
        seam[group, group] = form.seam[group, group].T
        stronger[: group.start, group] = True
    shapes = np.zeros((count, *vectors.shape), dtype=complex)
    forgotten = -np.log(np.finfo(float).eps) / form.apart
    for _ in range(2 + int(np.ceil(forgotten)) if len(form.groups) > 1 else 1):
        coordinates = seam @ np.where(stronger, shapes[0], vectors)
        for k in range(count - 1, -1, -1):
            # Real and imaginary parts by the routine behind scipy.linalg.solve_triangular.
            solved = scipy.linalg.lapack.dtrtrs(form.factors[k], coordinates.view(float))[0]
            coordinates = back * np.ascontiguousarray(solved).view(complex)
            shapes[k] = coordinates
    shapes = form.bases[:-1] @ shapes
    size = np.linalg.norm(shapes[0], axis=0)
    # A mode that dies away beyond the least number within a turn has no shape left.
    return np.asarray(shapes / np.where(size > 0, size, 1.0))
