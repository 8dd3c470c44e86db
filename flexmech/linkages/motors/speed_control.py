"""Speed control of a motor, and what motor and control make of a speed together.

Speed control is a PI rule on the rotor's speed over the gear ratio, whose integral follows a
saturated command (back-calculation; Astrom & Hagglund, *Advanced PID Control*, 2006, sect. 3.5).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages.motors.motor import Motor
from flexmech.units import ANGULAR_SPEED, to_si
from flexmech.validation import NOT_NEGATIVE, POSITIVE, check_instance, check_number


@dataclass(frozen=True)
class SpeedControl:
    """PI control of the crank's speed by the rotor's: of a DC motor's voltage, or of a torque.

    Its command is ``kp (target - speed)`` and the integral of ``ki (target - speed)``, as far as
    the motor can follow: up to its voltage either way, or its torque curve either way.

    Parameters
    ----------
    kp, ki : float
        In V s/rad and V/rad of a DC motor; in N m s/rad and N m/rad on the motor's shaft of a
        torque curve.
    target : float
        Crank speed in rad/s; negative turns backwards.
    speed_unit : str
        Unit in which the target was written, and results speak of it.

    Raises
    ------
    InputError
        If kp is not positive, ki is negative, the target is no speed, or the unit is none of one.

    Examples
    --------
    >>> flexmech.SpeedControl(kp=0.5, ki=0.0, target=20.0).has_integral
    False
    """

    kp: float
    ki: float
    target: float
    speed_unit: str = field(default=ANGULAR_SPEED.unit, compare=False)

    def __post_init__(self) -> None:
        check_number(self.kp, "kp", "", POSITIVE)
        check_number(self.ki, "ki", "", NOT_NEGATIVE)
        check_number(self.target, "target", "rad/s")
        try:
            to_si(1.0, self.speed_unit, ANGULAR_SPEED)
        except InputError as error:
            raise error.within("speed_unit") from error

    @property
    def has_integral(self) -> bool:
        """Whether the integral of the error counts."""
        return self.ki > 0


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
class DrivenBy:
    """A motor with its speed control, if any: its states and what they make of a speed.

    Parameters
    ----------
    motor : Motor
    control : SpeedControl, optional
    """

    motor: Motor
    control: SpeedControl | None = None

    def __post_init__(self) -> None:
        check_instance(self.motor, Motor, "motor", "give a TorqueMotor or a DcMotor")
        if self.control is not None:
            remedy = "give a SpeedControl(kp, ki, target)"
            check_instance(self.control, SpeedControl, "control", remedy)

    @property
    def state_count(self) -> int:
        """Number of states: the current, and the integral of the control."""
        return int(self.motor.has_current) + int(self._has_integral)

    @property
    def standing_torque(self) -> float:
        """On the motor's shaft in N m, at rest once its current has settled."""
        return float(self.steady_torque(np.zeros(()), np.zeros(self.state_count)))

    def steady_torque(self, speed: FloatArray, state: FloatArray) -> FloatArray:
        """On the motor's shaft in N m at crank speeds (...), once its current has settled."""
        rotor = self.motor.gear_ratio * speed
        command = self._command(speed, rotor, state[-1] if self._has_integral else None)[0]
        return self.motor.driven(rotor, None, command)[0]

    def output(self, speed: ArrayLike, state: FloatArray) -> MotorOutput:
        """What the motor gives.

        Parameters
        ----------
        speed : array_like, shape (...)
            Of the rotor over the gear ratio, in rad/s.
        state : ndarray, shape (state_count, ...)

        Returns
        -------
        MotorOutput
        """
        at_crank = np.asarray(speed, dtype=float)
        rotor, rates = self.motor.gear_ratio * at_crank, []
        integral = state[-1] if self._has_integral else None
        command, following = self._command(at_crank, rotor, integral)
        current = state[0] if self.motor.has_current else None
        torque, change, current, voltage = self.motor.driven(rotor, current, command)
        rates += [] if change is None else [change]
        rates += [] if following is None else [following]
        moved = np.stack(rates) if rates else np.zeros((0, *rotor.shape))
        return MotorOutput(torque, moved, current, voltage)

    @property
    def _has_integral(self) -> bool:
        return self.control is not None and self.control.has_integral

    def _command(
        self, speed: FloatArray, rotor: FloatArray, integral: FloatArray | None
    ) -> tuple[FloatArray | None, FloatArray | None]:
        """Command of the control within the motor's limits, and the rate of its integral."""
        control = self.control
        if control is None:
            return None, None
        error = control.target - speed
        wanted = control.kp * error + (0.0 if integral is None else integral)
        most = self.motor.limit(rotor)
        command = np.clip(wanted, -most, most)
        if integral is None:
            return command, None
        return command, control.ki * (error + (command - wanted) / control.kp)
