"""Table of a model file for the drive of the crank, and the drive that it states.

A motor and its speed control are drives too.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from flexmech import si, units
from flexmech.errors import InputError
from flexmech.linkages import (
    ConstantSpeed,
    DcMotor,
    Drive,
    InputShaper,
    LawDrive,
    LawName,
    Motor,
    MotorDrive,
    ShapedDrive,
    SpeedControl,
    TableDrive,
    TorqueMotor,
)
from flexmech.linkages.drives.laws import TableEnds
from flexmech.modelfile import base_table as base
from flexmech.modelfile.csv_files import check_rows, csv_lines
from flexmech.plausible import check_plausible, of_dimension
from flexmech.units import ANGLE, RATIO, TIME, Dimension, parse_quantity

_DC = ("resistance", "inductance", "torque_constant", "voltage", "initial_current")


class MotorTable(base.RecordTable, of=DcMotor, required=()):
    """A motor: its torque over its speed, or a DC motor."""

    kind: Literal["torque", "dc"] = base.optional(
        "torque with torque_speed; dc with resistance, torque_constant and voltage", "torque"
    )
    torque_speed: list[list[str | float]] | None = base.optional(
        "Rows of motor speed and torque, straight between them; the first torque before them, the "
        "last line beyond; a single row is a constant torque"
    )

    @model_validator(mode="after")
    def _of_its_kind(self) -> MotorTable:
        given = self.model_fields_set & set(_DC)
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
        if self.kind == "dc":
            return self.made(DcMotor)
        assert self.torque_speed is not None
        rows = [_row(number, row) for number, row in enumerate(self.torque_speed)]
        speeds, torques = zip(*rows, strict=True) if rows else ((), ())
        return self.made(TorqueMotor, speeds=speeds, torques=torques)


class SpeedControlTable(base.Table):
    """PI control of the crank's speed by the motor."""

    kp: str = Field(
        description="In V s/rad or V/rpm of a DC motor, or N m s/rad of the motor's torque"
    )
    ki: str | None = base.optional("In V/rad of a DC motor, or N m/rad; none if left out")
    target: si.WrittenSpeed = Field(description="Crank speed; negative turns backwards")

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
        quantity = parse_quantity(value, dimension)
        plausible = of_dimension(dimension)
        if plausible is not None:
            check_plausible(quantity, value, plausible)
    except InputError as error:
        raise error.within(key) from error
    return quantity


def _row(number: int, row: list[str | float]) -> tuple[float, float]:
    where = f"torque_speed[{number}]"
    if len(row) != 2:
        raise InputError(f"{where}: got {len(row)} values; give speed and torque")
    return (
        _quantity(row[0], units.ANGULAR_SPEED, where),
        _quantity(row[1], units.TORQUE, where),
    )


# Keys that go with one of the ways of saying it, and with all of them.
_KEYS = {
    "speed": {"run_up_time"},
    "law": {"travel", "time", "dwell", "master_angle", "master_dwell", "master_speed", "moves"}
    | {"forth_and_back", "impulses"},
    "table": {"smoothing", "ends", "dwell", "master_speed", "moves", "impulses"},
    "motor": {"speed_control", "time"},
}
_ANYWHERE = {"start_angle"}


def _rows_or_file(value: Any) -> str | None:
    if isinstance(value, str):
        return "file"
    return "rows" if isinstance(value, list | tuple) else None


RowsOrFile = Annotated[
    Annotated[base.Text, Tag("file")] | Annotated[list[list[str | float]], Tag("rows")],
    Discriminator(
        _rows_or_file,
        custom_error_type="no_table",
        custom_error_message=(
            "write the name of a CSV file, or rows as in [['0 s', '0 deg'], ['0.1 s', '30 deg']]"
        ),
    ),
]


class DriveTable(base.Table):
    """How the crank turns: a constant speed, a law of motion, a table, or a motor."""

    speed: si.Speed | None = base.optional("Constant speed; negative turns backwards")
    run_up_time: si.RunTime | None = base.optional("With speed: of a smooth run-up to it from rest")
    law: LawName | None = base.optional("A law of motion from rest to rest")
    travel: si.Angle | None = base.optional("With law: of a move; negative moves backwards")
    time: si.RunTime | None = base.optional(
        "With law: of a move. With motor: of the run; as many turns as asked for if left out"
    )
    dwell: si.TimeOrZero | None = base.optional(
        "With law, or a table that stops: rest after each move; 0 if left out"
    )
    master_angle: si.AngleOneWay | None = base.optional(
        "With law and master_speed, in place of time: angle of the master shaft during a move"
    )
    master_dwell: si.Angle | None = base.optional(
        "With master_angle, in place of dwell: angle of the master shaft during the rest"
    )
    master_speed: si.SpeedOneWay | None = base.optional(
        "Speed of a master shaft, whose angles replace times in law and table"
    )
    forth_and_back: base.Flag = base.optional(
        "With law: whether every second move goes back; else moves go on, one from the other", False
    )
    table: RowsOrFile | None = base.optional(
        "Rows of time, or master angle with master_speed, and crank angle; or a CSV file of them "
        "beside the model file, with units in its first line, as in time_s,crank_angle_deg"
    )
    smoothing: si.Angle | None = base.optional(
        "With table: root mean square by which its spline may leave the rows; 0 if left out"
    )
    ends: TableEnds = base.optional(
        "With table: rest begins and ends without speed and acceleration; free as the rows have "
        "it; held as the rows have it, and the crank is held after the last one",
        "free",
    )
    moves: Annotated[int, Field(strict=True)] = base.optional(
        "With law or table: how often it is gone through, one after another", 1
    )
    motor: MotorTable | None = base.optional(
        "A motor that turns the crank from rest; how it turns follows from the linkage"
    )
    speed_control: SpeedControlTable | None = base.optional(
        "With motor: PI control of the crank's speed"
    )
    impulses: list[list[str | float]] | None = base.optional(
        "With law or table: times and weights of the impulses of an input shaper, as in "
        "[['0 s', 0.5], ['11 ms', 0.5]]; flexmech response --shaper tells them"
    )
    start_angle: si.Angle | None = base.optional(
        "Crank angle at time zero; 0 if left out, or the first one of the table"
    )

    @model_validator(mode="after")
    def _one_way_of_saying_it(self) -> DriveTable:
        ways = [name for name in _KEYS if getattr(self, name) is not None]
        if len(ways) != 1:
            raise InputError("give either speed, or law with travel and time, or table, or motor")
        [way] = ways
        for key in sorted(self.model_fields_set - _KEYS[way] - _ANYWHERE - {way}):
            others = " or ".join(name for name, keys in _KEYS.items() if key in keys)
            raise InputError(f"{key} belongs to {others}, and not to {way}; leave it out")
        if way == "table" and self.start_angle is not None:
            raise InputError("start_angle is the first angle of the table; leave it out")
        if way == "law":
            self._check_times()
        return self

    def _check_times(self) -> None:
        if self.travel is None:
            raise InputError('travel is missing; add it, as travel = "120 deg"')
        if (self.time is None) == (self.master_angle is None):
            raise InputError("give either time, or master_angle and master_speed, of a move")
        by_master = self.master_angle is not None
        if by_master != (self.master_speed is not None):
            raise InputError("master_angle and master_speed go together; give both, or time")
        wrong = "dwell" if by_master else "master_dwell"
        if getattr(self, wrong) is not None:
            raise InputError(
                f"{wrong} does not go with {'master_angle' if by_master else 'time'}; give "
                f"{'master_dwell' if by_master else 'dwell'}"
            )

    def drive(self, folder: Path) -> Drive | MotorDrive:
        """The drive that is stated, shaped where impulses are.

        Parameters
        ----------
        folder : Path
            Folder of the model file.

        Returns
        -------
        Drive or MotorDrive

        Raises
        ------
        InputError
            If it is none, or its file cannot be read.
        """
        plain = self._unshaped(folder)
        if self.impulses is None or isinstance(plain, MotorDrive):
            return plain
        try:
            return ShapedDrive(plain, _shaper(self.impulses))
        except InputError as error:
            raise error.within("impulses") from error

    def _unshaped(self, folder: Path) -> Drive | MotorDrive:
        start = self.start_angle or 0.0
        if self.speed is not None:
            return ConstantSpeed(self.speed, self.run_up_time or 0.0, start)
        if self.law is not None:
            assert self.travel is not None
            time, dwell = self.time, self.dwell or 0.0
            if time is None:
                assert self.master_angle is not None
                assert self.master_speed is not None
                time = self.master_angle / self.master_speed
                dwell = (self.master_dwell or 0.0) / self.master_speed
            return LawDrive(
                self.law, self.travel, time, dwell, self.moves, self.forth_and_back, start
            )
        if self.motor is not None:
            return self._by_motor(self.motor, start)
        assert self.table is not None
        first = TIME if self.master_speed is None else ANGLE
        try:
            rows, where = _rows(self.table, first, folder), _shown(self.table)
        except InputError as error:
            raise error.within("table") from error
        factor = 1.0 if self.master_speed is None else 1 / self.master_speed
        times, angles = tuple(factor * row[0] for row in rows), tuple(row[1] for row in rows)
        try:
            return TableDrive(
                times, angles, self.smoothing or 0.0, self.ends, self.moves, self.dwell or 0.0
            )
        except InputError as error:
            raise error.within(where) from error

    def _by_motor(self, table: MotorTable, start: float) -> MotorDrive:
        try:
            motor = table.motor
        except InputError as error:
            raise error.within("motor") from error
        if self.speed_control is None:
            return MotorDrive(motor, None, start, self.time)
        try:
            return MotorDrive(motor, self.speed_control.control(motor), start, self.time)
        except InputError as error:
            raise error.within("speed_control") from error


def _shaper(rows: list[list[str | float]]) -> InputShaper:
    impulses = []
    for number, row in enumerate(rows):
        if len(row) != 2:
            raise InputError(f"[{number}]: got {len(row)} values; give time and weight")
        try:
            impulses.append((parse_quantity(row[0], TIME), parse_quantity(row[1], RATIO)))
        except InputError as error:
            raise error.within(f"[{number}]") from error
    return InputShaper(tuple(time for time, _ in impulses), tuple(weight for _, weight in impulses))


def _shown(table: str | list[list[str | float]]) -> str:
    return f"table: file {table}" if isinstance(table, str) else "table"


def _rows(
    table: str | list[list[str | float]], first: Dimension, folder: Path
) -> list[tuple[float, float]]:
    """Times, or angles of the master shaft, and crank angles."""
    if isinstance(table, str):
        return _rows_of_file(table, first, folder)
    rows = []
    for number, row in enumerate(table):
        if len(row) != 2:
            raise InputError(
                f"[{number}]: got {len(row)} values; give {_first_word(first)} and crank angle"
            )
        try:
            rows.append((_sized(row[0], first), _sized(row[1], ANGLE)))
        except InputError as error:
            raise error.within(f"[{number}]") from error
    return rows


def _rows_of_file(shown: str, first: Dimension, folder: Path) -> list[tuple[float, float]]:
    titles, lines = csv_lines(folder / shown, shown, "drive")
    units = [_unit(title) for title in titles]
    wanted = [_first_word(first).replace(" ", "_"), "crank_angle"]
    if [name for name, _ in units] != wanted:
        example = "time_s" if first is TIME else "master_angle_deg"
        other = (
            "state master_speed for angles of a master shaft"
            if first is TIME
            else "leave master_speed out for times"
        )
        raise InputError(
            f"file {shown}: its first line must be two columns with their units, as "
            f"{example},crank_angle_deg; {other}"
        )
    check_rows(lines, titles, shown)
    rows = []
    for number, line in enumerate(lines, start=2):
        try:
            place, angle = (
                _sized(f"{cell} {unit}", dimension)
                for cell, (_, unit), dimension in zip(line, units, (first, ANGLE), strict=True)
            )
        except InputError as error:
            raise error.within(f"file {shown}: line {number}") from error
        rows.append((place, angle))
    return rows


def _first_word(first: Dimension) -> str:
    return "time" if first is TIME else "master angle"


def _unit(title: str) -> tuple[str, str]:
    """Name of a column with underscores, and its unit: ``time_s``, ``crank angle (deg)``."""
    match = re.fullmatch(
        r"(time|(?:master|crank)[ _]angle)[ _]*[(\[]?\s*([^\s()\[\]]+)\s*[)\]]?", title.lower()
    )
    return ("", "") if match is None else (match[1].replace(" ", "_"), match[2])


def _sized(value: object, dimension: Dimension) -> float:
    size = parse_quantity(value, dimension)
    plausible = of_dimension(dimension)
    if plausible is not None:
        check_plausible(size, value, plausible)
    return size
