"""How records are written: in one line that says what they are, and as tables of a model file.

Text is exact: it reads back to the float that it was written from, to the last bit.
"""

from __future__ import annotations

import re
from dataclasses import fields, is_dataclass
from decimal import Context, Decimal
from typing import Any

import numpy as np

from flexmech import units
from flexmech.unit_registry import base_units, zero_of_scale
from flexmech.units import Dimension, parse_quantity

TomlTable = dict[str, Any]

# Most characters of a line that says what an object is: two lines of a terminal.
_MOST_CHARACTERS = 160

# Units that are read more easily than the SI unit, the best first.
_READABLE = {
    units.LENGTH: ("mm",),
    units.MASS: ("g",),
    units.ANGLE: ("deg",),
    units.ANGULAR_SPEED: ("rad/s", "rpm"),
    units.STRESS: ("GPa", "MPa"),
    units.PRESSURE_VELOCITY: ("MPa m/s",),
    units.MASS_PER_LENGTH: ("g/m",),
    units.TEMPERATURE: ("degC",),
    units.MOISTURE_EXPANSION: ("1/percent",),
    units.ACTIVATION_ENERGY: ("kJ/mol",),
}
# Tables with names, those that others refer to first.
_KINDS = ("materials", "fibres", "matrices", "plies", "laminates")
# Numbers that need no exponent, and no more than six digits before the point or two zeros after it.
_LEAST, _MOST = Decimal("1e-3"), Decimal("1e6")
# Digits of every float's shortest text, and fewer, which unites what rounding has parted; with
# more every float reads back from any unit.
_DIGITS = (15, 17, 20)


def quantity(
    value: float, dimension: Dimension, unit: str = "", *, always: bool = False
) -> str | float:
    """Write a quantity so that it reads back bit-equal, as short as its readable units allow.

    Parameters
    ----------
    value : float
        In SI units.
    dimension : Dimension
    unit : str
        Preferred to those that are read easily.
    always : bool
        Whether it stands in that unit wherever it can without an exponent, however long.

    Returns
    -------
    str or float
        Such as ``"279.4 mm"``; a ratio as a number.
    """
    # A zero has no sign in a file.
    value = float(value) + 0.0
    if dimension is units.RATIO:
        return value
    if always and (written := _number_in(value, unit, dimension)) is not None:
        return f"{written:f} {unit}"
    preferred = (unit,) if unit else ()
    texts = [
        (len(number.as_tuple().digits), abs(number) < 1, f"{number:f} {each}")
        for each in (*preferred, *_READABLE.get(dimension, ()), dimension.unit)
        if (number := _number_in(value, each, dimension)) is not None
    ]
    # The first of the shortest ones.
    return min(texts, key=lambda text: text[:2])[2] if texts else f"{value!r} {dimension.unit}"


def stated(**quantities: tuple[float | None, Dimension]) -> TomlTable:
    """Table of the quantities that are known, by their keys."""
    return {
        key: quantity(value, dimension)
        for key, (value, dimension) in quantities.items()
        if value is not None
    }


def _number_in(value: float, unit: str, dimension: Dimension) -> Decimal | None:
    """Shortest number that reads back as the value in a unit; None if it needs an exponent."""
    found, base = base_units(unit), base_units(dimension.unit)
    assert found is not None
    assert base is not None
    number = Decimal(repr(value)) * base.factor / found.factor
    if dimension is units.TEMPERATURE:
        number -= zero_of_scale(unit)
    if number and not _LEAST <= abs(number) < _MOST:
        return None
    for digits in _DIGITS:
        short = Context(prec=digits).create_decimal(number).normalize()
        if parse_quantity(f"{short:f} {unit}", dimension) == value:
            return short
    return None


class SharedTables:
    """Tables of a model file that others refer to by name; equal ones stand once."""

    def __init__(self) -> None:
        self.kinds: dict[str, dict[str, TomlTable]] = {}
        self._left: set[tuple[str, str]] = set()

    @property
    def in_order(self) -> dict[str, dict[str, TomlTable]]:
        """Tables by kind, those that others refer to first."""
        return {kind: self.kinds[kind] for kind in _KINDS if kind in self.kinds}

    def leave(self, kind: str, name: str) -> bool:
        """Whether a name can keep what it means without a table; none takes it from now on."""
        if name in self.kinds.get(kind, {}):
            return False
        self._left.add((kind, name))
        return True

    def name_of(
        self,
        kind: str,
        table: TomlTable,
        wanted: str,
        *,
        own_name: str | None = None,
    ) -> str:
        """Name under which a table stands; it is added where it does not stand yet.

        Parameters
        ----------
        kind : str
            Such as ``materials``.
        table : dict
        wanted : str
            Name that says best what it is.
        own_name : str, optional
            Name of what the table describes; written into it where the table's is another.

        Returns
        -------
        str
        """
        tables = self.kinds.setdefault(kind, {})
        stem = re.sub(r"[^\w.-]+", "_", wanted).strip("_") or kind
        name, number = stem, 1
        while True:
            stated = table if own_name in (None, name) else {"name": own_name, **table}
            if (kind, name) not in self._left and tables.setdefault(name, stated) == stated:
                return name
            number += 1
            name = f"{stem}_{number}"


def short_repr(record: object, *words: str) -> str:
    """Describe an object in one line: its class, and words that are not empty."""
    line = " ".join(", ".join(word for word in words if word).split())
    if len(line) > _MOST_CHARACTERS:
        line = f"{line[:_MOST_CHARACTERS]}..."
    return f"<{type(record).__name__}: {line}>"


def shapes(record: object) -> tuple[str, ...]:
    """Words for the arrays that a record of the fields of a dataclass holds."""
    assert is_dataclass(record)
    values = ((field.name, getattr(record, field.name)) for field in fields(record))
    return tuple(f"{name} {value.shape}" for name, value in values if isinstance(value, np.ndarray))
