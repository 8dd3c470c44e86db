"""What users type after an option, to SI values."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING

from flexmech.errors import InputError
from flexmech.units import (
    ANGLE,
    ANGULAR_SPEED,
    LENGTH,
    TIME,
    Dimension,
    Quantities,
    from_si,
    parse_number,
    parse_quantities,
    parse_quantity,
)

if TYPE_CHECKING:
    from flexmech.linkages import CouplerPoint

__all__ = [
    "AUTO",
    "CRANK_ANGLE",
    "MOST_ANGLES",
    "MOST_SPEEDS",
    "parse_angles",
    "parse_option",
    "parse_point",
    "parse_revolutions",
    "parse_run_up",
    "parse_speed",
    "parse_speeds",
    "parse_step",
]

MOST_ANGLES = 100_000
"""More crank angles than this are taken for a slip of the keyboard."""
MOST_SPEEDS = 10_000

CRANK_ANGLE = Dimension("an angle", "deg", ("0:360:5", "45 deg", "0.785 rad"))
"""Whole degrees stay exact if they do not pass through radians."""

# Speeds nearer to each other than this, relatively, are one speed in two units.
_SAME_SPEED = 1e-12

AUTO = "auto"
"""What ``--step`` takes for a step that the analysis chooses."""


def parse_speeds(text: str) -> Quantities:
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
    try:
        found = parse_quantities(text, ANGULAR_SPEED, "rad/s", most=MOST_SPEEDS)
        speeds = sorted(found.values)
        for lower, upper in pairwise(speeds):
            if math.isclose(lower, upper, rel_tol=_SAME_SPEED):
                raise InputError(
                    f"got {text!r}, in which {from_si(upper, found.unit):g} {found.unit} appears "
                    "twice; give each speed once"
                )
    except InputError as error:
        raise error.within("--speeds") from error
    return Quantities(tuple(speeds), found.unit)


def parse_angles(text: str) -> list[float]:
    """Crank angles of ``--angles``.

    Parameters
    ----------
    text : str
        ``START:STOP:STEP`` or a comma list; degrees unless a unit is given. See
        :func:`flexmech.units.parse_quantities`.

    Returns
    -------
    list of float
        In degrees, increasing.

    Raises
    ------
    InputError
        If one is no angle, the range cannot be, or the list does not increase.
    """
    try:
        angles = parse_quantities(text, CRANK_ANGLE, "deg", most=MOST_ANGLES).values
        for before, after in pairwise(angles):
            if not after > before:
                raise InputError(
                    f"got {text!r}, in which {after:g} follows {before:g}; modes are tracked from "
                    "angle to angle, so give each angle once, in increasing order (beyond 360 if "
                    "need be)"
                )
    except InputError as error:
        raise error.within("--angles") from error
    return list(angles)


def parse_option(
    option: str, text: str, dimension: Dimension, default_unit: str | None = None
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

    Returns
    -------
    float
        In the dimension's SI unit.

    Raises
    ------
    InputError
        If it is no such quantity.
    """
    try:
        return parse_quantity(text, dimension, default_unit=default_unit)
    except InputError as error:
        raise error.within(option) from error


def parse_point(text: str) -> CouplerPoint:
    """Coupler point of ``--point``, distance and angle with their units: ``"33 mm,320 deg"``."""
    from flexmech.linkages import CouplerPoint

    parts = [part.strip() for part in text.split(",")]
    try:
        if len(parts) != 2:
            raise InputError(f"got {text!r}, which has {len(parts)} parts")
        distance, angle = parse_quantity(parts[0], LENGTH), parse_quantity(parts[1], ANGLE)
        return CouplerPoint(distance, angle)
    except InputError as error:
        raise InputError(
            f'--point: {error}; write distance and angle, each with its unit, as in "33 mm,320 deg"'
        ) from error


def parse_speed(text: str) -> tuple[float, str]:
    """Crank speed of ``--speed`` in rad/s, and the unit that it was typed in.

    Parameters
    ----------
    text : str
        Such as ``"20"`` or ``"300 rpm"``; rad/s unless a unit is given.

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
    speed = parse_option("--speed", text, ANGULAR_SPEED, "rad/s")
    if speed == 0:
        raise InputError(
            f"--speed: got {text!r}, at which nothing turns; give a crank speed other than zero, "
            f"for example {ANGULAR_SPEED.example} (a negative one turns backwards)"
        )
    return speed, parse_quantities(text, ANGULAR_SPEED, "rad/s").unit


def parse_revolutions(text: str) -> float:
    """Number of ``--revolutions``, which may be a fraction.

    Parameters
    ----------
    text : str

    Returns
    -------
    float

    Raises
    ------
    InputError
        If it is no positive number.
    """
    try:
        revolutions = float(parse_number(text))
    except InputError as error:
        raise InputError(f"--revolutions: {error}") from error
    if revolutions <= 0:
        raise InputError(
            f"--revolutions: got {text!r}, which is not positive; write how many turns to run, "
            "for example 4 or 0.5 (a negative --speed turns backwards)"
        )
    return revolutions


def parse_step(text: str) -> float | None:
    """Time step of ``--step``.

    Parameters
    ----------
    text : str
        ``"auto"`` or a time; seconds unless a unit is given.

    Returns
    -------
    float or None
        In s; None where the analysis is to choose.

    Raises
    ------
    InputError
        If it is neither, or not positive.
    """
    if text.strip() == AUTO:
        return None
    try:
        step = parse_option("--step", text, TIME, "s")
    except InputError as error:
        raise InputError(f"{error}, or {AUTO}") from error
    if step <= 0:
        raise InputError(
            f"--step: got {text!r}, which is not positive; write a time, for example "
            f"{TIME.example}, or {AUTO}"
        )
    return step


def parse_run_up(text: str) -> float:
    """Duration of ``--run-up``.

    Parameters
    ----------
    text : str
        A time; seconds unless a unit is given.

    Returns
    -------
    float
        In s.

    Raises
    ------
    InputError
        If it is no time, or negative.
    """
    duration = parse_option("--run-up", text, TIME, "s")
    if duration < 0:
        raise InputError(
            f"--run-up: got {text!r}, which is negative; write how long the crank takes to reach "
            'its speed, for example "0.2 s"'
        )
    return duration
