"""Values of a model file's [drive] for a motor and its speed control."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from flexmech import units
from flexmech.errors import InputError
from flexmech.linkages import DcMotor, Motor, SpeedControl, TorqueMotor
from flexmech.modelfile import base_table as base
from flexmech.plausible import check_plausible, of_dimension
from flexmech.units import Dimension, parse_quantity
from flexmech.validation import POSITIVE

Resistance = Annotated[float, base.QuantityField(units.RESISTANCE, POSITIVE)]
Inductance = Annotated[float, base.QuantityField(units.INDUCTANCE, POSITIVE)]
Current = Annotated[float, base.QuantityField(units.CURRENT)]
TorqueConstant = Annotated[float, base.QuantityField(units.TORQUE_CONSTANT, POSITIVE)]
Voltage = Annotated[float, base.QuantityField(units.VOLTAGE)]
Coupling = Annotated[float, base.QuantityField(units.TORSIONAL_STIFFNESS, POSITIVE)]
Ratio = Annotated[float, base.QuantityField(units.RATIO, POSITIVE)]

_DC = ("resistance", "inductance", "torque_constant", "voltage", "initial_current")


class MotorTable(base.Table):
    """A motor: its torque over its speed, or a DC motor."""

    kind: Literal["torque", "dc"] = base.optional(
        "torque with torque_speed; dc with resistance, torque_constant and voltage", "torque"
    )
    torque_speed: list[list[str | float]] | None = base.optional(
        "Rows of motor speed and torque, straight between them; the first torque before them, the "
        "last line beyond; a single row is a constant torque"
    )
    resistance: Resistance | None = base.optional("Of a DC motor's armature")
    inductance: Inductance | None = base.optional(
        "Of a DC motor's armature; without it the current follows at once"
    )
    torque_constant: TorqueConstant | None = base.optional(
        "Of a DC motor; that of its back-EMF too"
    )
    voltage: Voltage | None = base.optional(
        "Of a DC motor; with speed_control the greatest one either way"
    )
    initial_current: Current | None = base.optional(
        "Of a DC motor with inductance at time zero, 0 A of one that is switched on then; if left "
        "out the one that holds the crank against its loads, as after a brake"
    )
    gear_ratio: Ratio = base.optional("Motor speed over crank speed", 1.0)
    inertia: base.Inertia = base.optional("Of the rotor about its axis", 0.0, "0 kg m^2")
    coupling_stiffness: Coupling | None = base.optional(
        "Of a coupling between gear and crank; rigid if left out"
    )
    coupling_damping: base.TorsionalDamping | None = base.optional("Of the coupling")

    @model_validator(mode="after")
    def _of_its_kind(self) -> MotorTable:
        given = {key for key in _DC if getattr(self, key) is not None}
        if self.kind == "dc":
            if self.torque_speed is not None:
                raise InputError("torque_speed does not go with kind dc; leave one of them out")
            missing = {"resistance", "torque_constant", "voltage"} - given
            if missing:
                raise InputError(f"{min(missing)} is missing; a DC motor needs it")
            return self
        if given:
            raise InputError(
                f'{min(given)} belongs to a DC motor; add kind = "dc", or leave it out'
            )
        if self.torque_speed is None:
            raise InputError(
                'torque_speed is missing; add it, as torque_speed = [["0 rpm", "12 N m"], '
                '["1500 rpm", "0 N m"]], or kind = "dc"'
            )
        return self

    @property
    def motor(self) -> Motor:
        """The motor that is stated.

        Raises
        ------
        InputError
            If it is none.
        """
        gear: dict[str, Any] = {
            "gear_ratio": self.gear_ratio,
            "inertia": self.inertia,
            "coupling_stiffness": self.coupling_stiffness,
            "coupling_damping": self.coupling_damping or 0.0,
        }
        if self.kind == "dc":
            assert self.resistance is not None
            assert self.torque_constant is not None
            assert self.voltage is not None
            return DcMotor(
                self.resistance,
                self.torque_constant,
                self.voltage,
                self.inductance or 0.0,
                self.initial_current,
                **gear,
            )
        assert self.torque_speed is not None
        rows = [_row(number, row) for number, row in enumerate(self.torque_speed)]
        return TorqueMotor(tuple(row[0] for row in rows), tuple(row[1] for row in rows), **gear)


class SpeedControlTable(base.Table):
    """PI control of the crank's speed by the motor."""

    kp: str = Field(
        description="In V s/rad or V/rpm of a DC motor, or N m s/rad of the motor's torque"
    )
    ki: str | None = base.optional("In V/rad of a DC motor, or N m/rad; none if left out")
    target: base.WrittenSpeed = Field(description="Crank speed; negative turns backwards")

    def control(self, motor: Motor) -> SpeedControl:
        """The control that is stated.

        Parameters
        ----------
        motor : Motor
            That it commands.

        Raises
        ------
        InputError
            If it is none of this motor.
        """
        gain, integral = motor.gain_dimensions
        kp = _quantity(self.kp, gain, "kp")
        ki = 0.0 if self.ki is None else _quantity(self.ki, integral, "ki")
        return SpeedControl(kp, ki, self.target.value, self.target.unit)


def _quantity(value: object, dimension: Dimension, key: str) -> float:
    try:
        found = parse_quantity(value, dimension)
        plausible = of_dimension(dimension)
        if plausible is not None:
            check_plausible(found, value, plausible)
    except InputError as error:
        raise error.within(key) from error
    return found


def _row(number: int, row: list[str | float]) -> tuple[float, float]:
    where = f"torque_speed[{number}]"
    if len(row) != 2:
        raise InputError(f"{where}: got {len(row)} values; give speed and torque")
    return (
        _quantity(row[0], units.ANGULAR_SPEED, where),
        _quantity(row[1], units.TORQUE, where),
    )
