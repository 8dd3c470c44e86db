"""Standard laws of motion from rest to rest, and the drive that moves by one of them.

Sine-constant-cosine acceleration is the family of Norton, *Cam Design and Manufacturing Handbook*,
2nd ed. 2009, ch. 3 (Neklutin 1969), of which cycloid, modified sine and modified trapezoid are
three members; they are the laws of VDI 2143 part 1 (1980) under their English names. The polynomial
4567 has no jump in its acceleration's rate at the ends either.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import ClassVar, Literal, get_args

import numpy as np

from flexmech.errors import InputError
from flexmech.linkages.drives.drive import Drive
from flexmech.linkages.drives.pieces import MotionPiece, PiecewiseMotion, Sine
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
def unit_law(name: LawName) -> tuple[MotionPiece, ...]:
    """Pieces of a law that moves by 1 in the time 1.

    Parameters
    ----------
    name : {"trapezoid", "cycloid", "modified sine", "polynomial 4567"}

    Returns
    -------
    tuple of MotionPiece
    """
    if name == "polynomial 4567":
        return (MotionPiece(0.0, 1.0, _POLYNOMIAL_4567),)
    b, d = _PARTS[name]
    peak = 4 * np.pi**2 / ((np.pi**2 - 8) * (b**2 - d**2) - 2 * np.pi * (np.pi - 2) * b + np.pi**2)
    # Acceleration over x: a constant, and a sine of its size, rate and phase at the piece's start.
    quarter = np.pi / 2
    rises: list[tuple[float, float, float, float, float]] = [
        (0.0, b / 2, 0.0, peak, 0.0),
        (b / 2, (1 - d) / 2, peak, 0.0, 0.0),
        ((1 - d) / 2, (1 + d) / 2, 0.0, peak, quarter),
        ((1 + d) / 2, 1 - b / 2, -peak, 0.0, 0.0),
        (1 - b / 2, 1.0, 0.0, peak, -quarter),
    ]
    rates = (np.pi / b, 0.0, np.pi / d, 0.0, np.pi / b)
    pieces, place, speed = list[MotionPiece](), 0.0, 0.0
    for (first, last, constant, size, phase), rate in zip(rises, rates, strict=True):
        length = last - first
        if length <= 0:
            continue
        sines: tuple[Sine, ...] = ()
        begin, own_speed = place, speed
        if size:
            # Minus the second integral; what it starts with is taken off again.
            wave = -size / rate**2
            begin -= wave * math.sin(phase)
            own_speed -= wave * rate * math.cos(phase)
            sines = ((wave, rate * length, phase),)
        polynomial = (begin, own_speed * length, constant * length**2 / 2)
        pieces.append(MotionPiece(first, length, polynomial, sines))
        place, speed = pieces[-1].end
    return tuple(pieces)


@dataclass(frozen=True)
class LawDrive(Drive):
    """Moves of the crank from rest to rest by a standard law, with a dwell after each.

    Parameters
    ----------
    kind : {"trapezoid", "cycloid", "modified sine", "polynomial 4567"}
        See :func:`unit_law`.
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
        pieces, angle = list[MotionPiece](), float(self.start_angle)
        for number in range(self.moves):
            way = -self.travel if self.forth_and_back and number % 2 else self.travel
            begin = number * self.cycle_time
            pieces += _scaled(unit_law(self.kind), begin, angle, self.time, way)
            angle += way
            if self.dwell and number + 1 < self.moves:
                pieces.append(MotionPiece(begin + self.time, self.dwell, (angle,)))
        return PiecewiseMotion.chained(pieces, angle)

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


def _scaled(
    law: Sequence[MotionPiece], begin: float, angle: float, time: float, travel: float
) -> list[MotionPiece]:
    """A unit law that begins at a time and an angle."""
    return [
        replace(
            piece.times(travel), start=time * piece.start, duration=time * piece.duration
        ).moved(begin, angle)
        for piece in law
    ]
