"""Torque of a motor that answers to its motion: known along one motion, linear beside it.

A motor's torque depends on the speed of its shaft, and on the past where it has a current or a
controller. Along a known motion of what it turns, the crank's shaft or a rotor on a coupling to
that, it is a history; beside that it changes by ``-damping * rate - stiffness * rotation``, of the
coordinate by which that turns. Runs are repeated, each with the torque along the motion of the one
before (Newton's method on the whole motion), until nothing changes: what was left out of the
change does not matter then.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linkages import Motor


@dataclass(frozen=True)
class RotorCoupling:
    """A coupling to the crank's shaft along a known motion.

    Parameters
    ----------
    motor : Motor
        Whose coupling it is.
    start : tuple of float
        Twist at time zero in rad, and its rate in rad/s.
    torque : ndarray, shape (m,)
        On the crank at the times of the known motion, in N m.
    lag : ndarray, shape (m,)
        What the coupling's torque by the coordinate of the shaft has less than by its rotation.
    """

    motor: Motor
    start: tuple[float, float]
    torque: FloatArray
    lag: FloatArray

    @property
    def stiffness(self) -> float:
        """Of the coupling in N m/rad."""
        assert self.motor.coupling_stiffness is not None
        return self.motor.coupling_stiffness


@dataclass(frozen=True)
class ShaftTorque:
    """Torque of a motor at the crank along a motion, and how it changes beside it.

    Parameters
    ----------
    time : ndarray, shape (m,)
        Increasing, in s.
    torque : ndarray, shape (m,)
        Along the motion, in N m.
    damping, stiffness : ndarray, shape (m,)
        In N m s/rad and N m/rad.
    across, turning : ndarray, shape (m,)
        Coordinate by which the shaft, or the rotor, turns in that motion, and its rate.
    coupling : RotorCoupling, optional
        Between rotor and shaft.
    recorded : list
        Of :meth:`record`, which fills it.
    """

    time: FloatArray
    torque: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    across: FloatArray
    turning: FloatArray
    coupling: RotorCoupling | None = None
    recorded: list[tuple[FloatArray, ...]] = field(default_factory=list, compare=False)

    def at(self, time: FloatArray) -> tuple[FloatArray, ...]:
        """Torque, damping, stiffness, and the coordinate with its rate, at times (m,) in s."""
        known = (self.torque, self.damping, self.stiffness, self.across, self.turning)
        return tuple(np.interp(time, self.time, own) for own in known)

    def pull(self, time: FloatArray) -> FloatArray:
        """What damping and stiffness take off too much at the known motion, (m,) in N m."""
        _, damping, stiffness, across, turning = self.at(time)
        return np.asarray(damping * turning + stiffness * across)

    def on_shaft(self, time: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Torque on the shaft along the motion, and where its coordinates are zero, (m,) in N m."""
        if self.coupling is None:
            torque = np.interp(time, self.time, self.torque)
            return torque, torque + self.pull(time)
        known = self.coupling.torque, self.coupling.lag
        torque, lag = (np.interp(time, self.time, own) for own in known)
        return torque, lag

    def answer_of_shaft(self, time: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Damping and stiffness of the torque on the shaft, (m,)."""
        if self.coupling is None:
            _, damping, stiffness, *_ = self.at(time)
            return damping, stiffness
        even = np.ones_like(time)
        return self.coupling.motor.coupling_damping * even, self.coupling.stiffness * even

    def beside(self, time: FloatArray, across: FloatArray, turning: FloatArray) -> FloatArray:
        """The torque of the motor (m,) where the coordinate and its rate have some values.

        Parameters
        ----------
        time : ndarray, shape (m,)
            In s.
        across, turning : ndarray, shape (m,)
        """
        torque, damping, stiffness, *known = self.at(time)
        return np.asarray(torque - damping * (turning - known[1]) - stiffness * (across - known[0]))

    def record(self, *histories: FloatArray) -> None:
        """Keep more steps: see :attr:`history`."""
        self.recorded.append(histories)

    @property
    def history(self) -> tuple[FloatArray, ...]:
        """What was recorded, each (m,), once at every instant.

        The time; the shaft's coordinate and its rate; its rotation and the rate of that; and of a
        rotor on a coupling its coordinate and rate.
        """
        parts = [np.concatenate(own) for own in zip(*self.recorded, strict=True)]
        time, first = np.unique(parts[0], return_index=True)
        return (time, *(own[first] for own in parts[1:]))
