"""Ambient conditions of a part: relative humidity and temperature of the air over time."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray, IntArray
from flexmech.errors import InputError


@dataclass(frozen=True)
class Period:
    """A time without corners, in which humidity and temperature run straight.

    Parameters
    ----------
    start, stop : float
        In s.
    relative_humidity : tuple of float
        At the start and at the stop.
    temperature : tuple of float
        At the start and at the stop in K.
    """

    start: float
    stop: float
    relative_humidity: tuple[float, float]
    temperature: tuple[float, float]

    def at(self, time: float) -> tuple[float, float]:
        """Relative humidity and temperature (K) at a time of the period."""
        share = (time - self.start) / (self.stop - self.start)
        humidity = _between(self.relative_humidity, share)
        return min(max(humidity, 0.0), 1.0), _between(self.temperature, share)


@dataclass(frozen=True, eq=False)
class Ambient:
    """Relative humidity and temperature of the air, straight from one time to the next.

    Before the first time and after the last one they stay as they are there. A time given twice
    is a step: the first values hold up to it, the second ones from it on.

    Parameters
    ----------
    time : ndarray, shape (k,)
        In s, not falling, none more than twice.
    relative_humidity : ndarray, shape (k,)
        From 0 to 1.
    temperature : ndarray, shape (k,)
        In K.

    Raises
    ------
    InputError
        If the three are not rows of the same length, times fall or stand three times, or a
        value is outside its range.
    """

    time: FloatArray
    relative_humidity: FloatArray
    temperature: FloatArray

    def __post_init__(self) -> None:
        for name in ("time", "relative_humidity", "temperature"):
            row = np.array(getattr(self, name), dtype=float)
            row.flags.writeable = False
            object.__setattr__(self, name, row)
        shapes = {self.time.shape, self.relative_humidity.shape, self.temperature.shape}
        if len(shapes) > 1 or self.time.ndim != 1 or not self.time.size:
            raise InputError(
                "ambient times need as many humidities and temperatures as they are, one or more; "
                f"got shapes {self.time.shape}, {self.relative_humidity.shape} and "
                f"{self.temperature.shape}"
            )
        self._check_values()

    def _check_values(self) -> None:
        time, humidity, temperature = self.time, self.relative_humidity, self.temperature
        if not np.all(np.isfinite(time)) or np.any(np.diff(time) < 0):
            raise InputError(f"ambient times must be numbers that rise, got {time}")
        if np.any(time[2:] == time[:-2]):
            raise InputError("an ambient time stands more than twice; a step needs two")
        if not np.all((humidity >= 0) & (humidity <= 1)):
            raise InputError(f"relative_humidity must lie between 0 and 1 (100 %), got {humidity}")
        if not np.all(np.isfinite(temperature) & (temperature > 0)):
            raise InputError(f"ambient temperature must be above 0 K, got {temperature}")

    @classmethod
    def constant(cls, relative_humidity: float, temperature: float) -> Self:
        """The same for all times.

        Parameters
        ----------
        relative_humidity : float
            From 0 to 1.
        temperature : float
            In K.

        Returns
        -------
        Ambient
        """
        return cls(np.zeros(1), np.array([relative_humidity]), np.array([temperature]))

    def at(self, time: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Relative humidity and temperature at times; after a step where a time is one.

        Parameters
        ----------
        time : array_like, shape (t,)
            In s.

        Returns
        -------
        tuple of ndarray, each of shape (t,)
            From 0 to 1, and in K.
        """
        times = np.atleast_1d(np.asarray(time, dtype=float))
        return self._values(times, np.searchsorted(self.time, times, side="right"))

    def periods(self, start: float, stop: float) -> tuple[Period, ...]:
        """The periods from one time to another, cut at the corners and steps between.

        Parameters
        ----------
        start, stop : float
            In s.

        Returns
        -------
        tuple of Period
            None if no time lies between.
        """
        if stop <= start:
            return ()
        inside = self.time[(self.time > start) & (self.time < stop)]
        ends = np.unique(np.concatenate([[start], inside, [stop]]))
        return tuple(self._period(float(a), float(b)) for a, b in pairwise(ends))

    def _period(self, start: float, stop: float) -> Period:
        ends = np.array([start, stop])
        # After a step at the start, before one at the stop.
        following = [
            int(np.searchsorted(self.time, start, side="right")),
            int(np.searchsorted(self.time, stop, side="left")),
        ]
        humidity, temperature = self._values(ends, np.array(following))
        return Period(
            start,
            stop,
            (float(humidity[0]), float(humidity[1])),
            (float(temperature[0]), float(temperature[1])),
        )

    def _values(self, times: FloatArray, following: IntArray) -> tuple[FloatArray, FloatArray]:
        """Humidity and temperature between the corners before and at ``following``."""
        low, high = np.maximum(following - 1, 0), np.minimum(following, self.time.size - 1)
        width = self.time[high] - self.time[low]
        share = np.clip((times - self.time[low]) / np.where(width > 0, width, 1.0), 0.0, 1.0)
        humidity, temperature = (
            np.where(share < 1, row[low] + share * (row[high] - row[low]), row[high])
            for row in (self.relative_humidity, self.temperature)
        )
        return humidity, temperature


def _between(ends: tuple[float, float], share: float) -> float:
    return ends[0] + share * (ends[1] - ends[0])
