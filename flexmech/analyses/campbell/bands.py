"""Lowest, mean and highest frequency of each branch over the crank angles, at many speeds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from flexmech.analyses.frequencies.extremes import extremes_between
from flexmech.analyses.frequencies.formulation import Systems
from flexmech.analyses.frequencies.frequency_map import frequencies_along
from flexmech.arrays import FloatArray
from flexmech.errors import ComputationError
from flexmech.linear_system import RefusedPositionsError

# Of a turn at a speed in doubt, every so many crank angles are tried first: what has no equilibrium
# has none over a part of the turn, which twelve of 72 angles find for a sixth of the cost.
PROBE_EVERY = 6
# Crank angles at which speeds are tried, once one has failed there: each failure adds two at most.
MOST_PROBES = 3
Solved = TypeVar("Solved")


@dataclass(frozen=True)
class Bands:
    """Frequencies over the crank angles at S speeds; m branches, in ascending order.

    Parameters
    ----------
    crank_speed : ndarray, shape (S,)
        Ascending, rad/s.
    values : ndarray, shape (S, 3, m)
        Lowest, mean and highest, in Hz.
    angle : ndarray, shape (S, 2, m)
        Crank angles of the lowest and the highest in rad.
    frequency : ndarray, shape (S, A, m)
        At the crank angles.
    """

    crank_speed: FloatArray
    values: FloatArray
    angle: FloatArray
    frequency: FloatArray

    @classmethod
    def none(cls, angles: int, branches: int) -> Bands:
        """Bands at no speed."""
        shapes = (0,), (0, 3, branches), (0, 2, branches), (0, angles, branches)
        return cls(*map(np.empty, shapes))

    def with_(self, other: Bands) -> Bands:
        """Both, in order of the speed."""
        pairs = zip(vars(self).values(), vars(other).values(), strict=True)
        both = [np.concatenate(pair) for pair in pairs]
        order = np.argsort(both[0])
        return Bands(*(each[order] for each in both))


@dataclass
class BandSolver:
    """Solves for bands, and keeps the speeds at which there is no solution.

    Parameters
    ----------
    systems : Systems
    crank_angles : ndarray, shape (A,)
        Increasing, rad, without the end of a full turn.
    full_turn : bool
        Whether the last angle leads back to the first.
    error : ndarray, shape (m,)
        Relative error that the frequencies have in any case.
    report : callable
        Called with the number of speeds after each that is done.

    Attributes
    ----------
    failures : dict of float to ComputationError
        By crank speed.
    solved_speeds : list of float
    """

    systems: Systems
    crank_angles: FloatArray
    full_turn: bool
    error: FloatArray
    report: Callable[[int], None]
    failures: dict[float, ComputationError] = field(init=False, default_factory=dict)
    solved_speeds: list[float] = field(init=False, default_factory=list)
    _doubtful: list[float] = field(init=False, default_factory=list)
    _passed: dict[float, set[float]] = field(init=False, default_factory=dict)

    def solve(self, crank_speeds: FloatArray) -> Bands:
        """Bands at those of the speeds (S,) that have a solution; the others are failures."""
        count = self.systems.formulation.modes
        found = Bands.none(len(self.crank_angles), count)
        at_a_time = max(1, self.systems.engine.batch_size // len(self.crank_angles))
        for start in range(0, len(crank_speeds), at_a_time):
            solved = self._without_failures(self._turns, crank_speeds[start : start + at_a_time])
            if solved is not None:
                found = found.with_(solved)
                self.solved_speeds += solved.crank_speed.tolist()
            self.report(len(crank_speeds[start : start + at_a_time]))
        return found

    def probe(self, crank_speeds: FloatArray) -> NDArray[np.bool_]:
        """Which of the speeds (S,) have no solution where others had none.

        At a few crank angles: what passes may fail at another one.
        """
        if not self._doubtful:
            angles = self.crank_angles[::PROBE_EVERY]
            self._without_failures(partial(self._positions, angles), crank_speeds)
        for angle in self._doubtful[:MOST_PROBES]:
            known = self._passed.setdefault(angle, set())
            left = crank_speeds[~self.failed(crank_speeds) & ~np.isin(crank_speeds, list(known))]
            self._without_failures(partial(self._positions, np.array([angle])), left)
            known |= set(left.tolist())
        return self.failed(crank_speeds)

    def failed(self, crank_speeds: FloatArray) -> NDArray[np.bool_]:
        """Which of the speeds (S,) are known to have no solution."""
        return np.isin(crank_speeds, list(self.failures))

    def reason(self, crank_speed: float) -> ComputationError:
        """Why there is no solution at a speed, in the words of that speed."""
        known = self.failures[crank_speed]
        if known.crank_speed == crank_speed:
            return known
        for angle in self._doubtful:
            try:
                self._positions(np.array([angle]), np.array([crank_speed]))
            except ComputationError as error:
                return error
        return known

    def _turns(self, crank_speeds: FloatArray) -> Bands:
        frequency = self._positions(self.crank_angles, crank_speeds)
        extremes = extremes_between(
            self.systems,
            self.crank_angles,
            crank_speeds,
            frequency,
            self.error,
            full_turn=self.full_turn,
        )
        mean = _mean(self.crank_angles, frequency, self.full_turn)
        # Of branches that no crank angle moves, round-off puts the mean beside the band.
        mean = np.clip(mean, extremes.lowest_frequency, extremes.highest_frequency)
        parts = [extremes.lowest_frequency, mean, extremes.highest_frequency]
        angles = np.stack([extremes.lowest_angle, extremes.highest_angle], axis=1)
        return Bands(crank_speeds, np.stack(parts, axis=1), angles, frequency)

    def _positions(self, crank_angles: FloatArray, crank_speeds: FloatArray) -> FloatArray:
        """Frequencies (S, A, m) at all crank angles and speeds."""
        speed, angle = (
            each.ravel() for each in np.meshgrid(crank_speeds, crank_angles, indexing="ij")
        )
        found = frequencies_along(self.systems, angle, speed)
        return found.reshape(len(crank_speeds), len(crank_angles), -1)

    def _without_failures(
        self, solve: Callable[[FloatArray], Solved], crank_speeds: FloatArray
    ) -> Solved | None:
        """What is solved at those speeds that do not fail; None if all do."""
        while len(crank_speeds):
            try:
                return solve(crank_speeds)
            except ComputationError as error:
                crank_speeds = crank_speeds[~self._blamed(error, crank_speeds)]
        return None

    def _blamed(self, error: ComputationError, crank_speeds: FloatArray) -> NDArray[np.bool_]:
        """Which speeds an error is of; it and they are kept."""
        refused = np.array([] if error.crank_speed is None else [error.crank_speed])
        if isinstance(error, RefusedPositionsError):
            refused = error.crank_speeds
            known = [angle for angle in error.crank_angles.tolist() if angle not in self._doubtful]
            # The first and the last: what bends a linkage too far does so over a part of the turn.
            self._doubtful += known[:1] + known[1:][-1:]
        blamed: NDArray[np.bool_] = np.isin(crank_speeds, refused)
        if not blamed.any():
            raise error
        self.failures |= dict.fromkeys(crank_speeds[blamed].tolist(), error)
        return blamed


def _mean(crank_angles: FloatArray, frequency: FloatArray, full_turn: bool) -> FloatArray:
    """Mean over the crank angle of frequencies (S, A, m), shape (S, m)."""
    if full_turn:
        # Of a periodic function the trapezoidal rule; the steps need not be equal.
        steps = np.diff(crank_angles, append=crank_angles[0] + 2 * np.pi)
        weights = (steps + np.roll(steps, 1)) / 2
    elif len(crank_angles) > 1:
        steps = np.diff(crank_angles)
        weights = (np.append(0.0, steps) + np.append(steps, 0.0)) / 2
    else:
        weights = np.ones(1)
    return np.asarray(np.einsum("sam,a->sm", frequency, weights) / weights.sum(), dtype=float)
