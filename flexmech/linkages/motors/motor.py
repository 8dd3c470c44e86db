"""Motors that turn the crank: torque curves and DC motors, speed control, gear, rotor, coupling.

All quantities of the motor are on its own shaft; ``gear_ratio`` is how often that turns while the
crank turns once. A DC motor obeys, with voltage u, current i and rotor speed w::

    L di/dt = u - R i - k w,    torque = k i

(Krishnan, *Electric Motor Drives*, 2001, ch. 2): in SI units its torque constant k is that of the
back-EMF. Speed control is a PI rule on the rotor's speed over the gear ratio, whose integral
follows a saturated command (back-calculation; Astrom & Hagglund, *Advanced PID Control*, 2006,
sect. 3.5).
"""

from __future__ import annotations

import abc
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from flexmech import si, units
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.model_text import TomlTable, quantity
from flexmech.units import Dimension, from_si, to_si
from flexmech.validation import (
    NOT_NEGATIVE,
    POSITIVE,
    check_instance,
    check_number,
    checked_array,
)


@dataclass(frozen=True, kw_only=True)
class Motor(abc.ABC):
    """A motor with its gear, rotor and coupling to the crank.

    Parameters
    ----------
    gear_ratio : float
        Motor speed over crank speed.
    inertia : float
        Inertia of the rotor about its axis in kg m^2.
    coupling_stiffness : float, optional
        Stiffness of a coupling between gear and crank, at the crank, in N m/rad; rigid if
        left out.
    coupling_damping : float
        Damping of the coupling in N m s/rad.

    Raises
    ------
    InputError
        If a number cannot be, or a coupling has no rotor behind it.
    """

    gear_ratio: si.PositiveRatio = 1.0
    inertia: si.Inertia = 0.0
    coupling_stiffness: si.CouplingStiffness | None = None
    coupling_damping: si.TorsionalDamping = 0.0

    def __post_init__(self) -> None:
        si.check(self)
        if self.coupling_stiffness is None:
            if self.coupling_damping:
                raise InputError("coupling_damping goes with coupling_stiffness; give both")
            return
        if not self.inertia:
            raise InputError(
                "coupling_stiffness needs a rotor behind it; give inertia, or leave the coupling "
                "out"
            )

    @property
    def inertia_at_crank(self) -> float:
        """Inertia of the rotor, reduced to the crank, in kg m^2."""
        return self.inertia * self.gear_ratio**2

    def coupling_torque(self, twist: FloatArray, rate: FloatArray) -> FloatArray:
        """Torque of the coupling on the crank in N m by its twist in rad and the rate of that.

        Parameters
        ----------
        twist, rate : ndarray, shape (...)
            Angle of the rotor against the crank in rad, and its rate in rad/s.

        Returns
        -------
        ndarray, shape (...)
        """
        assert self.coupling_stiffness is not None
        return np.asarray(self.coupling_stiffness * twist + self.coupling_damping * rate)

    @property
    def has_current(self) -> bool:
        """Whether the current is a state."""
        return False

    @property
    @abc.abstractmethod
    def words(self) -> str:
        """Description of the motor, for titles."""

    @abc.abstractmethod
    def to_table(self) -> TomlTable:
        """Value of the key ``motor`` of a model file."""

    @property
    @abc.abstractmethod
    def gain_dimensions(self) -> tuple[Dimension, Dimension]:
        """Dimensions of a speed control's kp and ki."""

    @abc.abstractmethod
    def holding_current(self, torque: float) -> float:
        """Current in A that gives a torque in N m; zero where it is no state."""

    def first_current(self, torque: float) -> float:
        """Current in A at time zero, where a torque in N m holds the crank."""
        return self.holding_current(torque)

    @abc.abstractmethod
    def limit(self, speed: FloatArray) -> FloatArray:
        """Greatest command either way at rotor speeds (...): torque in N m, or voltage in V."""

    @abc.abstractmethod
    def driven(
        self, speed: FloatArray, current: FloatArray | None, command: FloatArray | None
    ) -> tuple[FloatArray, FloatArray | None, FloatArray, FloatArray]:
        """Torque, rate of the current, current and voltage at rotor speeds (...).

        Parameters
        ----------
        speed : ndarray, shape (...)
            Speed of the rotor in rad/s.
        current : ndarray, shape (...), optional
            In A, where it is a state.
        command : ndarray, shape (...), optional
            Command of speed control, within its limits.
        """


@dataclass(frozen=True)
class TorqueMotor(Motor):
    """A motor whose torque is a curve over its speed.

    Between its points the curve is straight. Before the first one the torque is the first; beyond
    the last one the last piece goes on, so that a motor that is overrun brakes. A single point is
    a constant torque.

    Parameters
    ----------
    speeds : tuple of float
        Speeds of the motor in rad/s, increasing.
    torques : tuple of float
        On the motor's shaft in N m.
    gear_ratio, inertia, coupling_stiffness, coupling_damping : float, optional
        As of :class:`Motor`, by their names.

    Raises
    ------
    InputError
        If speeds do not increase, the last piece rises, or a number is none.

    Examples
    --------
    >>> motor = flexmech.TorqueMotor((0.0, 150.0), (12.0, 0.0), gear_ratio=10.0)
    >>> motor.torque([-10.0, 75.0, 160.0])
    array([12. ,  6. , -0.8])
    """

    speeds: tuple[float, ...]
    torques: tuple[float, ...]

    def __post_init__(self) -> None:
        super().__post_init__()
        speeds = checked_array(self.speeds, "speeds of torque_speed", "rad/s")
        torques = checked_array(self.torques, "torques of torque_speed", "N m")
        if speeds.ndim != 1 or speeds.shape != torques.shape or not speeds.size:
            raise InputError(
                f"torque_speed has {speeds.size} speeds and {torques.size} torques; give one row "
                "or more, each with both"
            )
        falls = np.flatnonzero(np.diff(speeds) <= 0)
        if falls.size:
            row = int(falls[0])
            raise InputError(
                f"torque_speed: the speed {speeds[row + 1]:.6g} rad/s follows {speeds[row]:.6g} "
                f"rad/s in row {row + 2}; give its rows with increasing speeds"
            )
        if len(torques) > 1 and torques[-1] > torques[-2]:
            raise InputError(
                f"torque_speed: the torque rises to {torques[-1]:.6g} N m in its last row, and "
                "would rise without bound beyond it; add a row with a torque that is no greater"
            )
        object.__setattr__(self, "speeds", tuple(speeds.tolist()))
        object.__setattr__(self, "torques", tuple(torques.tolist()))

    def torque(self, speed: ArrayLike) -> FloatArray:
        """Torque in N m at motor speeds in rad/s; shape (...) -> (...)."""
        motor_speed = np.asarray(speed, dtype=float)
        torque = np.interp(motor_speed, self.speeds, self.torques)
        if len(self.speeds) == 1:
            return np.asarray(torque)
        slope = (self.torques[-1] - self.torques[-2]) / (self.speeds[-1] - self.speeds[-2])
        return np.asarray(torque + slope * np.maximum(motor_speed - self.speeds[-1], 0.0))

    @property
    def words(self) -> str:
        """Greatest torque, and the gear."""
        return f"motor of up to {max(self.torques, key=abs):.4g} N m{_gear_words(self)}"

    def to_table(self) -> TomlTable:
        """Value of the key ``motor`` of a model file."""
        rows = [
            [quantity(speed, units.ANGULAR_SPEED), quantity(torque, units.TORQUE)]
            for speed, torque in zip(self.speeds, self.torques, strict=True)
        ]
        return {"torque_speed": rows, **si.table(self)}

    @property
    def gain_dimensions(self) -> tuple[Dimension, Dimension]:
        """Dimensions of a speed control's kp and ki."""
        return units.TORSIONAL_DAMPING, units.TORSIONAL_STIFFNESS

    def holding_current(self, torque: float) -> float:
        """Zero: it has no current."""
        return 0.0

    def limit(self, speed: FloatArray) -> FloatArray:
        """Greatest torque either way at rotor speeds (...), that of the curve at their size."""
        return np.maximum(self.torque(np.abs(speed)), 0.0)

    def driven(
        self, speed: FloatArray, current: FloatArray | None, command: FloatArray | None
    ) -> tuple[FloatArray, FloatArray | None, FloatArray, FloatArray]:
        """Torque at rotor speeds (...); it has no current."""
        none = np.full(np.shape(speed), np.nan)
        return self.torque(speed) if command is None else command, None, none, none


@dataclass(frozen=True)
class DcMotor(Motor):
    """A DC motor at a voltage.

    Parameters
    ----------
    resistance : float
        Resistance of a DC motor's armature in ohm.
    torque_constant : float
        Constant of a DC motor in N m/A, which is that of the back-EMF in V s/rad.
    voltage : float
        Voltage of a DC motor in V; with speed control the greatest one either way.
    inductance : float
        Inductance of a DC motor's armature in H; without it the current follows at once.
    initial_current : float, optional
        Initial current of a DC motor with inductance at time zero in A, 0 A of one that is switched
        on then; if left out the one that holds the crank against its loads, as a brake leaves it
        that is released at that current.
    gear_ratio, inertia, coupling_stiffness, coupling_damping : float, optional
        As of :class:`Motor`, by their names.

    Raises
    ------
    InputError
        If a number cannot be.

    Examples
    --------
    >>> motor = flexmech.DcMotor(resistance=1.2, torque_constant=0.06, voltage=24.0)
    >>> motor.no_load_speed, motor.stall_torque
    (400.0, 1.2)
    """

    resistance: si.Resistance
    torque_constant: si.TorqueConstant
    voltage: si.Voltage
    inductance: si.Inductance = 0.0
    initial_current: si.Current | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.initial_current is not None and not self.inductance:
            raise InputError(
                "initial_current goes with inductance, without which the current follows at once; "
                "give both, or leave initial_current out"
            )

    @property
    def no_load_speed(self) -> float:
        """No-load speed of the motor in rad/s."""
        return self.voltage / self.torque_constant

    @property
    def stall_torque(self) -> float:
        """On the motor's shaft at rest, in N m."""
        return self.torque_constant * self.voltage / self.resistance

    @property
    def has_current(self) -> bool:
        """Whether the current is a state."""
        return self.inductance > 0

    @property
    def words(self) -> str:
        """Voltage and gear."""
        return f"DC motor at {self.voltage:.4g} V{_gear_words(self)}"

    def to_table(self) -> TomlTable:
        """Value of the key ``motor`` of a model file."""
        return {"kind": "dc", **si.table(self)}

    @property
    def gain_dimensions(self) -> tuple[Dimension, Dimension]:
        """Dimensions of a speed control's kp and ki."""
        return units.VOLTAGE_GAIN, units.VOLTAGE_INTEGRAL_GAIN

    def holding_current(self, torque: float) -> float:
        """Current in A that gives a torque in N m."""
        return torque / self.torque_constant

    def first_current(self, torque: float) -> float:
        """Current in A at time zero: the stated one, or that which gives a torque in N m."""
        stated = self.initial_current
        return self.holding_current(torque) if stated is None else stated

    def limit(self, speed: FloatArray) -> FloatArray:
        """The voltage either way."""
        return np.full(np.shape(speed), abs(self.voltage))

    def driven(
        self, speed: FloatArray, current: FloatArray | None, command: FloatArray | None
    ) -> tuple[FloatArray, FloatArray | None, FloatArray, FloatArray]:
        """Torque, rate of the current, current and voltage at rotor speeds (...)."""
        voltage = np.full(np.shape(speed), self.voltage) if command is None else command
        left = voltage - self.torque_constant * np.asarray(speed)
        if current is None:
            current = left / self.resistance
            return self.torque_constant * current, None, current, voltage
        rate = (left - self.resistance * current) / self.inductance
        return self.torque_constant * current, rate, current, voltage


def _gear_words(motor: Motor) -> str:
    return "" if motor.gear_ratio == 1 else f", gear {motor.gear_ratio:.4g}:1"


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
    speed_unit: str = field(default=units.ANGULAR_SPEED.unit, compare=False)

    def __post_init__(self) -> None:
        check_number(self.kp, "kp", "", POSITIVE)
        check_number(self.ki, "ki", "", NOT_NEGATIVE)
        check_number(self.target, "target", "rad/s")
        try:
            to_si(1.0, self.speed_unit, units.ANGULAR_SPEED)
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
        return units.ANGULAR_SPEED.unit if self.control is None else self.control.speed_unit

    def to_table(self) -> TomlTable:
        """Table ``[drive]`` of a model file."""
        table: TomlTable = {"motor": self.motor.to_table()}
        if self.control is not None:
            gain, integral = self.motor.gain_dimensions
            table["speed_control"] = {
                "kp": quantity(self.control.kp, gain),
                "ki": quantity(self.control.ki, integral),
                "target": quantity(
                    self.control.target, units.ANGULAR_SPEED, self.speed_unit, always=True
                ),
            }
        if self.time is not None:
            table["time"] = quantity(self.time, units.TIME)
        if self.start_angle:
            table["start_angle"] = quantity(self.start_angle, units.ANGLE)
        return table


# Part of a speed and of a command over which the answer is differentiated.
_DIFFERENCE = 1e-6


@dataclass(frozen=True)
class MotorOutput:
    """Output of a motor at some instants.

    Parameters
    ----------
    torque : ndarray, shape (...)
        On its own shaft in N m.
    rates : ndarray, shape (k, ...)
        Rates of its states: of the current in A/s if that is one, of the control's integral.
    current, voltage : ndarray, shape (...)
        Current in A and voltage in V of a DC motor; not numbers for a torque curve.
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
        """Values of a shaft that are angles: the crank's, and that of a rotor on a coupling."""
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
        """Inertia of what turns rigidly with the crank in kg m^2."""
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
        """Output of the motor at crank speeds (...) in rad/s and states (state_count, ...)."""
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
            Crank angle in rad and crank speed in rad/s.
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
            Speed of the rotor over the gear ratio in rad/s.
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
