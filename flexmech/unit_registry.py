"""Units in SI base units, by pint: the ground that units and error messages stand on.

Units are compared in base units *with* the radian, so that 5 Hz and 5 rad/s are never mixed up.
All numbers are decimal, so that a conversion loses nothing before the final rounding.
"""

from __future__ import annotations

import re
from decimal import Decimal
from functools import cache
from tokenize import TokenError
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    import pint


# Pint skips characters that it does not know ("m$" is read as "m"), so only these may pass.
_UNIT_CHARACTERS = re.compile(r"[A-Za-zµμÅ°%_0-9\s*/^()·⋅²³⁴⁻¹-]*")
# Pint reads a unit by recursion, a factor a level, and computes powers of powers whole. A unit of
# six long names has 60 characters.
_MOST_CHARACTERS = 60
_TOWER = re.compile(r"(\^|\*\*)[^*/]*(\^|\*\*)|[0-9]{4}")

# What pint raises on malformed unit expressions, beside its own PintError, which is a class
# of the lazily imported module.
_MALFORMED = (
    ArithmeticError,
    AssertionError,
    AttributeError,
    KeyError,
    SyntaxError,
    TokenError,
    TypeError,
    ValueError,
)
# Units of which a number is the same in SI.
_SAME_IN_SI = frozenset({"", "m", "rad", "rad/s", "s", "kg", "Hz"})


class BaseUnits(NamedTuple):
    """A unit in base units: how many of which."""

    factor: Decimal
    name: str


# Factors by pint of the units that most model files are written in, to the last digit: a test asks
# it. Making its registry takes longer than small analyses.
COMMON_UNITS = {
    unit: BaseUnits(Decimal(factor), name)
    for name, factors in {
        "dimensionless": {"": "1", "%": "0.01", "percent": "0.01", "1/percent": "100"},
        "meter": {"m": "1", "cm": "0.01", "mm": "0.001", "µm": "1e-6", "nm": "1e-9", "km": "1e3"},
        "1 / meter": {"1/m": "1"},
        "kilogram": {"kg": "1", "g": "0.001"},
        "second": {"s": "1", "ms": "0.001", "µs": "1e-6"},
        "1 / second": {"Hz": "1", "kHz": "1e3"},
        "radian": {"rad": "1", "deg": "0.01745329251994329576923690768"},
        "radian / second": {
            "rad/s": "1",
            "deg/s": "0.01745329251994329576923690768",
            "rpm": "0.1047197551196597746154214461",
            "rps": "6.283185307179586476925286766",
        },
        "radian / second ** 2": {"rad/s^2": "1", "rpm/s": "0.1047197551196597746154214461"},
        "meter / second ** 2": {"m/s^2": "1"},
        "kilogram / meter / second ** 2": {"Pa": "1", "kPa": "1e3", "MPa": "1e6", "GPa": "1e9"},
        "kilogram / meter ** 3": {"kg/m^3": "1", "g/cm^3": "1e3", "t/mm^3": "1e12"},
        "kilogram / meter": {"kg/m": "1", "g/m": "0.001"},
        "kilogram * meter": {"kg m": "1"},
        "kilogram * meter ** 2": {"kg m^2": "1", "kg mm^2": "1e-6"},
        "kilogram * meter / second ** 2": {"N": "1"},
        "kilogram * meter ** 2 / second ** 2": {"N m": "1", "N mm": "0.001"},
        "kilogram * meter ** 3 / second ** 2": {"N m^2": "1", "N mm^2": "1e-6"},
        "kilogram * meter ** 2 / radian / second ** 2": {"N m/rad": "1"},
        "kilogram * meter ** 2 / radian / second": {"N m s/rad": "1"},
        "kilogram / second ** 2": {"N/m": "1", "N/mm": "1e3"},
        "kilogram / second": {"N s/m": "1", "N s/mm": "1e3"},
        "kelvin": {"K": "1", "degC": "1"},
        "1 / kelvin": {"1/K": "1", "1/degC": "1"},
        "meter ** 2 / second": {"m^2/s": "1", "mm^2/s": "1e-6"},
        "kilogram * meter ** 2 / mole / second ** 2": {"J/mol": "1", "kJ/mol": "1e3"},
    }.items()
    for unit, factor in factors.items()
}


@cache
def base_units(unit: str) -> BaseUnits | None:
    """Write a unit in base units, such as 0.01745 radian for "deg"; None where it is none."""
    return COMMON_UNITS.get(unit) or base_units_by_pint(unit)


def base_units_by_pint(unit: str) -> BaseUnits | None:
    """Write a unit in base units as pint finds them, or None.

    Parameters
    ----------
    unit : str

    Returns
    -------
    BaseUnits or None
    """
    import pint

    registry = _registry()
    if len(unit) > _MOST_CHARACTERS or _TOWER.search(unit):
        return None
    if not _UNIT_CHARACTERS.fullmatch(unit) or "//" in unit or "%%" in unit:
        return None
    try:
        found: tuple[Any, Any] = registry.get_base_units(registry.parse_units(unit))
    except (pint.PintError, *_MALFORMED):
        return None
    return BaseUnits(Decimal(found[0]), str(found[1]))


def zero_of_scale(unit: str) -> Decimal:
    """Zero of a temperature scale above absolute zero, in its own degrees."""
    registry = _registry()
    zero = registry.Quantity(Decimal(0), registry.parse_units(unit)).to("kelvin").magnitude
    found = base_units(unit)
    assert found is not None
    return Decimal(zero / found.factor)


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
    ValueError
        If the unit is unknown.
    """
    if unit in _SAME_IN_SI:
        return value
    found = base_units(unit)
    if found is None:
        raise ValueError(f"the unit {unit!r} is unknown; write one such as rpm, mm or s")
    return value / float(found.factor)


@cache
def _registry() -> pint.UnitRegistry[Any]:
    """Make the one registry when a rare unit is first met."""
    import pint

    registry: pint.UnitRegistry[Any] = pint.UnitRegistry(non_int_type=Decimal)
    registry.define("@alias turn = rev")
    return registry
