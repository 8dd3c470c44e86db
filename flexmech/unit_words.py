"""Messages on texts whose unit is unknown or of another dimension."""

from __future__ import annotations

import difflib
import reprlib

from flexmech.dimensions import ANGULAR_SPEED, FREQUENCY, Dimension

__all__ = ["shown", "unknown_unit", "wrong_dimension"]

# What files and options hold may be longer than anybody reads.
_REPR = reprlib.Repr()
_REPR.maxstring = _REPR.maxother = 100


def shown(text: object) -> str:
    """What was given, as a message shows it."""
    return _REPR.repr(text)


def unknown_unit(text: str, unit: str, dimension: Dimension) -> str:
    """Message on a unit that there is not.

    Parameters
    ----------
    text : str
        As it was given.
    unit : str
        In it.
    dimension : Dimension
        What it must be.

    Returns
    -------
    str
    """
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


def wrong_dimension(text: str, unit: str, base: str, dimension: Dimension) -> str:
    """Message on a unit of another dimension.

    Parameters
    ----------
    text : str
        As it was given.
    unit, base : str
        Unit in it, and the same in base units.
    dimension : Dimension
        What it must be.

    Returns
    -------
    str
    """
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
