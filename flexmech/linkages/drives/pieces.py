"""A motion in pieces, each a polynomial of time and sines: the one form of all laws."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray

Sine = tuple[float, float, float]

# Of the speeds of a motion, or of a radian over its whole time: what splines leave of rest.
_ROUND_OFF = 1e-9


@dataclass(frozen=True)
class MotionPiece:
    """``sum_k p[k] tau^k + sum a sin(w tau + phase)`` with ``tau = (t - start) / duration``.

    Parameters
    ----------
    start, duration : float
        In s.
    polynomial : tuple of float
        Coefficients ``p`` in rad, that of the zeroth power first.
    sines : tuple of tuple of float
        ``a`` in rad, ``w`` and ``phase`` in rad of each.
    """

    start: float
    duration: float
    polynomial: tuple[float, ...]
    sines: tuple[Sine, ...] = ()

    @property
    def end(self) -> tuple[float, float]:
        """Angle in rad and speed in rad/s at its end."""
        angle = sum(self.polynomial)
        speed = sum(power * each for power, each in enumerate(self.polynomial))
        for size, rate, phase in self.sines:
            angle += size * math.sin(rate + phase)
            speed += size * rate * math.cos(rate + phase)
        return angle, speed / self.duration

    def moved(self, time: float, angle: float) -> MotionPiece:
        """The same, later by a time in s and further on by an angle in rad."""
        first, *rest = self.polynomial
        return replace(self, start=self.start + time, polynomial=(first + angle, *rest))

    def part(self, start: float, duration: float) -> MotionPiece:
        """The same motion over a part of its time, in s; or beyond it, as its formula goes on."""
        begin, ratio = (start - self.start) / self.duration, duration / self.duration
        polynomial = tuple(
            ratio**power
            * sum(
                math.comb(above, power) * each * begin ** (above - power)
                for above, each in enumerate(self.polynomial)
                if above >= power
            )
            for power in range(len(self.polynomial))
        )
        sines = tuple(
            (size, rate * ratio, phase + rate * begin) for size, rate, phase in self.sines
        )
        return MotionPiece(start, duration, polynomial, sines)

    def times(self, weight: float) -> MotionPiece:
        """The same with all angles times a weight."""
        polynomial = tuple(weight * each for each in self.polynomial)
        sines = tuple((weight * size, rate, phase) for size, rate, phase in self.sines)
        return replace(self, polynomial=polynomial, sines=sines)


@dataclass(frozen=True)
class PiecewiseMotion:
    """Angle over time: pieces one after the other from time zero, then a constant speed.

    Parameters
    ----------
    pieces : tuple of MotionPiece
        None of a motion whose speed is constant from the start.
    end : float
        When the last piece ends, in s.
    end_angle, end_speed : float
        Angle then, and speed from then on, in rad and rad/s.
    """

    pieces: tuple[MotionPiece, ...]
    end: float
    end_angle: float
    end_speed: float

    @classmethod
    def chained(
        cls, pieces: Sequence[MotionPiece], end_angle: float, end_speed: float = 0.0
    ) -> Self:
        """Pieces that follow each other, and what the last of them leaves.

        Parameters
        ----------
        pieces : sequence of MotionPiece
            One or more.
        end_angle, end_speed : float
            Angle at the end in rad, and speed from then on in rad/s.

        Returns
        -------
        PiecewiseMotion
        """
        last = pieces[-1]
        return cls(tuple(pieces), last.start + last.duration, end_angle, end_speed)

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
    def blow(self) -> tuple[float, float] | None:
        """Time in s and size in rad/s of the greatest jump of the speed; None where it has none."""
        if not self.pieces:
            return None
        before = np.array([piece.end[1] for piece in self.pieces])
        jumps = self.speed(self.knots[1:]) - before
        place = int(np.abs(jumps).argmax())
        if abs(jumps[place]) <= _ROUND_OFF * max(float(np.abs(before).max()), 1 / self.end):
            return None
        return float(self.knots[1 + place]), float(jumps[place])

    def piece_at(self, time: float) -> MotionPiece:
        """The piece at a time in s, one before the end."""
        return self.pieces[max(int(np.searchsorted(self._starts, time, side="right")) - 1, 0)]

    @property
    def knots(self) -> FloatArray:
        """Times in s at which pieces begin, and at which the last one ends; (n + 1,)."""
        return np.append(self._starts if self.pieces else np.zeros(0), self.end)

    @cached_property
    def _tables(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Coefficients of the pieces' polynomials and of their first two derivatives."""
        width = max(len(piece.polynomial) for piece in self.pieces)
        table = np.zeros((len(self.pieces), max(width, 3)))
        for row, piece in zip(table, self.pieces, strict=True):
            row[: len(piece.polynomial)] = piece.polynomial
        powers = np.arange(table.shape[1])
        first = (table * powers)[:, 1:]
        return table, first, (first * powers[:-1])[:, 1:]

    @cached_property
    def _starts(self) -> FloatArray:
        return np.array([piece.start for piece in self.pieces])

    @cached_property
    def _spans(self) -> FloatArray:
        return np.array([piece.duration for piece in self.pieces])

    @cached_property
    def _sines(self) -> FloatArray:
        """Size, rate and phase of each piece's sines, (k, 3, pieces); what it lacks has no size."""
        most = max(len(piece.sines) for piece in self.pieces)
        table = np.zeros((most, 3, len(self.pieces)))
        for column, piece in enumerate(self.pieces):
            for row, sine in enumerate(piece.sines):
                table[row, :, column] = sine
        return table

    def _values(self, time: ArrayLike, order: int) -> FloatArray:
        t = np.asarray(time, dtype=float)
        after = (self.end_angle + self.end_speed * (t - self.end), self.end_speed, 0.0)[order]
        if not self.pieces:
            return np.array(np.broadcast_to(after, t.shape))
        number = np.maximum(np.searchsorted(self._starts, t, side="right") - 1, 0)
        span = self._spans[number]
        part = (np.minimum(t, self.end) - self._starts[number]) / span
        value = np.zeros(t.shape)
        for column in self._tables[order].T[::-1]:
            value = value * part + column[number]
        for size, rate, phase in self._sines[:, :, number]:
            # The derivative of a sine is a quarter of a period ahead.
            value = value + size * rate**order * np.sin(rate * part + phase + order * np.pi / 2)
        return np.asarray(np.where(t >= self.end, after, value / span**order))
