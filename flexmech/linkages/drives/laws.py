"""Drives by laws of motion: standard laws from rest to rest, and splines through tables.

Sine-constant-cosine acceleration is the family of Norton, *Cam Design and Manufacturing Handbook*,
2nd ed. 2009, ch. 3 (Neklutin 1969), of which cycloid, modified sine and modified trapezoid are
three members; they are the laws of VDI 2143 part 1 (1980) under their English names. The polynomial
4567 has no jump in its acceleration's rate at the ends either. A table of crank angles over time
has one spline through it, smoothed if asked for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Any, ClassVar, Literal, get_args

import numpy as np

from flexmech import si
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages.drives.drive import Drive, PiecewiseMotion
from flexmech.model_text import TomlTable, quantity
from flexmech.units import ANGLE, TIME
from flexmech.validation import (
    NOT_NEGATIVE,
    check_choice,
    check_count,
    check_flag,
    check_number,
    checked_array,
)

LawName = Literal["trapezoid", "cycloid", "modified sine", "polynomial 4567"]
"""Laws of motion from rest to rest; trapezoid is the modified one, without a jump."""
LAWS: tuple[LawName, ...] = get_args(LawName)

# Parts of sine-constant-cosine acceleration: parts of the time with sines at both ends, and with
# the cosine in the middle.
_PARTS = {"trapezoid": (0.25, 0.25), "cycloid": (0.5, 0.5), "modified sine": (0.25, 0.75)}
_POLYNOMIAL_4567 = (0.0, 0.0, 0.0, 0.0, 35.0, -84.0, 70.0, -20.0)
# A move and its dwell that is repeated more often is a slip of the keyboard.
_MOST_MOVES = 10_000


@cache
def _unit_law(name: LawName) -> PiecewiseMotion:
    """A law that moves by 1 in the time 1."""
    if name == "polynomial 4567":
        one = np.array([_POLYNOMIAL_4567])
        return PiecewiseMotion(np.array([0.0, 1.0]), one, np.zeros((1, 0, 3)), 1.0)
    b, d = _PARTS[name]
    peak = 4 * np.pi**2 / ((np.pi**2 - 8) * (b**2 - d**2) - 2 * np.pi * (np.pi - 2) * b + np.pi**2)
    # Acceleration: until when, a constant, and a sine of its size, rate and phase at the start.
    quarter = np.pi / 2
    rises = [
        (b / 2, 0.0, peak, np.pi / b, 0.0),
        ((1 - d) / 2, peak, 0.0, 0.0, 0.0),
        ((1 + d) / 2, 0.0, peak, np.pi / d, quarter),
        (1 - b / 2, -peak, 0.0, 0.0, 0.0),
        (1.0, 0.0, peak, np.pi / b, -quarter),
    ]
    knots, polynomials, sines, place, speed = [0.0], [], [], 0.0, 0.0
    for last, constant, size, rate, phase in rises:
        length = last - knots[-1]
        if length <= 0:
            continue
        # Minus the second integral; what it starts with is taken off again.
        wave = -size / rate**2 if size else 0.0
        begin = place - wave * math.sin(phase)
        sloping = (speed - wave * rate * math.cos(phase)) * length
        curved, turned = constant * length**2 / 2, rate * length + phase
        knots.append(last)
        polynomials.append((begin, sloping, curved))
        sines.append([(wave, rate * length, phase)])
        place = begin + sloping + curved + wave * math.sin(turned)
        speed = (sloping + 2 * curved) / length + wave * rate * math.cos(turned)
    return PiecewiseMotion(np.array(knots), np.array(polynomials), np.array(sines), 1.0)


@dataclass(frozen=True)
class LawDrive(Drive):
    """Moves of the crank from rest to rest by a standard law, with a dwell after each.

    Parameters
    ----------
    kind : {"trapezoid", "cycloid", "modified sine", "polynomial 4567"}
        Its shape.
    travel : float
        Travel of a move in rad; negative moves backwards.
    time : float
        Time of a move in s.
    dwell : float
        Rest after each move in s.
    moves : int
        How many moves there are.
    forth_and_back : bool
        Whether every second move goes back; else each goes on from where the last one ended.
    start_angle : float
        Crank angle at time zero in rad.

    Raises
    ------
    InputError
        If there is no such law, the travel is zero, or a time cannot be.

    Examples
    --------
    >>> drive = flexmech.LawDrive("cycloid", travel=2.0, time=0.1, dwell=0.05)
    >>> drive.crank_angle([0.0, 0.05, 0.1, 0.15]).round(12)
    array([0., 1., 2., 2.])
    >>> float(drive.crank_speed(0.05).round(9))  # twice the mean
    40.0
    """

    kind: LawName
    travel: si.Angle
    time: si.RunTime
    dwell: si.TimeOrZero = 0.0
    moves: int = 1
    forth_and_back: bool = False
    start_angle: si.Angle = 0.0
    speed: ClassVar[float] = 0.0  # type: ignore[misc]

    def __post_init__(self) -> None:
        check_choice(self.kind, LAWS, "law")
        si.check(self)
        if self.travel == 0:
            raise InputError("travel must be an angle other than zero, got 0 rad")
        check_count(self.moves, "moves", most=_MOST_MOVES)
        check_flag(self.forth_and_back, "forth_and_back")

    def to_table(self) -> TomlTable:
        """Table ``[drive]`` of a model file."""
        table: TomlTable = {"law": self.kind, **si.table(self)}
        if self.moves > 1:
            table |= {"moves": self.moves, "forth_and_back": self.forth_and_back}
        return table

    @cached_property
    def law(self) -> PiecewiseMotion:
        """Moves and the rests between them; the last rest is the final speed, zero."""
        unit = _unit_law(self.kind)
        ways = np.full(self.moves, float(self.travel))
        if self.forth_and_back:
            ways[1::2] *= -1
        starts = self.start_angle + np.append(0.0, np.cumsum(ways[:-1]))
        once = replace(unit, knots=self.time * unit.knots)
        return once.repeated(starts, self.dwell, ways)

    @property
    def cycle_time(self) -> float:
        """Time of a move and its dwell in s."""
        return self.time + self.dwell

    def stretched(self, factor: float) -> Drive:
        """The same moves over another time, with the same dwells.

        Parameters
        ----------
        factor : float
            By which every move takes longer.

        Returns
        -------
        LawDrive
        """
        return replace(self, time=factor * self.time)

    def run_time(self, revolutions: float) -> float:
        """Duration in s of all moves and dwells.

        Parameters
        ----------
        revolutions : float
            Revolutions of no account.
        """
        return self.moves * self.cycle_time

    @property
    def words(self) -> str:
        """The law, its travel and times."""
        dwell = f", dwell {self.dwell:.4g} s" if self.dwell else ""
        way = ", forth and back" if self.forth_and_back and self.moves > 1 else ""
        times = f", {self.moves} moves{way}" if self.moves > 1 else ""
        travel = f"{np.degrees(self.travel):.4g} deg in {self.time:.4g} s"
        return f"{self.kind}, {travel}{dwell}{times}"


TableEnds = Literal["free", "rest", "held"]
"""How a table begins and ends: as its spline has it; at rest without acceleration; or as its spline
has it, and held after its last row."""
TABLE_ENDS: tuple[TableEnds, ...] = get_args(TableEnds)

# Degree of the spline, whose acceleration is smooth; of fewer rows than that takes the lower one.
_DEGREE, _LOWER_DEGREE = 5, 3
# Part of the travel of a table, or of a tenth of a turn where that is more: rows that leave a
# straight line by this much are on it but for the round-off of their numbers.
_STRAIGHT = 1e-13
# A step whose speed is beyond this many times those of the steps beside it, and that of all others
# on average, is a jump of the angle.
_JUMP = 20.0
_MOST_CYCLES = 10_000


@dataclass(frozen=True)
class TableDrive(Drive):
    """Crank angles at times, with a spline of fifth degree through them.

    With ``smoothing`` the angles are first smoothed by a spline of as few knots as leave them by
    that much on average (Dierckx, *Curve and Surface Fitting with Splines*, 1993). Rows of constant
    speed are a drive of constant speed. After the last row the crank goes on at the speed that it
    has there, or is held: then the speed that it still has there ends within no time, a blow to the
    links.

    Parameters
    ----------
    times : tuple of float
        In s, increasing; the first of them is time zero of the run.
    angles : tuple of float
        In rad.
    smoothing : float
        Root mean square in rad by which the spline may leave the rows; zero goes through them.
    ends : {"free", "rest", "held"}
        Whether the crank begins and ends at rest, without acceleration; or moves as the rows have
        it and is held after the last one.
    moves : int
        How often the table is gone through, each time from the angle that was reached. Where its
        ends are free speed and acceleration are those of its start at the end.
    dwell : float
        Rest in s after each time, of ends that are not free.

    Raises
    ------
    InputError
        If times do not increase, an angle jumps, there are fewer than four rows, or a number is
        none.

    Examples
    --------
    >>> time = np.linspace(0.0, 0.2, 21)
    >>> drive = flexmech.TableDrive(tuple(time), tuple(1 - np.cos(5 * np.pi * time)), ends="rest")
    >>> float(drive.crank_angle(0.2).round(9)), drive.speed
    (2.0, 0.0)
    """

    times: tuple[float, ...]
    angles: tuple[float, ...]
    smoothing: si.Angle = 0.0
    ends: TableEnds = "free"
    moves: int = 1
    dwell: float = 0.0

    def __post_init__(self) -> None:
        times = checked_array(self.times, "times of a table", "s")
        angles = checked_array(self.angles, "angles of a table", "rad")
        check_number(self.smoothing, "smoothing", "rad", NOT_NEGATIVE)
        check_choice(self.ends, TABLE_ENDS, "ends")
        check_count(self.moves, "moves", most=_MOST_CYCLES)
        check_number(self.dwell, "dwell", "s", NOT_NEGATIVE)
        if self.dwell and self.ends == "free":
            raise InputError(
                "a table with a dwell stops: choose ends rest or held, or leave dwell out"
            )
        if times.ndim != 1 or times.shape != angles.shape or len(times) <= _LOWER_DEGREE:
            raise InputError(
                f"the table has {times.size} times and {angles.size} angles; give four rows or "
                "more, each with both"
            )
        falls = np.flatnonzero(np.diff(times) <= 0)
        if falls.size:
            row = int(falls[0])
            raise InputError(
                f"the table is not increasing in time: {times[row + 1]:.6g} s follows "
                f"{times[row]:.6g} s in row {row + 2}; give each time once, in increasing order"
            )
        self._refuse_jumps(times, angles)
        # Plain numbers, so that equal drives compare so and are hashed.
        object.__setattr__(self, "times", tuple(times.tolist()))
        object.__setattr__(self, "angles", tuple(angles.tolist()))

    def _refuse_jumps(self, times: FloatArray, angles: FloatArray) -> None:
        """Refuse a step of half a turn, and one that is far steeper than all beside it."""
        step = np.abs(np.diff(angles))
        slope = step / np.diff(times)
        beside = np.maximum(np.append(slope[1:], 0.0), np.insert(slope[:-1], 0, 0.0))
        others = (slope.sum() - slope) / (len(slope) - 1)
        steep = (slope > _JUMP * np.maximum(beside, others)) & (step > self.smoothing)
        jumps = np.flatnonzero(steep | (step > np.pi))
        if jumps.size:
            row = int(jumps[0])
            raise InputError(
                f"the angle jumps from {np.degrees(angles[row]):.6g} to "
                f"{np.degrees(angles[row + 1]):.6g} deg in row {row + 2}, from {times[row]:.6g} to "
                f"{times[row + 1]:.6g} s; count angles on beyond 360 deg, and give rows between "
                "the two"
            )

    def to_table(self) -> TomlTable:
        """Table ``[drive]`` of a model file, with all rows."""
        rows = [
            [quantity(time, TIME), quantity(angle, ANGLE)]
            for time, angle in zip(self.times, self.angles, strict=True)
        ]
        table: TomlTable = {"table": rows, **si.table(self)}
        table |= {"ends": self.ends} if self.ends != "free" else {}
        table |= {"dwell": quantity(self.dwell, TIME)} if self.dwell else {}
        return table | ({"moves": self.moves} if self.moves > 1 else {})

    @cached_property
    def law(self) -> PiecewiseMotion:
        """The spline in pieces, each time that the table is gone through."""
        time = np.array(self.times) - self.times[0]
        angle = np.array(self.angles)
        free, travel, total = self.ends == "free", float(angle[-1] - angle[0]), float(time[-1])
        # What leaves the straight line from end to end, of which less is lost to round-off.
        speed = travel / total
        bent = angle - angle[0] - speed * time
        fine = _STRAIGHT * max(abs(travel), np.pi / 5) * len(time) ** 0.5
        if free and np.abs(bent).max() <= max(fine, self.smoothing):
            return PiecewiseMotion.steady(float(angle[0]), speed)
        once = _through(time, bent, speed, self, float(angle[0]))
        return once.repeated(travel * np.arange(float(self.moves)), self.dwell)

    @property
    def _pass_time(self) -> float:
        """Time in s of going through the table once, with its dwell."""
        return self.times[-1] - self.times[0] + self.dwell

    @property
    def start_angle(self) -> float:  # type: ignore[override]
        """Crank angle at time zero in rad, as the spline has it."""
        return float(self.law.angle(0.0))

    @property
    def speed(self) -> float:  # type: ignore[override]
        """Crank speed in rad/s after the last row."""
        return self.law.end_speed

    @property
    def turns_on(self) -> bool:
        """Whether the table is one of constant speed: others end with their last row."""
        return self.is_constant and self.speed != 0

    @property
    def cycle_time(self) -> float:
        """Time of the table and its dwell in s; of constant speed that of a turn."""
        return self.revolution_time if self.turns_on else self._pass_time

    def run_time(self, revolutions: float) -> float:
        """Duration in s of the table with its dwell, as often as it is gone through.

        Parameters
        ----------
        revolutions : float
            Revolutions of no account.
        """
        return self.moves * self._pass_time

    def stretched(self, factor: float) -> Drive:
        """The same table over another time, with the same dwells.

        Parameters
        ----------
        factor : float
            By which it takes longer.

        Returns
        -------
        TableDrive

        Raises
        ------
        InputError
            If it does not stop.
        """
        if self.speed:
            return super().stretched(factor)
        return replace(self, times=tuple(factor * time for time in self.times))

    @property
    def corners(self) -> FloatArray:
        """Times in s at which the table begins, again and again, and ends; its spline has none."""
        if self.is_constant:
            return np.zeros(1)
        begins = self._pass_time * np.arange(float(self.moves))
        if not self.dwell:
            return np.append(begins, self.law.end)
        ends = begins + self.times[-1] - self.times[0]
        return np.asarray(np.column_stack([begins, ends]).reshape(-1))

    @property
    def greatest_acceleration(self) -> float:
        """Second derivative of the spline in rad/s^2, greatest size."""
        return float(np.abs(self.crank_acceleration(self.passing_times)).max())

    @property
    def deviation(self) -> float:
        """By how much the spline leaves the rows at most, in rad."""
        time = np.array(self.times) - self.times[0]
        # The end belongs to the last piece.
        inside = np.minimum(time, np.nextafter(time[-1], 0.0))
        return float(np.abs(self.crank_angle(inside) - np.array(self.angles)).max())

    @property
    def spline_words(self) -> str:
        """The table as its spline has it: second derivative, and distance from the rows."""
        spline = (
            f"spline through the table: its second derivative is at most "
            f"{self.greatest_acceleration:.5g} rad/s², and it leaves the rows by at most "
            f"{np.degrees(self.deviation):.3g} deg"
        )
        if (blow := self.law.blow) is None:
            return spline
        return (
            f"{spline}; at {blow[0]:.4g} s its speed jumps by {blow[1]:.4g} rad/s, a blow whose "
            "torque is no number, and its printed value depends on the time step"
        )

    @property
    def words(self) -> str:
        """How many rows, and the travel and time."""
        travel = np.degrees(self.angles[-1] - self.angles[0])
        smoothed = " smoothed" if self.smoothing else ""
        often = f", {self.moves} times" if self.moves > 1 else ""
        held = ", then held" if self.ends == "held" else ""
        dwell = f", dwell {self.dwell:.4g} s" if self.dwell else ""
        return (
            f"table of {len(self.times)} rows{smoothed}, {travel:.4g} deg in "
            f"{self.times[-1] - self.times[0]:.4g} s{held}{dwell}{often}"
        )


def _through(
    time: FloatArray, bent: FloatArray, speed: float, drive: TableDrive, start: float
) -> PiecewiseMotion:
    """The motion by a spline, to which its line from end to end is added, once."""
    from scipy.interpolate import PPoly, make_interp_spline, splev, splrep

    repeats = drive.moves > 1 and drive.ends == "free"
    fitting = _DEGREE if len(time) > _DEGREE else _LOWER_DEGREE
    degree = _DEGREE if drive.ends == "rest" else fitting
    if drive.smoothing:
        allowed = len(time) * drive.smoothing**2
        smooth = splrep(time, bent, k=fitting, s=allowed, per=int(repeats))
        bent = splev(time, smooth)
        if drive.ends == "rest":
            # The ends stay, so that the crank stops where the table says.
            bent[[0, -1]] = 0.0
    ends: Any = None
    if drive.ends == "rest":
        at_rest = [(1, -speed), (2, 0.0)]
        ends = (at_rest, at_rest)
    elif repeats:
        bent[-1] = bent[0]
        ends = "periodic"
    spline = PPoly.from_spline(make_interp_spline(time, bent, k=degree, bc_type=ends))
    span = np.diff(spline.x)
    # Without knots that are there several times, and those of a periodic spline beyond its period.
    kept = (span > 0) & (spline.x[:-1] >= time[0]) & (spline.x[:-1] < time[-1])
    begin, span = spline.x[:-1][kept], span[kept]
    polynomials = spline.c[::-1, kept].T * span[:, None] ** np.arange(len(spline.c))
    polynomials[:, 0] += start + speed * begin
    polynomials[:, 1] += speed * span
    knots = np.append(begin, begin[-1] + span[-1])
    motion = PiecewiseMotion(
        knots, polynomials, np.zeros((len(span), 0, 3)), start + speed * float(time[-1])
    )
    angle, last = (float(reached[-1]) for reached in motion.ends)
    return replace(
        motion,
        end_angle=angle if drive.smoothing else float(drive.angles[-1]),
        end_speed=last if drive.ends == "free" else 0.0,
    )
