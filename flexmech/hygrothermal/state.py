"""The heat and water that a mechanism is in."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.errors import InputError

__all__ = ["Environment", "Exposure", "HygrothermalState", "State"]

DAY = 86400.0


@dataclass(frozen=True)
class HygrothermalState:
    """Every link equally hot and its resin equally moist; dry and unheated by default.

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
    """

    temperature_rise: float = 0.0
    moisture: float = 0.0

    def __post_init__(self) -> None:
        _check_rise(self.temperature_rise)
        if not (np.isfinite(self.moisture) and self.moisture >= 0):
            raise InputError(f"moisture must be zero or positive, got {100 * self.moisture:g} %")

    @property
    def label(self) -> str:
        """Short name for titles and legends."""
        if not (self.temperature_rise or self.moisture):
            return "dry"
        return f"{self.temperature_rise:+.4g} K, {100 * self.moisture:.4g} % moisture"


@dataclass(frozen=True)
class Exposure:
    """Constant humid surroundings for a time, from dry; the links take up what diffuses in.

    Parameters
    ----------
    temperature_rise : float
        Over the mechanism's reference temperature in K, everywhere at once: heat diffuses a
        million times as fast as water.
    relative_humidity : float
        From 0 to 1.
    time : float
        In s.

    Raises
    ------
    InputError
        If a number is out of its range.
    """

    temperature_rise: float
    relative_humidity: float
    time: float

    def __post_init__(self) -> None:
        _check_rise(self.temperature_rise)
        if not 0 <= self.relative_humidity <= 1:
            raise InputError(
                f"relative_humidity must lie between 0 and 100 %, got "
                f"{100 * self.relative_humidity:g} %"
            )
        if not (np.isfinite(self.time) and self.time >= 0):
            raise InputError(f"time of exposure must be zero or positive, got {self.time} s")

    @property
    def label(self) -> str:
        """Short name for titles and legends."""
        return (
            f"{self.temperature_rise:+.4g} K, {100 * self.relative_humidity:.4g} % humidity for "
            f"{self.time / DAY:.4g} d"
        )


Environment = HygrothermalState | Exposure
State = Environment


def _check_rise(rise: float) -> None:
    if not np.isfinite(rise):
        raise InputError(f"temperature_rise must be a number, got {rise} K")
