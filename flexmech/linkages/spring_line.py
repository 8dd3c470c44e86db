"""A spring between two points: its direction, its length and the force that it carries."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexmech.errors import InputError
from flexmech.linkages.attachments import Spring
from flexmech.types import FloatArray

# In units of the linkage's size: the ends of a spring that are nearer have met.
MET = 1e-9


@dataclass(frozen=True)
class SpringLine:
    """A spring at its length.

    Parameters
    ----------
    along : ndarray, shape (..., 2)
        Unit vector from the first end to the second, in ground axes.
    length : ndarray, shape (...)
        In m.
    relative_velocity : ndarray, shape (..., 2)
        Velocity of the second end against the first in m/s.
    tension : ndarray, shape (...)
        In N.
    """

    along: FloatArray
    length: FloatArray
    relative_velocity: FloatArray
    tension: FloatArray

    @property
    def rate(self) -> FloatArray:
        """Rate of the length in m/s, (...)."""
        return np.asarray(np.sum(self.along * self.relative_velocity, axis=-1))

    @classmethod
    def of(
        cls,
        spring: Spring,
        crank_angle: FloatArray,
        places: Sequence[FloatArray],
        velocities: Sequence[FloatArray],
        size: float,
        *,
        needs_direction: bool = True,
    ) -> SpringLine:
        """Line of a spring whose ends are known.

        Parameters
        ----------
        spring : Spring
        crank_angle : ndarray, shape (...)
            In rad, for messages.
        places, velocities : sequence of ndarray, shape (..., 2)
            Of its first and its second end, in ground axes.
        size : float
            Of the linkage in m.
        needs_direction : bool
            Whether ends that meet are refused. The force alone of a spring without free
            length and damping is nothing there.

        Returns
        -------
        SpringLine

        Raises
        ------
        InputError
            Where the ends meet; names the crank angle.
        """
        line, relative_velocity = places[1] - places[0], velocities[1] - velocities[0]
        length = np.linalg.norm(line, axis=-1)
        met = length <= MET * size
        if needs_direction and np.any(met):
            angle = np.degrees(crank_angle[met].flat[0])
            raise InputError(
                f"spring {spring.name}: its ends meet at crank angle {angle:.6g} deg, where its "
                "force has no direction; move an end, or leave that crank angle out"
            )
        along = line / np.where(met, 1.0, length)[..., None]
        tension = spring.stiffness * (length - spring.free_length)
        tension = tension + spring.damping * np.sum(along * relative_velocity, axis=-1)
        return cls(along, length, relative_velocity, tension)
