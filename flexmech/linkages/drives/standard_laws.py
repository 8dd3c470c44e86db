"""Standard laws of motion from rest to rest, and the drive that moves by one of them.

Sine-constant-cosine acceleration is the family of Norton, *Cam Design and Manufacturing Handbook*,
2nd ed. 2009, ch. 3 (Neklutin 1969), of which cycloid, modified sine and modified trapezoid are
three members; they are the laws of VDI 2143 part 1 (1980) under their English names. The polynomial
4567 has no jump in its acceleration's rate at the ends either.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import ClassVar, Literal, get_args

import numpy as np

from flexmech.errors import InputError
from flexmech.linkages.drives.drive import Drive
from flexmech.linkages.drives.pieces import PiecewiseMotion
from flexmech.model_text import TomlTable, fields_table
from flexmech.units import ANGLE, TIME
from flexmech.validation import (
    NOT_NEGATIVE,
    POSITIVE,
    check_choice,
    check_count,
    check_flag,
    check_number,
)

LawName = Literal["trapezoid", "cycloid", "modified sine", "polynomial 4567"]
"""Laws of motion from rest to rest; trapezoid is the modified one, without a jump."""
LAWS: tuple[LawName, ...] = get_args(LawName)

# Of sine-constant-cosine acceleration: parts of the time with sines at both ends, and with the
# cosine in the middle.
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
        Of a move in rad; negative moves backwards.
    time : float
        Of a move in s.
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
    travel: float
    time: float
    dwell: float = 0.0
    moves: int = 1
    forth_and_back: bool = False
    start_angle: float = 0.0
    speed: ClassVar[float] = 0.0  # type: ignore[misc]

    def __post_init__(self) -> None:
        check_choice(self.kind, LAWS, "law")
        check_number(self.travel, "travel", "rad")
        if self.travel == 0:
            raise InputError("travel must be an angle other than zero, got 0 rad")
        check_number(self.time, "time", "s", POSITIVE)
        check_number(self.dwell, "dwell", "s", NOT_NEGATIVE)
        check_count(self.moves, "moves", most=_MOST_MOVES)
        check_flag(self.forth_and_back, "forth_and_back")
        check_number(self.start_angle, "start_angle", "rad")

    def to_table(self) -> TomlTable:
        """Table ``[drive]`` of a model file."""
        dimensions = {"travel": ANGLE, "time": TIME, "dwell": TIME, "start_angle": ANGLE}
        table: TomlTable = {"law": self.kind, **fields_table(self, dimensions)}
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
            Of no account.
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
