"""Torque of a motor that answers to its motion: known along one motion, linear beside it.

A motor's torque depends on the speed of its shaft, and on the past where it has a current or a
controller. Along a known motion of what it turns, the crank's shaft or a rotor on a coupling to
that, it is a history; beside that it changes by ``-damping * rate - stiffness * rotation``, of the
coordinate by which that turns. Runs are repeated, each with the torque along the motion of the one
before (Newton's method on the whole motion), until nothing changes: what was left out of the
change does not matter then.

The rotor on a coupling is the last coordinate. It counts from the prescribed angle of the crank,
with which the frames of the links turn.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.dynamical_systems import VibrationState
from flexmech.linear_system import SystemMatrices
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

    def started(self, state: VibrationState) -> VibrationState:
        """A start with the twist that the coupling has at time zero."""
        position, velocity = state.position.copy(), state.velocity.copy()
        position[-1], velocity[-1] = self.start
        return VibrationState(position, velocity, state.acceleration)


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

    def added(
        self, time: FloatArray, matrices: SystemMatrices, shaft: FloatArray
    ) -> SystemMatrices:
        """Matrices with the answer of the motor, and with the rotor on a coupling.

        Parameters
        ----------
        time : ndarray, shape (m,)
            In s.
        matrices : SystemMatrices
            Of all coordinates but the rotor's, (m, n, n).
        shaft : ndarray, shape (n,)
            By these, that by which the shaft turns.

        Returns
        -------
        SystemMatrices
            Arrays of shape (m, n + 1, n + 1) with a coupling.
        """
        more = (0, int(self.coupling is not None))
        parts = (matrices.mass, matrices.damping, matrices.stiffness)
        mass, damped, held = (np.pad(part, ((0, 0), more, more)) for part in parts)
        turned = np.pad(shaft, more)
        if self.coupling is not None:
            motor, rotor = self.coupling.motor, np.eye(len(turned))[-1]
            twist, turned = np.outer(rotor - turned, rotor - turned), rotor
            mass += motor.inertia_at_crank * np.outer(rotor, rotor)
            damped += motor.coupling_damping * twist
            held += self.coupling.stiffness * twist
        _, damping, stiffness, *_ = self.at(time)
        damped += damping[:, None, None] * np.outer(turned, turned)
        held += stiffness[:, None, None] * np.outer(turned, turned)
        return SystemMatrices(mass, damped, held)

    def forces(self, time: FloatArray, force: FloatArray, acceleration: FloatArray) -> FloatArray:
        """Forces (m, n) with that on the rotor on a coupling, (m, n + 1).

        Parameters
        ----------
        time : ndarray, shape (m,)
            In s.
        force : ndarray, shape (m, n)
        acceleration : ndarray, shape (m,)
            Of the prescribed angle of the crank in rad/s^2.
        """
        if self.coupling is None:
            return force
        motor = np.interp(time, self.time, self.torque) + self.pull(time)
        lag = np.interp(time, self.time, self.coupling.lag)
        turned = self.coupling.motor.inertia_at_crank * acceleration
        return np.column_stack([force, motor - lag - turned])

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
