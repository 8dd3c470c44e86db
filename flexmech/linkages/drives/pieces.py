"""A motion in pieces, each a polynomial of time and sines: the one form of all laws."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import FloatArray, IntArray

# Of the speeds of a motion, or of a radian over its whole time: what splines leave of rest.
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
            Of each rest, in s.
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
        own, sines = self.polynomials[number], self.sines[number]
        moved = np.zeros_like(own)
        for power in range(own.shape[1]):
            for above in range(power, own.shape[1]):
                moved[:, power] += (
                    math.comb(above, power) * own[:, above] * begin ** (above - power)
                )
        moved *= ratio[:, None] ** np.arange(own.shape[1])
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
        number: IntArray = np.searchsorted(self._starts, time, side="right")
        return np.maximum(number - 1, 0)

    @cached_property
    def _starts(self) -> FloatArray:
        return self.knots[:-1]

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
        part = (np.minimum(t, end) - self._starts[number]) / span
        value = np.zeros(t.shape)
        for column in self._derivatives[order].T[::-1]:
            value = value * part + column[number]
        for size, rate, phase in self._waves[:, :, number]:
            # The derivative of a sine is a quarter of a period ahead.
            value = value + size * rate**order * np.sin(rate * part + phase + order * np.pi / 2)
        return np.asarray(np.where(t >= end, after, value / span**order))


def first_greatest(values: FloatArray) -> int:
    """Place of the greatest size among values (m,), the first one of those alike."""
    size = np.abs(values)
    return int(np.argmax(size >= (1 - _ALIKE) * size.max()))
