"""What users type after an option of a run in time, to SI values: speed, turns and times."""

from __future__ import annotations

from enum import StrEnum

from flexmech.errors import InputError
from flexmech.units import ANGULAR_SPEED, TIME, Dimension, parse_number, parse_quantity

__all__ = [
    "AUTO",
    "Integrator",
    "Start",
    "parse_revolutions",
    "parse_run_up",
    "parse_speed",
    "parse_step",
]

AUTO = "auto"
"""What ``--step`` takes for a step that the analysis chooses."""


class Start(StrEnum):
    """Choices of ``--start``."""

    rigid = "rigid"
    equilibrium = "equilibrium"
    periodic = "periodic"


class Integrator(StrEnum):
    """Choices of ``--integrator``."""

    trapezoidal = "trapezoidal"
    generalized_alpha = "generalized-alpha"


def parse_speed(text: str) -> float:
    """Crank speed of ``--speed``.

    Parameters
    ----------
    text : str
        Such as ``"20"`` or ``"300 rpm"``; rad/s unless a unit is given.

    Returns
    -------
    float
        In rad/s; negative turns backwards.

    Raises
    ------
    InputError
        If it is no angular speed, or zero.
    """
    speed = _quantity("--speed", text, ANGULAR_SPEED)
    if speed == 0:
        raise InputError(
            f"--speed: got {text!r}, at which nothing turns; give a crank speed other than zero, "
            f"for example {ANGULAR_SPEED.example} (a negative one turns backwards)"
        )
    return speed


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
        step = _quantity("--step", text, TIME)
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
    duration = _quantity("--run-up", text, TIME)
    if duration < 0:
        raise InputError(
            f"--run-up: got {text!r}, which is negative; write how long the crank takes to reach "
            'its speed, for example "0.2 s"'
        )
    return duration


def _quantity(option: str, text: str, dimension: Dimension) -> float:
    try:
        return parse_quantity(text, dimension, default_unit=dimension.unit)
    except InputError as error:
        raise InputError(f"{option}: {error}") from error
