"""A catalogue of motors: a CSV table of the user, with the units in its first line."""

from __future__ import annotations

import re
from dataclasses import dataclass
from os import PathLike

from flexmech import si, units
from flexmech.errors import InputError
from flexmech.files import given_path
from flexmech.modelfile.csv_files import csv_lines
from flexmech.units import Dimension, parse_quantity
from flexmech.validation import NOT_NEGATIVE, POSITIVE, check_number

# Columns with their dimensions; those of the second line may be left out.
_NEEDED = {
    "rated_torque": units.TORQUE,
    "peak_torque": units.TORQUE,
    "max_speed": units.ANGULAR_SPEED,
    "inertia": units.INERTIA,
}
_OPTIONAL = {"gear_ratio": units.RATIO, "max_inertia_ratio": units.RATIO}
_COLUMNS = _NEEDED | _OPTIONAL
_TITLE = re.compile(r"(?P<name>[\w -]*?)\s*(?:[(\[](?P<unit>.*)[)\]])?")
EXAMPLE = "name,rated_torque (N m),peak_torque (N m),max_speed (rpm),inertia (kg cm^2)"
"""First line of a catalogue."""


@dataclass(frozen=True)
class CatalogueMotor:
    """A motor of a catalogue, with its gear.

    Parameters
    ----------
    name : str
    rated_torque : float
        Continuous torque on the motor's shaft in N m.
    peak_torque : float
        Short-time torque there in N m.
    max_speed : float
        Greatest speed of that shaft in rad/s.
    inertia : float
        Inertia of the rotor in kg m^2.
    gear_ratio : float
        Motor speed over crank speed.
    max_inertia_ratio : float, optional
        Most inertia of what it drives, reduced to its shaft, over that of its rotor.

    Raises
    ------
    InputError
        If a number is out of its range.

    Examples
    --------
    >>> CatalogueMotor("M", 2.0, 6.0, 314.0, 1e-4).gear_ratio
    1.0
    """

    name: str
    rated_torque: si.Torque
    peak_torque: si.Torque
    max_speed: si.Speed
    inertia: si.Inertia
    gear_ratio: si.PositiveRatio = 1.0
    max_inertia_ratio: si.PositiveRatio | None = None

    def __post_init__(self) -> None:
        for key, dimension in _COLUMNS.items():
            value, bounds = getattr(self, key), NOT_NEGATIVE if key == "inertia" else POSITIVE
            if value is not None or key != "max_inertia_ratio":
                check_number(value, key, dimension.unit, bounds)


def motor_catalogue(file: str | PathLike[str]) -> tuple[CatalogueMotor, ...]:
    """Motors of a catalogue, in its order.

    Columns beyond those of :class:`CatalogueMotor` are left aside.

    Parameters
    ----------
    file : str or path-like
        CSV file whose first line names the columns with their units, as in ``max_speed (rpm)``.

    Returns
    -------
    tuple of CatalogueMotor

    Raises
    ------
    InputError
        If the file cannot be read, a column or a unit is missing, or a cell is no number; names
        the line.
    """
    path = given_path(file)
    titles, rows = csv_lines(path, str(path), "catalogue of motors")
    columns = _columns(titles, str(path))
    motors = []
    for number, row in enumerate(rows, start=2):
        where = f"file {path}: line {number}"
        if len(row) != len(titles):
            raise InputError(f"{where} has {len(row)} fields, the first line {len(titles)}")
        try:
            motors.append(_motor(dict(zip(titles, row, strict=True)), columns))
        except InputError as error:
            raise error.within(where) from error
    names = [motor.name for motor in motors]
    if not motors:
        raise InputError(f"file {path}: there is no motor below its first line; give at least one")
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise InputError(f"file {path}: {twice[0]} stands twice; give each motor another name")
    return tuple(motors)


def _columns(titles: list[str], shown: str) -> dict[str, tuple[str, str]]:
    """Title and unit of each column that is known, by its name."""
    columns: dict[str, tuple[str, str]] = {}
    for title in titles:
        match = _TITLE.fullmatch(title)
        # Words of a title may be joined in any way.
        name = "" if match is None else re.sub(r"[ -]+", "_", match["name"].strip())
        if match is None or name not in {"name", *_COLUMNS}:
            continue
        if name in columns:
            raise InputError(f"file {shown}: the column {name} stands twice; keep one")
        unit = match["unit"] or ""
        if name in _NEEDED and not unit:
            example = f"{name} ({_NEEDED[name].unit})"
            raise InputError(f"file {shown}: {name} has no unit; write it as in {example!r}")
        columns[name] = title, unit
    for name in ("name", *_NEEDED):
        if name not in columns:
            raise InputError(
                f"file {shown}: the column {name} is missing; begin the file as in {EXAMPLE!r}"
            )
    return columns


def _motor(cells: dict[str, str], columns: dict[str, tuple[str, str]]) -> CatalogueMotor:
    name = cells[columns["name"][0]].strip()
    if not name:
        raise InputError("name is empty; name the motor")
    numbers = {
        key: _number(cells[columns[key][0]], columns[key][1], key, dimension)
        for key, dimension in _COLUMNS.items()
        if key in columns and (key in _NEEDED or cells[columns[key][0]].strip())
    }
    return CatalogueMotor(name, **numbers)


def _number(cell: str, unit: str, key: str, dimension: Dimension) -> float:
    try:
        return parse_quantity(f"{cell.strip()} {unit}".strip(), dimension)
    except InputError as error:
        raise error.within(key) from error
