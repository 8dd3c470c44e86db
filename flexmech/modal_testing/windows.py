"""Windows of a hammer test: a force window about the impact, an exponential one over the record.

The exponential window ``exp(-a t)`` lets the record of a lightly damped structure end small. It
moves every pole by ``a`` to the left, so that each mode seems to be damped more than it is. Taken
over force *and* response it does nothing else: the transforms are those at ``s = a + i omega``,
and so is their ratio, the frequency-response function. The poles found in it are moved back by
``a``, exactly. Source: W. A. Fladung and R. W. Rost, Mechanical Systems and Signal Processing 11
(1997), 23-36, "Application and correction of the exponential window for frequency response
functions".
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.errors import InputError
from flexmech.types import FloatArray


@dataclass(frozen=True)
class ForceWindow:
    """One over the impact, zero after it: noise of the force channel after the impact is cut off.

    Parameters
    ----------
    length : float
        Time in s, from the record's begin, that is kept in full.
    taper : float
        Time in s after it over which the window falls to zero as half a cosine.

    Raises
    ------
    InputError
        The length is not above zero, or the taper is below zero.
    """

    length: float
    taper: float = 0.0

    def __post_init__(self) -> None:
        if not self.length > 0.0:
            raise InputError(f"a force window of {self.length:g} s: give a length above 0 s")
        if not self.taper >= 0.0:
            raise InputError(f"a force window with a taper of {self.taper:g} s: give 0 s or more")

    def values(self, time: FloatArray) -> FloatArray:
        """The window over time.

        Parameters
        ----------
        time : ndarray, shape (N,)
            In s, from the record's begin.

        Returns
        -------
        ndarray, shape (N,)
            From 1 to 0.
        """
        if self.taper == 0.0:
            return (np.asarray(time) <= self.length).astype(float)
        part = np.clip((np.asarray(time) - self.length) / self.taper, 0.0, 1.0)
        window: FloatArray = 0.5 * (1.0 + np.cos(np.pi * part))
        return window


@dataclass(frozen=True)
class ExponentialWindow:
    """A window ``exp(-a t)`` over force and response.

    Parameters
    ----------
    decay_rate : float
        The a in 1/s: by so much every pole moves to the left.

    Raises
    ------
    InputError
        The rate is below zero or not a number.
    """

    decay_rate: float

    def __post_init__(self) -> None:
        if not (np.isfinite(self.decay_rate) and self.decay_rate >= 0.0):
            raise InputError(
                f"an exponential window that decays by {self.decay_rate:g} 1/s: give 0 or more"
            )

    @classmethod
    def ending_at(cls, duration: float, value: float = 0.01) -> ExponentialWindow:
        """The window that has come down to a value at the end of a record.

        Parameters
        ----------
        duration : float
            Of the record in s.
        value : float
            Between 0 and 1; laboratories take 0.01 to 0.05.

        Returns
        -------
        ExponentialWindow

        Raises
        ------
        InputError
            The duration is not above zero, or the value is not in (0, 1].

        Examples
        --------
        >>> round(ExponentialWindow.ending_at(2.0).decay_rate, 4)
        2.3026
        """
        if not duration > 0.0:
            raise InputError(f"a record of {duration:g} s: give a duration above 0 s")
        if not 0.0 < value <= 1.0:
            raise InputError(
                f"an exponential window that ends at {value:g}: give a value above 0 and up to 1"
            )
        return cls(float(-np.log(value) / duration))

    def values(self, time: FloatArray) -> FloatArray:
        """The window over time.

        Parameters
        ----------
        time : ndarray, shape (N,)
            In s, from the record's begin.

        Returns
        -------
        ndarray, shape (N,)
        """
        return np.exp(-self.decay_rate * np.asarray(time))

    def added_damping_ratio(self, frequency: FloatArray | float) -> FloatArray:
        """Damping ratio that the window adds to a lightly damped mode.

        Parameters
        ----------
        frequency : float or ndarray
            Natural frequency in Hz.

        Returns
        -------
        ndarray
            ``a / (2 pi f)``, of the frequency's shape.
        """
        return np.asarray(self.decay_rate / (2 * np.pi * np.asarray(frequency, dtype=float)))
