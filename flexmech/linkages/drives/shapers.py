"""Input shapers: impulses that a law of motion is convolved with, so that modes stay quiet.

A motion that is given in parts, one after the other, excites a mode by each of them. Where times
and weights of the parts suit the mode's frequency and damping ratio, what they leave adds up to
nothing (Singer and Seering, J. Dynamic Systems, Measurement, and Control 112 (1990) 76), or stays
within what is tolerated over a range of frequencies (Singhose, Seering and Singer, J. Mechanical
Design 116 (1994) 654).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray
from flexmech.choices import SHAPERS, ShaperName
from flexmech.errors import ComputationError, InputError
from flexmech.model_text import quantity
from flexmech.units import TIME
from flexmech.validation import POSITIVE, Bounds, check_choice, check_number, checked_array

DAMPING_RATIO = Bounds(least=0.0, below=1.0)
TOLERATED = Bounds(above=0.0, below=1.0)
# A damped EI shaper is found from the undamped one, whose form is closed, in steps of this ratio.
_RATIO_STEP = 0.01
# Of the impulses' sum, and of the conditions of an EI shaper: some thousand unit round-offs.
_CLOSED = 1e-12


@dataclass(frozen=True)
class InputShaper:
    """Impulses at times, whose weights add up to one.

    Parameters
    ----------
    times : tuple of float
        In s, increasing from zero.
    weights : tuple of float
    label : str
        What it is made for.

    Raises
    ------
    InputError
        If the times do not increase from zero, or the weights do not add up to one.

    Examples
    --------
    >>> shaper = flexmech.input_shaper("zv", frequency=2.0)
    >>> shaper.times, shaper.weights
    ((0.0, 0.25), (0.5, 0.5))
    """

    times: tuple[float, ...]
    weights: tuple[float, ...]
    label: str = ""

    def __post_init__(self) -> None:
        times = checked_array(self.times, "times of impulses", "s")
        weights = checked_array(self.weights, "weights of impulses", "")
        if times.ndim != 1 or times.shape != weights.shape or not times.size:
            raise InputError(
                f"got {times.size} times and {weights.size} weights of impulses; give each impulse "
                "both"
            )
        if times[0] != 0 or (np.diff(times) <= 0).any():
            raise InputError("times of impulses must increase from 0 s; sort them")
        # Weights that are written with ten digits.
        if abs(weights.sum() - 1) > 1e-9 * len(weights):
            raise InputError(
                f"weights of impulses must add up to 1, got {weights.sum():.10g}; divide them by "
                "their sum"
            )
        object.__setattr__(self, "times", tuple(times.tolist()))
        object.__setattr__(self, "weights", tuple(weights.tolist()))

    def to_rows(self) -> list[list[str | float]]:
        """Key ``impulses`` of a model file's ``[drive]``: times with their unit, and weights."""
        return [[quantity(t, TIME), w] for t, w in zip(self.times, self.weights, strict=True)]

    @property
    def duration(self) -> float:
        """By how much it makes a motion longer, in s."""
        return self.times[-1]

    def convolved(self, other: InputShaper) -> InputShaper:
        """Both, one after the other: what each keeps quiet both do.

        Parameters
        ----------
        other : InputShaper

        Returns
        -------
        InputShaper
            Impulses at one time are one.
        """
        times = np.add.outer(self.times, other.times).reshape(-1)
        weights = np.multiply.outer(self.weights, other.weights).reshape(-1)
        order = np.argsort(times, kind="stable")
        times, weights = times[order], weights[order]
        close = _CLOSED * (times[-1] or 1.0)
        first = np.append(True, np.diff(times) > close)
        added = np.add.reduceat(weights, np.flatnonzero(first))
        label = ", ".join(each for each in (self.label, other.label) if each)
        return InputShaper(tuple(times[first].tolist()), tuple(added.tolist()), label)

    def residual(self, frequency: ArrayLike, damping_ratio: float = 0.0) -> FloatArray:
        """Amplitude that it leaves of a mode, over that by one impulse at time zero.

        Parameters
        ----------
        frequency : array_like, shape (...)
            Natural frequency of the mode in Hz.
        damping_ratio : float

        Returns
        -------
        ndarray, shape (...)
            At the time of the last impulse (Singer and Seering 1990).

        Examples
        --------
        >>> shaper = flexmech.input_shaper("zv", frequency=2.0)
        >>> shaper.residual([2.0, 2.2, 4.0]).round(4)  # |cos(pi/2 f/2)|
        array([0.    , 0.1564, 1.    ])
        """
        check_number(damping_ratio, "damping ratio", "", DAMPING_RATIO)
        exponent = 2 * np.pi * np.multiply.outer(frequency, np.array(self.times))
        turns = exponent * (damping_ratio + 1j * math.sqrt(1 - damping_ratio**2))
        # From the last impulse on, so that nothing grows.
        turns = turns - damping_ratio * exponent[..., -1:]
        return np.asarray(np.abs(np.exp(turns) @ np.array(self.weights)))


def input_shaper(
    kind: ShaperName, frequency: float, damping_ratio: float = 0.0, tolerated: float = 0.05
) -> InputShaper:
    """Impulses that keep a mode of known frequency and damping quiet.

    Parameters
    ----------
    kind : {"zv", "zvd", "ei"}
        Zero vibration, two impulses; zero vibration and derivative, three impulses that tolerate
        some error of the frequency; extra insensitive, three impulses that leave some vibration at
        the frequency and none below and above it.
    frequency : float
        Natural frequency in Hz.
    damping_ratio : float
        Below 0.3 for EI.
    tolerated : float
        Residual vibration that EI leaves at the frequency, over that without a shaper.

    Returns
    -------
    InputShaper

    Raises
    ------
    InputError
        If there is no such shaper, or a number cannot be.
    ComputationError
        If the conditions of EI are not met.

    Examples
    --------
    >>> flexmech.input_shaper("ei", 10.0, tolerated=0.05).weights
    (0.2625, 0.475, 0.2625)
    """
    check_choice(kind, SHAPERS, "shaper")
    check_number(frequency, "frequency of a shaper", "Hz", POSITIVE)
    check_number(damping_ratio, "damping ratio of a shaper", "", DAMPING_RATIO)
    period = 1 / (frequency * math.sqrt(1 - damping_ratio**2))
    if kind == "ei":
        times, weights = _extra_insensitive(damping_ratio, tolerated)
    else:
        left = math.exp(-math.pi * damping_ratio / math.sqrt(1 - damping_ratio**2))
        parts = [1.0, left] if kind == "zv" else [1.0, 2 * left, left**2]
        times = [part / 2 for part in range(len(parts))]
        weights = [part / sum(parts) for part in parts]
    damped = f", damping ratio {100 * damping_ratio:.3g} %" if damping_ratio else ""
    label = f"{kind.upper()} at {frequency:.4g} Hz{damped}"
    return InputShaper(tuple(period * time for time in times), tuple(weights), label)


def _extra_insensitive(damping_ratio: float, tolerated: float) -> tuple[list[float], list[float]]:
    """Impulses over a damped period of what leaves ``tolerated`` at it, and nothing beside it.

    Two frequencies at which nothing is left, the first and the last weight and the time of the
    middle impulse are found from five conditions: nothing at these two, the tolerated part at the
    frequency itself.
    """
    from scipy.optimize import root

    check_number(tolerated, "tolerated vibration", "", TOLERATED)
    if damping_ratio > 0.3:
        raise InputError(
            f"an EI shaper is for damping ratios up to 0.3, got {damping_ratio:.3g}; take ZV: a "
            "mode that is damped so much rings hardly"
        )
    side, middle = (1 + tolerated) / 4, (1 - tolerated) / 2
    if not damping_ratio:
        return [0.0, 0.5, 1.0], [side, middle, side]

    def conditions(unknown: FloatArray, ratio: float) -> list[float]:
        first, last, time, low, high = unknown
        weights = np.array([first, 1 - first - last, last])
        angle = 2 * np.pi * np.array([0.0, time, 1.0])
        rate = 1j + ratio / math.sqrt(1 - ratio**2)
        left = [np.exp(part * rate * angle) @ weights for part in (low, high, 1.0)]
        decayed = math.exp(-rate.real * angle[-1])
        zero = [side for one in left[:2] for side in (one.real, one.imag)]
        return [*zero, decayed * abs(left[2]) - tolerated]

    apart = math.acos(-middle / (2 * side)) / math.pi
    found = np.array([side, side, 0.5, apart, 2 - apart])
    steps = math.ceil(damping_ratio / _RATIO_STEP)
    for ratio in damping_ratio * np.arange(1, steps + 1) / steps:
        solution = root(conditions, found, args=(float(ratio),), tol=_CLOSED)
        found = solution.x
    if np.abs(conditions(found, damping_ratio)).max() > 1e3 * _CLOSED:
        raise ComputationError(
            f"no EI shaper is found for a damping ratio of {damping_ratio:.4g} and a tolerated "
            f"vibration of {tolerated:.4g}; tolerate less, or take ZVD"
        )
    first, last, time, *_ = found.tolist()
    return [0.0, time, 1.0], [first, 1 - first - last, last]
