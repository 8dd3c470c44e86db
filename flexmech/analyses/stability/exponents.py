"""Exponents of Floquet modes at a crank speed, and what follows from them alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexmech.types import FloatArray

GROWS = 1e-7
"""Logarithm of a multiplier's modulus that is growth, and not round-off."""


@dataclass(frozen=True)
class FloquetExponents:
    """Exponents of k Floquet modes.

    Parameters
    ----------
    crank_speed : float
        rad/s.
    exponent : ndarray of complex, shape (k,)
        1/s.
    """

    crank_speed: float
    exponent: NDArray[np.complex128]

    @property
    def period(self) -> float:
        """Time of a turn in s."""
        return 2 * np.pi / abs(self.crank_speed)

    @property
    def log_modulus(self) -> FloatArray:
        """Logarithm of the multipliers' moduli, (k,)."""
        return np.asarray(self.exponent.real * self.period)

    @property
    def angle(self) -> FloatArray:
        """Angle of the multipliers between -pi and pi, (k,)."""
        return wrapped(self.exponent.imag * self.period)

    @property
    def growth_rate(self) -> float:
        """Greatest of all, 1/s."""
        return float(self.exponent.real.max())

    def grows_beyond(self, error: FloatArray) -> bool:
        """Whether a modulus exceeds one by more than errors (k,) of the logarithms."""
        growing = np.expm1(self.log_modulus)
        return bool(np.any(growing > error * (1 + growing)))


def wrapped(values: FloatArray, turn: float = 2 * np.pi) -> FloatArray:
    """Values less the whole turns in them: between minus and plus half a turn."""
    return np.asarray(values - turn * np.round(values / turn))
