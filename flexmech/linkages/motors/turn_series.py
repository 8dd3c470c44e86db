"""A function of an angle that repeats itself from turn to turn, as a Fourier series.

It has all derivatives: an integration of high order along it takes long steps.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import ComplexArray, FloatArray


@dataclass(frozen=True, eq=False)
class TurnSeries:
    """Real part of ``sum_n c_n exp(i n angle)``.

    Parameters
    ----------
    coefficients : ndarray of complex, shape (harmonics + 1,)
        That of the mean first.
    """

    coefficients: ComplexArray

    @classmethod
    def of(cls, angle: FloatArray, values: FloatArray, harmonics: int) -> Self:
        """The series of a function that is known at some angles.

        Parameters
        ----------
        angle : ndarray, shape (m,)
            Increasing, over less than a turn, in rad; far closer than the harmonics need.
        values : ndarray, shape (m,)
        harmonics : int

        Returns
        -------
        TurnSeries
        """
        from scipy.interpolate import CubicSpline

        whole, closed = np.append(angle, angle[0] + 2 * np.pi), np.append(values, values[0])
        spline = CubicSpline(whole, closed, bc_type="periodic", extrapolate="periodic")
        count = len(angle)
        found = np.fft.rfft(spline(2 * np.pi / count * np.arange(count))) / count
        found[1:] *= 2.0
        return cls(found[: harmonics + 1])

    def __call__(self, angle: ArrayLike, order: int = 0) -> FloatArray:
        """Values, or those of a derivative by the angle, at angles in rad; (...) -> (...)."""
        number = np.arange(len(self.coefficients))
        waves = np.exp(1j * number * np.asarray(angle, dtype=float)[..., None])
        return np.asarray((waves @ (self.coefficients * (1j * number) ** order)).real)
