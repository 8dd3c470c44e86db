"""Units of universal files: data set 164, the codes of data set 58, and their SI units."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from flexmech.errors import InputError
from flexmech.measured_data.headers import read_header
from flexmech.measured_data.uff_contents import UffQuantity

QUANTITY_CODES: dict[UffQuantity, int] = {
    "none": 0,
    "strain": 3,
    "displacement": 8,
    "velocity": 11,
    "acceleration": 12,
    "force": 13,
}
"""Specific data types of data set 58; a force is one of excitation."""
REACTION_FORCE = 9
# Exponents of length and force; time is in seconds in every universal file.
_EXPONENTS: dict[UffQuantity, tuple[int, int]] = {
    "none": (0, 0),
    "strain": (0, 0),
    "displacement": (1, 0),
    "velocity": (1, 0),
    "acceleration": (1, 0),
    "force": (0, 1),
}
_UNITS: dict[tuple[UffQuantity, UffQuantity], str] = {
    ("none", "none"): "",
    ("strain", "none"): "",
    ("displacement", "none"): "m",
    ("velocity", "none"): "m/s",
    ("acceleration", "none"): "m/s^2",
    ("force", "none"): "N",
    ("displacement", "force"): "m/N",
    ("velocity", "force"): "m/(N s)",
    ("acceleration", "force"): "m/(N s^2)",
    ("strain", "force"): "1/N",
}


class UffUnits(NamedTuple):
    """Numbers of a file's own units in an SI unit (data set 164).

    Parameters
    ----------
    length : float
        In one metre.
    force : float
        In one newton.
    """

    length: float
    force: float


SI = UffUnits(1.0, 1.0)


def quantity_of(code: int) -> UffQuantity:
    """Quantity of a specific data type of data set 58.

    Parameters
    ----------
    code : int

    Returns
    -------
    str
        ``"other"`` for one that has no place here.

    Examples
    --------
    >>> quantity_of(12)
    'acceleration'
    """
    if code == REACTION_FORCE:
        return "force"
    return next((name for name, known in QUANTITY_CODES.items() if known == code), "other")


def si_unit(quantity: UffQuantity, over: UffQuantity = "none") -> str:
    """SI unit of a quantity, or of one over another.

    Parameters
    ----------
    quantity, over : str

    Returns
    -------
    str
        Empty for a ratio.

    Raises
    ------
    InputError
        If no such ratio can be written.
    """
    if quantity == over:
        return ""
    try:
        return _UNITS[quantity, over]
    except KeyError:
        raise InputError(
            f"{quantity} over {over} has no data type in a universal file; give displacement, "
            "velocity, acceleration or strain, alone or over force"
        ) from None


def ordinate_unit(dataset: Mapping[str, Any], units: UffUnits | None) -> tuple[str | None, float]:
    """SI unit of a function that was read, and the SI value of one of the file's units.

    The codes of the data types and data set 164 tell it; without data set 164 the labels of the
    axes do, where they are units.

    Parameters
    ----------
    dataset : mapping
        Data set 58 as pyuff gives it.
    units : UffUnits, optional
        None where the file has no data set 164.

    Returns
    -------
    tuple of str or None and float
        None where nothing tells a unit.
    """
    quantity = quantity_of(int(dataset["ordinate_spec_data_type"]))
    over = quantity_of(int(dataset["orddenom_spec_data_type"]))
    known = (quantity, over) in _UNITS or (quantity == over and quantity != "other")
    if int(dataset["func_type"]) == 6:  # a coherence has no unit, whatever its axes are called
        return "", 1.0
    if known and si_unit(quantity, over) == "" and quantity != "none":
        return "", 1.0
    if units is not None and known and quantity != "none":
        length, force = _EXPONENTS[quantity]
        per_length, per_force = _EXPONENTS[over]
        factor = units.length ** (length - per_length) * units.force ** (force - per_force)
        return si_unit(quantity, over), 1.0 / factor
    numerator = _label(dataset, "ordinate")
    if numerator is None:
        return None, 1.0
    denominator = _label(dataset, "orddenom")
    text = numerator if denominator is None else f"({numerator})/({denominator})"
    try:
        header = read_header(f"{dataset['id1'] or 'function'} [{text}]")
    except InputError:
        return None, 1.0
    return header.unit, header.factor


def _label(dataset: Mapping[str, Any], axis: str) -> str | None:
    text = str(dataset.get(f"{axis}_axis_units_lab", "")).strip()
    return text if text and text.upper() != "NONE" else None
