"""Linear equations of motion at some instants, and what follows from their coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from flexmech.linkages import RigidMotion
from flexmech.time_domain.state import VibrationState
from flexmech.types import FloatArray

__all__ = ["Equations", "Following"]


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
class Equations:
    """Equations of motion ``M z'' + C z' + K z = f`` at m instants.

    Parameters
    ----------
    motion : RigidMotion
        Batch of shape (m,).
    mass, damping, stiffness : ndarray, shape (m, n, n)
    force : ndarray, shape (m, n)
    following : Following
        Coordinates of the frames that follow statically.
    """

    motion: RigidMotion
    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    force: FloatArray
    following: Following

    def quasi_static(self) -> FloatArray:
        """Displacement z that the loads would cause if nothing moved, (m, n)."""
        return np.asarray(np.linalg.solve(self.stiffness, self.force[..., None])[..., 0])
