"""A drive by a motor: which motor turns the crank, by which speed control, from where, how long.

Speed control is a PI rule on the rotor's speed over the gear ratio, whose integral follows a
saturated command (back-calculation; Astrom & Hagglund, *Advanced PID Control*, 2006, sect. 3.5).
"""

from __future__ import annotations

from dataclasses import dataclass, field

from flexmech.errors import InputError
from flexmech.linkages.motors.motor import Motor
from flexmech.model_text import TomlTable, quantity
from flexmech.units import ANGLE, ANGULAR_SPEED, TIME, from_si, to_si
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
        check_instance(self.motor, Motor, "motor", "give a TorqueMotor or a DcMotor")
        if self.control is not None:
            remedy = "give a SpeedControl(kp, ki, target)"
            check_instance(self.control, SpeedControl, "control", remedy)
        check_number(self.start_angle, "start_angle", "rad")
        if self.time is not None:
            check_number(self.time, "time", "s", POSITIVE)

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
