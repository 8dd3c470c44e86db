"""Lowest, mean and highest frequency of each branch over the crank angles, at many speeds.

Few of the speeds are solved for. Branches are smooth in speed but for bends, where a band's end
passes from one crank angle to another. Between solved speeds runs the cubic through the four
nearest. A speed in the middle between two is predicted, then solved: where both differ by more than
the tolerance the halves are divided in turn.

The lowest frequency over the crank angle is the least of several smooth functions of speed, one
for each of its minima. Where another one becomes the least, the curve has a bend that no
polynomial follows. Elsewhere, of the cubics through the two nearest nodes and two more, that with
the least third difference is taken: one that does not reach over a bend (essentially
non-oscillatory interpolation; Harten et al. 1987, Journal of Computational Physics 71, 231-303).
In the interval of the bend the curves from the left and the right are continued to where they
cross.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from flexmech.analyses.frequencies.extremes import extremes_between
from flexmech.analyses.frequencies.frequency_map import frequencies_along
from flexmech.arrays import FloatArray, IntArray, unbroken_runs
from flexmech.errors import ComputationError
from flexmech.mechanics import RefusedPositionsError
from flexmech.solvers.formulation import Systems

# At a speed in doubt every so many crank angles of a turn are tried first: what has no
# equilibrium has none over a part of the turn, which twelve of 72 angles find for a sixth of the
# cost.
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


# A cubic through them is of fourth order; more nodes would run over the bend of a band's end.
NODES_OF_A_CUBIC = 4
# Relative difference of a predicted and a solved frequency up to which a fit is accepted: as much
# as a usual mesh is off by.
FIT_TOLERANCE = 3e-4
# Relative distance by which curves continued from both sides miss the node beyond a bend: a tenth
# of the tolerance of the fit, below which a bend does not matter.
BEND = 0.1 * FIT_TOLERANCE
# The sense in which the lowest, the mean and the highest frequency bend; the mean does not.
SENSE = np.array([1.0, 0.0, -1.0])[:, None]


def band_fit(nodes: FloatArray, values: FloatArray, at: FloatArray) -> FloatArray:
    """Lowest, mean and highest frequency at speeds between solved ones.

    Parameters
    ----------
    nodes : ndarray, shape (n,)
        Increasing.
    values : ndarray, shape (n, 3, m)
        Lowest, mean and highest frequency of m branches.
    at : ndarray, shape (P,)
        Between the first and the last node.

    Returns
    -------
    ndarray, shape (P, 3, m)
        Of fewer than four nodes the polynomial through all.

    Examples
    --------
    >>> nodes, sense = np.arange(8.0), np.array([1.0, 1.0, -1.0])[:, None]
    >>> bent = sense * np.minimum(nodes, 7.25 - nodes)[:, None, None]
    >>> band_fit(nodes, bent, np.array([3.5]))[0, ::2, 0].round(6).tolist()
    [3.5, -3.5]
    """
    count = len(nodes)
    size = min(NODES_OF_A_CUBIC, count)
    interval = np.clip(np.searchsorted(nodes, at, side="right") - 1, 0, max(count - 2, 0))
    found = np.empty((len(at), *values.shape[1:]))
    least = np.full(found.shape, np.inf)
    for shift in range(size - 1):
        first = np.clip(interval - shift, 0, count - size)
        value, roughness = _through(nodes, values, first, size, at)
        better = roughness < least
        found, least = np.where(better, value, found), np.where(better, roughness, least)
    if size == 1:
        return values[np.zeros(len(at), dtype=np.intp)]
    # Only where both sides have nodes enough to be continued.
    inner = np.flatnonzero((interval >= size - 1) & (interval + 1 + size <= count))
    left, right = interval[inner] - (size - 1), interval[inner] + 1
    before, _ = _through(nodes, values, left, size, at[inner])
    behind, _ = _through(nodes, values, right, size, at[inner])
    missed_right = _through(nodes, values, left, size, nodes[right])[0] - values[right]
    missed_left = _through(nodes, values, right, size, nodes[right - 1])[0] - values[right - 1]
    least_miss = BEND * np.abs(values[right])
    bends = np.minimum(SENSE * missed_right, SENSE * missed_left) > least_miss
    crossing = np.where(SENSE > 0, np.minimum(before, behind), np.maximum(before, behind))
    found[inner] = np.where(bends, crossing, found[inner])
    return found


def _through(
    nodes: FloatArray, values: FloatArray, first: IntArray, size: int, at: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Values (P, ...) of polynomials through nodes from ``first`` on, and their roughness.

    That is the size of the divided difference of highest order.
    """
    used = first[:, None] + np.arange(size)
    x = nodes[used]
    weights, difference = np.ones(used.shape), np.ones(used.shape)
    for n in range(size):
        for other in range(size):
            if other != n:
                weights[:, n] *= (at - x[:, other]) / (x[:, n] - x[:, other])
                difference[:, n] /= x[:, n] - x[:, other]
    y = values[used]
    value, rough = (np.einsum("pn,pn...->p...", w, y) for w in (weights, difference))
    return np.asarray(value, dtype=float), np.abs(rough)


# So few speeds are all solved before any is fitted, for they cost little.
ALL_SOLVED = 13
# Eight intervals, each of which is divided once at least: 17 of the speeds are solved.
FIRST_SOLVED = 9
# The crank speed is divided into at least so many steps, in each of which crossings are looked for:
# of two crossings in one step none is seen.
LEAST_STEPS = 128
# Speeds that are tried at a time in search of those without a solution: each round leaves a seventh
# of the range, at the cost of one batch. Speed alone.
TRIED = 6


@dataclass(frozen=True)
class SampledBands:
    """Bands on a grid of speeds; m branches.

    Parameters
    ----------
    crank_speed : ndarray, shape (G,)
        Ascending, rad/s.
    values : ndarray, shape (G, 3, m)
        Lowest, mean and highest frequency in Hz; not a number where there is no solution.
    solved : Bands
        At those of the speeds that were solved for.
    fit_error : float
        Greatest relative difference of fit and solution at speeds that were not used in the
        fit; 0 where nothing is fitted.
    """

    crank_speed: FloatArray
    values: FloatArray
    solved: Bands
    fit_error: float

    @property
    def exists(self) -> NDArray[np.bool_]:
        """Where there is a solution, shape (G,)."""
        return np.isfinite(self.values[:, 0, 0])


def speed_grid(crank_speeds: FloatArray) -> tuple[FloatArray, IntArray]:
    """Crank speeds and as many between them as the search for crossings needs.

    Parameters
    ----------
    crank_speeds : ndarray, shape (S,)
        Ascending.

    Returns
    -------
    ndarray, shape (G,)
    ndarray of int, shape (S,)
        Places of the crank speeds on it.
    """
    count = len(crank_speeds)
    parts = 1 if count == 1 else -(-LEAST_STEPS // (count - 1))
    places = np.arange(count) * parts
    between = np.arange((count - 1) * parts + 1) / parts
    grid = np.interp(between, np.arange(count), crank_speeds)
    grid[places] = crank_speeds
    return grid, places


def sampled_bands(solver: BandSolver, crank_speeds: FloatArray) -> tuple[SampledBands, IntArray]:
    """Bands at crank speeds and between them.

    Parameters
    ----------
    solver : BandSolver
    crank_speeds : ndarray, shape (S,)
        Ascending, rad/s.

    Returns
    -------
    SampledBands
    ndarray of int, shape (S,)
        Places of the crank speeds on its grid.
    """
    grid, places = speed_grid(crank_speeds)
    failed = _failing(solver, grid, places)
    first = places
    if len(places) > ALL_SOLVED:
        alive = places[~failed[places]]
        ends = np.linspace(0, len(alive) - 1, FIRST_SOLVED)
        first = alive[np.unique(np.round(ends).astype(np.intp))]
    solved = solver.solve(grid[first[~failed[first]]])
    # Each interval between neighbours is divided once at least.
    fine: set[tuple[int, int]] = set()
    error = 0.0
    while True:
        failed = _failing_beyond(solver, grid, failed)
        here = np.searchsorted(grid, solved.crank_speed)
        wanted, owners = [], []
        for low, high in _intervals(here, failed):
            if (low, high) not in fine:
                wanted.append((low + high) // 2)
                owners.append((low, high))
        if not wanted:
            break
        middle = np.array(wanted)
        guess = _fitted(grid, here, solved.values, failed, middle)
        found = solver.solve(grid[middle])
        for place, (low, high), predicted in zip(middle.tolist(), owners, guess, strict=True):
            row = np.flatnonzero(found.crank_speed == grid[place])
            if not len(row) or not np.isfinite(predicted).all():
                continue
            off = float(np.max(np.abs(predicted / found.values[row[0]] - 1)))
            if off <= FIT_TOLERANCE:
                fine |= {(low, place), (place, high)}
                error = max(error, off)
        solved = solved.with_(found)
    here = np.searchsorted(grid, solved.crank_speed)
    values = _fitted(grid, here, solved.values, failed, np.arange(len(grid)))
    values[here] = solved.values
    return SampledBands(grid, values, solved, error), places


def _intervals(solved: IntArray, failed: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Pairs of known places with unknown ones between them."""
    known = np.union1d(solved, np.flatnonzero(failed)).tolist()
    pairs = pairwise(known)
    return [(low, high) for low, high in pairs if high - low > 1]


def _failing(solver: BandSolver, grid: FloatArray, asked: IntArray) -> NDArray[np.bool_]:
    """Which places of the grid have no solution where the greatest speed asked for has none.

    Solutions that fail take long, so that speeds are tried where one has failed already. What
    passes may fail elsewhere.
    """
    failed = np.zeros(len(grid), dtype=bool)
    ends = np.unique(asked[[0, -1]])
    failed[ends] = solver.probe(grid[ends])
    passed = np.zeros(len(grid), dtype=bool)
    passed[ends] = ~failed[ends]
    while (unknown := _between_unlike(failed, passed)).size:
        some = unknown[np.unique(np.linspace(0, unknown.size - 1, TRIED).astype(np.intp))]
        failed[some] = solver.probe(grid[some])
        passed[some] = ~failed[some]
    inside = np.array(
        [n for low, high in _pairs(failed | passed) if failed[low] and failed[high]
         for n in range(low + 1, high)],
        dtype=np.intp,
    )  # fmt: skip
    if inside.size:
        failed[inside] = solver.probe(grid[inside])
    return failed


def _failing_beyond(
    solver: BandSolver, grid: FloatArray, failed: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """The failures, those among them that were met since, and speeds between two of them."""
    failed = failed | solver.failed(grid)
    for low, high in _pairs(failed):
        between = np.arange(low + 1, high)
        if len(between) and not np.isin(grid[between], solver.solved_speeds).any():
            failed[between] = solver.probe(grid[between])
    return failed


def _between_unlike(failed: NDArray[np.bool_], passed: NDArray[np.bool_]) -> IntArray:
    """Places between one that has failed and one that has passed."""
    for low, high in _pairs(failed | passed):
        if failed[low] != failed[high] and high - low > 1:
            return np.arange(low + 1, high)
    return np.arange(0)


def _pairs(known: NDArray[np.bool_]) -> list[tuple[int, int]]:
    places = np.flatnonzero(known).tolist()
    return list(pairwise(places))


def _fitted(
    grid: FloatArray,
    solved: IntArray,
    values: FloatArray,
    failed: NDArray[np.bool_],
    places: IntArray,
) -> FloatArray:
    """Values (P, ...) at places of the grid by the solved ones between the same gaps.

    Not a number at failures and beyond the solved speeds.
    """
    found = np.full((len(places), *values.shape[1:]), np.nan)
    for stretch in unbroken_runs(~failed):
        own = np.isin(solved, stretch)
        nodes = solved[own]
        if not len(nodes):
            continue
        inside = (places >= nodes[0]) & (places <= nodes[-1])
        found[inside] = band_fit(grid[nodes], values[own], grid[places[inside]])
    return found
