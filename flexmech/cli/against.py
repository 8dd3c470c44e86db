"""The second parameter of ``flexmech stability`` and its range, as users type them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexmech import units
from flexmech.cli.failures import naming
from flexmech.errors import InputError, suggestion

if TYPE_CHECKING:
    from flexmech.mechanism import Mechanism


AUTO = "auto"
MOST_STEPS = 999
# Bare numbers are percent, as those of --moisture are.
IN_PERCENT = "moisture"


def parse_against(
    mechanism: Mechanism, typed: tuple[str, str] | None
) -> tuple[str, list[float]] | None:
    """Parameter and values of ``--against``.

    Parameters
    ----------
    mechanism : Mechanism
        Whose model file names parameters.
    typed : tuple of str, optional
        A parameter and START:STOP:STEPS, which are STEPS equal steps from START to STOP, both
        included; or a comma list. One unit at the end of STOP covers START too. Bare numbers are
        ratios, kelvins, percent of moisture, or SI values of what needs no unit; others are
        refused.

    Returns
    -------
    tuple of str and list of float
        In SI units; None where nothing was typed.

    Raises
    ------
    InputError
        If there is no such parameter, or the range cannot be.
    """
    if typed is None:
        return None
    from flexmech.analyses.stability import parameters_of

    parameter, text = typed
    known = parameters_of(mechanism)
    with naming("--against"):
        if parameter not in known:
            raise InputError(
                f"there is no parameter {parameter!r}; {suggestion(parameter, list(known))}"
            )
        return parameter, _values(parameter, text, known[parameter])


def parse_damping_ratio(text: str | None) -> float | None:
    """Damping ratio of ``--damping-ratio``, ``"0.1 %"`` or ``"0.001"``; None where left out."""
    if text is None:
        return None
    with naming("--damping-ratio"):
        ratio = units.parse_quantity(text, units.RATIO)
        if not 0 <= ratio < 1:
            raise InputError(
                f'must be at least 0 and less than 1, got {text!r}; write "0.1%" or 0.001 for a '
                "tenth of a percent"
            )
    return ratio


def parse_steps(text: str) -> int | None:
    """Steps a turn of ``--steps``; None for ``"auto"``."""
    if text.strip() == AUTO:
        return None
    with naming("--steps"):
        try:
            number = units.parse_number(text)
            if number != int(number):
                raise InputError(f"got {text!r}, which is no whole number")
        except InputError as error:
            raise InputError(f"{error}; write a multiple of 16, such as 256, or {AUTO}") from error
    return int(number)


def _values(parameter: str, text: str, dimension: units.Dimension) -> list[float]:
    percent = parameter == IN_PERCENT
    default = "%" if percent else _default_unit(dimension)
    if ":" not in text:
        return list(_list(text, dimension, default))
    parts = [part.strip() for part in text.split(":")]
    remedy = 'write START:STOP:STEPS, as in "0:2%:20" for 20 equal steps from 0 to 2 %'
    if len(parts) != 3 or not all(parts):
        raise InputError(f"got {text!r}; {remedy}, or a comma list")
    start, stop = _list(",".join(parts[:2]), dimension, default)
    try:
        steps = units.parse_number(parts[2])
    except InputError as error:
        raise InputError(
            f"got {text!r}, whose last part is not a number of steps; {remedy}"
        ) from error
    if steps != int(steps) or not 1 <= steps <= MOST_STEPS:
        raise InputError(
            f"got {text!r}; STEPS must be a whole number from 1 to {MOST_STEPS}; {remedy}"
        )
    if not stop > start:
        raise InputError(f"got {text!r}; STOP must be greater than START; {remedy}")
    count = int(steps)
    return [start + (stop - start) * number / count for number in range(count)] + [stop]


def _list(text: str, dimension: units.Dimension, default: str | None) -> tuple[float, ...]:
    if default is None:
        # Without a unit it is refused, with an example.
        last = text.split(",")[-1]
        units.parse_quantity(last.strip(), dimension)
        default = dimension.unit
    return units.parse_quantities(text, dimension, default).values


def _default_unit(dimension: units.Dimension) -> str | None:
    """Unit of a bare number; None where it must be written."""
    if dimension is units.TEMPERATURE_DIFFERENCE:
        return "K"
    return "" if not dimension.unit else None
