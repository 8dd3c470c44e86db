"""Linear systems ``x' = A(t) x`` whose matrix repeats itself."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from flexmech.dynamical_systems.fourier import FourierSeries
from flexmech.types import FloatArray


class PeriodicSystem(Protocol):
    """A linear system of n states over a period."""

    @property
    def period(self) -> float:
        """In s."""

    @property
    def size(self) -> int:
        """Number of states n."""

    def matrices(self, count: int, shift: float) -> FloatArray:
        """A at the times ``(k + shift) period / count``, shape (count, n, n)."""

    def traces(self, count: int) -> FloatArray:
        """Trace of A at the times ``k period / count``, shape (count,)."""


@dataclass(frozen=True)
class StatedPeriodicSystem:
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

    @property
    def size(self) -> int:
        """Number of states n."""
        return int(self.matrices(1, 0.0).shape[-1])

    def matrices(self, count: int, shift: float) -> FloatArray:
        """A at the times ``(k + shift) period / count``, shape (count, n, n)."""
        time: FloatArray = self.period / count * (np.arange(count, dtype=float) + shift)
        return np.asarray(self.matrix(time))

    def traces(self, count: int) -> FloatArray:
        """Trace of A at the times ``k period / count``, shape (count,)."""
        return np.asarray(np.trace(self.matrices(count, 0.0), axis1=1, axis2=2))


@dataclass(frozen=True)
class SampledPeriodicSystem:
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
        """Whether the series is of one value."""
        return not self.matrix.harmonics

    def matrices(self, count: int, shift: float) -> FloatArray:
        """A at the times ``(k + shift) period / count``, shape (count, n, n)."""
        return self.matrix.samples(count, shift)

    def traces(self, count: int) -> FloatArray:
        """Trace of A at the times ``k period / count``, shape (count,)."""
        coefficients = np.trace(self.matrix.coefficients, axis1=1, axis2=2)
        return FourierSeries(coefficients).samples(count)
