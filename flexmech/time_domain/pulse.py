r"""The force of an impact hammer: a half-sine pulse, and where it acts.

A pulse of peak :math:`F` and duration :math:`T` has the spectrum
:math:`2 F T \cos(\pi f T) / (\pi (1 - 4 f^2 T^2))` times the delay of its middle. Its first zero
is at ``1.5 / T``; at ``1 / T`` it is a third of that at zero frequency (9.5 dB lower).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flexmech.choices import LINK_DIRECTIONS, LinkDirection
from flexmech.linear_system import LinkPoint
from flexmech.numbers import NOT_NEGATIVE, POSITIVE, check_choice, check_instance, check_number
from flexmech.types import ComplexArray, FloatArray

# Where numerator and denominator of the spectrum vanish together, f T = 1/2.
NEAR_HALF = 1e-6


@dataclass(frozen=True)
class HalfSinePulse:
    """``F sin(pi (t - start) / T)`` while the pulse lasts, zero before and after.

    Parameters
    ----------
    peak_force : float
        In N; negative pushes the other way.
    duration : float
        T in s.
    start : float
        In s.

    Raises
    ------
    InputError
        If one is no number, the duration is not positive or the start negative.
    """

    peak_force: float
    duration: float
    start: float = 0.0

    def __post_init__(self) -> None:
        check_number(self.peak_force, "peak_force of a pulse", "N")
        check_number(self.duration, "duration of a pulse", "s", POSITIVE)
        check_number(self.start, "start of a pulse", "s", NOT_NEGATIVE)

    @property
    def end(self) -> float:
        """When it is over, in s."""
        return self.start + self.duration

    @property
    def momentum(self) -> float:
        """Its integral in N s."""
        return 2 * self.peak_force * self.duration / np.pi

    def force(self, time: ArrayLike) -> FloatArray:
        """Force in N at times in s, of their shape."""
        phase = (np.asarray(time, dtype=float) - self.start) / self.duration
        inside = (phase > 0) & (phase < 1)
        return np.where(inside, self.peak_force * np.sin(np.pi * phase), 0.0)

    def spectrum(self, frequency: ArrayLike) -> ComplexArray:
        """Fourier integral of the force in N s, ``int f(t) exp(-2j pi f t) dt``.

        Parameters
        ----------
        frequency : array_like
            In Hz.

        Returns
        -------
        ndarray of complex, of the same shape
        """
        frequency = np.asarray(frequency, dtype=float)
        periods = frequency * self.duration
        half = np.abs(np.abs(periods) - 0.5) < NEAR_HALF
        safe = np.where(half, 0.0, periods)
        # Both vanish at one half, where the limit is pi / 4.
        ratio = np.where(half, np.pi / 4, np.cos(np.pi * safe) / (1 - 4 * safe**2))
        delay = np.exp(-2j * np.pi * frequency * (self.start + self.duration / 2))
        return np.asarray(self.momentum * ratio * delay)


@dataclass(frozen=True)
class Impact:
    """A pulse on a point of a link, in the axes of the link's rigid frame.

    Parameters
    ----------
    point : LinkPoint
    direction : {"transverse", "axial"}
        Across the link's frame or along it; the force turns with the frame.
    pulse : HalfSinePulse

    Raises
    ------
    InputError
        If one is no such thing.
    """

    point: LinkPoint
    direction: LinkDirection
    pulse: HalfSinePulse

    def __post_init__(self) -> None:
        check_instance(self.point, LinkPoint, "point of an impact", "give a flexmech.LinkPoint")
        check_choice(self.direction, LINK_DIRECTIONS, "direction of an impact")
        check_instance(self.pulse, HalfSinePulse, "pulse of an impact", "give a HalfSinePulse")
