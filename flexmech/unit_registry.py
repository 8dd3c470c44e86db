"""What a unit is in SI base units, by pint: the ground that units and error messages stand on.

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
# Units of which a number is the same in SI. They need no pint, whose first import takes longer
# than small analyses.
_SAME_IN_SI = frozenset({"", "m", "rad", "rad/s", "s", "kg", "Hz"})


class BaseUnits(NamedTuple):
    """A unit in base units: how many of which."""

    factor: Decimal
    name: str


@cache
def base_units(unit: str) -> BaseUnits | None:
    """Write a unit in base units, such as 0.01745 radian for "deg"; None where it is none.

    Pint takes 5 ms for each.
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
    """What a temperature scale counts from, above absolute zero, in its own degrees."""
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
    """Make the one registry when a unit is first met: importing pint takes a second."""
    import pint

    registry: pint.UnitRegistry[Any] = pint.UnitRegistry(non_int_type=Decimal)
    registry.define("@alias turn = rev")
    return registry
