"""The environment of a mechanism on the command line: heat, moisture and exposure."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexmech.cli.arguments import parse_option, parse_percent, parse_time
from flexmech.errors import InputError
from flexmech.units import TEMPERATURE_DIFFERENCE

if TYPE_CHECKING:
    from flexmech.hygrothermal import Environment


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
    if moisture is not None:
        return HygrothermalState(rise, parse_percent("--moisture", moisture))
    return None if temperature_rise is None else HygrothermalState(rise)
