"""The environment that a mechanism is put into: heat, and water that is there or diffuses in."""

from __future__ import annotations

from dataclasses import dataclass

from flexmech.errors import InputError
from flexmech.units import from_si
from flexmech.validation import NOT_NEGATIVE, Bounds, check_fields


@dataclass(frozen=True)
class HygrothermalState:
    """Every link at the same temperature and its resin equally moist; dry and unheated by default.

    Parameters
    ----------
    temperature_rise : float
        Over the mechanism's reference temperature in K.
    moisture : float
        Mass of water over the dry mass of the resin. Materials that take up no water ignore
        it.

    Raises
    ------
    InputError
        If the rise is not a number or the moisture negative.

    Examples
    --------
    >>> flexmech.HygrothermalState(temperature_rise=60.0, moisture=0.04).label
    '+60 K, 4 % moisture'
    """

    temperature_rise: float = 0.0
    moisture: float = 0.0

    def __post_init__(self) -> None:
        check_fields(self, {"temperature_rise": "K"})
        check_fields(self, {"moisture": ""}, NOT_NEGATIVE)

    @property
    def label(self) -> str:
        """Short name for titles and legends."""
        if not (self.temperature_rise or self.moisture):
            return "dry"
        return f"{self.temperature_rise:+.4g} K, {100 * self.moisture:.4g} % moisture"


@dataclass(frozen=True)
class Exposure:
    """Air of constant temperature and humidity for a time, from dry; water diffuses into the links.

    Parameters
    ----------
    temperature_rise : float
        Over the mechanism's reference temperature in K. Heat diffuses a million times as fast as
        water, so that all links are at this temperature from the start.
    relative_humidity : float
        From 0 to 1.
    time : float
        In s.

    Raises
    ------
    InputError
        If a number is out of its range.

    Examples
    --------
    >>> flexmech.Exposure(temperature_rise=60.0, relative_humidity=0.85, time=30 * 86400.0).label
    '+60 K, 85 % humidity for 30 d'
    """

    temperature_rise: float
    relative_humidity: float
    time: float

    def __post_init__(self) -> None:
        check_fields(self, {"temperature_rise": "K"})
        check_fields(self, {"relative_humidity": ""}, Bounds(least=0.0, most=1.0))
        check_fields(self, {"time": "s"}, NOT_NEGATIVE, "of exposure")

    @property
    def label(self) -> str:
        """Short name for titles and legends."""
        return (
            f"{self.temperature_rise:+.4g} K, {100 * self.relative_humidity:.4g} % humidity for "
            f"{from_si(self.time, 'day'):.4g} d"
        )


Environment = HygrothermalState | Exposure
"""Surroundings of a mechanism."""


def environment_of(
    temperature_rise: float,
    moisture: float | None,
    relative_humidity: float | None,
    time: float | None,
) -> Environment:
    """Environment by what is stated of it: how moist the links are, or what they are exposed to.

    Parameters
    ----------
    temperature_rise : float
        In K.
    moisture : float or None
    relative_humidity : float or None
        From 0 to 1.
    time : float or None
        In s; with the humidity.

    Returns
    -------
    HygrothermalState or Exposure

    Raises
    ------
    InputError
        If one of humidity and time is missing, or moisture is given beside them.
    """
    if (relative_humidity is None) != (time is None):
        given, absent = ("--relative-humidity", "--time")[:: 1 if time is None else -1]
        raise InputError(f"{given} is given without {absent}; give both, or --moisture instead")
    if moisture is not None and time is not None:
        raise InputError(
            "--moisture and --relative-humidity with --time are both given; keep one: the "
            "moisture of the links, or their exposure"
        )
    if relative_humidity is not None and time is not None:
        return Exposure(temperature_rise, relative_humidity, time)
    return HygrothermalState(temperature_rise, moisture or 0.0)
