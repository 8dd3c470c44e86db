"""Linear systems ``x' = A(t) x`` whose matrix repeats itself, and their transition matrices.

The Magnus expansion of sixth order: the transition matrix of a step is the exponential of one
matrix that is made of A at the three Gauss points and its commutators (S. Blanes, F. Casas,
J. A. Oteo & J. Ros, The Magnus expansion and some of its applications, Physics Reports 470
(2009) 151-238, section 5.4). What holds for the exact transition matrix holds for this one
whatever the step: that of a Hamiltonian system is symplectic, its determinant is the exponential
of the integral of the trace (Liouville), and what is strongly damped dies out. A constant system
is solved exactly.

The exponential is the Taylor polynomial of degree 16 of a matrix that is halved until its norm is
small, squared as often (N. J. Higham, Functions of Matrices, SIAM 2008, section 10.3). All of it
is products of stacked matrices, six of them and one a squaring. For small matrices that is several
times faster than one call of a general routine for each.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from math import factorial

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.dynamical_systems.fourier import FourierSeries

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
    def matrices(self, count: int, shift: float, part: slice = slice(None)) -> FloatArray:
        """A at the times ``(k + shift) period / count``, shape (count, n, n).

        Parameters
        ----------
        count : int
        shift : float
            In spacings.
        part : slice
            Of the numbers k; all by default.
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

    def matrices(self, count: int, shift: float, part: slice = slice(None)) -> FloatArray:
        """A at the times ``(k + shift) period / count``, shape (count, n, n).

        Parameters
        ----------
        count : int
        shift : float
            In spacings.
        part : slice
            Of the numbers k; all by default.
        """
        time: FloatArray = self.period / count * (np.arange(count, dtype=float)[part] + shift)
        return np.asarray(self.matrix(time))


@dataclass(frozen=True)
class SampledPeriodicSystem(PeriodicSystem):
    """A periodic system whose matrix is a Fourier series.

    Parameters
    ----------
    matrix : FourierSeries
        Of A, (n, n).
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

    def matrices(self, count: int, shift: float, part: slice = slice(None)) -> FloatArray:
        """A at the times ``(k + shift) period / count``, shape (count, n, n).

        Parameters
        ----------
        count : int
        shift : float
            In spacings.
        part : slice
            Of the numbers k; all by default.
        """
        return self.matrix.samples(count, shift, part)

    def traces(self, count: int) -> FloatArray:
        """Trace of A at the times ``k period / count``, shape (count,)."""
        coefficients = np.trace(self.matrix.coefficients, axis1=1, axis2=2)
        return FourierSeries(coefficients).samples(count)


def magnus_exponents(system: PeriodicSystem, steps: int, part: slice = slice(None)) -> FloatArray:
    """Matrices whose exponentials are the transition matrices of a period's steps.

    Parameters
    ----------
    system : PeriodicSystem
    steps : int
        N, all of the same length.

    part : slice
        Of the steps; all by default.

    Returns
    -------
    ndarray, shape (N, n, n)
    """
    first, middle, last = (system.matrices(steps, place, part) for place in GAUSS_POINTS)
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
        part = slice(first, first + EXPONENTS)
        result[part] = matrix_exponentials(magnus_exponents(system, steps, part))
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
        for part in parts[2::-1]:
            result = result @ fourth + part
        for _ in range(halvings):
            result = result @ result
    return result
