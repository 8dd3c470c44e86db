"""What turns the crank: motor and speed control, gear, rotor, and the coupling to the crank."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linkages.motors.motor import Motor
from flexmech.linkages.motors.motor_drive import SpeedControl

# Of the speed and of a command, over which the answer is differentiated.
_DIFFERENCE = 1e-6


@dataclass(frozen=True)
class MotorOutput:
    """What a motor gives at some instants.

    Parameters
    ----------
    torque : ndarray, shape (...)
        On its own shaft in N m.
    rates : ndarray, shape (k, ...)
        Of its states: of the current in A/s if that is one, of the control's integral.
    current, voltage : ndarray, shape (...)
        Of a DC motor in A and V; not numbers of a torque curve.
    """

    torque: FloatArray
    rates: FloatArray
    current: FloatArray
    voltage: FloatArray


@dataclass(frozen=True)
class DriveTrain:
    """Motor, gear and coupling: their states, and the torque on the crank.

    A rotor on a coupling has two states, its angle and its speed over the gear ratio; those of the
    motor follow. A rotor without a coupling turns with the crank.

    Parameters
    ----------
    motor : Motor
    control : SpeedControl, optional
    """

    motor: Motor
    control: SpeedControl | None = None

    @property
    def is_coupled(self) -> bool:
        """Whether the rotor turns against the crank."""
        return self.motor.coupling_stiffness is not None

    @property
    def state_count(self) -> int:
        """Number of states."""
        return self.motor_place + int(self.motor.has_current) + int(self.has_integral)

    @property
    def motor_place(self) -> int:
        """Place of the first state of the motor: after those of a rotor on a coupling."""
        return 2 * self.is_coupled

    @property
    def has_integral(self) -> bool:
        """Whether the last state is the integral of speed control."""
        return self.control is not None and self.control.has_integral

    @property
    def angles(self) -> list[int]:
        """Which values of a shaft are angles: the crank's, and that of a rotor on a coupling."""
        return [0, 2] if self.is_coupled else [0]

    @property
    def without_coupling(self) -> DriveTrain:
        """Motor and gear alone, which turn the rotor."""
        if not self.is_coupled:
            return self
        motor = replace(self.motor, coupling_stiffness=None, coupling_damping=0.0)
        return replace(self, motor=motor)

    @property
    def rigid_inertia(self) -> float:
        """Of what turns rigidly with the crank in kg m^2."""
        return 0.0 if self.is_coupled else self.motor.inertia_at_crank

    @property
    def standing_torque(self) -> float:
        """On the crank in N m, at rest once the current has settled."""
        still = np.zeros(self.state_count)
        return self.motor.gear_ratio * float(self._steady_torque(np.zeros(()), still))

    @property
    def way(self) -> float:
        """To which side the motor turns from rest: 1, -1, or 0 of none."""
        return float(np.sign(self.standing_torque))

    def start(self, angle: float, needed: float) -> FloatArray:
        """States (state_count,) at rest at a crank angle in rad, where the crank needs a torque.

        As a brake leaves them that is released once coupling and current hold the crank; a
        current that would have to turn the other way is zero, and one that the motor states is
        that one.
        """
        motor, states = self.motor, np.zeros(self.state_count)
        if motor.coupling_stiffness is not None:
            states[0] = angle + needed / motor.coupling_stiffness
        if motor.has_current:
            states[self.motor_place] = motor.first_current(self.held_by_current(needed))
        return states

    def held_by_current(self, needed: float) -> float:
        """Torque in N m on the motor's shaft that holds the crank where it needs one at rest.

        Zero where the crank would have to be held against the way that the motor turns.
        """
        return max(needed * self.way, 0.0) * self.way / self.motor.gear_ratio

    def rotor_speed(self, speed: FloatArray, states: FloatArray) -> FloatArray:
        """Speed of the rotor over the gear ratio in rad/s, (...)."""
        return states[1] if self.is_coupled else speed

    def motor_output(self, speed: FloatArray, states: FloatArray) -> MotorOutput:
        """What the motor gives at crank speeds (...) in rad/s and states (state_count, ...)."""
        turning = np.asarray(self.rotor_speed(speed, states), dtype=float)
        rotor = self.motor.gear_ratio * turning
        command, following = self._command(turning, states)
        current = states[self.motor_place] if self.motor.has_current else None
        torque, change, current, voltage = self.motor.driven(rotor, current, command)
        rates = [rate for rate in (change, following) if rate is not None]
        moved = np.stack(rates) if rates else np.zeros((0, *rotor.shape))
        return MotorOutput(torque, moved, current, voltage)

    def on_crank(
        self, angle: FloatArray, speed: FloatArray, states: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Torque on the crank, and the rates of the states.

        Parameters
        ----------
        angle, speed : ndarray, shape (...)
            Of the crank in rad and rad/s.
        states : ndarray, shape (state_count, ...)

        Returns
        -------
        torque : ndarray, shape (...)
            In N m.
        rates : ndarray, shape (state_count, ...)
        """
        given, motor = self.motor_output(speed, states), self.motor
        torque = np.asarray(motor.gear_ratio * given.torque)
        if motor.coupling_stiffness is None:
            return torque, given.rates
        rotor, turning = states[:2]
        carried = motor.coupling_torque(rotor - angle, turning - speed)
        accelerated = (torque - carried) / motor.inertia_at_crank
        return carried, np.concatenate([np.stack([turning, accelerated]), given.rates])

    def answer(self, speed: FloatArray, states: FloatArray) -> tuple[FloatArray, FloatArray]:
        """How the torque of a motor falls with its speed and angle, once a current has settled.

        At the crank, without a coupling.

        Parameters
        ----------
        speed : ndarray, shape (m,)
            Of the rotor over the gear ratio in rad/s.
        states : ndarray, shape (state_count, m)

        Returns
        -------
        damping, stiffness : ndarray, shape (m,)
            In N m s/rad and N m/rad.
        """
        ratio, steady = self.motor.gear_ratio, self._steady_torque
        step = _DIFFERENCE * max(float(np.abs(speed).max()), 1.0)
        faster, slower = (steady(speed + change, states) for change in (step, -step))
        damping = ratio * (slower - faster) / (2 * step)
        if self.control is None or not self.has_integral:
            return damping, np.zeros_like(damping)
        moved = states.copy()
        step = _DIFFERENCE * max(float(np.abs(states[-1]).max()), 1.0)
        moved[-1] += step
        change = (steady(speed, moved) - steady(speed, states)) / step
        return damping, ratio * self.control.ki * change

    def _steady_torque(self, speed: FloatArray, states: FloatArray) -> FloatArray:
        """On the motor's shaft in N m at rotor speeds (...), once its current has settled."""
        command = self._command(speed, states)[0]
        return self.motor.driven(self.motor.gear_ratio * speed, None, command)[0]

    def _command(
        self, speed: FloatArray, states: FloatArray
    ) -> tuple[FloatArray | None, FloatArray | None]:
        """Command of the control within the motor's limits, and the rate of its integral."""
        control = self.control
        if control is None:
            return None, None
        error = control.target - speed
        wanted = control.kp * error + (states[-1] if self.has_integral else 0.0)
        most = self.motor.limit(self.motor.gear_ratio * speed)
        command = np.clip(wanted, -most, most)
        if not self.has_integral:
            return command, None
        return command, control.ki * (error + (command - wanted) / control.kp)
