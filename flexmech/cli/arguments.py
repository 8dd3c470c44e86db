"""What users type after an option, to SI values."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from itertools import pairwise
from typing import TYPE_CHECKING

from flexmech import units
from flexmech.cli.failures import naming
from flexmech.errors import InputError
from flexmech.plausible import RUN_UP, Plausible, check_plausible, of_dimension

if TYPE_CHECKING:
    from flexmech.linkages import CouplerPoint

MOST_ANGLES = 100_000
"""More crank angles than this are taken for a slip of the keyboard."""
MOST_SPEEDS = 10_000
MOST_DEGREES = 2880
MOST_ORDER = 1000
"""Of the crank's speed in a Campbell diagram."""
DOUBTFUL_SPEED = 200.0
"""In rad/s: a bare number beyond may be meant in turns a minute."""

CRANK_ANGLE = units.Dimension("an angle", "deg", ("0:360:5", "45 deg", "0.785 rad"))
"""Whole degrees stay exact if they do not pass through radians."""

# Speeds nearer to each other than this, relatively, are one speed in two units.
_SAME_SPEED = 1e-12

AUTO = "auto"
"""What ``--step`` takes for a step that the analysis chooses."""


def parse_option(
    option: str,
    text: str,
    dimension: units.Dimension,
    default_unit: str | None = None,
    plausible: Plausible | None = None,
) -> float:
    """Quantity of an option.

    Parameters
    ----------
    option : str
        Its name, for messages.
    text : str
    dimension : Dimension
    default_unit : str, optional
        Unit of a bare number; without it such a number is refused.
    plausible : Plausible, optional
        What sizes it can have; those of its dimension if left out.

    Returns
    -------
    float
        In the dimension's SI unit.

    Raises
    ------
    InputError
        If it is no such quantity, or of a size that none has.
    """
    with naming(option):
        return _plausible(text, dimension, default_unit, plausible)


def parse_speeds(text: str) -> units.Quantities:
    """Crank speeds of ``--speeds``.

    Parameters
    ----------
    text : str
        Comma list such as ``"0,50,100 rpm"`` or range START:STOP:STEP; rad/s unless a unit is
        given. See :func:`flexmech.units.parse_quantities`.

    Returns
    -------
    Quantities
        In rad/s, ascending.

    Raises
    ------
    InputError
        If one is no angular speed or appears twice, or the range cannot be.
    """
    with naming("--speeds"):
        found = units.parse_quantities(text, units.ANGULAR_SPEED, "rad/s", most=MOST_SPEEDS)
        speeds = sorted(found.values)
        for speed in (speeds[0], speeds[-1]):
            _check_speed(speed, text)
        for lower, upper in pairwise(speeds):
            if math.isclose(lower, upper, rel_tol=_SAME_SPEED):
                typed = f"{units.from_si(upper, found.unit):g} {found.unit}"
                raise InputError(
                    f"got {text!r}, in which {typed} appears twice; give each speed once"
                )
    return units.Quantities(tuple(speeds), found.unit)


def parse_angles(text: str, option: str = "--angles") -> list[float]:
    """Crank angles of an option such as ``--angles``.

    Parameters
    ----------
    text : str
        ``START:STOP:STEP`` or a comma list; degrees unless a unit is given. See
        :func:`flexmech.units.parse_quantities`.
    option : str
        For messages.

    Returns
    -------
    list of float
        In degrees, increasing.

    Raises
    ------
    InputError
        If one is no angle, the range cannot be, or the list does not increase.
    """
    with naming(option):
        angles = units.parse_quantities(text, CRANK_ANGLE, "deg", most=MOST_ANGLES).values
        if max(map(abs, angles)) > MOST_DEGREES:
            raise InputError(
                f"got {text!r}, which goes beyond {MOST_DEGREES} deg; positions repeat every "
                "turn, so give angles of the first eight turns"
            )
        for before, after in pairwise(angles):
            if not after > before:
                raise InputError(
                    f"got {text!r}, in which {after:g} follows {before:g}; modes are tracked from "
                    "angle to angle, so give each angle once, in increasing order (beyond 360 if "
                    "need be)"
                )
    return list(angles)


def parse_angle(text: str, option: str = "--angle") -> float:
    """One crank angle of an option in degrees, which are its unit by default; see parse_angles."""
    angle = parse_option(option, text, CRANK_ANGLE, "deg")
    if abs(angle) > MOST_DEGREES:
        raise InputError(
            f"{option}: got {text!r}, which goes beyond {MOST_DEGREES} deg; positions repeat every "
            "turn, so give an angle of the first eight turns"
        )
    return angle


def parse_orders(text: str) -> list[int]:
    """Orders of ``--orders``: ``START:STOP``, ``START:STOP:STEP`` or a comma list.

    Parameters
    ----------
    text : str
        Such as ``"1:10"``, ``"2:12:2"`` or ``"1,2,4"``.

    Returns
    -------
    list of int
        Ascending.

    Raises
    ------
    InputError
        If one is no whole number from 1 on, or appears twice, or the range cannot be.
    """
    remedy = 'write whole numbers from 1 on: "1:10", or with a step "2:12:2", or a list "1,2,4"'
    separator = ":" if ":" in text else ","
    with naming("--orders"):
        parts = [units.parse_number(part) for part in text.split(separator)]
        if any(part != int(part) or not 1 <= part <= MOST_ORDER for part in parts):
            raise InputError(f"got {text!r}; {remedy} (up to {MOST_ORDER})")
        whole = [int(part) for part in parts]
        if separator == ":":
            if len(whole) not in (2, 3) or whole[1] < whole[0]:
                raise InputError(f"got {text!r}, which is no range; {remedy}")
            return list(range(whole[0], whole[1] + 1, *whole[2:]))
        if len(set(whole)) < len(whole):
            raise InputError(f"got {text!r}, which repeats an order; give each one once")
        return sorted(whole)


def parse_point(text: str) -> CouplerPoint:
    """Coupler point of ``--point``, distance and angle with their units: ``"33 mm,320 deg"``."""
    from flexmech.linkages import CouplerPoint

    parts = [part.strip() for part in text.split(",")]
    try:
        if len(parts) != 2:
            raise InputError(f"got {text!r}, which has {len(parts)} parts")
        distance = _plausible(parts[0], units.LENGTH)
        return CouplerPoint(distance, _plausible(parts[1], units.ANGLE))
    except InputError as error:
        raise InputError(
            f'--point: {error}; write distance and angle, each with its unit, as in "33 mm,320 deg"'
        ) from error


def parse_speed(text: str, option: str = "--speed") -> tuple[float, str]:
    """Crank speed of an option in rad/s, and the unit that it was typed in.

    Parameters
    ----------
    text : str
        Such as ``"20"`` or ``"300 rpm"``; rad/s unless a unit is given.
    option : str

    Returns
    -------
    float
        In rad/s; negative turns backwards.
    str

    Raises
    ------
    InputError
        If it is no angular speed, or zero.
    """
    speed, unit = parse_crank_speed(text, option)
    if speed == 0:
        raise InputError(
            f"{option}: got {text!r}, at which nothing turns; give a crank speed other than zero, "
            f"for example {units.ANGULAR_SPEED.example} (a negative one turns backwards)"
        )
    return speed, unit


def parse_crank_speed(text: str, option: str = "--speed") -> tuple[float, str]:
    """Crank speed of an option in rad/s, which may be zero, and the unit that it was typed in.

    Parameters
    ----------
    text : str
        Such as ``"20"`` or ``"190 rpm"``; rad/s unless a unit is given.
    option : str

    Returns
    -------
    float
        In rad/s; negative turns backwards.
    str

    Raises
    ------
    InputError
        If it is no angular speed.
    """
    speed = parse_option(option, text, units.ANGULAR_SPEED, "rad/s")
    return speed, units.parse_quantities(text, units.ANGULAR_SPEED, "rad/s").unit


def parse_lumped(text: str) -> tuple[int, ...]:
    """Elements of each link of ``--lumped``.

    Parameters
    ----------
    text : str
        Such as ``"1,4,4"``.

    Returns
    -------
    tuple of int

    Raises
    ------
    InputError
        If one is no whole number of one or more.
    """
    counts = [part.strip() for part in text.split(",")]
    if not all(re.fullmatch(r"0*[1-9][0-9]{0,3}", count, re.ASCII) for count in counts):
        raise InputError(
            f"--lumped: got {text!r}; give the elements of each link, whole numbers of one or "
            "more with commas between them, for example 1,4,4"
        )
    return tuple(map(int, counts))


def parse_revolutions(text: str) -> float:
    """Number of ``--revolutions``; positive, and may be a fraction."""
    with naming("--revolutions"):
        revolutions = float(units.parse_number(text))
        if revolutions <= 0:
            raise InputError(
                f"got {text!r}, which is not positive; write how many turns to run, for example "
                "4 or 0.5 (a negative --speed turns backwards)"
            )
    return revolutions


def parse_step(text: str) -> float | None:
    """Time step of ``--step`` in s, which is its unit by default; None for ``"auto"``."""
    if text.strip() == AUTO:
        return None
    try:
        step = parse_option("--step", text, units.TIME, "s")
        if step <= 0:
            raise InputError(
                f"--step: got {text!r}, which is not positive; write a time, for example "
                f"{units.TIME.example}"
            )
    except InputError as error:
        raise InputError(f"{error}, or {AUTO}") from error
    return step


def parse_run_up(text: str) -> float:
    """Duration of ``--run-up`` in s, which is its unit by default; zero or positive."""
    duration = parse_option("--run-up", text, units.TIME, "s", RUN_UP)
    if duration < 0:
        raise InputError(
            f"--run-up: got {text!r}, which is negative; write how long the crank takes to reach "
            'its speed, for example "0.2 s"'
        )
    return duration


def parse_time(text: str) -> float:
    """Time of exposure of ``--time`` in s; it needs a unit, and is zero or positive."""
    time = parse_option("--time", text, units.TIME)
    if time < 0:
        raise InputError(f"--time: must be zero or positive, got {text!r}")
    return time


def parse_temperature(text: str) -> float:
    """Temperature of ``--temperature`` in K, degrees Celsius unless a unit is given."""
    kelvin = parse_option("--temperature", text, units.TEMPERATURE, "degC")
    if kelvin <= 0:
        raise InputError(f"--temperature: must be above absolute zero, got {text!r}")
    return kelvin


def parse_percent(option: str, text: str) -> float:
    """Fraction of an option in percent, ``"7"`` or ``"7 %"``: 0.07; from 0 to 1."""
    unit = next((unit for unit in ("percent", "%") if text.strip().endswith(unit)), "")
    try:
        percent = float(units.parse_number(text.strip().removesuffix(unit)))
    except InputError as error:
        raise InputError(f"{option}: {error} (in percent)") from error
    if not 0 <= percent <= 100:
        raise InputError(f"{option}: must lie between 0 and 100 percent, got {text!r}")
    return percent / 100


def speed_remark(option: str, text: str, speeds: Iterable[float]) -> str:
    """Say how many turns a minute a bare number is that is large for rad/s.

    Parameters
    ----------
    option : str
    text : str
        As it was typed.
    speeds : iterable of float
        In rad/s.

    Returns
    -------
    str
        Empty where a unit was typed, or none is fast.
    """
    fastest = max(map(abs, speeds))
    if fastest < DOUBTFUL_SPEED or re.search(r"[a-df-zA-DF-Z]", text):
        return ""
    return (
        f"remark: {fastest:.6g} rad/s is {units.from_si(fastest, 'rpm'):.5g} rpm; for turns a "
        f'minute write {option} "{text.strip()} rpm"'
    )


def _check_speed(speed: float, text: str) -> None:
    """Refuse a crank speed that no machine has; its remedy is told in turns a minute."""
    sizes = of_dimension(units.ANGULAR_SPEED)
    if sizes is not None and not sizes.holds(speed):
        raise InputError(
            f"got {text!r}, but {sizes.words}, 9.5e6 rpm; a bare number is in rad/s, check its unit"
        )


def _plausible(
    text: str,
    dimension: units.Dimension,
    default_unit: str | None = None,
    plausible: Plausible | None = None,
) -> float:
    value = units.parse_quantity(text, dimension, default_unit=default_unit)
    if (sizes := plausible or of_dimension(dimension)) is not None:
        check_plausible(value, text, sizes)
    return value
