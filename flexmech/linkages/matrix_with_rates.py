"""Time-varying matrices with their first and second derivatives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from flexmech.arrays import FloatArray, IntArray


@dataclass(frozen=True)
class MatrixWithRates:
    """A matrix and its time derivatives over a batch of positions.

    Parameters
    ----------
    value : ndarray, shape (B, r, c)
    rate : ndarray, shape (B, r, c)
        First time derivative.
    centripetal, tangential : ndarray, shape (B, r, c)
        Second time derivative: the parts in squares and products of velocities of the rigid
        motion, and in its accelerations.

    Examples
    --------
    >>> import numpy as np
    >>> from flexmech.linkages.matrix_with_rates import MatrixWithRates
    >>> turn = MatrixWithRates.rotation(np.array([0.5]), np.array([2.0]), np.array([0.0]))
    >>> still = turn.solve(turn)
    >>> bool(np.allclose(still.value, np.eye(2)))
    True
    >>> bool(np.allclose(still.rate, 0.0))
    True
    """

    value: FloatArray
    rate: FloatArray
    centripetal: FloatArray
    tangential: FloatArray

    @classmethod
    def constant(cls, matrix: FloatArray, batch: int) -> Self:
        """A constant matrix.

        Parameters
        ----------
        matrix : ndarray, shape (r, c)
        batch : int
            How many times.
        """
        nothing = np.zeros((batch, *matrix.shape))
        return cls(nothing + matrix, nothing, nothing, nothing)

    @classmethod
    def rotation(cls, angle: FloatArray, speed: FloatArray, change: FloatArray) -> Self:
        """Rotation by an angle, (B, 2, 2).

        Parameters
        ----------
        angle, speed, change : ndarray, shape (B,)
            In rad, with its first and second time derivative.
        """
        cosine, sine = np.cos(angle), np.sin(angle)
        turn = np.stack([cosine, -sine, sine, cosine], axis=-1).reshape(-1, 2, 2)
        quarter = np.stack([-sine, -cosine, cosine, -sine], axis=-1).reshape(-1, 2, 2)
        return cls(
            turn,
            speed[:, None, None] * quarter,
            -(speed[:, None, None] ** 2) * turn,
            change[:, None, None] * quarter,
        )

    def rows(self, which: IntArray) -> Self:
        """Some rows, by their numbers."""
        return type(self)(*(part[:, which] for part in self.parts))

    def columns(self, which: IntArray) -> Self:
        """Some columns, by their numbers."""
        return type(self)(*(part[:, :, which] for part in self.parts))

    def __matmul__(self, other: MatrixWithRates) -> MatrixWithRates:
        return MatrixWithRates(
            self.value @ other.value,
            self.rate @ other.value + self.value @ other.rate,
            self.centripetal @ other.value
            + 2 * self.rate @ other.rate
            + self.value @ other.centripetal,
            self.tangential @ other.value + self.value @ other.tangential,
        )

    def __sub__(self, other: MatrixWithRates) -> MatrixWithRates:
        return MatrixWithRates(
            *(own - its for own, its in zip(self.parts, other.parts, strict=True))
        )

    def __neg__(self) -> MatrixWithRates:
        return MatrixWithRates(*(-part for part in self.parts))

    def solve(self, right: MatrixWithRates) -> MatrixWithRates:
        """``X`` of ``self @ X = right``, by implicit differentiation.

        Parameters
        ----------
        right : MatrixWithRates
            Of shape (B, n, c); ``self`` is of shape (B, n, n).

        Returns
        -------
        MatrixWithRates
            Of shape (B, n, c).
        """
        inverse = np.asarray(np.linalg.inv(self.value), dtype=float)
        value = inverse @ right.value
        rate = inverse @ (right.rate - self.rate @ value)
        centripetal = right.centripetal - self.centripetal @ value - 2 * self.rate @ rate
        tangential = right.tangential - self.tangential @ value
        return MatrixWithRates(value, rate, inverse @ centripetal, inverse @ tangential)

    @classmethod
    def stacked(cls, parts: list[MatrixWithRates]) -> MatrixWithRates:
        """Several matrices stacked by rows."""
        every = zip(*(part.parts for part in parts), strict=True)
        return cls(*(np.concatenate(one, axis=1) for one in every))

    @property
    def parts(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Value, rate, and the two parts of the second derivative."""
        return self.value, self.rate, self.centripetal, self.tangential
