"""Equations of the shaft of a rigid linkage that a motor turns, as a system of first order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages.motors.speed_control import DrivenBy


class ShaftLoad(Protocol):
    """What a rigid linkage asks of its shaft."""

    @property
    def over_time(self) -> bool:
        """Whether a load goes over time, so that no turn is like another."""

    def inertia(self, angle: ArrayLike) -> FloatArray:
        """Inertia reduced to the crank in kg m^2 at crank angles in rad; (...) -> (...)."""

    def needed(self, angle: ArrayLike, speed: ArrayLike, time: ArrayLike) -> FloatArray:
        """Torque without acceleration in N m at crank angles, speeds and times; (...).

        Parameters
        ----------
        angle, speed, time : array_like, shape (...)
            In rad, rad/s and s.
        """

    def parts(
        self, angle: ArrayLike, speed: ArrayLike, time: ArrayLike
    ) -> tuple[FloatArray, FloatArray]:
        """Both at once.

        Parameters
        ----------
        angle, speed, time : array_like, shape (...)
            In rad, rad/s and s.
        """


@dataclass(frozen=True, eq=False)
class ShaftEquation:
    """Crank angle and speed, those of a rotor on a coupling, and the motor's states.

    Parameters
    ----------
    load : ShaftLoad
    shaft_inertia : float
        Of the shaft that drives the crank, in kg m^2.
    motor : DrivenBy
    """

    load: ShaftLoad
    shaft_inertia: float
    motor: DrivenBy

    @property
    def is_coupled(self) -> bool:
        """Whether the rotor turns against the crank."""
        return self.motor.motor.coupling_stiffness is not None

    def start(self, angle: float) -> FloatArray:
        """Values (n,) at rest at a crank angle in rad.

        As a brake leaves them that is released once coupling and current hold the crank; a
        current that would have to turn the other way is zero.
        """
        needed, motor = float(self.load.needed(angle, 0.0, 0.0)), self.motor.motor
        values = [angle, 0.0]
        if motor.coupling_stiffness is not None:
            values += [angle + needed / motor.coupling_stiffness, 0.0]
        state = np.zeros(self.motor.state_count)
        if motor.has_current and needed * self.way > 0:
            state[0] = motor.holding_current(needed / motor.gear_ratio)
        return np.array([*values, *state])

    @property
    def way(self) -> float:
        """To which side the motor turns from rest: 1, -1, or 0 of none."""
        return float(np.sign(self.motor.standing_torque))

    def starts(self, angle: float) -> bool:
        """Whether the motor moves the linkage from rest at a crank angle in rad."""
        given = self.motor.motor.gear_ratio * self.motor.standing_torque
        return bool(self.way * (given - float(self.load.needed(angle, 0.0, 0.0))) > 0)

    def inertia(self, angle: ArrayLike) -> FloatArray:
        """Of all that turns rigidly with the crank in kg m^2 at crank angles in rad; (...)."""
        return self.load.inertia(angle) + self._rigid_inertia

    def check_inertia(self) -> None:
        """Refuse a shaft without any inertia.

        Raises
        ------
        InputError
        """
        around = np.radians(np.arange(0.0, 360.0, 5.0))
        if not float(self.inertia(around).min()) > 0:
            raise InputError(
                "drive: neither the linkage nor its shaft nor the motor has any inertia, so that "
                "the motor would start at once; state [shaft] inertia or that of the motor"
            )

    def rates(self, time: ArrayLike, values: FloatArray) -> FloatArray:
        """Time derivatives of the values, (n, ...) at times (...)."""
        angle, speed = values[:2]
        motor, gear = self.motor.motor, self.motor.motor.gear_ratio
        own, needed = self.load.parts(angle, speed, time)
        inertia = own + self._rigid_inertia
        if not self.is_coupled:
            given = self.motor.output(speed, values[2:])
            acceleration = (gear * given.torque - needed) / inertia
            return np.concatenate([np.stack([speed, acceleration]), given.rates])
        rotor, rotor_speed = values[2:4]
        given = self.motor.output(rotor_speed, values[4:])
        carried = self.coupling_torque(rotor - angle, rotor_speed - speed)
        turning = (gear * given.torque - carried) / motor.inertia_at_crank
        moved = np.stack([speed, (carried - needed) / inertia, rotor_speed, turning])
        return np.concatenate([moved, given.rates])

    def crank_torque(self, values: FloatArray) -> FloatArray:
        """Torque on the crank in N m, (...), of values (n, ...)."""
        if self.is_coupled:
            return self.coupling_torque(values[2] - values[0], values[3] - values[1])
        given = self.motor.output(values[1], values[2:])
        return np.asarray(self.motor.motor.gear_ratio * given.torque)

    def coupling_torque(self, twist: FloatArray, rate: FloatArray) -> FloatArray:
        """Torque of the coupling on the crank in N m, (...), by its twist in rad and its rate."""
        motor = self.motor.motor
        assert motor.coupling_stiffness is not None
        return np.asarray(motor.coupling_stiffness * twist + motor.coupling_damping * rate)

    def tolerances(self, relative: float) -> FloatArray:
        """Absolute tolerances (n,) of an integration with a relative one."""
        # In rad and rad/s; current and command are of order one or greater where they matter.
        count = 2 + 2 * self.is_coupled + self.motor.state_count
        return np.full(count, 0.1 * relative)

    @property
    def _rigid_inertia(self) -> float:
        """Of all that turns with the crank besides the linkage."""
        return self.shaft_inertia + (0.0 if self.is_coupled else self.motor.motor.inertia_at_crank)
