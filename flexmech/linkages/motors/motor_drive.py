"""A drive by a motor: which motor turns the crank, from where, and how long."""

from __future__ import annotations

from dataclasses import dataclass

from flexmech.linkages.motors.motor import Motor
from flexmech.linkages.motors.speed_control import DrivenBy, SpeedControl
from flexmech.model_text import TomlTable, quantity
from flexmech.units import ANGLE, ANGULAR_SPEED, TIME, from_si
from flexmech.validation import POSITIVE, check_number


@dataclass(frozen=True)
class MotorDrive:
    """A motor that turns the crank from rest.

    How the crank turns follows from the linkage: :func:`flexmech.motor_run` finds it.

    Parameters
    ----------
    motor : TorqueMotor or DcMotor
    control : SpeedControl, optional
    start_angle : float
        Crank angle at time zero in rad.
    time : float, optional
        How long the run lasts in s; left out, a run in time lasts for the turns that are asked
        for, and that of the rigid linkage until its speed repeats itself from turn to turn.

    Raises
    ------
    InputError
        If one is no such thing.

    Examples
    --------
    >>> drive = flexmech.MotorDrive(flexmech.TorqueMotor((0.0,), (0.1,)), time=3.0)
    >>> drive.words
    'motor of up to 0.1 N m'
    """

    motor: Motor
    control: SpeedControl | None = None
    start_angle: float = 0.0
    time: float | None = None

    def __post_init__(self) -> None:
        # Refuses what is none.
        _ = self.driven_by
        check_number(self.start_angle, "start_angle", "rad")
        if self.time is not None:
            check_number(self.time, "time", "s", POSITIVE)

    @property
    def driven_by(self) -> DrivenBy:
        """The motor with its control."""
        return DrivenBy(self.motor, self.control)

    @property
    def is_constant(self) -> bool:
        """No: it begins at rest."""
        return False

    @property
    def words(self) -> str:
        """Motor and control, for titles."""
        if self.control is None:
            return self.motor.words
        unit = self.control.speed_unit
        target = f"{from_si(self.control.target, unit):.6g} {unit}"
        return f"{self.motor.words}, speed control to {target}"

    @property
    def speed_unit(self) -> str:
        """Unit in which results speak of crank speeds: that of the target, else rad/s."""
        return ANGULAR_SPEED.unit if self.control is None else self.control.speed_unit

    def to_table(self) -> TomlTable:
        """Table ``[drive]`` of a model file."""
        table: TomlTable = {"motor": self.motor.to_table()}
        if self.control is not None:
            gain, integral = self.motor.gain_dimensions
            table["speed_control"] = {
                "kp": quantity(self.control.kp, gain),
                "ki": quantity(self.control.ki, integral),
                "target": quantity(
                    self.control.target, ANGULAR_SPEED, self.speed_unit, always=True
                ),
            }
        if self.time is not None:
            table["time"] = quantity(self.time, TIME)
        if self.start_angle:
            table["start_angle"] = quantity(self.start_angle, ANGLE)
        return table
