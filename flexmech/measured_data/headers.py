"""Headers of a record's columns: a name and a unit, as flexmech or a laboratory writes them."""

from __future__ import annotations

import re
from math import radians
from typing import NamedTuple

from flexmech.errors import InputError
from flexmech.unit_registry import base_units

RATIO = ""
# SI unit and factor of the units that need no pint, whose first import takes a second.
_KNOWN: dict[str, tuple[str, float]] = {
    unit: (si, size)
    for si, sizes in {
        "s": {"ms": 1e-3, "us": 1e-6},
        "Hz": {"kHz": 1e3},
        "rad": dict.fromkeys(("deg", "°", "degree", "degrees"), radians(1.0)),
        "m": {"mm": 1e-3, "um": 1e-6},
        "N m": {"Nm": 1.0},
        "m/s^2": {},
        **{si: {} for si in ("N", "m/s", "rad/s", "m/N", "m/(N s)", "m/(N s^2)")},
        RATIO: {
            **dict.fromkeys(("m/m", "1", "-"), 1.0),
            "%": 1e-2,
            **dict.fromkeys(("um/m", "ustrain", "microstrain", "uε", "ue", "1e-6"), 1e-6),
        },
    }.items()
    for unit, size in {si: 1.0, **sizes}.items()
}
# Behind a name, as flexmech's own files have them: coupler_mid_deflection_m, crank_angle_deg.
_SUFFIXES: dict[str, str] = {
    **{name: name for name in ("s", "ms", "us", "Hz", "kHz", "deg", "rad", "m", "mm", "um", "N")},
    "Nm": "N m",
    "um_m": "um/m",
    "m_N": "m/N",
    "m_s": "m/s",
    "m_s2": "m/s^2",
    "rad_s": "rad/s",
    "m_Ns": "m/(N s)",
    "m_Ns2": "m/(N s^2)",
}
# By the names of base units, what units are called here.
_SI_NAMES = {
    "second": "s",
    "1 / second": "Hz",
    "radian": "rad",
    "radian / second": "rad/s",
    "meter": "m",
    "meter / second": "m/s",
    "meter / second ** 2": "m/s^2",
    "dimensionless": RATIO,
    "kilogram * meter / second ** 2": "N",
    "kilogram * meter ** 2 / second ** 2": "N m",
    "second ** 2 / kilogram": "m/N",
    "second ** 2 / kilogram / meter": "1/N",
    "second / kilogram": "m/(N s)",
    "1 / kilogram": "m/(N s^2)",
}
# Quantities that are ratios by nature, so that flexmech's own files write no unit for them.
_RATIOS = re.compile(r"(.*_)?(strain|coherence|mode|damping_ratio|order|turn|mac)")
_BRACKETS = re.compile(r"(?P<name>.*?)\s*(\[(?P<square>[^\]]*)\]|\((?P<round>.*)\))")
_QUOTIENT = re.compile(r"(?P<name>.*?\S)\s+/\s+(?P<unit>\S.*)")
# A "g" behind the name of an acceleration, alone or over a force, is standard gravity and no gram.
_ACCELERATION = re.compile(r"acc|inertance", re.IGNORECASE)
_GRAVITY = re.compile(r"(?<![\w.])([mu]?)[gG](_?[n0])?(?!\w)")
# "s2" and "sec2" are squares of a second.
_SECONDS = re.compile(r"(?<![\w.])(s|sec)2(?!\w)")
# Both signs for micro, Greek and Latin, and the Greek epsilon of strains.
_MICRO = str.maketrans({"µ": "u", "μ": "u", "ϵ": "ε", "·": " ", "⋅": " "})


class Header(NamedTuple):
    """Name and unit of a column.

    Parameters
    ----------
    name : str
        Without the unit; blanks are underscores.
    unit : str or None
        SI unit, empty for a ratio; None where none is written.
    factor : float
        SI value of one of the column's own units.
    """

    name: str
    unit: str | None
    factor: float


def read_header(text: str) -> Header:
    """Read the header of a column.

    Parameters
    ----------
    text : str
        Such as ``"time_s"``, ``"coupler_mid_deflection_m"``, ``"time [s]"``,
        ``"strain (um/m)"`` or ``"time / ms"``.

    Returns
    -------
    Header

    Raises
    ------
    InputError
        If a unit is written that is none.

    Examples
    --------
    >>> read_header("strain (um/m)")
    Header(name='strain', unit='', factor=1e-06)
    >>> read_header("acceleration [g]")
    Header(name='acceleration', unit='m/s^2', factor=9.80665)
    """
    bare = text.strip()
    if match := _BRACKETS.fullmatch(bare):
        unit = match["square"] if match["square"] is not None else match["round"]
        return Header(_name(match["name"]), *_unit(unit, bare, match["name"]))
    if match := _QUOTIENT.fullmatch(bare):
        unit = match["unit"].strip("()")
        return Header(_name(match["name"]), *_unit(unit, bare, match["name"]))
    for suffix in sorted(_SUFFIXES, key=len, reverse=True):
        if bare.endswith(f"_{suffix}") and len(bare) > len(suffix) + 1:
            return Header(_name(bare[: -len(suffix) - 1]), *_unit(_SUFFIXES[suffix], bare))
    name = _name(bare)
    return Header(name, RATIO if _RATIOS.fullmatch(name.lower()) else None, 1.0)


def _name(text: str) -> str:
    return re.sub(r"\s+", "_", text.strip())


def _unit(text: str, header: str, name: str = "") -> tuple[str, float]:
    """SI unit of a written unit, and the SI value of one of it."""
    unit = text.strip().translate(_MICRO)
    if _ACCELERATION.search(name):
        unit = _GRAVITY.sub(r"\1standard_gravity", unit)
    unit = _SECONDS.sub(r"\1^2", unit)
    if unit == "uepsilon":
        unit = "microstrain"
    if unit and unit in _KNOWN:
        return _KNOWN[unit]
    known = base_units(unit) if unit else None
    if known is None:
        raise InputError(
            f"the unit {text.strip()!r} of the column {header!r} is unknown; write one such as s, "
            "mm, um/m, deg or m/N in brackets behind the name, and [-] for a ratio"
        )
    return _SI_NAMES.get(known.name, known.name), float(known.factor)
