"""Floquet multipliers and modes of a periodic linear system, however far apart they are.

A mode is a solution ``phi(t) exp(lambda t)`` whose shape phi repeats itself after a period T; its
multiplier is ``exp(lambda T)``. They follow from the periodic Schur form of the transition matrices
along a period (:mod:`flexmech.dynamical_systems.periodic_schur`).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import gcd

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, IntArray
from flexmech.dynamical_systems.periodic_schur import (
    PeriodicSchurForm,
    block_eigenvalues,
    chunk_products,
    modes_backwards,
    parted_steps,
    periodic_schur_form,
    short_products,
)
from flexmech.dynamical_systems.periodic_system import (
    PeriodicSystem,
    SampledPeriodicSystem,
    magnus_exponents,
    transition_matrices,
)

# Instants at which the trace is known: the trapezoidal rule over a period converges beyond all
# orders, and eight thousand show more harmonics than a linkage has.
MOST_TRACES = 8192


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
    _shapes: _ConstantShapes | _PropagatedShapes

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
        return self._shapes.turns if isinstance(self._shapes, _ConstantShapes) else None

    def shapes(self, every: int = 1, wanted: IntArray | None = None) -> NDArray[np.complex128]:
        """Shapes ``phi`` at the starts of the N steps, (N, n, k): (step, state, mode).

        Parameters
        ----------
        every : int
            A divisor of N: at the start of every so many steps alone, (N / every, n, k).
        wanted : ndarray of int, shape (k,), optional
            Numbers of modes; all n by default.
        """
        return self._shapes.shapes(
            every, np.arange(len(self.exponent)) if wanted is None else wanted
        )


def floquet_modes(system: PeriodicSystem, steps: int) -> FloquetModes:
    """Floquet modes of a periodic system.

    Parameters
    ----------
    system : PeriodicSystem
    steps : int
        Steps of the propagator (:mod:`flexmech.dynamical_systems.periodic_system`) a period.

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
    return FloquetModes(system.period, log[order] / system.period, integral, propagated)


@dataclass(frozen=True)
class _ConstantShapes:
    """Shapes of a constant system's modes, which turn by whole angles in a period."""

    steps: int
    vectors: NDArray[np.complex128]
    turns: FloatArray

    def shapes(self, every: int, wanted: IntArray) -> NDArray[np.complex128]:
        phase = 2j * np.pi * np.arange(0, self.steps, every)[:, None] / self.steps
        return np.asarray(self.vectors[:, wanted] * np.exp(phase * self.turns[wanted])[:, None])


def _constant_modes(matrix: FloatArray, period: float, steps: int) -> FloquetModes:
    """Modes of a constant system, by its eigenvalues: some may die out within any step."""
    values, vectors = np.linalg.eig(matrix)
    order = np.argsort(-values.real, kind="stable")
    log = period * values[order].astype(complex)
    turns = np.round(log.imag / (2 * np.pi))
    shapes = _ConstantShapes(steps, vectors[:, order].astype(complex), turns)
    trace = period * float(np.trace(matrix))
    exponent = ((log - 2j * np.pi * turns) / period).astype(np.complex128)
    return FloquetModes(period, exponent, trace, shapes)


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
        own = np.flatnonzero(~self._conjugate)
        return modes_backwards(self.triangular, self.log, self.vectors, own)

    def shapes(self, every: int, wanted: IntArray) -> NDArray[np.complex128]:
        raw = self.order[wanted]
        found = self._own_shapes(every, (np.cumsum(~self._conjugate) - 1)[raw], raw)
        mirrored = self._conjugate[raw]
        found[..., mirrored] = found[..., mirrored].conj()
        return found

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
        Between -1 and 1; zero where the multiplier is not on the unit circle. Of modes that share
        a multiplier it is that of the vectors given, not of the multiplier.
    """
    half = shapes.shape[-2] // 2
    y, p = shapes[..., :half, :], shapes[..., half:, :]
    size = (np.abs(shapes) ** 2).sum(axis=-2)
    return np.asarray(2 * (y.conj() * p).imag.sum(axis=-2) / size, dtype=float)
