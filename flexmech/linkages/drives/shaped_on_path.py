"""A drive that is shaped for a frequency which changes along the path of the crank.

Impulses at fixed times keep one frequency quiet. Where the frequency changes on the way, as the
posture does, the parts of a motion must follow each other by the same *phase* of the vibration:
impulses in periods of the mode, over the phase ``psi = integral f(theta(t)) dt``, in place of
impulses in seconds over time. Time-varying impulse sequences go back to Cho and Park (Robotica 13
(1995) 305); the phase is that of the WKB approximation (Bender and Orszag, *Advanced Mathematical
Methods*, 1978, ch. 10), which holds where the frequency changes little within a period.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages.drives.drive import Drive
from flexmech.linkages.drives.hermite import hermite_pieces
from flexmech.linkages.drives.pieces import PiecewiseMotion
from flexmech.linkages.drives.shaped import ShapedDrive
from flexmech.linkages.drives.tabulated import TableDrive
from flexmech.model_text import TomlTable
from flexmech.validation import check_instance, checked_array

# From one corner of the law to the next: nodes at which the phase is known, and pieces of the
# fifth degree, whose error falls with the sixth power of their length.
_NODES, _PIECES = 2000, 24
# Of an interval: as far inside of it as this its ends are taken, as accelerations may jump there.
_INSIDE = 1e-9


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
    def _phases(self) -> _Phases:
        return _Phases.of(self.drive, self.path)

    @cached_property
    def _corner_phases(self) -> FloatArray:
        """Phase in periods at each corner of each part, in order."""
        return self._shifted(self._phases.at(self.drive.corners))

    @cached_property
    def _corner_times(self) -> FloatArray:
        """Times of the shaped motion at these, from the frequencies on its own way."""
        return np.asarray(self._times(_NODES)[:: _NODES - 1])

    def _nodes(self, count: int) -> FloatArray:
        """Phases evenly spaced from each corner to the next, (intervals * (count - 1) + 1,)."""
        corners, part = self._corner_phases, np.arange(count - 1) / (count - 1)
        inside = corners[:-1, None] + np.diff(corners)[:, None] * part
        return np.append(inside, corners[-1])

    def _times(self, count: int) -> FloatArray:
        """Time in s at phases of :meth:`_nodes`: the integral of the period over the phase."""
        phase = self._nodes(count)
        return _integral(phase, lambda at: 1 / self.path.at(self._state(at)[0])[0])

    def _state(self, phase: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Angle, and its first and second derivative over the phase, as sums of all parts."""
        total = np.zeros((3, len(phase)))
        for later, weight in zip(self.shaper.times, self.shaper.weights, strict=True):
            total += weight * np.stack(self._phases.state(phase - later))
        return total[0], total[1], total[2]

    @cached_property
    def law(self) -> PiecewiseMotion:
        """Quintics that meet with equal speeds, and accelerations where the law's do not jump."""
        stride = (_NODES - 1) // _PIECES
        count = stride * _PIECES + 1
        time, phase = self._times(count)[::stride], self._nodes(count)[::stride]
        inside = _INSIDE * np.diff(phase)
        starts, ends = self._motion(phase[:-1] + inside), self._motion(phase[1:] - inside)
        pieces = hermite_pieces(time, starts, ends)
        return PiecewiseMotion.chained(pieces, self.drive.law.end_angle)

    def _motion(self, phase: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Angle, speed and acceleration over time at phases, (m,) each."""
        angle, first, second = self._state(phase)
        frequency, rate = self.path.at(angle)
        return angle, first * frequency, frequency * (second * frequency + rate * first**2)

    @property
    def delay(self) -> float:
        """By how much the law is longer, in s."""
        return float(self._corner_times[-1]) - self.drive.law_time

    @property
    def corners(self) -> FloatArray:
        """Times in s at which the jerk of the law, or of one of its parts, may jump."""
        return self._corner_times

    def to_table(self) -> TomlTable:
        """Table ``[drive]`` of a model file: rows of what the crank does."""
        return self.tabulated().to_table()

    def tabulated(self) -> TableDrive:
        """The motion as a table, whose spline it is but for some parts in a million."""
        time = self.law.knots
        angle = np.append(self.crank_angle(time[:-1]), self.law.end_angle)
        dwell = self.run_time(1.0) - self.law_time
        return TableDrive(tuple(time), tuple(angle), ends="rest", dwell=dwell)


@dataclass(frozen=True)
class _Phases:
    """Phase of a mode while a law goes on: times and phases at nodes, each corner among them.

    Parameters
    ----------
    drive : Drive
    path : FrequenciesOnPath
    time, phase : ndarray, shape (N,)
        In s and in periods.
    """

    drive: Drive
    path: FrequenciesOnPath
    time: FloatArray
    phase: FloatArray

    @classmethod
    def of(cls, drive: Drive, path: FrequenciesOnPath) -> _Phases:
        """Of a law from its start to its end."""
        corners, part = drive.corners, np.arange(_NODES - 1) / (_NODES - 1)
        inside = corners[:-1, None] + np.diff(corners)[:, None] * part
        time = np.append(inside, corners[-1])
        return cls(drive, path, time, _integral(time, lambda at: path.at(drive.crank_angle(at))[0]))

    def _frequency(self, time: FloatArray) -> FloatArray:
        return self.path.at(self.drive.crank_angle(time))[0]

    def at(self, time: FloatArray) -> FloatArray:
        """Phases at times from the start to the end, (m,)."""
        from scipy.interpolate import CubicHermiteSpline

        along = CubicHermiteSpline(self.time, self.phase, self._frequency(self.time))
        return np.asarray(along(time))

    def state(self, phase: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Angle of the law, and its first and second derivative over the phase, at any phases."""
        from scipy.interpolate import CubicHermiteSpline

        inverse = CubicHermiteSpline(self.phase, self.time, 1 / self._frequency(self.time))
        time = inverse(np.clip(phase, 0.0, self.phase[-1]))
        angle = self.drive.crank_angle(time)
        frequency, rate = self.path.at(angle)
        moves = (phase > 0) & (phase < self.phase[-1])
        first = np.where(moves, self.drive.crank_speed(time) / frequency, 0.0)
        second = self.drive.crank_acceleration(time) / frequency**2 - rate * first**2 / frequency
        return angle, first, np.where(moves, second, 0.0)


def _integral(x: FloatArray, function: Any) -> FloatArray:
    """Integral of a function from the first of increasing places to each, by Gauss's rule; (N,)."""
    points, weights = np.polynomial.legendre.leggauss(3)
    step = np.diff(x)
    total = np.zeros(len(step))
    for point, weight in zip(points, weights, strict=True):
        total += weight / 2 * step * function(x[:-1] + (point + 1) / 2 * step)
    return np.concatenate([[0.0], np.cumsum(total)])
