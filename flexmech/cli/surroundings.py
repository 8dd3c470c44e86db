"""Heat and moisture on the command line: options that several commands share."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from flexmech.errors import InputError
from flexmech.units import TEMPERATURE_DIFFERENCE, TIME, parse_number, parse_quantity

if TYPE_CHECKING:
    from flexmech.hygrothermal import State
    from flexmech.mechanism import Mechanism

__all__ = [
    "ExposureTime",
    "Moisture",
    "RelativeHumidity",
    "TemperatureRise",
    "in_state",
    "parse_percent",
    "parse_state",
]

TemperatureRise = Annotated[
    str | None,
    typer.Option(
        help="Temperature over the model's reference temperature: degrees Celsius unless a unit "
        "is given.",
        metavar="C",
    ),
]
Moisture = Annotated[
    str | None,
    typer.Option(
        help="Moisture of every resin: mass of water over its dry mass, in percent.",
        metavar="PERCENT",
    ),
]
RelativeHumidity = Annotated[
    str | None,
    typer.Option(
        help="Instead of --moisture: humidity of the surroundings in percent, with --time.",
        metavar="PERCENT",
    ),
]
ExposureTime = Annotated[
    str | None,
    typer.Option(help='Time since the links were dry, such as "30 day".', metavar="T"),
]


def parse_state(
    temperature_rise: str | None,
    moisture: str | None,
    relative_humidity: str | None,
    time: str | None,
) -> State | None:
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
    rise = 0.0 if temperature_rise is None else parse_rise(temperature_rise)
    if relative_humidity is not None and time is not None:
        humidity = parse_percent("--relative-humidity", relative_humidity)
        return Exposure(rise, humidity, parse_time(time))
    if temperature_rise is None and moisture is None:
        return None
    return HygrothermalState(
        rise, 0.0 if moisture is None else parse_percent("--moisture", moisture)
    )


def in_state(dry: Mechanism, state: State | None) -> Mechanism:
    """A mechanism in the heat and moisture asked for.

    Parameters
    ----------
    dry : Mechanism
    state : HygrothermalState or Exposure, optional
        None leaves the mechanism as it is.

    Returns
    -------
    Mechanism

    Raises
    ------
    InputError
        See :func:`flexmech.hygrothermal.mechanism_in_state`.
    """
    from flexmech.hygrothermal import mechanism_in_state

    return dry if state is None else mechanism_in_state(dry, state)


def parse_rise(text: str) -> float:
    """Temperature difference of ``--temperature-rise`` in K."""
    try:
        return parse_quantity(text, TEMPERATURE_DIFFERENCE, default_unit="K")
    except InputError as error:
        raise InputError(f"--temperature-rise: {error}") from error


def parse_time(text: str) -> float:
    """Time of ``--time`` in s; it needs a unit."""
    try:
        time = parse_quantity(text, TIME)
    except InputError as error:
        raise InputError(f"--time: {error}") from error
    if time < 0:
        raise InputError(f"--time: must be zero or positive, got {text!r}")
    return time


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
