"""Quantities as text, such as ``"279.4 mm"``, to SI floats: the only door for units.

Everything behind this door is an SI float. Text is split here into a number and a unit, and
pint sees the unit alone: pint's own number parsing would read "1,5 mm" as 15 mm. The conversion
is done in decimal arithmetic: "279.4 mm" is the float 0.2794, correctly rounded.
"""

from __future__ import annotations

import math
import re
import reprlib
from dataclasses import dataclass
from decimal import Decimal

from flexmech import unit_registry
from flexmech.errors import InputError, nearest
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
VOLTAGE = Dimension("a voltage", "V", ("24 V", "0.4 kV"))
RESISTANCE = Dimension("a resistance", "ohm", ("1.2 ohm", "800 mohm"))
INDUCTANCE = Dimension("an inductance", "H", ("1 mH", "2e-4 H"))
CURRENT = Dimension("a current", "A", ("0 A", "2.5 A"))
TORQUE_CONSTANT = Dimension("a torque constant", "N m/A", ("0.06 N m/A", "60 mN m/A"))
VOLTAGE_GAIN = Dimension("a gain of speed control", "V s/rad", ("0.5 V s/rad", "0.05 V/rpm"))
VOLTAGE_INTEGRAL_GAIN = Dimension("an integral gain of speed control", "V/rad", ("2 V/rad",))
PRESSURE_VELOCITY = Dimension("a p v", "W/m^2", ("1.8 MPa m/s", "1.8 N/mm^2 m/s"))
RATIO = Dimension("a ratio", "", ("0.01", "1 %"))

NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
"""Regular expression of a decimal number: no thousands separators, no NaN, no infinity."""

_SPLIT = re.compile(rf"\s*(?P<number>{NUMBER})(?P<unit>.*)", re.DOTALL)

# What files and options hold may be longer than anybody reads.
_REPR = reprlib.Repr()
_REPR.maxstring = _REPR.maxother = 100


def shown(text: object) -> str:
    """The given value, as a message shows it."""
    return _REPR.repr(text)


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


def parse_percent(text: str) -> float:
    """Read a fraction that is written in percent: ``"7"`` or ``"7 %"`` is 0.07.

    Parameters
    ----------
    text : str

    Returns
    -------
    float

    Raises
    ------
    InputError
        If it is no number, or not between 0 and 100 percent.
    """
    unit = next((unit for unit in ("percent", "%") if text.strip().endswith(unit)), "")
    try:
        percent = float(parse_number(text.strip().removesuffix(unit)))
    except InputError as error:
        raise InputError(f"{error} (in percent)") from error
    if not 0 <= percent <= 100:
        raise InputError(f"must lie between 0 and 100 percent, got {text!r}")
    return percent / 100


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
    number, unit = split_quantity(value, dimension)
    if not unit and not unitless:
        if default_unit is None:
            raise InputError(
                f"got {shown(value)}, which has no unit; write {dimension.name} with its unit, "
                f"for example {dimension.example}"
            )
        unit = default_unit
    factor = unit_factor(value, unit, dimension)
    if dimension is TEMPERATURE:
        number += zero_of_scale(unit)
    return finite_value(number, factor, value)


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


def to_si(value: float, unit: str, dimension: Dimension) -> float:
    """SI value of a number in a unit: the float that its text with this unit is.

    Parameters
    ----------
    value : float
    unit : str
        Unit of the dimension, without an offset.
    dimension : Dimension

    Returns
    -------
    float

    Raises
    ------
    InputError
        If the unit is unknown or of another dimension.
    """
    text = f"{float(value)!r} {unit}"
    if not isinstance(unit, str):
        raise InputError(
            f"a unit is needed, got {shown(unit)}; write it as text, for example "
            f"{dimension.example.split()[-1][:-1]!r}"
        )
    factor = unit_factor(text, unit, dimension)
    # What is no finite number is refused where it is checked, with its name.
    return (
        finite_value(Decimal(repr(float(value))), factor, text) if math.isfinite(value) else value
    )


def split_quantity(text: str, dimension: Dimension) -> tuple[Decimal, str]:
    """Split a text into number and unit.

    Parameters
    ----------
    text : str
    dimension : Dimension
        Dimension of which it should be, for messages.

    Returns
    -------
    Decimal
    str
        Empty where there is none.

    Raises
    ------
    InputError
        If it does not begin with a number.
    """
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


def unit_factor(text: str, unit: str, dimension: Dimension) -> Decimal:
    """SI value of one unit.

    Parameters
    ----------
    text : str
        What was given, for messages.
    unit : str
    dimension : Dimension

    Returns
    -------
    Decimal

    Raises
    ------
    InputError
        If the unit is unknown or of another dimension.
    """
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
    close = nearest(unit.lower(), list(by_lower_case))
    remedy = f"did you mean {by_lower_case[close]!r}?" if close else "write"
    example = known[by_lower_case[close]] if close else dimension.examples[0]
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


def finite_value(number: Decimal, factor: Decimal, text: object) -> float:
    """SI value of a number in a unit.

    Parameters
    ----------
    number : Decimal
    factor : Decimal
        SI value of one unit.
    text : object
        What was given, for messages.

    Returns
    -------
    float

    Raises
    ------
    InputError
        If it is too large.
    """
    try:
        result = float(number * factor)
    except ArithmeticError:
        result = math.inf
    if not math.isfinite(result):
        raise InputError(f"got {shown(text)}, which is too large; write a smaller number")
    return result
