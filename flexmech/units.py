"""Quantities as text, such as ``"279.4 mm"``, to SI floats: the only door for units.

Everything behind this door is an SI float. Text is split here into a number and a unit, and
pint sees the unit alone: pint's own number parsing would read "1,5 mm" as 15 mm. The conversion
is done in decimal arithmetic: "279.4 mm" is the float 0.2794, correctly rounded.
"""

from __future__ import annotations

import difflib
import math
import re
import reprlib
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal

from flexmech import unit_registry
from flexmech.errors import InputError
from flexmech.unit_registry import base_units, zero_of_scale

ZERO_CELSIUS = 273.15
"""Zero of the Celsius scale in K, by its definition."""


@dataclass(frozen=True)
class Dimension:
    """A kind of physical quantity.

    Parameters
    ----------
    name : str
        With its article, for messages: ``"a length"``.
    unit : str
        SI unit of the float that :func:`parse_quantity` returns; empty for a ratio.
    examples : tuple of str
        Well-formed values, the first one for messages.
    """

    name: str
    unit: str
    examples: tuple[str, ...]

    @property
    def example(self) -> str:
        """A well-formed value in quotes, as in a model file."""
        return f'"{self.examples[0]}"'


LENGTH = Dimension("a length", "m", ("279.4 mm", "0.2794 m", "28 cm", "11 inch"))
MASS = Dimension("a mass", "kg", ("25 g", "0.025 kg", "1 lb"))
TIME = Dimension("a time", "s", ("2e-5 s", "20 µs", "0.02 ms"))
FREQUENCY = Dimension("a frequency", "Hz", ("50 Hz", "1.2 kHz"))
ANGLE = Dimension("an angle", "rad", ("45 deg", "0.785 rad"))
ANGULAR_SPEED = Dimension("an angular speed", "rad/s", ("20 rad/s", "300 rpm", "5 rps", "90 deg/s"))
ANGULAR_ACCELERATION = Dimension("an angular acceleration", "rad/s^2", ("50 rad/s^2", "300 rpm/s"))
ACCELERATION = Dimension("an acceleration", "m/s^2", ("-9.81 m/s^2", "0 m/s^2"))
STRESS = Dimension("a stress", "Pa", ("68.9 GPa", "200000 MPa", "2e11 Pa", "1e7 psi"))
DENSITY = Dimension("a density", "kg/m^3", ("7800 kg/m^3", "2.7 g/cm^3"))
FORCE = Dimension("a force", "N", ("4900 N", "1.2 MN", "100 lbf"))
CURVATURE = Dimension("a curvature", "1/m", ("0.2 1/m",))
BENDING_STIFFNESS = Dimension("a bending stiffness", "N m^2", ("1.5 N m^2", "2e6 N mm^2"))
MASS_PER_LENGTH = Dimension("a mass per length", "kg/m", ("0.2 kg/m", "200 g/m"))
ROTARY_INERTIA = Dimension("a rotary inertia per length", "kg m", ("3e-7 kg m", "0.3 g mm"))
TEMPERATURE = Dimension("a temperature", "K", ("80 degC", "353.15 K", "176 degF"))
"""On a scale with its own zero: "20 degC" is 293.15 K."""
TEMPERATURE_DIFFERENCE = Dimension("a temperature difference", "K", ("80 K", "80 degC"))
"""Between two temperatures: "20 degC" is 20 K."""
EXPANSION = Dimension("a thermal expansion", "1/K", ("58.4e-6 1/K", "11.7e-6 1/degC"))
MOISTURE_EXPANSION = Dimension("a moisture expansion", "", ("3.02e-3 1/percent", "0.302"))
DIFFUSIVITY = Dimension("a diffusivity", "m^2/s", ("1.2e-12 m^2/s", "1.2e-6 mm^2/s"))
ACTIVATION_ENERGY = Dimension("an activation energy", "J/mol", ("45 kJ/mol", "45000 J/mol"))
DAMPING = Dimension("a damping", "N s/m", ("2 N s/m", "0.002 N s/mm"))
INERTIA = Dimension("a moment of inertia", "kg m^2", ("2e-4 kg m^2", "200 kg mm^2"))
SPRING_STIFFNESS = Dimension("a spring stiffness", "N/m", ("500 N/m", "0.5 N/mm"))
TORQUE = Dimension("a torque", "N m", ("1.5 N m", "200 N mm"))
TORSIONAL_DAMPING = Dimension("a torsional damping", "N m s/rad", ("1e-3 N m s/rad",))
TORSIONAL_STIFFNESS = Dimension("a torsional stiffness", "N m/rad", ("2 N m/rad", "0.03 N m/deg"))
RATIO = Dimension("a ratio", "", ("0.01", "1 %"))

NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
"""Regular expression of a decimal number: no thousands separators, no NaN, no infinity."""

_SPLIT = re.compile(rf"\s*(?P<number>{NUMBER})(?P<unit>.*)", re.DOTALL)

# A range hits its end when it comes this close, in steps: 0:1:0.333333 means thirds.
_HIT = Decimal("1e-5")

# What files and options hold may be longer than anybody reads.
_REPR = reprlib.Repr()
_REPR.maxstring = _REPR.maxother = 100


def shown(text: object) -> str:
    """What was given, as a message shows it."""
    return _REPR.repr(text)


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
        raise InputError(_unknown_unit(text, unit, dimension))
    assert wanted is not None
    if found.name != wanted.name:
        raise InputError(_wrong_dimension(text, unit, found.name, dimension))
    return found.factor / wanted.factor


def _unknown_unit(text: str, unit: str, dimension: Dimension) -> str:
    """Message on a unit that there is not."""
    known = {example.split(maxsplit=1)[-1]: example for example in dimension.examples}
    by_lower_case = {name.lower(): name for name in known}
    close = difflib.get_close_matches(unit.lower(), by_lower_case, n=1)
    remedy = f"did you mean {by_lower_case[close[0]]!r}?" if close else "write"
    example = known[by_lower_case[close[0]]] if close else dimension.examples[0]
    joint = " For example" if close else f" {dimension.name}, for example"
    return (
        f"got {shown(text)}, in which the unit {shown(unit)} is unknown; "
        f'{remedy}{joint} "{example}"'
    )


def _wrong_dimension(text: str, unit: str, base: str, dimension: Dimension) -> str:
    """Message on a unit of another dimension; ``base`` is the same in base units."""
    if dimension is ANGULAR_SPEED and base == "1 / second":
        number = text[: text.rfind(unit)].strip() or "5"
        return (
            f"got {shown(text)}, which is a frequency and not an angular speed; write turns per "
            f'second as "{number} rps", turns per minute as "300 rpm", or an angle per time '
            'as "20 rad/s"'
        )
    if dimension is FREQUENCY and base == "radian / second":
        return (
            f"got {shown(text)}, which is an angular speed and not a frequency; write cycles per "
            f"second, for example {dimension.example}"
        )
    return (
        f"got {shown(text)}, whose unit {shown(unit)} ({base}) is not that of {dimension.name}; "
        f"write {dimension.name}, for example {dimension.example}"
    )


def _finite(number: Decimal, factor: Decimal, text: object) -> float:
    try:
        result = float(number * factor)
    except ArithmeticError:
        result = math.inf
    if not math.isfinite(result):
        raise InputError(f"got {shown(text)}, which is too large; write a smaller number")
    return result
