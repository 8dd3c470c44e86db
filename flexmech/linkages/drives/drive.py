"""Prescribed motion of the crank: its angle over time in pieces of polynomials and sines."""

from __future__ import annotations

import abc
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from flexmech import si
from flexmech.arrays import FloatArray, IntArray
from flexmech.errors import InputError
from flexmech.linkages.linkage import Linkage
from flexmech.linkages.motion import RigidMotion
from flexmech.model_text import TomlTable
from flexmech.units import ANGULAR_SPEED
from flexmech.validation import NOT_NEGATIVE, check_number

# Part of a motion's speeds, or of a radian over its whole time: what splines leave of rest.
_ROUND_OFF = 1e-9
# Moves forth and back are alike but for this part of their speed.
_ALIKE = 1e-12


@dataclass(frozen=True, eq=False)
class PiecewiseMotion:
    """Angle over time: n pieces one after the other, then a constant speed.

    With ``tau`` from 0 to 1 over a piece it is ``sum_k p[k] tau^k + sum a sin(w tau + phase)``.

    Parameters
    ----------
    knots : ndarray, shape (n + 1,)
        Times in s at which pieces begin, and at which the last one ends; of a motion whose speed
        is constant from the start zero alone.
    polynomials : ndarray, shape (n, k)
        Coefficients ``p`` in rad, that of the zeroth power first.
    sines : ndarray, shape (n, s, 3)
        ``a`` in rad, ``w`` and ``phase`` in rad of each.
    end_angle, end_speed : float
        Angle at the end, and speed from then on, in rad and rad/s.
    """

    knots: FloatArray
    polynomials: FloatArray
    sines: FloatArray
    end_angle: float
    end_speed: float = 0.0

    @classmethod
    def steady(cls, angle: float, speed: float) -> PiecewiseMotion:
        """Constant speed from the start, in rad and rad/s."""
        return cls(np.zeros(1), np.zeros((0, 1)), np.zeros((0, 0, 3)), angle, speed)

    @classmethod
    def hermite(
        cls,
        knots: FloatArray,
        starts: Sequence[FloatArray],
        ends: Sequence[FloatArray],
        end_angle: float,
        end_speed: float = 0.0,
    ) -> PiecewiseMotion:
        """Polynomials between instants at which angles and some of their derivatives are known.

        SciPy's ``BPoly.from_derivatives`` takes one interval after the other: too slow for the
        steps of a run.

        Parameters
        ----------
        knots : ndarray, shape (n + 1,)
            Increasing, in s.
        starts, ends : sequence of ndarray, shape (n,)
            Angle in rad and its time derivatives where each piece starts and ends.
        end_angle, end_speed : float
            In rad and rad/s.

        Returns
        -------
        PiecewiseMotion
        """
        count = len(starts)
        scales = [np.diff(knots) ** order / math.factorial(order) for order in range(count)]
        lower = [start * by for start, by in zip(starts, scales, strict=True)]
        # What the powers of the start leave at the end is made by as many higher ones.
        left = [
            end * scales[order]
            - sum(math.comb(power, order) * row for power, row in enumerate(lower))
            for order, end in enumerate(ends)
        ]
        matrix = [[math.comb(count + j, order) for j in range(count)] for order in range(count)]
        higher = np.linalg.inv(np.array(matrix, dtype=float)) @ np.stack(left)
        polynomials = np.concatenate([np.stack(lower), higher]).T
        return cls(knots, polynomials, np.zeros((len(knots) - 1, 0, 3)), end_angle, end_speed)

    def angle(self, time: ArrayLike) -> FloatArray:
        """Angle in rad at times in s; shape (...) -> (...)."""
        return self._values(time, 0)

    def speed(self, time: ArrayLike) -> FloatArray:
        """Speed in rad/s at times in s; shape (...) -> (...)."""
        return self._values(time, 1)

    def acceleration(self, time: ArrayLike) -> FloatArray:
        """Acceleration in rad/s^2 at times in s; shape (...) -> (...)."""
        return self._values(time, 2)

    @property
    def is_steady(self) -> bool:
        """Whether the speed is constant from the start."""
        return len(self.polynomials) == 0

    @property
    def end(self) -> float:
        """When the last piece ends, in s."""
        return float(self.knots[-1])

    @property
    def ends(self) -> tuple[FloatArray, FloatArray]:
        """Angle in rad and speed in rad/s at the end of each piece, (n,)."""
        size, rate, phase = np.moveaxis(self.sines, 2, 0)
        powers = np.arange(self.polynomials.shape[1])
        angle = self.polynomials.sum(axis=1) + np.sum(size * np.sin(rate + phase), axis=1)
        speed = self.polynomials @ powers + np.sum(size * rate * np.cos(rate + phase), axis=1)
        return angle, speed / self._spans

    @property
    def blow(self) -> tuple[float, float] | None:
        """Time in s and size in rad/s of the greatest jump of the speed; None where it has none."""
        if self.is_steady:
            return None
        before = self.ends[1]
        jumps = self.speed(self.knots[1:]) - before
        place = first_greatest(jumps)
        if abs(jumps[place]) <= _ROUND_OFF * max(float(np.abs(before).max()), 1 / self.end):
            return None
        return float(self.knots[1 + place]), float(jumps[place])

    def repeated(
        self, starts: FloatArray, dwell: float, factors: FloatArray | None = None
    ) -> PiecewiseMotion:
        """The same motion, which stops, again and again with a rest between.

        Parameters
        ----------
        starts : ndarray, shape (m,)
            By how many rad it is moved on, each time.
        dwell : float
            Dwell of each rest, in s.
        factors : ndarray, shape (m,), optional
            By which the angles are multiplied before; one if left out.

        Returns
        -------
        PiecewiseMotion
        """
        times = len(starts)
        factor = np.ones(times) if factors is None else factors
        polynomials = factor[:, None, None] * self.polynomials
        polynomials[:, :, 0] += starts[:, None]
        sines = np.repeat(self.sines[None], times, axis=0)
        sines[..., 0] *= factor[:, None, None]
        begins = self.knots[:-1]
        if dwell:
            rest = np.zeros((times, 1, polynomials.shape[2]))
            rest[:, 0, 0] = factor * self.ends[0][-1] + starts
            polynomials = np.concatenate([polynomials, rest], axis=1)
            sines = np.concatenate([sines, np.zeros((times, 1, *sines.shape[2:]))], axis=1)
            begins = self.knots
        every = (self.end + dwell) * np.arange(times)
        count = polynomials.shape[1] * times - (dwell > 0)
        return PiecewiseMotion(
            np.append((every[:, None] + begins).reshape(-1)[:count], every[-1] + self.end),
            np.concatenate(polynomials)[:count],
            np.concatenate(sines)[:count],
            float(factor[-1] * self.end_angle + starts[-1]),
            self.end_speed,
        )

    def within(self, start: FloatArray, span: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Polynomials and sines of intervals, at rest before the first piece and after the last.

        Parameters
        ----------
        start, span : ndarray, shape (m,)
            Where intervals begin, and how long they are, in s. No knot is inside one.

        Returns
        -------
        polynomials : ndarray, shape (m, k)
        sines : ndarray, shape (m, s, 3)
        """
        middle = start + span / 2
        number = self._number(middle)
        length = self._spans[number]
        begin, ratio = (start - self.knots[number]) / length, span / length
        coefficients, sines = self.polynomials[number], self.sines[number]
        moved = np.zeros_like(coefficients)
        for power in range(coefficients.shape[1]):
            for above in range(power, coefficients.shape[1]):
                moved[:, power] += (
                    math.comb(above, power) * coefficients[:, above] * begin ** (above - power)
                )
        moved *= ratio[:, None] ** np.arange(coefficients.shape[1])
        sines[..., 2] += sines[..., 1] * begin[:, None]
        sines[..., 1] *= ratio[:, None]
        for rests, angle in (
            (middle < 0, float(self.angle(0.0))),
            (middle >= self.end, self.end_angle),
        ):
            moved[rests], sines[rests] = 0.0, 0.0
            moved[rests, 0] = angle
        return moved, sines

    def _number(self, time: FloatArray) -> IntArray:
        """Pieces (...) at times (...), the first and the last one beyond."""
        number: IntArray = np.searchsorted(self.knots[:-1], time, side="right")
        return np.maximum(number - 1, 0)

    @cached_property
    def _spans(self) -> FloatArray:
        return np.diff(self.knots)

    @cached_property
    def _waves(self) -> FloatArray:
        """Size, rate and phase of the pieces' sines, (s, 3, n)."""
        return np.moveaxis(self.sines, 0, 2)

    @cached_property
    def _derivatives(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Coefficients of the pieces' polynomials and of their first two derivatives."""
        missing = max(0, 3 - self.polynomials.shape[1])
        table = np.pad(self.polynomials, ((0, 0), (0, missing)))
        powers = np.arange(table.shape[1])
        first = (table * powers)[:, 1:]
        return table, first, (first * powers[:-1])[:, 1:]

    def _values(self, time: ArrayLike, order: int) -> FloatArray:
        t, end = np.asarray(time, dtype=float), self.knots[-1]
        after = (self.end_angle + self.end_speed * (t - end), self.end_speed, 0.0)[order]
        if self.is_steady:
            return np.array(np.broadcast_to(after, t.shape))
        number = self._number(t)
        span = self._spans[number]
        fraction = (np.minimum(t, end) - self.knots[number]) / span
        value = np.zeros(t.shape)
        for column in self._derivatives[order].T[::-1]:
            value = value * fraction + column[number]
        for size, rate, phase in self._waves[:, :, number]:
            # The derivative of a sine is a quarter of a period ahead.
            value = value + size * rate**order * np.sin(rate * fraction + phase + order * np.pi / 2)
        return np.asarray(np.where(t >= end, after, value / span**order))


def first_greatest(values: FloatArray) -> int:
    """Place of the greatest size among values (m,), the first one of those alike."""
    size = np.abs(values)
    return int(np.argmax(size >= (1 - _ALIKE) * size.max()))


# Samples of a law, and the fewest of each of its pieces.
_SAMPLES, _OF_A_PIECE = 240, 4
# Samples of a turn, both ends included: one every five degrees.
_OF_A_TURN = 73


class Drive(abc.ABC):
    """Prescribed angle of the crank over time: a law of motion, then a constant speed.

    A crank that is to stop has the final speed zero. All drives are evaluated in one form, pieces
    of polynomials and sines, by both engines and by the kinematics.

    Attributes
    ----------
    start_angle : float
        Crank angle at time zero in rad.
    speed : float
        Final crank speed in rad/s, from :attr:`law_time` on.

    Examples
    --------
    >>> drive = flexmech.ConstantSpeed(20.0)
    >>> isinstance(drive, flexmech.Drive), float(drive.crank_angle(0.1))
    (True, 2.0)
    """

    start_angle: float
    speed: float

    @property
    @abc.abstractmethod
    def law(self) -> PiecewiseMotion:
        """The motion in pieces."""

    @property
    @abc.abstractmethod
    def words(self) -> str:
        """Description of the drive, for titles."""

    @abc.abstractmethod
    def to_table(self) -> TomlTable:
        """Table ``[drive]`` of a model file."""

    @property
    def law_time(self) -> float:
        """Time in s from which on the crank turns at its final speed."""
        return self.law.end

    @property
    def speed_unit(self) -> str:
        """Unit in which results speak of crank speeds."""
        return ANGULAR_SPEED.unit

    @property
    def is_constant(self) -> bool:
        """Whether the crank turns at its final speed, or stands, from the start."""
        return self.law.is_steady

    @property
    def repeats(self) -> bool:
        """Whether the crank moves in every turn as in the one before."""
        return self.is_constant

    @property
    def turns_on(self) -> bool:
        """Whether a run goes on at the final speed after the law, turn by turn."""
        return self.speed != 0

    @property
    def revolution_time(self) -> float:
        """Time of a revolution at the final speed in s; infinite of a crank that stops."""
        return 2 * np.pi / abs(self.speed) if self.speed else np.inf

    @property
    def cycle_time(self) -> float:
        """Time in s over which samples are counted: of a turn at the final speed, or of a move."""
        return self.revolution_time

    def run_time(self, revolutions: float) -> float:
        """Duration in s of a run: the law, and turns at the final speed after it.

        Parameters
        ----------
        revolutions : float
            Revolutions of no account where the crank stops: such a run lasts as long as the law.

        Returns
        -------
        float
        """
        return self.law_time + (revolutions * self.revolution_time if self.speed else 0.0)

    def stretched(self, factor: float) -> Drive:
        """The same law over another time, with the same dwells.

        Parameters
        ----------
        factor : float
            By which every move takes longer.

        Returns
        -------
        Drive

        Raises
        ------
        InputError
            If the drive has no moves.
        """
        raise InputError(
            f"times of a move need a law that stops, and the crank goes on turning ({self.words}); "
            'give a law in [drive], as law = "cycloid" with travel, time and dwell'
        )

    def crank_angle(self, time: ArrayLike) -> FloatArray:
        """Crank angle in rad at times in s; shape (...) -> (...)."""
        return self.law.angle(time)

    def crank_speed(self, time: ArrayLike) -> FloatArray:
        """Crank speed in rad/s at times in s; shape (...) -> (...)."""
        return self.law.speed(time)

    def crank_acceleration(self, time: ArrayLike) -> FloatArray:
        """Crank acceleration in rad/s^2 at times in s; shape (...) -> (...)."""
        return self.law.acceleration(time)

    def motion(self, linkage: Linkage, time: ArrayLike) -> RigidMotion:
        """Rigid motion of a linkage with this drive, at times in s of shape (m,)."""
        return linkage.motion(
            self.crank_angle(time), self.crank_speed(time), self.crank_acceleration(time)
        )

    @property
    def passing_times(self) -> FloatArray:
        """Times in s at which the crank passes all that it passes, (m,).

        Within every piece of the law, and over a turn at the final speed.
        """
        knots = self.law.knots
        count = max(_OF_A_PIECE, _SAMPLES // max(1, len(knots) - 1))
        parts = np.arange(count) / count
        inside = (knots[:-1, None] + np.diff(knots)[:, None] * parts).reshape(-1)
        if not self.turns_on:
            return np.append(inside, self.law_time)
        turn = self.law_time + self.revolution_time * np.linspace(0.0, 1.0, _OF_A_TURN)
        return np.append(inside, turn)

    @property
    def corners(self) -> FloatArray:
        """Times in s, the first and the last of the law among them, at which its jerk may jump."""
        return self.law.knots

    @property
    def greatest_speed(self) -> float:
        """The greatest crank speed in rad/s, with its sign; that of rest where it never moves."""
        speeds = self.crank_speed(self.passing_times)
        return float(speeds[first_greatest(speeds)])

    def passed_angles(self, count: int) -> FloatArray:
        """Crank angles that the crank passes, evenly spaced and of one turn at most.

        Parameters
        ----------
        count : int
            At most, of a whole turn.

        Returns
        -------
        ndarray, shape (count,)
            In rad, the end of a whole turn left out.
        """
        angles = self.crank_angle(self.passing_times)
        low, high = float(angles.min()), float(angles.max())
        if self.turns_on or high - low >= 2 * np.pi:
            turn = np.linspace(0.0, 2 * np.pi, count, endpoint=False)
            return np.asarray(self.start_angle + turn)
        return np.linspace(low, high, count)


@dataclass(frozen=True)
class ConstantSpeed(Drive):
    """Constant speed after an optional cycloidal run-up.

    During the run-up of duration ``T`` the speed is
    ``speed * (t / T - sin(2 pi t / T) / (2 pi))``, whose acceleration starts and ends at
    zero (Simo & Vu-Quoc 1986, the spin-up maneuver).

    Parameters
    ----------
    speed : float
        Final crank speed in rad/s; negative turns backwards.
    run_up_time : float
        Duration of the run-up in s; zero turns at the final speed from the start.
    start_angle : float
        Crank angle at time zero in rad.

    Raises
    ------
    InputError
        If the speed is zero or not finite, or the run-up time is negative.

    Examples
    --------
    >>> drive = flexmech.ConstantSpeed(speed=20.0, run_up_time=0.5)
    >>> drive.crank_speed([0.0, 0.25, 0.5]).round(9)
    array([ 0., 10., 20.])
    """

    speed: si.Speed
    run_up_time: si.TimeOrZero = 0.0
    start_angle: si.Angle = 0.0

    def __post_init__(self) -> None:
        check_number(self.speed, "crank speed", "rad/s")
        # At the least numbers a turn takes longer than numbers tell.
        if not np.isfinite(self.revolution_time):
            raise InputError(
                f"crank speed must be a number other than zero, got {self.speed:g} rad/s; give a "
                "speed at which the crank turns"
            )
        check_number(self.run_up_time, "run-up time", "s", NOT_NEGATIVE)
        check_number(self.start_angle, "start angle", "rad")

    def to_table(self) -> TomlTable:
        """Table ``[drive]`` of a model file."""
        return si.table(self)

    @cached_property
    def law(self) -> PiecewiseMotion:
        """The run-up; no pieces of a constant speed."""
        begin, total = float(self.start_angle), float(self.run_up_time)
        if not total:
            return PiecewiseMotion.steady(begin, float(self.speed))
        extent, turn = self.speed * total, 2 * np.pi
        # The second integral of 1 - cos(2 pi tau).
        rising = np.array([[begin - extent / turn**2, 0.0, extent / 2]])
        sine = np.array([[[extent / turn**2, turn, np.pi / 2]]])
        end = begin + extent / 2
        return PiecewiseMotion(np.array([0.0, total]), rising, sine, end, float(self.speed))

    @property
    def words(self) -> str:
        """The final speed, and the run-up."""
        after = f" after a run-up of {self.run_up_time:.3g} s" if self.run_up_time else ""
        return f"{self.speed:.10g} rad/s{after}"


@dataclass(frozen=True)
class LockedCrank(Drive):
    """A crank whose shaft is fixed at an angle.

    Parameters
    ----------
    angle : float
        In rad.

    Raises
    ------
    InputError
        If it is no number.
    """

    angle: float
    speed: ClassVar[float] = 0.0  # type: ignore[misc]

    def __post_init__(self) -> None:
        check_number(self.angle, "angle of a locked crank", "rad")

    @property
    def start_angle(self) -> float:  # type: ignore[override]
        """The angle in rad."""
        return self.angle

    def to_table(self) -> TomlTable:
        """None: a model file has a crank that turns."""
        return {}

    @cached_property
    def law(self) -> PiecewiseMotion:
        """Rest."""
        return PiecewiseMotion.steady(float(self.angle), 0.0)

    @property
    def words(self) -> str:
        """Where the crank is fixed."""
        return f"crank fixed at {np.degrees(self.angle):.4g} deg"
