"""A drive whose law is given in parts, at the times and with the weights of an input shaper."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import ClassVar, Self

import numpy as np
from numpy.polynomial.polynomial import polyadd

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages.drives.drive import Drive
from flexmech.linkages.drives.pieces import MotionPiece, PiecewiseMotion, Sine
from flexmech.linkages.drives.shapers import InputShaper
from flexmech.model_text import TomlTable
from flexmech.validation import check_instance

# Times that differ by less, over the whole, are one: sums of the same times in another order.
_SAME = 1e-12


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
        knots = self._shifted(self.drive.law.knots)
        pieces = [self._piece(float(first), float(last)) for first, last in pairwise(knots)]
        return PiecewiseMotion.chained(pieces, self.drive.law.end_angle)

    def _piece(self, first: float, last: float) -> MotionPiece:
        """The motion from one knot to the next."""
        law, middle, duration = self.drive.law, (first + last) / 2, last - first
        polynomial: FloatArray = np.zeros(1)
        sines = list[Sine]()
        for time, weight in zip(self.shaper.times, self.shaper.weights, strict=True):
            if middle >= time + law.end:
                polynomial[0] += weight * law.end_angle
                continue
            if middle < time:
                polynomial[0] += weight * float(law.angle(0.0))
                continue
            part = law.piece_at(middle - time).part(first - time, duration).times(weight)
            polynomial = np.asarray(polyadd(polynomial, part.polynomial), dtype=float)
            sines += part.sines
        return MotionPiece(first, duration, tuple(polynomial.tolist()), tuple(sines))

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
