"""Torque on a free shaft that answers to its motion: known along one motion, linear beside it.

A motor's torque depends on the speed of its shaft, and on the past where it has a current or a
controller. Along a known motion of the shaft it is a history; beside that it changes by
``-damping * rate - stiffness * rotation``, of the coordinate by which the shaft turns. Runs are
repeated, each with the torque along the motion of the one before (Newton's method on the whole
motion), until nothing changes: what was left out of the change does not matter then.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from flexmech.arrays import FloatArray


@dataclass(frozen=True)
class ShaftTorque:
    """Torque of a motor on the crank's shaft along a motion, and how it changes beside it.

    Parameters
    ----------
    time : ndarray, shape (m,)
        Increasing, in s.
    torque : ndarray, shape (m,)
        Along the motion, in N m.
    damping, stiffness : ndarray, shape (m,)
        In N m s/rad and N m/rad.
    across, turning : ndarray, shape (m,)
        Coordinate by which the shaft turns, and its rate, in that motion.
    recorded : list
        Of :meth:`record`, which fills it.
    """

    time: FloatArray
    torque: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    across: FloatArray
    turning: FloatArray
    recorded: list[tuple[FloatArray, ...]] = field(default_factory=list, compare=False)

    def at(self, time: FloatArray) -> tuple[FloatArray, ...]:
        """Torque, damping, stiffness, and the coordinate with its rate, at times (m,) in s."""
        known = (self.torque, self.damping, self.stiffness, self.across, self.turning)
        return tuple(np.interp(time, self.time, own) for own in known)

    def pull(self, time: FloatArray) -> FloatArray:
        """What damping and stiffness take off too much at the known motion, (m,) in N m."""
        _, damping, stiffness, across, turning = self.at(time)
        return np.asarray(damping * turning + stiffness * across)

    def beside(self, time: FloatArray, across: FloatArray, turning: FloatArray) -> FloatArray:
        """The torque (m,) where the coordinate and its rate have some values.

        Parameters
        ----------
        time : ndarray, shape (m,)
            In s.
        across, turning : ndarray, shape (m,)
        """
        torque, damping, stiffness, *known = self.at(time)
        return np.asarray(torque - damping * (turning - known[1]) - stiffness * (across - known[0]))

    def record(self, *histories: FloatArray) -> None:
        """Keep the time, the coordinate and its rate, rotation and its rate, of more steps."""
        self.recorded.append(histories)

    @property
    def history(self) -> tuple[FloatArray, ...]:
        """What was recorded, each (m,), once at every instant."""
        parts = [np.concatenate(own) for own in zip(*self.recorded, strict=True)]
        time, first = np.unique(parts[0], return_index=True)
        return (time, *(own[first] for own in parts[1:]))
