"""Linear equations of motion at some instants, and what follows from their coordinates."""

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
class Following:
    """How all coordinates of the frames follow from z at m instants.

    Parameters
    ----------
    expansion : ndarray, shape (m, size, n) or (1, n, n)
        From z to the coordinates of the frames; one unit matrix where none follows.
    offset : ndarray, shape (m, size)
        What the loads alone add to those that follow.
    """

    expansion: FloatArray
    offset: FloatArray

    @classmethod
    def of_all(cls, size: int) -> Self:
        """None of ``size`` coordinates follows another."""
        return cls(np.eye(size)[None], np.zeros((1, size)))

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
        if self.expansion.shape[1] == self.expansion.shape[2]:
            return parts
        position, velocity, acceleration = (
            (self.expansion @ part[..., None])[..., 0] for part in parts
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
    following : Following
        Coordinates of the frames that follow statically.
    """

    motion: RigidMotion
    following: Following

    @classmethod
    def condensed(
        cls,
        motion: RigidMotion,
        matrices: SystemMatrices,
        force: FloatArray,
        follows: NDArray[np.bool_],
    ) -> Self:
        """Equations of those coordinates that do not follow the others statically.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (m,).
        matrices : SystemMatrices
            Of all coordinates of the frames.
        force : ndarray, shape (m, size)
        follows : ndarray of bool, shape (size,)

        Returns
        -------
        Equations
        """
        gone, kept = np.flatnonzero(follows), np.flatnonzero(~follows)
        following = Following.of_all(len(follows))
        if len(gone):
            offset = np.zeros_like(force)
            hold = matrices.stiffness[:, gone[:, None], gone]
            offset[:, gone] = np.linalg.solve(hold, force[:, gone, None])[..., 0]
            matrices, expansion = condense(matrices, follows)
            force = force[:, kept] + np.einsum(
                "mgk,mg->mk", expansion[:, gone[:, None], np.arange(len(kept))], force[:, gone]
            )
            following = Following(expansion, offset)
        parts = matrices.mass, matrices.damping, matrices.stiffness, force
        return cls(*parts, motion, following)
