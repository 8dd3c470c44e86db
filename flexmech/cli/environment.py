"""The environment of a mechanism on the command line: heat, moisture and exposure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexmech.cli.arguments import parse_option
from flexmech.errors import InputError
from flexmech.units import TEMPERATURE, TEMPERATURE_DIFFERENCE, TIME, parse_number

if TYPE_CHECKING:
    from flexmech.hygrothermal import Environment

__all__ = ["parse_environment", "parse_percent", "parse_temperature", "parse_time"]


def parse_environment(
    temperature_rise: str | None,
    moisture: str | None,
    relative_humidity: str | None,
    time: str | None,
) -> Environment | None:
    """Heat and moisture of the shared options.

    Parameters
    ----------
    temperature_rise, moisture, relative_humidity, time : str or None
        As typed; None where left out.

    Returns
    -------
    HygrothermalState, Exposure or None
        None if nothing is asked for.

    Raises
    ------
    InputError
        If a value cannot be, or options do not go together; names the option.
    """
    from flexmech.hygrothermal import Exposure, HygrothermalState

    if (relative_humidity is None) != (time is None):
        given, absent = ("--relative-humidity", "--time")[:: 1 if time is None else -1]
        raise InputError(f"{given} is given without {absent}; give both, or --moisture instead")
    if moisture is not None and time is not None:
        raise InputError(
            "--moisture and --relative-humidity with --time are both given; keep one: how moist "
            "the links are, or what they are exposed to"
        )
    rise = 0.0
    if temperature_rise is not None:
        rise = parse_option("--temperature-rise", temperature_rise, TEMPERATURE_DIFFERENCE, "K")
    if relative_humidity is not None and time is not None:
        humidity = parse_percent("--relative-humidity", relative_humidity)
        return Exposure(rise, humidity, parse_time(time))
    if temperature_rise is None and moisture is None:
        return None
    return HygrothermalState(
        rise, 0.0 if moisture is None else parse_percent("--moisture", moisture)
    )


def parse_time(text: str) -> float:
    """Time of exposure in s; it needs a unit."""
    time = parse_option("--time", text, TIME)
    if time < 0:
        raise InputError(f"--time: must be zero or positive, got {text!r}")
    return time


def parse_temperature(text: str) -> float:
    """Temperature of ``--temperature`` in K, degrees Celsius unless a unit is given."""
    kelvin = parse_option("--temperature", text, TEMPERATURE, "degC")
    if kelvin <= 0:
        raise InputError(f"--temperature: must be above absolute zero, got {text!r}")
    return kelvin


def parse_percent(option: str, text: str) -> float:
    """Fraction of an option in percent, ``"7"`` or ``"7 %"``.

    Parameters
    ----------
    option : str
        Its name, for messages.
    text : str

    Returns
    -------
    float
        0.07 for ``"7"``.

    Raises
    ------
    InputError
        If it is no number from 0 to 100.
    """
    unit = next((unit for unit in ("percent", "%") if text.strip().endswith(unit)), "")
    try:
        percent = float(parse_number(text.strip().removesuffix(unit)))
    except InputError as error:
        raise InputError(f"{option}: {error} (in percent)") from error
    if not 0 <= percent <= 100:
        raise InputError(f"{option}: must lie between 0 and 100 percent, got {text!r}")
    return percent / 100
