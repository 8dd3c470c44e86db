"""Input shapers, and drives whose law is given in parts at the times and with the weights of one.

A motion that is given in parts, one after the other, excites a mode by each of them. Where times
and weights of the parts suit the mode's frequency and damping ratio, what they leave adds up to
nothing (Singer and Seering, J. Dynamic Systems, Measurement, and Control 112 (1990) 76), or stays
within what is tolerated over a range of frequencies (Singhose, Seering and Singer, J. Mechanical
Design 116 (1994) 654).

Impulses at fixed times keep one frequency quiet. Where the frequency changes on the way, as the
posture does, the parts of a motion must follow each other by the same *phase* of the vibration:
impulses in periods of the mode, over the phase ``psi = integral f(theta(t)) dt``, in place of
impulses in seconds over time. Time-varying impulse sequences go back to Cho and Park (Robotica 13
(1995) 305); the phase is that of the WKB approximation (Bender and Orszag, *Advanced Mathematical
Methods*, 1978, ch. 10), which holds where the frequency changes little within a period.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray
from flexmech.choices import MOST_MODES, SHAPED_FOR, SHAPERS, ShapedFor, ShaperName
from flexmech.errors import ComputationError, InputError
from flexmech.linkages.drives.drive import Drive, PiecewiseMotion
from flexmech.linkages.drives.laws import TableDrive
from flexmech.model_text import TomlTable, quantity
from flexmech.units import TIME
from flexmech.validation import (
    POSITIVE,
    Bounds,
    check_choice,
    check_count,
    check_instance,
    check_number,
    checked_array,
)

DAMPING_RATIO = Bounds(least=0.0, below=1.0)
TOLERATED = Bounds(above=0.0, below=1.0)
# A damped EI shaper is found from the undamped one, whose form is closed, in steps of this ratio.
_RATIO_STEP = 0.01
# Tolerance of the impulses' sum and of an EI shaper's conditions: thousands of unit round-offs.
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
        label = ", ".join(name for name in (self.label, other.label) if name)
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
        times = [count / 2 for count in range(len(parts))]
        weights = [count / sum(parts) for count in parts]
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
        left = [
            np.exp(ratio_to_design * rate * angle) @ weights for ratio_to_design in (low, high, 1.0)
        ]
        decayed = math.exp(-rate.real * angle[-1])
        zero = [side for one in left[:2] for side in (one.real, one.imag)]
        return [*zero, decayed * abs(left[2]) - tolerated]

    apart = math.acos(-middle / (2 * side)) / math.pi
    unknowns = np.array([side, side, 0.5, apart, 2 - apart])
    steps = math.ceil(damping_ratio / _RATIO_STEP)
    for ratio in damping_ratio * np.arange(1, steps + 1) / steps:
        solution = root(conditions, unknowns, args=(float(ratio),), tol=_CLOSED)
        unknowns = solution.x
    if np.abs(conditions(unknowns, damping_ratio)).max() > 1e3 * _CLOSED:
        raise ComputationError(
            f"no EI shaper is found for a damping ratio of {damping_ratio:.4g} and a tolerated "
            f"vibration of {tolerated:.4g}; tolerate less, or take ZVD"
        )
    first, last, time, *_ = unknowns.tolist()
    return [0.0, time, 1.0], [first, 1 - first - last, last]


# Times that differ by less, over the whole, are one: sums of the same times in another order.
_SAME = 1e-12
# From one corner of the law to the next: pieces of the fifth degree, whose error falls with the
# sixth power of their length, and in each piece steps of the integrals of phase and time.
_PIECES, _STEPS = 24, 84
# Distance inside an interval at which its ends are evaluated: accelerations may jump at them.
_INSIDE = 1e-9


@dataclass(frozen=True)
class Shaping:
    """An input shaper that a law of motion is given, to be run beside the plain law.

    Parameters
    ----------
    kind : {"zv", "zvd", "ei"}
        See :func:`flexmech.input_shaper`.
    modes : tuple of int, optional
        Modes of the linkage where it stops, counted from 1, for which it is shaped, one after the
        other. Left out: those that ring by more than a tenth of what rings most after the plain
        law.
    frequencies : {"end", "path"}
        Natural frequencies for which it is shaped: where the crank stops, or those along its path.
    tolerated : float, optional
        Residual vibration of EI at the frequency itself, over that of the plain law; a twentieth
        if left out.

    Raises
    ------
    InputError
        If a value is impossible.

    Examples
    --------
    >>> flexmech.Shaping("zvd", modes=(1, 2), frequencies="path").words
    'ZVD shaper along the path'
    """

    kind: ShaperName
    modes: tuple[int, ...] | None = None
    frequencies: ShapedFor = "end"
    tolerated: float | None = None

    def __post_init__(self) -> None:
        check_choice(self.kind, SHAPERS, "shaper")
        check_choice(self.frequencies, SHAPED_FOR, "shaped_for")
        if self.tolerated is not None:
            check_number(self.tolerated, "tolerated vibration", "", Bounds(above=0.0, below=1.0))
            if self.kind != "ei":
                raise InputError(
                    f"a tolerated vibration belongs to the shaper ei, and not to {self.kind}; "
                    "leave it out, or take ei"
                )
        if self.modes is not None:
            if not self.modes or len(set(self.modes)) < len(self.modes):
                raise InputError("shaped modes must be one or more, each once, as 1,2")
            for mode in self.modes:
                check_count(mode, "shaped mode", most=MOST_MODES)

    @property
    def words(self) -> str:
        """The shaper, and that it goes by the path."""
        along = " along the path" if self.frequencies == "path" else ""
        return f"{self.kind.upper()} shaper{along}"


def check_shapeable(drive: Drive) -> None:
    """Refuse a drive that does not go from rest to a stop.

    Parameters
    ----------
    drive : Drive

    Raises
    ------
    InputError
    """
    check_instance(drive, Drive, "drive", "give a flexmech.Drive")
    if drive.speed or drive.is_constant:
        raise InputError(
            f"a shaper is for a law that stops, and the crank goes on turning ({drive.words}); "
            'give a law in [drive], as law = "cycloid" with travel, time and dwell'
        )
    start = float(drive.crank_speed(0.0))
    # The spline of a table that begins free has some speed of round-off.
    if abs(start) > 1e-6 * abs(drive.greatest_speed):
        raise InputError(
            f"a shaper is for a law that begins at rest, and this one begins at {start:.4g} rad/s; "
            "begin the table at rest"
        )


@dataclass(frozen=True)
class ShapedDrive(Drive):
    """A law of motion convolved with the impulses of an input shaper.

    The crank angle is the sum of the law's angles, each later by an impulse's time and times its
    weight; before a law begins and after it ends the crank rests. Its pieces are sums of the
    law's, exactly.

    Parameters
    ----------
    drive : Drive
        The law, from rest to a stop.
    shaper : InputShaper

    Raises
    ------
    InputError
        If the crank does not begin at rest, or goes on turning.

    Examples
    --------
    >>> law = flexmech.LawDrive("cycloid", travel=2.0, time=0.1)
    >>> shaped = flexmech.ShapedDrive(law, flexmech.input_shaper("zv", frequency=5.0))
    >>> shaped.law_time, shaped.crank_angle([0.1, 0.15, 0.2]).round(9).tolist()
    (0.2, [1.0, 1.5, 2.0])
    """

    drive: Drive
    shaper: InputShaper
    speed: ClassVar[float] = 0.0  # type: ignore[misc]

    def __post_init__(self) -> None:
        check_shapeable(self.drive)
        check_instance(self.shaper, InputShaper, "shaper", "give a flexmech.InputShaper")

    @property
    def start_angle(self) -> float:  # type: ignore[override]
        """Crank angle at time zero in rad."""
        return self.drive.start_angle

    @cached_property
    def law(self) -> PiecewiseMotion:
        """Sums of the law's pieces, from one knot of any of its parts to the next."""
        law = self.drive.law
        knots = self._shifted(law.knots)
        span, sines = np.diff(knots), list[FloatArray]()
        polynomials = np.zeros((len(span), law.polynomials.shape[1]))
        for time, weight in zip(self.shaper.times, self.shaper.weights, strict=True):
            polynomial, waves = law.within(knots[:-1] - time, span)
            waves[..., 0] *= weight
            polynomials += weight * polynomial
            sines.append(waves)
        return PiecewiseMotion(knots, polynomials, np.concatenate(sines, axis=1), law.end_angle)

    def _shifted(self, times: FloatArray) -> FloatArray:
        """Times later by those of all impulses, in order; each once."""
        every = np.sort(np.add.outer(self.shaper.times, times).reshape(-1))
        apart = np.diff(every) > _SAME * every[-1]
        # The last of those that are one, so that the law's own end stays.
        return np.asarray(every[np.append(apart, True)])

    @property
    def delay(self) -> float:
        """By how much the law is longer, in s."""
        return self.shaper.duration

    @property
    def cycle_time(self) -> float:
        """Time of a move and its dwell in s, of the law itself."""
        return self.drive.cycle_time

    def run_time(self, revolutions: float) -> float:
        """Duration in s of the law, which is longer by the shaper, and its last dwell.

        Parameters
        ----------
        revolutions : float
            Revolutions of no account.
        """
        return self.drive.run_time(revolutions) + self.delay

    @property
    def corners(self) -> FloatArray:
        """Times in s at which the jerk of the law, or of one of its parts, may jump."""
        return self._shifted(self.drive.corners)

    def to_table(self) -> TomlTable:
        """Table ``[drive]`` of a model file: the law's, with impulses."""
        inner, shaper = self.drive, self.shaper
        if isinstance(inner, ShapedDrive):
            return ShapedDrive(inner.drive, inner.shaper.convolved(shaper)).to_table()
        return inner.to_table() | {"impulses": shaper.to_rows()}

    def stretched(self, factor: float) -> Self:
        """The law over another time, shaped as before.

        Parameters
        ----------
        factor : float
            By which every move of the law takes longer.

        Returns
        -------
        ShapedDrive
        """
        return replace(self, drive=self.drive.stretched(factor))

    @property
    def words(self) -> str:
        """The law, what it is shaped for, and by how much longer it is."""
        made = self.shaper.label or f"{len(self.shaper.times)} impulses"
        longer = f"{1e3 * self.delay:.4g} ms longer"
        return f"{self.drive.words}, shaped by {made}, {longer}"


@dataclass(frozen=True)
class FrequenciesOnPath:
    """Natural frequency of a mode over the crank angle, with a spline through it.

    Parameters
    ----------
    angles : tuple of float
        In rad, increasing, six or more; beyond the first and the last one the frequency stays.
    frequencies : tuple of float
        In Hz.

    Raises
    ------
    InputError
        If angles do not increase, or a frequency is none.
    """

    angles: tuple[float, ...]
    frequencies: tuple[float, ...]

    def __post_init__(self) -> None:
        angles = checked_array(self.angles, "crank angles of frequencies", "rad")
        frequencies = checked_array(self.frequencies, "frequencies on the path", "Hz")
        if angles.ndim != 1 or angles.shape != frequencies.shape or len(angles) < 6:
            raise InputError(
                f"got {angles.size} crank angles and {frequencies.size} frequencies; give six or "
                "more of both"
            )
        if (np.diff(angles) <= 0).any() or (frequencies <= 0).any():
            raise InputError("crank angles must increase and frequencies be positive; sort them")

    @cached_property
    def _spline(self) -> Any:
        from scipy.interpolate import make_interp_spline

        return make_interp_spline(self.angles, self.frequencies, k=5)

    def at(self, angle: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Frequency in Hz, and its derivative over the angle, at angles of shape (m,)."""
        inside = np.clip(angle, self.angles[0], self.angles[-1])
        rate = np.where(inside == angle, self._spline(inside, 1), 0.0)
        return np.asarray(self._spline(inside)), rate


@dataclass(frozen=True)
class PathShapedDrive(ShapedDrive):
    """A law of motion convolved with impulses over the phase of a mode.

    Parameters
    ----------
    drive : Drive
        The law, from rest to a stop.
    shaper : InputShaper
        Its times in natural periods: made for 1 Hz.
    path : FrequenciesOnPath

    Raises
    ------
    InputError
        If the crank does not begin at rest, or goes on turning.
    """

    path: FrequenciesOnPath

    def __post_init__(self) -> None:
        super().__post_init__()
        check_instance(self.path, FrequenciesOnPath, "path", "give a FrequenciesOnPath")

    @cached_property
    def law(self) -> PiecewiseMotion:
        """Quintics that meet with equal speeds, and accelerations where the law's do not jump."""
        time, phase = (nodes[::_STEPS] for nodes in self._way)
        inside = _INSIDE * np.diff(phase)
        starts, ends = self._motion(phase[:-1] + inside), self._motion(phase[1:] - inside)
        return PiecewiseMotion.hermite(time, starts, ends, self.drive.law.end_angle)

    @property
    def delay(self) -> float:
        """By how much the law is longer, in s."""
        return float(self._way[0][-1]) - self.drive.law_time

    @property
    def corners(self) -> FloatArray:
        """Times in s at which the jerk of the law, or of one of its parts, may jump."""
        return self._way[0][:: _PIECES * _STEPS]

    @cached_property
    def _law_way(self) -> tuple[FloatArray, FloatArray]:
        """Times in s and phases in periods of the law itself, from corner to corner."""
        time = _nodes(self.drive.corners)
        return time, _integral(time, self._law_frequency)

    @cached_property
    def _way(self) -> tuple[FloatArray, FloatArray]:
        """Times in s and phases in periods from each corner of each part to the next.

        Time is the integral of the period over the phase, by the frequencies on its own way.
        """
        phase = _nodes(self._shifted(self._law_way[1][:: _PIECES * _STEPS]))
        return _integral(phase, lambda at: 1 / self.path.at(self._state(at)[0])[0]), phase

    @cached_property
    def _law_time(self) -> Any:
        """Times of the law in s over its phases."""
        from scipy.interpolate import CubicHermiteSpline

        time, phase = self._law_way
        return CubicHermiteSpline(phase, time, 1 / self._law_frequency(time))

    def _law_frequency(self, time: FloatArray) -> FloatArray:
        return self.path.at(self.drive.crank_angle(time))[0]

    def _state(self, phase: FloatArray) -> FloatArray:
        """Angle and its first two derivatives over the phase, of all parts together, (3, m)."""
        total = np.zeros((3, len(phase)))
        last = self._law_way[1][-1]
        for later, weight in zip(self.shaper.times, self.shaper.weights, strict=True):
            elapsed = phase - later
            time = self._law_time(np.clip(elapsed, 0.0, last))
            angle, moves = self.drive.crank_angle(time), (elapsed > 0) & (elapsed < last)
            frequency, rate = self.path.at(angle)
            first = np.where(moves, self.drive.crank_speed(time) / frequency, 0.0)
            second = self.drive.crank_acceleration(time) / frequency**2
            second -= rate * first**2 / frequency
            total += weight * np.stack([angle, first, np.where(moves, second, 0.0)])
        return total

    def _motion(self, phase: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Angle, speed and acceleration over time at phases, (m,) each."""
        angle, first, second = self._state(phase)
        frequency, rate = self.path.at(angle)
        return angle, first * frequency, frequency * (second * frequency + rate * first**2)

    def to_table(self) -> TomlTable:
        """Table ``[drive]`` of a model file: rows of what the crank does."""
        return self.tabulated().to_table()

    def tabulated(self) -> TableDrive:
        """The motion as a table, whose spline it is but for some parts in a million."""
        time = self.law.knots
        angle = np.append(self.crank_angle(time[:-1]), self.law.end_angle)
        dwell = self.run_time(1.0) - self.law_time
        return TableDrive(tuple(time), tuple(angle), ends="rest", dwell=dwell)


def _nodes(corners: FloatArray) -> FloatArray:
    """Places evenly spaced from each corner (n,) to the next, ((n - 1) * pieces * steps + 1,)."""
    fraction = np.arange(_PIECES * _STEPS) / (_PIECES * _STEPS)
    return np.append(corners[:-1, None] + np.diff(corners)[:, None] * fraction, corners[-1])


def _integral(x: FloatArray, function: Any) -> FloatArray:
    """Integral of a function from the first of increasing places to each, by Gauss's rule; (N,)."""
    points, weights = np.polynomial.legendre.leggauss(3)
    step = np.diff(x)
    total = np.zeros(len(step))
    for point, weight in zip(points, weights, strict=True):
        total += weight / 2 * step * function(x[:-1] + (point + 1) / 2 * step)
    return np.concatenate([[0.0], np.cumsum(total)])
