"""Motors: torque by a curve over speed, or a DC motor with its current; gear, rotor, coupling.

Everything of the motor is told on its own shaft; ``gear_ratio`` is how often that turns while the
crank turns once. A DC motor obeys, with voltage u, current i and rotor speed w::

    L di/dt = u - R i - k w,    torque = k i

(Krishnan, *Electric Motor Drives*, 2001, ch. 2): in SI units its torque constant k is that of the
back-EMF.
"""

from __future__ import annotations

import abc
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.model_text import TomlTable, fields_table, quantity
from flexmech.units import (
    ANGULAR_SPEED,
    CURRENT,
    INDUCTANCE,
    INERTIA,
    RATIO,
    RESISTANCE,
    TORQUE,
    TORQUE_CONSTANT,
    TORSIONAL_DAMPING,
    TORSIONAL_STIFFNESS,
    VOLTAGE,
    VOLTAGE_GAIN,
    VOLTAGE_INTEGRAL_GAIN,
    Dimension,
)
from flexmech.validation import (
    NOT_NEGATIVE,
    POSITIVE,
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
        Of the rotor about its axis in kg m^2.
    coupling_stiffness : float, optional
        Between gear and crank, at the crank, in N m/rad; rigid if left out.
    coupling_damping : float
        In N m s/rad.

    Raises
    ------
    InputError
        If a number cannot be, or a coupling has no rotor behind it.
    """

    gear_ratio: float = 1.0
    inertia: float = 0.0
    coupling_stiffness: float | None = None
    coupling_damping: float = 0.0

    def __post_init__(self) -> None:
        check_number(self.gear_ratio, "gear_ratio", "", POSITIVE)
        check_number(self.inertia, "inertia", "kg m^2", NOT_NEGATIVE)
        check_number(self.coupling_damping, "coupling_damping", "N m s/rad", NOT_NEGATIVE)
        if self.coupling_stiffness is None:
            if self.coupling_damping:
                raise InputError("coupling_damping goes with coupling_stiffness; give both")
            return
        check_number(self.coupling_stiffness, "coupling_stiffness", "N m/rad", POSITIVE)
        if not self.inertia:
            raise InputError(
                "coupling_stiffness needs a rotor behind it; give inertia, or leave the coupling "
                "out"
            )

    @property
    def inertia_at_crank(self) -> float:
        """Of the rotor, reduced to the crank, in kg m^2."""
        return self.inertia * self.gear_ratio**2

    def coupling_torque(self, twist: FloatArray, rate: FloatArray) -> FloatArray:
        """Torque of the coupling on the crank in N m by its twist in rad and the rate of that.

        Parameters
        ----------
        twist, rate : ndarray, shape (...)
            Of the rotor against the crank, in rad and rad/s.

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
        """What it is, for titles."""

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
            Of the rotor in rad/s.
        current : ndarray, shape (...), optional
            In A, where it is a state.
        command : ndarray, shape (...), optional
            Of speed control, within its limits.
        """

    @property
    def _own_table(self) -> TomlTable:
        return fields_table(
            self,
            {
                "gear_ratio": RATIO,
                "inertia": INERTIA,
                "coupling_stiffness": TORSIONAL_STIFFNESS,
                "coupling_damping": TORSIONAL_DAMPING,
            },
        )


@dataclass(frozen=True)
class TorqueMotor(Motor):
    """A motor whose torque is a curve over its speed.

    Between its points the curve is straight. Before the first one the torque is the first; beyond
    the last one the last piece goes on, so that a motor that is overrun brakes. A single point is
    a constant torque.

    Parameters
    ----------
    speeds : tuple of float
        Of the motor in rad/s, increasing.
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
        own = np.asarray(speed, dtype=float)
        found = np.interp(own, self.speeds, self.torques)
        if len(self.speeds) == 1:
            return np.asarray(found)
        slope = (self.torques[-1] - self.torques[-2]) / (self.speeds[-1] - self.speeds[-2])
        return np.asarray(found + slope * np.maximum(own - self.speeds[-1], 0.0))

    @property
    def words(self) -> str:
        """Greatest torque, and the gear."""
        return f"motor of up to {max(self.torques, key=abs):.4g} N m{_gear_words(self)}"

    def to_table(self) -> TomlTable:
        """Value of the key ``motor`` of a model file."""
        rows = [
            [quantity(speed, ANGULAR_SPEED), quantity(torque, TORQUE)]
            for speed, torque in zip(self.speeds, self.torques, strict=True)
        ]
        return {"torque_speed": rows, **self._own_table}

    @property
    def gain_dimensions(self) -> tuple[Dimension, Dimension]:
        """Dimensions of a speed control's kp and ki."""
        return TORSIONAL_DAMPING, TORSIONAL_STIFFNESS

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
        Of the armature in ohm.
    torque_constant : float
        In N m/A, which is that of the back-EMF in V s/rad.
    voltage : float
        In V; with speed control the greatest one either way.
    inductance : float
        Of the armature in H; without it the current follows at once.
    initial_current : float, optional
        Of a motor with inductance at time zero, in A; left out, the one that holds the crank
        against its loads, as a brake leaves it that is released at that current.
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

    resistance: float
    torque_constant: float
    voltage: float
    inductance: float = 0.0
    initial_current: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        check_number(self.resistance, "resistance", "ohm", POSITIVE)
        check_number(self.torque_constant, "torque_constant", "N m/A", POSITIVE)
        check_number(self.voltage, "voltage", "V")
        check_number(self.inductance, "inductance", "H", NOT_NEGATIVE)
        if self.initial_current is None:
            return
        check_number(self.initial_current, "initial_current", "A")
        if not self.inductance:
            raise InputError(
                "initial_current goes with inductance, without which the current follows at once; "
                "give both, or leave initial_current out"
            )

    @property
    def no_load_speed(self) -> float:
        """Of the motor in rad/s."""
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
        dimensions = {
            "resistance": RESISTANCE,
            "inductance": INDUCTANCE,
            "torque_constant": TORQUE_CONSTANT,
            "voltage": VOLTAGE,
        }
        own = {key: quantity(getattr(self, key), of) for key, of in dimensions.items()}
        if not self.inductance:
            del own["inductance"]
        if self.initial_current is not None:
            own["initial_current"] = quantity(self.initial_current, CURRENT)
        return {"kind": "dc", **own, **self._own_table}

    @property
    def gain_dimensions(self) -> tuple[Dimension, Dimension]:
        """Dimensions of a speed control's kp and ki."""
        return VOLTAGE_GAIN, VOLTAGE_INTEGRAL_GAIN

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
