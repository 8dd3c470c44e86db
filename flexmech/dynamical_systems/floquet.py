"""Floquet multipliers and modes of a periodic linear system, however far apart they are.

A mode is a solution ``phi(t) exp(lambda t)`` whose shape phi repeats itself after a period T; its
multiplier is ``exp(lambda T)``.

Multiplied together, the transition matrices of a whole period lose what decays fast beside what
does not: of a multiplier of ``exp(-24 * 2 pi)`` beside one of 1 nothing is left. So they stay
short, and are brought to triangular form one after the other::

    G_k Q_(k-1) = Q_k R_k

Where the multipliers come in groups that are far apart, the columns of Q_k tend to the subspaces
of these groups as the turns go by, the strongest group first (orthogonal iteration; this is the
periodic Schur form of A. Bojanczyk, G. H. Golub & P. Van Dooren, SPIE 1770 (1992) 31-42, in blocks
of comparable size). The multipliers of a group are the eigenvalues of the product of its blocks on
the diagonals of R_k alone. The modes follow backwards in time, where what is weak is not lost
beside what is strong.

Transition matrices of a system ``x' = A(t) x`` come from the Magnus expansion of sixth order: the
transition matrix of a step is the exponential of one matrix that is made of A at the three Gauss
points and its commutators (S. Blanes, F. Casas, J. A. Oteo & J. Ros, The Magnus expansion and some
of its applications, Physics Reports 470 (2009) 151-238, section 5.4). What holds for the exact
transition matrix holds for this one whatever the step: that of a Hamiltonian system is symplectic,
its determinant is the exponential of the integral of the trace (Liouville), and what is strongly
damped dies out. A constant system is solved exactly.

The exponential is the Taylor polynomial of degree 16 of a matrix that is halved until its norm is
small, squared as often (N. J. Higham, Functions of Matrices, SIAM 2008, section 10.3). All of it
is products of stacked matrices, six of them and one a squaring. For small matrices that is several
times faster than one call of a general routine for each.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import pairwise
from math import factorial, gcd

import numpy as np
import scipy.linalg
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, IntArray
from flexmech.dynamical_systems.fourier import FourierSeries
from flexmech.errors import ComputationError

# Gauss-Legendre points of a step: their quadrature is exact to sixth order, as the expansion is.
GAUSS_POINTS = tuple((0.5 + 0.1 * np.sqrt(15.0) * np.array([-1.0, 0.0, 1.0])).tolist())
# Norm up to which the polynomial of this degree is exact to double precision (A. H. Al-Mohy &
# N. J. Higham, SIAM Journal on Scientific Computing 33 (2011) 488-511, eq. 3.3 and table 3.1).
LARGEST_NORM = 0.78
# Row j: coefficients of A^(4 j) to A^(4 j + 3).
COEFFICIENTS = np.array([[1 / factorial(4 * j + k) for k in range(4)] for j in range(4)])
LAST = 1 / factorial(16)
# Steps whose exponents are kept at a time. Memory alone: a slow turn takes tens of thousands.
EXPONENTS = 2048
# Bytes of matrices taken at a time. Speed alone: a dozen arrays of them fit into a processor's
# cache.
BLOCK = 2**17


class PeriodicSystem(ABC):
    """A linear system of n states over a period.

    Attributes
    ----------
    period : float
        In s.
    """

    period: float

    @property
    def size(self) -> int:
        """Number of states n."""
        return int(self.matrices(1, 0.0).shape[-1])

    @abstractmethod
    def matrices(self, count: int, shift: float, which: slice = slice(None)) -> FloatArray:
        """A at the times ``(k + shift) period / count``, shape (count, n, n).

        Parameters
        ----------
        count : int
        shift : float
            In spacings.
        which : slice
            Part of the numbers k; all by default.
        """

    def traces(self, count: int) -> FloatArray:
        """Trace of A at the times ``k period / count``, shape (count,)."""
        return np.asarray(np.trace(self.matrices(count, 0.0), axis1=1, axis2=2))


@dataclass(frozen=True)
class StatedPeriodicSystem(PeriodicSystem):
    """A periodic system whose matrix is a function of time.

    Parameters
    ----------
    matrix : callable
        From times of shape (N,) in s to A, shape (N, n, n).
    period : float
        In s.
    """

    matrix: Callable[[FloatArray], FloatArray]
    period: float

    def matrices(self, count: int, shift: float, which: slice = slice(None)) -> FloatArray:
        """A at the times ``(k + shift) period / count``, shape (count, n, n).

        Parameters
        ----------
        count : int
        shift : float
            In spacings.
        which : slice
            Part of the numbers k; all by default.
        """
        time: FloatArray = self.period / count * (np.arange(count, dtype=float)[which] + shift)
        return np.asarray(self.matrix(time))


@dataclass(frozen=True)
class SampledPeriodicSystem(PeriodicSystem):
    """A periodic system whose matrix is a Fourier series.

    Parameters
    ----------
    matrix : FourierSeries
        Matrix of A, (n, n).
    period : float
        In s.
    """

    matrix: FourierSeries
    period: float

    @property
    def size(self) -> int:
        """Number of states n."""
        return int(self.matrix.coefficients.shape[-1])

    @property
    def is_constant(self) -> bool:
        """Whether the matrix does not change over the period."""
        return not self.matrix.harmonics

    def matrices(self, count: int, shift: float, which: slice = slice(None)) -> FloatArray:
        """A at the times ``(k + shift) period / count``, shape (count, n, n).

        Parameters
        ----------
        count : int
        shift : float
            In spacings.
        which : slice
            Part of the numbers k; all by default.
        """
        return self.matrix.samples(count, shift, which)

    def traces(self, count: int) -> FloatArray:
        """Trace of A at the times ``k period / count``, shape (count,)."""
        coefficients = np.trace(self.matrix.coefficients, axis1=1, axis2=2)
        return FourierSeries(coefficients).samples(count)


def magnus_exponents(system: PeriodicSystem, steps: int, which: slice = slice(None)) -> FloatArray:
    """Matrices whose exponentials are the transition matrices of a period's steps.

    Parameters
    ----------
    system : PeriodicSystem
    steps : int
        N, all of the same length.

    which : slice
        Part of the steps; all by default.

    Returns
    -------
    ndarray, shape (N, n, n)
    """
    first, middle, last = (system.matrices(steps, place, which) for place in GAUSS_POINTS)
    step = system.period / steps
    result = np.empty(middle.shape)
    for block in cache_blocks(middle):
        mean = step * middle[block]
        slope = np.sqrt(15.0) / 3.0 * step * (last[block] - first[block])
        bow = 10.0 / 3.0 * step * (last[block] - 2.0 * middle[block] + first[block])
        turn = _commutator(mean, slope)
        twist = _commutator(mean, 2.0 * bow + turn) / -60.0
        outer = _commutator(turn - 20.0 * mean - bow, slope + twist)
        result[block] = mean + bow / 12.0 + outer / 240.0
    return result


def transition_matrices(system: PeriodicSystem, steps: int) -> FloatArray:
    """Transition matrices of the steps of a period.

    Parameters
    ----------
    system : PeriodicSystem
    steps : int
        N, all of the same length.

    Returns
    -------
    ndarray, shape (N, n, n)
    """
    result = np.empty((steps, system.size, system.size))
    for first in range(0, steps, EXPONENTS):
        steps_at_once = slice(first, first + EXPONENTS)
        result[steps_at_once] = matrix_exponentials(magnus_exponents(system, steps, steps_at_once))
    return result


def _commutator(first: FloatArray, second: FloatArray) -> FloatArray:
    return first @ second - second @ first


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
        result[block] = _exponentials_of_block(matrices[block])
    return result


def cache_blocks(matrices: FloatArray) -> list[slice]:
    """Parts of a stack (N, n, n) so short that a dozen arrays like each stay in the cache."""
    count = max(1, BLOCK // max(1, matrices[:1].nbytes))
    return [slice(first, first + count) for first in range(0, len(matrices), count)]


def _exponentials_of_block(matrices: FloatArray) -> FloatArray:
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
        for term in parts[2::-1]:
            result = result @ fourth + term
        for _ in range(halvings):
            result = result @ result
    return result


# Instants at which the trace is known: the trapezoidal rule over a period converges beyond all
# orders, and eight thousand show more harmonics than a linkage has.
MOST_TRACES = 8192
# Logarithm of how far apart the multipliers, and singular values, of one short transition matrix
# may be: twelve digits of the weakest remain.
SHORT = 9.0
# Groups part where the logarithms of neighbouring moduli are this far apart, and where they are
# less far apart if a group would be wider than that from its strongest to its weakest mode: of
# the weakest, ten digits remain.
GROUPS_APART = 4.0
WIDEST = 12.0
# Part of a group in another one that is round-off of a turn of some thousand products.
PARTED = 1e-11
# Turns that groups take to show: averages over ten of them tell which part. And how many times what
# their distance asks for they may take, since columns of a group have to be separated first.
FIRST_TURNS = 20
PATIENCE = 3.0
# Parts of a step, where damping ratios are far above one: exp(8 * 1024) fits within a step.
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
    whole_turns : ndarray, shape (n,), optional
        Whole turns a period of each shape of a constant system: such a shape is one harmonic,
        eigenvectors whose phase turns. None of other systems.
    """

    period: float
    exponent: NDArray[np.complex128]
    trace_integral: float
    whole_turns: FloatArray | None
    _shapes: Callable[[int, IntArray], NDArray[np.complex128]]

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

    def shapes(self, every: int = 1, wanted: IntArray | None = None) -> NDArray[np.complex128]:
        """Shapes ``phi`` at the starts of the N steps, (N, n, k): (step, state, mode).

        Parameters
        ----------
        every : int
            A divisor of N: at the start of every so many steps alone, (N / every, n, k).
        wanted : ndarray of int, shape (k,), optional
            Numbers of modes; all n by default.
        """
        return self._shapes(every, np.arange(len(self.exponent)) if wanted is None else wanted)


def floquet_modes(system: PeriodicSystem, steps: int) -> FloquetModes:
    """Floquet modes of a periodic system.

    Parameters
    ----------
    system : PeriodicSystem
    steps : int
        Steps of the propagator (:mod:`flexmech.dynamical_systems.floquet`) a period.

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
    trace = system.traces(min(2 * steps, MOST_TRACES))
    integral = float(trace.mean() * system.period)
    matrices = transition_matrices(system, steps)
    if not np.ptp(matrices, axis=0).any():
        exponent = magnus_exponents(system, steps)
        # Matrices of which nothing is left are equal too.
        if not np.ptp(exponent, axis=0).any():
            return _constant_modes(exponent[0] * (steps / system.period), system.period, steps)
    spread = float(np.abs(trace).mean() * system.period)
    short = short_products(matrices, spread)
    chunks, products = short or parted_steps(magnus_exponents(system, steps))
    triangular = periodic_schur_form(products)
    log, vectors = block_eigenvalues(triangular)
    order = np.argsort(-log.real, kind="stable")
    propagated = _PropagatedShapes(steps, chunks, triangular, log, vectors, order)
    shapes, period = propagated.shapes, system.period
    return FloquetModes(period, log[order] / period, integral, None, shapes)


def _turning_shapes(
    steps: int,
    vectors: NDArray[np.complex128],
    turns: FloatArray,
    every: int,
    wanted: IntArray,
) -> NDArray[np.complex128]:
    """Shapes of a constant system's modes, which turn by whole angles in a period."""
    phase = 2j * np.pi * np.arange(0, steps, every)[:, None] / steps
    return np.asarray(vectors[:, wanted] * np.exp(phase * turns[wanted])[:, None])


def _constant_modes(matrix: FloatArray, period: float, steps: int) -> FloquetModes:
    """Modes of a constant system, by its eigenvalues: some may die out within any step."""
    values, vectors = np.linalg.eig(matrix)
    order = np.argsort(-values.real, kind="stable")
    log = period * values[order].astype(complex)
    turns = np.round(log.imag / (2 * np.pi))
    shapes = partial(_turning_shapes, steps, vectors[:, order].astype(complex), turns)
    trace = period * float(np.trace(matrix))
    exponent = ((log - 2j * np.pi * turns) / period).astype(np.complex128)
    return FloquetModes(period, exponent, trace, turns, shapes)


@dataclass(frozen=True)
class _PropagatedShapes:
    """Shapes by the periodic Schur form; ``order`` is that in which the modes stand."""

    steps: int
    chunks: FloatArray
    triangular: PeriodicSchurForm
    log: NDArray[np.complex128]
    vectors: NDArray[np.complex128]
    order: IntArray

    @cached_property
    def _conjugate(self) -> NDArray[np.bool_]:
        """Whether a mode is the conjugate of the one before it, (n,)."""
        before = np.roll(self.log, 1)
        return np.asarray((self.log.imag < 0) & (self.log == before.conj()))

    @cached_property
    def _starts(self) -> NDArray[np.complex128]:
        """Shapes at the starts of the K rows of the modes that are no conjugates of others."""
        unpaired = np.flatnonzero(~self._conjugate)
        return modes_backwards(self.triangular, self.log, self.vectors, unpaired)

    def shapes(self, every: int, wanted: IntArray) -> NDArray[np.complex128]:
        raw = self.order[wanted]
        shapes = self._own_shapes(every, (np.cumsum(~self._conjugate) - 1)[raw], raw)
        mirrored = self._conjugate[raw]
        shapes[..., mirrored] = shapes[..., mirrored].conj()
        return shapes

    def _own_shapes(self, every: int, place: IntArray, raw: IntArray) -> NDArray[np.complex128]:
        """Shapes (.., n, k) of modes at places among those that are no conjugates."""
        count, length, size, _ = self.chunks.shape
        parts = count * length // self.steps
        if every * parts % length == 0:
            return self._starts[:: every * parts // length][..., place]
        now = np.ascontiguousarray(self._starts[..., place])
        # Nothing is wanted in the middle of so many transition matrices.
        joined = gcd(every * parts, length)
        length //= joined
        chunks = chunk_products(self.chunks.reshape(-1, joined, size, size))
        chunks = chunks.reshape(count, length, size, size)
        shapes = np.empty((count, length, *now.shape[1:]), dtype=complex)
        log = self.log[raw]
        back = np.exp(-np.where(self._conjugate[raw], log.conj(), log) / (count * length))
        for step in range(length):
            shapes[:, step] = now
            # Real matrices move real and imaginary parts by themselves.
            moved = chunks[:, step] @ now.view(float)
            now = back * moved.view(complex)
        return shapes.reshape(-1, *now.shape[1:])[:: every * parts // joined].copy()


def krein_signature(shapes: NDArray[np.complex128]) -> FloatArray:
    """Krein signature of Floquet modes in canonical coordinates ``x = (y, p)``.

    A multiplier of a Hamiltonian system leaves the unit circle only where it meets another one,
    and only if the two have opposite signatures (V. A. Yakubovich & V. M. Starzhinskii, Linear
    Differential Equations with Periodic Coefficients, Wiley 1975, chapter III). Where the Hamilton
    function is positive definite, the signature is the sign of the frequency: the multiplier of
    ``f_a`` then meets an opposite one in that of ``-f_b`` alone, so that sums of frequencies can
    be unstable and differences cannot.

    It is ``x^H i J x / x^H x`` with ``J x' = H x``, so with ``J = [0, -1; 1, 0]``, and is the same
    at all times but for the size of x. A mode of a constant system with positive energy has the
    sign of its frequency.

    Parameters
    ----------
    shapes : ndarray of complex, shape (..., 2 m, k)
        Modes in columns, y before p.

    Returns
    -------
    ndarray, shape (..., k)
        Between -1 and 1; zero where the multiplier is not on the unit circle. Modes that share a
        multiplier have the signatures of the vectors given, not of the multiplier.
    """
    half = shapes.shape[-2] // 2
    y, p = shapes[..., :half, :], shapes[..., half:, :]
    size = (np.abs(shapes) ** 2).sum(axis=-2)
    return np.asarray(2 * (y.conj() * p).imag.sum(axis=-2) / size, dtype=float)


def short_products(matrices: FloatArray, spread: float) -> tuple[FloatArray, FloatArray] | None:
    """Transition matrices of a period in rows so short that no product loses a weak multiplier.

    Parameters
    ----------
    matrices : ndarray, shape (N, n, n)
        Transition matrices of the steps.
    spread : float
        By how much the logarithms of the multipliers differ by damping alone. Where vibrations
        grow, rows are halved on.

    Returns
    -------
    ndarray, shape (K, m, n, n)
        K rows of m matrices each.
    ndarray, shape (K, n, n)
        Their products. None of both where a step is too long for itself.
    """
    steps = len(matrices)
    divisors = [n for n in range(1, steps + 1) if steps % n == 0]
    wanted, count = max(1, int(np.ceil(spread / SHORT))), 0
    while count < steps:
        count = next((n for n in divisors if n >= wanted), steps)
        chunks = matrices.reshape(count, steps // count, *matrices.shape[1:])
        # Steps far longer than a vibration's period can let it grow beyond all numbers.
        with np.errstate(over="ignore", invalid="ignore"):
            products = chunk_products(chunks)
        if _log_condition(products) <= SHORT:
            return chunks, products
        wanted = 2 * count
    return None


def parted_steps(exponent: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Transition matrices of parts of steps that are too long for themselves.

    The matrix of a step is the power of that of its part.

    Parameters
    ----------
    exponent : ndarray, shape (N, n, n)
        Logarithms of the transition matrices of the steps.

    Returns
    -------
    ndarray, shape (K, 1, n, n)
    ndarray, shape (K, n, n)
        As of :func:`short_products`.

    Raises
    ------
    ComputationError
        If modes grow or decay too far within one step.
    """
    parts = 1
    while parts < MOST_PARTS:
        parts *= 2
        split = matrix_exponentials(exponent / parts)
        if _log_condition(split) <= SHORT:
            products = np.repeat(split, parts, axis=0)
            return products[:, None], products
    raise ComputationError(
        f"modes grow or die out too far within one of {len(exponent)} steps a turn; take more steps"
    )


def _log_condition(matrices: FloatArray) -> float:
    """Logarithm of the greatest ratio of a matrix's singular values, or a bound within SHORT."""
    if not np.isfinite(matrices).all():
        return np.inf
    largest = -np.inf
    with np.errstate(divide="ignore", over="ignore"):
        for block in cache_blocks(matrices):
            # The bound takes a tenth of the time of singular values.
            greatest = np.linalg.cond(matrices[block], "fro").max()
            if not np.log(greatest) <= SHORT:
                greatest = np.linalg.cond(matrices[block]).max()
            largest = max(largest, float(np.log(greatest)))
            if not largest <= SHORT:
                break
    return largest


def chunk_products(chunks: FloatArray) -> FloatArray:
    """Product of each row of matrices, the first rightmost.

    Parameters
    ----------
    chunks : ndarray, shape (K, m, n, n)

    Returns
    -------
    ndarray, shape (K, n, n)
    """
    while chunks.shape[1] > 1:
        even = chunks.shape[1] // 2 * 2
        paired, rest = chunks[:, 1:even:2] @ chunks[:, 0:even:2], chunks[:, even:]
        chunks = np.concatenate([paired, rest], axis=1) if rest.shape[1] else paired
    return np.asarray(chunks[:, 0])


@dataclass(frozen=True)
class PeriodicSchurForm:
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


def periodic_schur_form(matrices: FloatArray) -> PeriodicSchurForm:
    """Periodic Schur form of K matrices in groups of columns.

    Parameters
    ----------
    matrices : ndarray, shape (K, n, n)
        G_1 to G_K.

    Returns
    -------
    PeriodicSchurForm

    Raises
    ------
    ComputationError
        If the multipliers do not part into groups.
    """
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
            return PeriodicSchurForm(bases, factors, seam, groups, apart)
        most_turns = FIRST_TURNS - PATIENCE * np.log(PARTED) / apart
        start = bases[-1].copy()
        del bases, factors  # They are as large as all that is left.
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
    factors *= np.tri(size).T
    return bases, factors


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


def block_eigenvalues(
    form: PeriodicSchurForm,
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Eigenvalues of the product ``G_K ... G_1``, group by group.

    Parameters
    ----------
    form : PeriodicSchurForm

    Returns
    -------
    ndarray of complex, shape (n,)
        Logarithms of the multipliers.
    ndarray of complex, shape (n, n)
        Eigenvectors of their groups' diagonal blocks.
    """
    size = len(form.seam)
    logs = np.zeros(size, dtype=complex)
    vectors = np.zeros((size, size), dtype=complex)
    for group in form.groups:
        product, scale = _scaled_product(form.factors[:, group, group])
        values, vectors[group, group] = np.linalg.eig(form.seam[group, group] @ product)
        logs[group] = np.log(values.astype(complex)) + scale
    return logs, vectors


def _scaled_product(matrices: FloatArray) -> tuple[FloatArray, float]:
    """Product of matrices (K, n, n), the first rightmost, over a factor with this logarithm."""
    scale = 0.0
    while True:
        largest = np.abs(matrices).max(axis=(1, 2))
        matrices, scale = matrices / largest[:, None, None], scale + float(np.log(largest).sum())
        if len(matrices) == 1:
            return matrices[0], scale
        even = len(matrices) // 2 * 2
        paired = matrices[1:even:2] @ matrices[0:even:2]
        matrices = np.concatenate([paired, matrices[even:]])


def modes_backwards(
    form: PeriodicSchurForm,
    log: NDArray[np.complex128],
    vectors: NDArray[np.complex128],
    wanted: IntArray,
) -> NDArray[np.complex128]:
    """Shapes of modes at the starts of the K matrices.

    Backwards a mode outgrows those that are stronger than it, to which its own group's columns
    and those before them are open; after some turns its share in them is what it must be.

    Parameters
    ----------
    form : PeriodicSchurForm
    log : ndarray of complex, shape (n,)
    vectors : ndarray of complex, shape (n, n)
        Both of :func:`block_eigenvalues`.
    wanted : ndarray of int, shape (k,)
        Numbers of the modes.

    Returns
    -------
    ndarray of complex, shape (K, n, k)
        Modes in columns.
    """
    count = len(form.factors)
    back = np.exp(log[wanted] / count)
    # Round-off would put strong modes into weaker columns, which grow most backwards.
    seam, stronger = np.zeros_like(form.seam), np.zeros(vectors.shape, dtype=bool)
    for group in form.groups:
        seam[group, group] = form.seam[group, group].T
        stronger[: group.start, group] = True
    stronger, vectors = stronger[:, wanted], vectors[:, wanted]
    shapes = np.zeros((count, *vectors.shape), dtype=complex)
    forgotten = -np.log(np.finfo(float).eps) / form.apart
    for _ in range(2 + int(np.ceil(forgotten)) if len(form.groups) > 1 else 1):
        coordinates = seam @ np.where(stronger, shapes[0], vectors)
        for k in range(count - 1, -1, -1):
            # Real and imaginary parts by the routine behind scipy.linalg.solve_triangular.
            solved = scipy.linalg.lapack.dtrtrs(form.factors[k], coordinates.view(float))[0]
            coordinates = back * np.ascontiguousarray(solved).view(complex)
            shapes[k] = coordinates
    for block in cache_blocks(shapes):
        shapes[block] = form.bases[:-1][block] @ shapes[block]
    size = np.linalg.norm(shapes[0], axis=0)
    # A mode that dies away beyond the least number within a turn has no shape left.
    shapes /= np.where(size > 0, size, 1.0)
    return shapes
