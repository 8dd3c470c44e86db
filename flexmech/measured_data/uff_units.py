"""Units of universal files: data set 164, the codes of data set 58, and their SI units."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from flexmech.errors import InputError
from flexmech.measured_data.headers import read_header
from flexmech.measured_data.uff_contents import UffQuantity


class _Quantity(NamedTuple):
    """Specific data type of data set 58, SI unit, alone and over a force, and exponents in that.

    Time is in seconds in every universal file; of a ratio that has no data type no unit is known.
    """

    code: int
    unit: str
    over_force: str | None = None
    length: int = 0
    force: int = 0


# What functions of universal files are of; a force is one of excitation.
QUANTITIES: dict[UffQuantity, _Quantity] = {
    "none": _Quantity(0, ""),
    "strain": _Quantity(3, "", "1/N"),
    "displacement": _Quantity(8, "m", "m/N", length=1),
    "velocity": _Quantity(11, "m/s", "m/(N s)", length=1),
    "acceleration": _Quantity(12, "m/s^2", "m/(N s^2)", length=1),
    "force": _Quantity(13, "N", force=1),
}
# The other kind of force in the format: what is measured of a support is as good.
REACTION_FORCE = 9


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
    return next((name for name, known in QUANTITIES.items() if known.code == code), "other")


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
    unit = _unit(quantity, over)
    if unit is None:
        raise InputError(
            f"{quantity} over {over} has no data type in a universal file; give displacement, "
            "velocity, acceleration or strain, alone or over force"
        )
    return unit


def _unit(quantity: UffQuantity, over: UffQuantity) -> str | None:
    if quantity == over:
        return ""
    known = QUANTITIES.get(quantity)
    if known is None or over not in ("none", "force"):
        return None
    return known.unit if over == "none" else known.over_force


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
    unit = None if "other" in (quantity, over) else _unit(quantity, over)
    if int(dataset["func_type"]) == 6:  # a coherence has no unit, whatever its axes are called
        return "", 1.0
    if unit == "" and quantity != "none":
        return "", 1.0
    if units is not None and unit is not None and quantity != "none":
        of, per = QUANTITIES[quantity], QUANTITIES[over]
        factor = units.length ** (of.length - per.length) * units.force ** (of.force - per.force)
        return unit, 1.0 / factor
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
