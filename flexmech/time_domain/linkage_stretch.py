"""The second-order stretch of all links of a linkage, in its independent coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from flexmech.linear_system import LinkFrames, LinkStretch
from flexmech.linkages import RigidMotion
from flexmech.types import FloatArray

__all__ = ["LinkageStretch", "PinTurns", "StretchForces"]


@dataclass(frozen=True)
class PinTurns:
    """How the followers' ends turn from their leaders' at m instants.

    Parameters
    ----------
    turn, rate : ndarray, shape (m, f, k)
        From the first k independent coordinates, those of link ends, to the f displacements
        of following ends, and the time derivative of that.
    """

    turn: FloatArray
    rate: FloatArray


class LinkageStretch:
    """Strains of all links in spread coordinates: z, then the followers' ends.

    In these nothing depends on the position of the linkage: only the spreading does.

    Parameters
    ----------
    frames : LinkFrames
    links : sequence of LinkStretch
        In the links' own coordinates.

    Attributes
    ----------
    gradient, slopes, weights : ndarray, shape (s, p), (g, p), (s, g)
        Of all links together; see :class:`flexmech.linear_system.LinkStretch`.
    damping_time : ndarray, shape (s,)
    size : int
        Number p of spread coordinates.
    end_count : int
        How many independent coordinates, the first ones, are displacements of link ends.
    """

    def __init__(self, frames: LinkFrames, links: Sequence[LinkStretch]) -> None:
        self.links = tuple(links)
        self._frames = frames
        self.end_count = frames.end_count
        self._places = [np.array(target) for target in frames.targets]
        self.size = frames.size
        for number, places in enumerate(self._places):
            own = frames.following(number)
            places[own] = np.arange(self.size, self.size + len(own))
            self.size += len(own)
        self.gradient, self.slopes = self._spread("gradient"), self._spread("slopes")
        self.weights = scipy.linalg.block_diag(*(link.weights for link in links))
        self.damping_time = np.concatenate(
            [np.full(len(link.gradient), link.damping_time) for link in links]
        )

    @property
    def is_damped(self) -> bool:
        """Whether stretching is damped in any link."""
        return bool(self.damping_time.any())

    def pin_turns(self, motion: RigidMotion) -> PinTurns:
        """Turns of the following ends; ``motion`` is a batch of shape (m,)."""
        count, first = len(motion.crank_angle), self._frames.size
        turn, rate = np.zeros((2, count, self.size - first, self._frames.end_count))
        for places, following in zip(
            self._places, self._frames.following_rows(motion), strict=True
        ):
            for led in following:
                rows = places[led.rows] - first
                turn[:, rows[:, None], led.columns] = led.turn
                rate[:, rows[:, None], led.columns] = led.rate
        return PinTurns(turn, rate)

    def remainder(self, turns: PinTurns, position: FloatArray, velocity: FloatArray) -> FloatArray:
        """Forces on z beyond the linear ones, elastic and of damping, (m, n).

        Parameters
        ----------
        turns : PinTurns
            At m instants.
        position, velocity : ndarray, shape (m, n)
        """
        parts = []
        for turn, rate, z, v in zip(turns.turn, turns.rate, position, velocity, strict=True):
            forces = StretchForces(self, len(z), 1.0)
            forces.position[:], forces.rate[:] = z, v
            force = forces.evaluate(turn, rate)
            own = force[: len(z)].copy()
            own[: self.end_count] += turn.T @ force[len(z) :]
            parts.append(own)
        return np.array(parts)

    def still(self, turns: PinTurns, position: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Force on z of links at rest beyond the linear one, (n,), and its derivative (n, n).

        Parameters
        ----------
        turns : PinTurns
            At one instant.
        position : ndarray, shape (n,)
        """
        forces, size = StretchForces(self, len(position), 1.0), len(position)
        forces.position[:], forces.rate[:] = position, 0.0
        spreading = np.eye(self.size, size)
        spreading[size:, : self.end_count] = turns.turn[0]
        force = forces.evaluate(turns.turn[0], 0.0 * turns.rate[0])
        return spreading.T @ force, spreading.T @ forces.tangent(0.0) @ spreading

    def gathered(self, turns: PinTurns, columns: FloatArray) -> FloatArray:
        """``columns @ spreading^T``: from forces on spread coordinates to those on z.

        Parameters
        ----------
        turns : PinTurns
        columns : ndarray, shape (m, r, n)

        Returns
        -------
        ndarray, shape (m, r, p)
        """
        ends = columns[..., : self._frames.end_count]
        return np.concatenate([columns, ends @ np.swapaxes(turns.turn, 1, 2)], axis=-1)

    def yielding(self, turns: PinTurns, answer: FloatArray, step: float) -> FloatArray:
        """By how much tensions fall within a step as links yield to them, (m, s, s).

        Parameters
        ----------
        turns : PinTurns
            At the ends of m steps.
        answer : ndarray, shape (m, n, p)
            By how much unit forces at a step's end move the next prediction, which is four
            times how they move the position.
        step : float
            In s.
        """
        moved = answer @ self.gradient.T
        followers = turns.turn @ moved[:, : self.end_count]
        strain = self.gradient @ np.concatenate([moved, followers], axis=1) / 4
        # A rate changes by two steps' worth of what the position changes by.
        return np.asarray((1 + 2 * self.damping_time / step)[:, None] * strain)

    def _spread(self, name: str) -> FloatArray:
        blocks = []
        for link, places in zip(self.links, self._places, strict=True):
            values = getattr(link, name)
            block = np.zeros((len(values), self.size))
            free = places >= 0
            block[:, places[free]] = values[:, free]
            blocks.append(block)
        return np.concatenate(blocks)


class StretchForces:
    """Forces beyond the linear ones, one instant after the other.

    Everything that an evaluation needs is laid out before: what is left are some ten small
    products. They are called as methods of arrays, which costs least.

    Parameters
    ----------
    stretch : LinkageStretch
    size : int
        Number n of independent coordinates.
    step : float
        Time step h in s; rates are given times h.
    scale : float
        Positions and rates are given times this, too.

    Attributes
    ----------
    position, rate : ndarray, shape (n,)
        Where z and h z' of the instant, times ``scale``, are to be written.
    second : ndarray, shape (s,)
        The last second-order tensions.
    """

    def __init__(self, stretch: LinkageStretch, size: int, step: float, scale: float = 1.0) -> None:
        strains = len(stretch.gradient)
        both = np.concatenate([stretch.gradient, stretch.slopes])
        self._both, self._back = both / scale, np.ascontiguousarray(both.T)
        self._weights, self._half = stretch.weights, stretch.weights / 2
        self._spread = np.ascontiguousarray(stretch.weights.T)
        self._times = stretch.damping_time / step if stretch.is_damped else None
        self._end_count = stretch.end_count
        self._turned = np.empty(stretch.size - size)
        self._tension, self._tension_rate = np.empty((2, strains))
        self._change, self._yielded = np.empty((2, strains))
        self._square, self._spread_tension = np.empty((2, len(stretch.slopes)))
        self._load = np.empty(len(self._both))
        self.second, self._across = self._load[:strains], self._load[strains:]
        self._force = np.empty(stretch.size)
        # Spread coordinates and the strains and slopes that they make; of rates as well.
        place, self._pulled = np.empty(stretch.size), np.empty(len(self._both))
        moved, self._pulled_rate = np.empty(stretch.size), np.empty(len(self._both))
        self._place, self._moved = place, moved
        self.position, self.rate = place[:size], moved[:size]
        self._ends, self._end_rates = place[: self._end_count], moved[: self._end_count]
        self._followers, self._follower_rates = place[size:], moved[size:]
        self._linear, self._slopes = self._pulled[:strains], self._pulled[strains:]
        self._linear_rate, self._slope_rates = (
            self._pulled_rate[:strains],
            self._pulled_rate[strains:],
        )

    def evaluate(
        self,
        turn: FloatArray,
        rate: FloatArray,
        yielding: FloatArray | None = None,
        second: FloatArray | None = None,
    ) -> FloatArray:
        """Force on the spread coordinates at ``position`` and ``rate``; overwritten next time.

        Parameters
        ----------
        turn, rate : ndarray, shape (f, k)
            Of :class:`PinTurns` at the instant.
        yielding : ndarray, shape (s, s), optional
            Let the links yield to the change of their second-order tension at once.
        second : ndarray, shape (s,), optional
            The second-order tension to which position and rate have yielded; overwritten by
            that which is found.

        Returns
        -------
        ndarray, shape (p,)
        """
        turn.dot(self._ends, self._followers)
        self._both.dot(self._place, self._pulled)
        np.multiply(self._slopes, self._slopes, self._square)
        self._half.dot(self._square, self.second)
        np.add(self._linear, self.second, self._tension)
        if self._times is not None:
            self._add_damping(turn, rate)
        if yielding is not None and second is not None:
            np.subtract(self.second, second, self._change)
            second[:] = self.second
            yielding.dot(self._change, self._yielded)
            np.subtract(self._tension, self._yielded, self._tension)
        self._spread.dot(self._tension, self._spread_tension)
        np.multiply(self._spread_tension, self._slopes, self._across)
        return self._back.dot(self._load, self._force)

    def tangent(self, rate_by_position: float) -> FloatArray:
        """Derivative of the last force by the spread coordinates, (p, p).

        Parameters
        ----------
        rate_by_position : float
            By how much h z' changes with z.
        """
        strains = len(self._tension)
        gradient, slopes = self._back[:, :strains].T, self._back[:, strains:].T
        own = gradient + (self._weights * self._slopes) @ slopes
        weight = np.ones(strains)
        if self._times is not None:
            weight += rate_by_position * self._times
        along = own.T @ (weight[:, None] * own) - gradient.T @ (weight[:, None] * gradient)
        return np.asarray(along + slopes.T @ (self._spread_tension[:, None] * slopes))

    def _add_damping(self, turn: FloatArray, rate: FloatArray) -> None:
        assert self._times is not None
        turn.dot(self._end_rates, self._follower_rates)
        rate.dot(self._ends, self._turned)
        np.add(self._follower_rates, self._turned, self._follower_rates)
        self._both.dot(self._moved, self._pulled_rate)
        np.multiply(self._slopes, self._slope_rates, self._square)
        self._weights.dot(self._square, self._tension_rate)
        np.multiply(self._tension_rate, self._times, self._tension_rate)
        np.add(self.second, self._tension_rate, self.second)
        np.add(self._tension, self._tension_rate, self._tension)
        np.multiply(self._linear_rate, self._times, self._tension_rate)
        np.add(self._tension, self._tension_rate, self._tension)
