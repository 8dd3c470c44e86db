"""Linear equations of motion at some instants, and the coordinates condensed statically."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import FloatArray
from flexmech.dynamical_systems import EquationsOfMotion, VibrationState
from flexmech.linear_system import SystemMatrices, condense
from flexmech.linkages import RigidMotion


@dataclass(frozen=True)
class StaticExpansion:
    """All coordinates of the frames by z, and by the loads, at m instants (static condensation).

    Parameters
    ----------
    matrix : ndarray, shape (m, size, n) or (1, n, n)
        From z to the coordinates of the frames; one unit matrix where none is condensed.
    offset : ndarray, shape (m, size)
        What the loads alone add to the condensed ones.
    """

    matrix: FloatArray
    offset: FloatArray

    @classmethod
    def of_all(cls, size: int) -> Self:
        """Expansion of ``size`` coordinates of which none is condensed."""
        return cls(np.eye(size)[None], np.zeros((1, size)))

    def under(
        self, force: FloatArray, flexibility: FloatArray, eliminated: NDArray[np.bool_]
    ) -> tuple[FloatArray, FloatArray]:
        """What forces on all coordinates add to the condensed ones, and those forces on z.

        Parameters
        ----------
        force : ndarray, shape (m, size)
        flexibility : ndarray, shape (m, i, i)
            Of the condensed coordinates.
        eliminated : ndarray of bool, shape (size,)
            Coordinates that are condensed.

        Returns
        -------
        ndarray, shape (m, size)
            To add to ``offset``.
        ndarray, shape (m, n)
        """
        offset = np.zeros_like(force)
        offset[:, eliminated] = (flexibility @ force[:, eliminated, None])[..., 0]
        return offset, (force[:, None] @ self.matrix)[:, 0]

    def expanded(self, vibration: VibrationState) -> tuple[FloatArray, FloatArray, FloatArray]:
        """All coordinates of the frames and their time derivatives, each (m, size).

        Parameters
        ----------
        vibration : VibrationState
            Arrays of shape (m, n).

        Returns
        -------
        tuple of ndarray
        """
        parts = (vibration.position, vibration.velocity, vibration.acceleration)
        if self.matrix.shape[1] == self.matrix.shape[2]:
            return parts
        position, velocity, acceleration = (
            (self.matrix @ part[..., None])[..., 0] for part in parts
        )
        return position + self.offset, velocity, acceleration


@dataclass(frozen=True)
class Equations(EquationsOfMotion):
    """Equations of motion of a linkage at m instants.

    Parameters
    ----------
    mass, damping, stiffness : ndarray, shape (m, n, n)
    force : ndarray, shape (m, n)
    motion : RigidMotion
        Batch of shape (m,).
    expansion : StaticExpansion
        To the condensed coordinates of the frames.
    flexibility : ndarray, shape (m, i, i)
        Of the condensed coordinates.
    """

    motion: RigidMotion
    expansion: StaticExpansion
    flexibility: FloatArray

    @classmethod
    def condensed(
        cls,
        motion: RigidMotion,
        matrices: SystemMatrices,
        force: FloatArray,
        eliminated: NDArray[np.bool_],
    ) -> Self:
        """Equations after static condensation of some coordinates (Guyan, 1965).

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (m,).
        matrices : SystemMatrices
            Of all coordinates of the frames.
        force : ndarray, shape (m, size)
        eliminated : ndarray of bool, shape (size,)
            Coordinates that are condensed.

        Returns
        -------
        Equations
        """
        inner = np.flatnonzero(eliminated)
        flexibility = np.asarray(
            np.linalg.inv(matrices.stiffness[:, inner[:, None], inner]), dtype=float
        )
        expansion = StaticExpansion.of_all(len(eliminated))
        if len(inner):
            matrices, matrix = condense(matrices, eliminated)
            expansion = StaticExpansion(matrix, np.zeros_like(force))
            offset, force = expansion.under(force, flexibility, eliminated)
            expansion = StaticExpansion(matrix, offset)
        parts = matrices.mass, matrices.damping, matrices.stiffness, force
        return cls(*parts, motion, expansion, flexibility)
