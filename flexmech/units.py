"""Quantities as text, such as ``"279.4 mm"``, to SI floats: the only door for units.

Everything behind this door is an SI float. Text is split here into a number and a unit, and
pint sees the unit alone: pint's own number parsing would read "1,5 mm" as 15 mm. The conversion
is done in decimal arithmetic: "279.4 mm" is the float 0.2794, correctly rounded.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal

from flexmech import unit_registry
from flexmech.dimensions import (
    ACCELERATION,
    ACTIVATION_ENERGY,
    ANGLE,
    ANGULAR_SPEED,
    BENDING_STIFFNESS,
    CURVATURE,
    DAMPING,
    DENSITY,
    DIFFUSIVITY,
    EXPANSION,
    FORCE,
    FREQUENCY,
    INERTIA,
    LENGTH,
    MASS,
    MASS_PER_LENGTH,
    MOISTURE_EXPANSION,
    RATIO,
    ROTARY_INERTIA,
    SPRING_STIFFNESS,
    STRESS,
    TEMPERATURE,
    TEMPERATURE_DIFFERENCE,
    TIME,
    TORQUE,
    TORSIONAL_DAMPING,
    TORSIONAL_STIFFNESS,
    Dimension,
    shown,
    unknown_unit,
    wrong_dimension,
)
from flexmech.errors import InputError
from flexmech.unit_registry import ZERO_CELSIUS, base_units, zero_of_scale

__all__ = [
    "ACCELERATION",
    "ACTIVATION_ENERGY",
    "ANGLE",
    "ANGULAR_SPEED",
    "BENDING_STIFFNESS",
    "CURVATURE",
    "DAMPING",
    "DENSITY",
    "DIFFUSIVITY",
    "EXPANSION",
    "FORCE",
    "FREQUENCY",
    "INERTIA",
    "LENGTH",
    "MASS",
    "MASS_PER_LENGTH",
    "MOISTURE_EXPANSION",
    "NUMBER",
    "RATIO",
    "ROTARY_INERTIA",
    "SPRING_STIFFNESS",
    "STRESS",
    "TEMPERATURE",
    "TEMPERATURE_DIFFERENCE",
    "TIME",
    "TORQUE",
    "TORSIONAL_DAMPING",
    "TORSIONAL_STIFFNESS",
    "ZERO_CELSIUS",
    "Dimension",
    "Quantities",
    "from_si",
    "parse_number",
    "parse_quantities",
    "parse_quantity",
]

NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
"""Regular expression of a decimal number: no thousands separators, no NaN, no infinity."""

_SPLIT = re.compile(rf"\s*(?P<number>{NUMBER})(?P<unit>.*)", re.DOTALL)

# A range hits its end when it comes this close, in steps: 0:1:0.333333 means thirds.
_HIT = Decimal("1e-5")


@dataclass(frozen=True)
class Quantities:
    """Several quantities of one text.

    Parameters
    ----------
    values : tuple of float
        In SI units.
    unit : str
        In which they were written, the last one of several.
    """

    values: tuple[float, ...]
    unit: str


def parse_number(text: str) -> Decimal:
    """Read a plain decimal number, exactly.

    Parameters
    ----------
    text : str
        For example ``"-2.5"`` or ``"2e-5"``, with nothing but blanks around it.

    Returns
    -------
    Decimal
        Finite, also as a float.

    Raises
    ------
    InputError
        If it is anything else.
    """
    # Only what a keyboard's blanks are: strip() alone also takes off control characters.
    bare = text.strip(" \t\r\n")
    if not re.fullmatch(NUMBER, bare):
        raise InputError(f"got {shown(bare)}, which is not a plain number; {_decimal_hint(text)}")
    try:
        number = Decimal(bare)
        rounded = float(number)
    except ArithmeticError:
        rounded = math.inf
    if not math.isfinite(rounded):
        raise InputError(f"got {shown(text.strip())}, which is too large; write a smaller number")
    return number


def parse_quantity(
    value: object, dimension: Dimension, *, default_unit: str | None = None
) -> float:
    """Read a quantity in SI units from text such as ``"279.4 mm"``.

    Parameters
    ----------
    value : object
        Text: a number and a unit. A ratio may be a number, ``"0.005"`` or ``"0.5 %"``.
    dimension : Dimension
        What it must be.
    default_unit : str, optional
        Unit of a number that carries none. Without it such a number is refused.

    Returns
    -------
    float
        In ``dimension.unit``; finite.

    Raises
    ------
    InputError
        If the value is not text, has no number or no unit, is not finite, or is a quantity
        of another dimension. The message says what was got and names the remedy.
    """
    unitless = dimension in (RATIO, MOISTURE_EXPANSION)
    if unitless and isinstance(value, int | float) and not isinstance(value, bool):
        value = repr(value)
    if isinstance(value, int | float) and not isinstance(value, bool):
        raise InputError(
            f"got the number {shown(value)}, which has no unit; write {dimension.name} as text "
            f"with its unit, for example {dimension.example}"
        )
    if not isinstance(value, str):
        raise InputError(
            f"got {shown(value)}, which is not {dimension.name}; write it as text with its unit, "
            f"for example {dimension.example}"
        )
    number, unit = _split(value, dimension)
    if not unit and not unitless:
        if default_unit is None:
            raise InputError(
                f"got {shown(value)}, which has no unit; write {dimension.name} with its unit, "
                f"for example {dimension.example}"
            )
        unit = default_unit
    factor = _factor(value, unit, dimension)
    if dimension is TEMPERATURE:
        number += zero_of_scale(unit)
    return _finite(number, factor, value)


def parse_quantities(
    text: str, dimension: Dimension, default_unit: str, *, most: int = 10_000
) -> Quantities:
    """Read quantities from a comma list or from a range START:STOP:STEP.

    A unit that only the last entry has covers all of them: "0,50,100 rpm". Otherwise each entry
    other than 0 has its own.

    Parameters
    ----------
    text : str
        Such as ``"0,50,100 rpm"``, ``"0:300:50 rpm"`` or ``"10 rad/s,300 rpm"``.
    dimension : Dimension
        Without a zero of its own: no temperature.
    default_unit : str
        Where no unit is written.
    most : int
        Longer ranges are taken for a slip of the keyboard.

    Returns
    -------
    Quantities
        In the order of the text. STOP is included when a whole number of steps leads to it.
        Counted in decimal, so that nothing adds up: 0:360:0.1 ends with 359.9 and 360 exactly.

    Raises
    ------
    InputError
        If a value is missing or no such quantity, the range is empty, endless or too long, or
        some entries have a unit and others have none.
    """
    separator = ":" if ":" in text else ","
    parts = text.split(separator)
    if separator == ":" and len(parts) != 3:
        raise InputError(
            f"got {shown(text)}, which has {len(parts)} parts; write START:STOP:STEP, for example "
            f'"0:300:50 {default_unit}"'
        )
    if not all(part.strip() for part in parts):
        raise InputError(
            f"got {shown(text)}, in which a value is missing; write START:STOP:STEP, for example "
            f'"0:300:50 {default_unit}", or a comma list such as "0,50,100 {default_unit}"'
        )
    entries = [_split(part.strip(), dimension) for part in parts]
    unit = _unit_of_bare(text, separator, entries) or default_unit
    factors = [_factor(text, own or unit, dimension) for _, own in entries]
    numbers = [number for number, _ in entries]
    if separator == ":":
        # In the last unit, which all three parts usually have.
        same = [
            number * (factor / factors[-1]) for number, factor in zip(numbers, factors, strict=True)
        ]
        numbers = _counted(text, *same, most=most)
        factors = [factors[-1]] * len(numbers)
    values = (_finite(n, factor, text) for n, factor in zip(numbers, factors, strict=True))
    return Quantities(tuple(values), unit)


def _unit_of_bare(text: str, separator: str, entries: Sequence[tuple[Decimal, str]]) -> str:
    """Unit of the entries that have none: the last one that is written; empty if there is none."""
    written = [unit for _, unit in entries if unit]
    covers_all = len(written) == 1 and entries[-1][1] != ""
    if written and not covers_all and any(number and not unit for number, unit in entries):
        bare = separator.join(str(number) for number, _ in entries)
        remedy = f'write the unit once, at the end: "{bare} {written[-1]}"'
        raise InputError(
            f"got {shown(text)}, in which some values have a unit and others have none; "
            + (remedy if len(set(written)) == 1 else "give each value its unit")
        )
    return written[-1] if written else ""


def _counted(
    text: str, start: Decimal, stop: Decimal, step: Decimal, *, most: int
) -> list[Decimal]:
    """Count the numbers of a range."""
    if step <= 0:
        raise InputError(f"got {shown(text)}; STEP must be positive, for example 0:360:5")
    if stop < start:
        raise InputError(
            f"got {shown(text)}; STOP must not be less than START, for example -90:90:5"
        )
    if (stop - start) >= most * step:
        raise InputError(
            f"got {shown(text)}, which is too long; choose a STEP that gives at most {most} values"
        )
    steps = (stop - start) / step
    count = int(steps + _HIT)
    numbers = [start + number * step for number in range(count + 1)]
    if abs(steps - count) <= _HIT:
        numbers[-1] = stop
    return numbers


def from_si(value: float, unit: str) -> float:
    """Number that an SI value has in another unit, such as 31.4 rad/s in rpm.

    Parameters
    ----------
    value : float
        In the SI unit of the same dimension.
    unit : str
        Without an offset: no temperature scale.

    Returns
    -------
    float

    Raises
    ------
    InputError
        If the unit is unknown.
    """
    try:
        return unit_registry.from_si(value, unit)
    except ValueError as error:
        raise InputError(str(error)) from error


def _split(text: str, dimension: Dimension) -> tuple[Decimal, str]:
    """Split a text into number and unit; the unit may be empty."""
    match = _SPLIT.fullmatch(text)
    if match is None:
        raise InputError(
            f"got {shown(text)}, which does not begin with a number; write {dimension.name} as a "
            f"number and a unit, for example {dimension.example}"
        )
    unit = match["unit"].strip()
    if match["unit"][:1] in (",", "_", "."):
        raise InputError(
            f"got {shown(text)}, in which {shown(match['unit'])} follows the number; "
            f"{_decimal_hint(text)}"
        )
    return parse_number(match["number"]), unit


def _decimal_hint(text: str) -> str:
    if "," in text or "_" in text:
        return "write numbers with a decimal point and no separators, for example 1250.5"
    return "write a number such as 12.5 or 2e-5"


def _factor(text: str, unit: str, dimension: Dimension) -> Decimal:
    """SI value of one ``unit``, which must have the dimension."""
    # The SI unit itself needs no pint, whose first import takes longer than small analyses.
    if unit == dimension.unit:
        return Decimal(1)
    found, wanted = base_units(unit), base_units(dimension.unit)
    if found is None:
        raise InputError(unknown_unit(text, unit, dimension))
    assert wanted is not None
    if found.name != wanted.name:
        raise InputError(wrong_dimension(text, unit, found.name, dimension))
    return found.factor / wanted.factor


def _finite(number: Decimal, factor: Decimal, text: object) -> float:
    try:
        result = float(number * factor)
    except ArithmeticError:
        result = math.inf
    if not math.isfinite(result):
        raise InputError(f"got {shown(text)}, which is too large; write a smaller number")
    return result
