"""What turns the crank: motor and speed control, gear, rotor, and the coupling to the crank."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linkages.motors.speed_control import DrivenBy, MotorOutput

# Of the speed and of a command, over which the answer is differentiated.
_DIFFERENCE = 1e-6


@dataclass(frozen=True)
class DriveTrain:
    """Motor, gear and coupling: their states, and the torque on the crank.

    A rotor on a coupling has two states, its angle and its speed over the gear ratio; those of the
    motor follow. A rotor without a coupling turns with the crank.

    Parameters
    ----------
    driven_by : DrivenBy
        The motor with its control.
    """

    driven_by: DrivenBy

    @property
    def is_coupled(self) -> bool:
        """Whether the rotor turns against the crank."""
        return self.driven_by.motor.coupling_stiffness is not None

    @property
    def state_count(self) -> int:
        """Number of states."""
        return self._own + self.driven_by.state_count

    @property
    def angles(self) -> list[int]:
        """Which values of a shaft are angles: the crank's, and that of a rotor on a coupling."""
        return [0, 2] if self.is_coupled else [0]

    @property
    def without_coupling(self) -> DriveTrain:
        """Motor and gear alone, which turn the rotor."""
        if not self.is_coupled:
            return self
        motor = replace(self.driven_by.motor, coupling_stiffness=None, coupling_damping=0.0)
        return DriveTrain(replace(self.driven_by, motor=motor))

    @property
    def rigid_inertia(self) -> float:
        """Of what turns rigidly with the crank in kg m^2."""
        return 0.0 if self.is_coupled else self.driven_by.motor.inertia_at_crank

    @property
    def standing_torque(self) -> float:
        """On the crank in N m, at rest once the current has settled."""
        return self.driven_by.motor.gear_ratio * self.driven_by.standing_torque

    @property
    def way(self) -> float:
        """To which side the motor turns from rest: 1, -1, or 0 of none."""
        return float(np.sign(self.driven_by.standing_torque))

    def start(self, angle: float, needed: float) -> FloatArray:
        """States (state_count,) at rest at a crank angle in rad, where the crank needs a torque.

        As a brake leaves them that is released once coupling and current hold the crank; a
        current that would have to turn the other way is zero, and one that the motor states is
        that one.
        """
        motor, states = self.driven_by.motor, np.zeros(self.state_count)
        if motor.coupling_stiffness is not None:
            states[0] = angle + needed / motor.coupling_stiffness
        if motor.has_current:
            states[self._own] = motor.first_current(self.held_by_current(needed))
        return states

    def held_by_current(self, needed: float) -> float:
        """Torque in N m on the motor's shaft that holds the crank where it needs one at rest.

        Zero where the crank would have to be held against the way that the motor turns.
        """
        return max(needed * self.way, 0.0) * self.way / self.driven_by.motor.gear_ratio

    def motor_states(self, states: FloatArray) -> FloatArray:
        """Those of the motor alone, (motor's count, ...), of all states (state_count, ...)."""
        return np.asarray(states[self._own :])

    def rotor_speed(self, speed: FloatArray, states: FloatArray) -> FloatArray:
        """Speed of the rotor over the gear ratio in rad/s, (...)."""
        return states[1] if self.is_coupled else speed

    def motor_output(self, speed: FloatArray, states: FloatArray) -> MotorOutput:
        """What the motor gives at crank speeds (...) in rad/s and states (state_count, ...)."""
        turning = self.rotor_speed(speed, states)
        return self.driven_by.output(turning, self.motor_states(states))

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
        given, motor = self.motor_output(speed, states), self.driven_by.motor
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
        motor, control = self.driven_by.motor, self.driven_by.control
        step = _DIFFERENCE * max(float(np.abs(speed).max()), 1.0)
        steady = self.driven_by.steady_torque
        faster, slower = (steady(speed + change, states) for change in (step, -step))
        damping = motor.gear_ratio * (slower - faster) / (2 * step)
        if control is None or not control.has_integral:
            return damping, np.zeros_like(damping)
        moved = states.copy()
        step = _DIFFERENCE * max(float(np.abs(states[-1]).max()), 1.0)
        moved[-1] += step
        change = (steady(speed, moved) - steady(speed, states)) / step
        return damping, motor.gear_ratio * control.ki * change

    @property
    def _own(self) -> int:
        """States of the rotor."""
        return 2 * self.is_coupled
