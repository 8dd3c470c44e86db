"""A drive whose law is given in parts, at the times and with the weights of an input shaper.

Impulses at fixed times keep one frequency quiet. Where the frequency changes on the way, as the
posture does, the parts of a motion must follow each other by the same *phase* of the vibration:
impulses in periods of the mode, over the phase ``psi = integral f(theta(t)) dt``, in place of
impulses in seconds over time. Time-varying impulse sequences go back to Cho and Park (Robotica 13
(1995) 305); the phase is that of the WKB approximation (Bender and Orszag, *Advanced Mathematical
Methods*, 1978, ch. 10), which holds where the frequency changes little within a period.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages.drives.drive import Drive
from flexmech.linkages.drives.pieces import PiecewiseMotion
from flexmech.linkages.drives.shapers import InputShaper
from flexmech.linkages.drives.tabulated import TableDrive
from flexmech.model_text import TomlTable
from flexmech.validation import check_instance, checked_array

# Times that differ by less, over the whole, are one: sums of the same times in another order.
_SAME = 1e-12
# From one corner of the law to the next: pieces of the fifth degree, whose error falls with the
# sixth power of their length, and in each piece steps of the integrals of phase and time.
_PIECES, _STEPS = 24, 84
# Distance inside an interval at which its ends are evaluated: accelerations may jump at them.
_INSIDE = 1e-9


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
    # Of a table that begins free its spline has some speed of round-off.
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
            Of no account.
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
        found = checked_array(self.frequencies, "frequencies on the path", "Hz")
        if angles.ndim != 1 or angles.shape != found.shape or len(angles) < 6:
            raise InputError(
                f"got {angles.size} crank angles and {found.size} frequencies; give six or more of "
                "both"
            )
        if (np.diff(angles) <= 0).any() or (found <= 0).any():
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
            own = phase - later
            time = self._law_time(np.clip(own, 0.0, last))
            angle, moves = self.drive.crank_angle(time), (own > 0) & (own < last)
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
    part = np.arange(_PIECES * _STEPS) / (_PIECES * _STEPS)
    return np.append(corners[:-1, None] + np.diff(corners)[:, None] * part, corners[-1])


def _integral(x: FloatArray, function: Any) -> FloatArray:
    """Integral of a function from the first of increasing places to each, by Gauss's rule; (N,)."""
    points, weights = np.polynomial.legendre.leggauss(3)
    step = np.diff(x)
    total = np.zeros(len(step))
    for point, weight in zip(points, weights, strict=True):
        total += weight / 2 * step * function(x[:-1] + (point + 1) / 2 * step)
    return np.concatenate([[0.0], np.cumsum(total)])
