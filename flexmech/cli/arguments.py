"""What users type after an option, to SI values: speeds and angles; and choices."""

from __future__ import annotations

import math
from decimal import Decimal
from enum import StrEnum
from itertools import pairwise
from pathlib import Path
from typing import Annotated

import typer

from flexmech.errors import InputError
from flexmech.units import ANGULAR_SPEED, parse_number, parse_quantity

__all__ = [
    "MOST_ANGLES",
    "Angles",
    "LinkageKind",
    "MapPrestress",
    "Model",
    "NoPlots",
    "Out",
    "Prestress",
    "parse_angles",
    "parse_speeds",
]

MOST_ANGLES = 100_000
"""More crank angles than this are taken for a slip of the keyboard."""

# A range hits its end when it comes this close, in steps: 0:1:0.333333 means thirds.
_HIT = Decimal("1e-5")

# Speeds nearer to each other than this, relatively, are one speed in two units.
_SAME_SPEED = 1e-12

Model = Annotated[Path, typer.Argument(help="Model file.", metavar="MODEL")]
Out = Annotated[Path, typer.Option(help="Folder for the files.", metavar="DIR")]
NoPlots = Annotated[bool, typer.Option("--no-plots", help="Write no pictures.")]
Angles = Annotated[
    str, typer.Option(help="Crank angles in degrees: START:STOP:STEP, or a comma list.")
]


class Prestress(StrEnum):
    """Choices of ``--prestress``."""

    none = "none"
    axial = "axial"
    equilibrium = "equilibrium"


class MapPrestress(StrEnum):
    """Choices of ``--prestress`` where a simulation's states count as well."""

    none = "none"
    axial = "axial"
    equilibrium = "equilibrium"
    trajectory = "trajectory"


class LinkageKind(StrEnum):
    """Kinds of model files that ``flexmech new`` writes."""

    four_bar = "four-bar"
    composite_four_bar = "composite-four-bar"
    rotating_arm = "rotating-arm"


def parse_speeds(text: str) -> list[float]:
    """Crank speeds of ``--speeds``.

    Parameters
    ----------
    text : str
        Comma list such as ``"0,10 rad/s,300 rpm"``; rad/s unless a unit is given.

    Returns
    -------
    list of float
        In rad/s, ascending.

    Raises
    ------
    InputError
        If one is no angular speed or appears twice.
    """
    speeds = []
    for item in text.split(","):
        if not item.strip():
            raise InputError(
                f"--speeds: got {text!r}, in which a value is missing; write a comma list, for "
                'example "0,10,300 rpm"'
            )
        try:
            speeds.append(parse_quantity(item.strip(), ANGULAR_SPEED, default_unit="rad/s"))
        except InputError as error:
            raise InputError(f"--speeds: {error}") from error
    speeds.sort()
    for lower, upper in pairwise(speeds):
        if math.isclose(lower, upper, rel_tol=_SAME_SPEED):
            raise InputError(
                f"--speeds: got {text!r}, in which {upper:g} rad/s appears twice; give each "
                "speed once"
            )
    return speeds


def parse_angles(text: str) -> list[float]:
    """Crank angles of ``--angles``.

    Parameters
    ----------
    text : str
        ``START:STOP:STEP`` or a comma list, in degrees. STOP is included when a whole number
        of steps leads to it.

    Returns
    -------
    list of float
        In degrees, increasing. Counted in decimal, so that nothing adds up: 0:360:0.1 ends
        with 359.9 and 360 exactly.

    Raises
    ------
    InputError
        If the range is empty, endless or too long, or the list does not increase.
    """
    if ":" in text:
        return _angle_range(text)
    angles = [_angle(text, item) for item in text.split(",")]
    for before, after in pairwise(angles):
        if not after > before:
            raise InputError(
                f"--angles: got {text!r}, in which {after:g} follows {before:g}; modes are "
                "tracked from angle to angle, so give each angle once, in increasing order "
                "(beyond 360 if need be)"
            )
    return [float(angle) for angle in angles]


def _angle_range(text: str) -> list[float]:
    parts = text.split(":")
    if len(parts) != 3:
        raise InputError(
            f"--angles: got {text!r}, which has {len(parts)} parts; write START:STOP:STEP, for "
            'example "0:360:5"'
        )
    start, stop, step = (_angle(text, part) for part in parts)
    if step <= 0:
        raise InputError(f"--angles: got {text!r}; STEP must be positive, for example 0:360:5")
    if stop < start:
        raise InputError(
            f"--angles: got {text!r}; STOP must not be less than START, for example -90:90:5"
        )
    steps = (stop - start) / step
    if steps >= MOST_ANGLES:
        raise InputError(
            f"--angles: got {text!r}, which is {steps:.6g} steps; choose a STEP that gives at "
            f"most {MOST_ANGLES} angles"
        )
    count = int(steps + _HIT)
    angles = [float(start + number * step) for number in range(count + 1)]
    if abs(steps - count) <= _HIT:
        angles[-1] = float(stop)
    return angles


def _angle(text: str, item: str) -> Decimal:
    if not item.strip():
        raise InputError(
            f"--angles: got {text!r}, in which a value is missing; write START:STOP:STEP, for "
            'example "0:360:5", or a comma list such as "0,60,120"'
        )
    try:
        return parse_number(item)
    except InputError as error:
        raise InputError(f"--angles: {error} (plain degrees, without a unit)") from error
