"""Least and greatest values over the crank angle, between the angles too, and means over turns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from flexmech.arrays import ROUND_OFF, FloatArray
from flexmech.errors import InputError

Values = Callable[[FloatArray], FloatArray]
"""From crank angles (A,) in rad to quantities there, (A, n)."""

# Step of the first search: between two of these angles a linkage and its loads have one extreme.
_STEP = np.radians(1.0)
# Each zoom lays so many angles into the two steps around an extreme, and goes on with the two
# around the best of them; so often, two degrees become 1e-7 deg, where a corner of a table of loads
# or a dead point is found to 1e-9 of a quantity that changes by its own size over a radian.
_INSIDE, _ZOOMS = 17, 8
# Angles closer than this part of a step count as one.
_SAME = 1e-9
# Steps of the first trapezoidal rule a turn for a mean, and how often they are halved at most. The
# rule converges faster than any power for what is smooth and periodic, as the square of the step
# for tables of loads, whose mean is known to 1e-7 by then.
_FEWEST_STEPS, _HALVINGS = 360, 5


class Peaks(NamedTuple):
    """Greatest values of n quantities, where they are, and how far they are known.

    Parameters
    ----------
    value, angle, error : ndarray, shape (n,)
        Angles in rad, or times in s.
    """

    value: FloatArray
    angle: FloatArray
    error: FloatArray


@dataclass(frozen=True)
class Extremes:
    """Least and greatest values of n quantities, where they are, and how far they are known.

    Parameters
    ----------
    least, least_angle, greatest, greatest_angle : ndarray, shape (n,)
        Angles in rad.
    error : ndarray, shape (n,)
        Error of either value; not a number where nothing was sought between the angles.
    """

    least: FloatArray
    least_angle: FloatArray
    greatest: FloatArray
    greatest_angle: FloatArray
    error: FloatArray


def extremes(values_at: Values, crank_angles: FloatArray, *, step: float | None = None) -> Extremes:
    """Least and greatest values from the first to the last of some crank angles, or times.

    They are sought in steps of a degree, and each is narrowed down between its neighbours. Where
    the linkage cannot be moved through all angles between, because it passes a dead point or a gap
    of its range of motion, values at the angles alone count, and errors are not numbers.

    Parameters
    ----------
    values_at : callable
        See :data:`Values`; raises InputError where the linkage cannot stand.
    crank_angles : ndarray, shape (A,)
        In rad, increasing.
    step : float, optional
        In place of a degree, of times: what is over time does not go round.

    Returns
    -------
    Extremes

    Raises
    ------
    InputError
        If the linkage cannot stand at one of the angles.
    """
    try:
        return _extremes(values_at, with_steps(crank_angles, step or _STEP), True, step is None)
    except InputError:
        return _extremes(values_at, crank_angles, False, step is None)


def _extremes(values_at: Values, angles: FloatArray, between: bool, turns: bool) -> Extremes:
    values = values_at(angles)
    greatest = _greatest(values_at, angles, values, 1.0, between, turns)
    least = _greatest(values_at, angles, values, -1.0, between, turns)
    error = np.maximum(greatest.error, least.error)
    return Extremes(-least.value, least.angle, greatest.value, greatest.angle, error)


def greatest_between(
    values_at: Values,
    crank_angles: FloatArray,
    *,
    step: float = _STEP,
    zooms: int = _ZOOMS,
) -> Peaks:
    """Greatest values from the first to the last of some crank angles, between them too.

    Parameters
    ----------
    values_at : callable
        See :data:`Values`.
    crank_angles : ndarray, shape (A,)
        In rad, increasing.
    step : float
        Step of the first search, in rad: between two of its angles a quantity has one peak.
    zooms : int
        Each narrows a peak down to an eighth.

    Returns
    -------
    Peaks

    Examples
    --------
    >>> cosine = lambda angle: np.cos(angle - 0.1234)[:, None]
    >>> found = greatest_between(cosine, np.array([0.0, 3.0]))
    >>> found.value.round(9), found.angle.round(4)
    (array([1.]), array([0.1234]))
    """
    angles = with_steps(crank_angles, step)
    return _greatest(values_at, angles, values_at(angles), 1.0, True, True, zooms)


def peaks_between(values: FloatArray, place: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Greatest size of each history, and where it is.

    The vertex of the parabola through the greatest sample and its neighbours; a peak at an end
    of the history is the sample there.

    Parameters
    ----------
    values : ndarray, shape (N, k)
        Evenly sampled.
    place : ndarray, shape (N,)
        Time or crank angle of the samples.

    Returns
    -------
    size, where : ndarray, shape (k,)

    Examples
    --------
    >>> time = np.arange(8.0)
    >>> size, where = peaks_between(-np.cos(0.4 * time - 1.3)[:, None], time)
    >>> size.round(3), where.round(2)
    (array([1.]), array([3.25]))
    """
    size = np.abs(values)
    columns, number = np.arange(values.shape[1]), size.argmax(axis=0)
    if len(values) < 3:
        return size[number, columns], place[number]
    inner = np.clip(number, 1, len(values) - 2)
    before, at, after = (size[inner + step, columns] for step in (-1, 0, 1))
    slope, bend = (after - before) / 2, before - 2 * at + after
    with np.errstate(divide="ignore", invalid="ignore"):
        shift = np.where((bend < 0) & (number == inner), -slope / bend, 0.0)
    spacing = np.where(shift > 0, place[inner + 1] - place[inner], place[inner] - place[inner - 1])
    rounded = at + slope * shift / 2
    return (
        np.where(number == inner, rounded, size[number, columns]),
        np.where(number == inner, place[inner] + shift * spacing, place[number]),
    )


def with_steps(angles: FloatArray, step: float) -> FloatArray:
    """Angles, and others between them in even steps from the first to the last.

    A step that differs by round-off from an angle is that angle: a peak is sought between the
    neighbours of its own.

    Parameters
    ----------
    angles : ndarray, shape (A,)
        In rad, increasing; or times.
    step : float
        Greatest length of a step.

    Returns
    -------
    ndarray, shape (B,)
        Increasing, with the angles themselves.

    Examples
    --------
    >>> with_steps(np.array([0.0, 0.5, 2.0]), 1.0)
    array([0. , 0.5, 1. , 2. ])
    """
    even = np.linspace(
        angles[0], angles[-1], int(np.ceil(round((angles[-1] - angles[0]) / step, 6))) + 1
    )
    after = np.minimum(np.searchsorted(angles, even), len(angles) - 1)
    apart = np.abs(even - angles[[np.maximum(after - 1, 0), after]]).min(axis=0)
    return np.union1d(angles, even[apart > _SAME * step])


def _greatest(
    values_at: Values,
    angles: FloatArray,
    values: FloatArray,
    sign: float,
    between: bool,
    turns: bool,
    zooms: int = _ZOOMS,
) -> Peaks:
    """Greatest values of the quantities times a sign, their angles, and their errors."""
    found, columns = sign * values, np.arange(values.shape[1])
    place = _first_peak(_vertices(found) if between else found)
    best, where = found[place, columns], angles[place]
    error = np.full(best.shape, np.nan)
    if angles.size == 1:
        return Peaks(best, where, np.zeros_like(error))
    if not between:
        return Peaks(best, where, error)
    step = np.diff(angles)
    ends = (0, len(angles) - 1)
    # A periodic quantity goes on from the end of a whole turn with its beginning.
    size = np.abs(values).max(axis=0)
    joined = np.abs(values[-1] - values[0]) <= ROUND_OFF * size
    joined &= turns and is_whole(angles[-1] - angles[0])
    low = where - np.where((place > ends[0]) | joined, step[np.maximum(place - 1, 0)], 0.0)
    high = where + np.where((place < ends[1]) | joined, step[np.minimum(place, len(step) - 1)], 0.0)
    for _ in range(zooms):
        inside = np.linspace(low, high, _INSIDE)
        flat = sign * values_at(inside.ravel())
        own = flat.reshape(_INSIDE, len(columns), -1)[:, columns, columns]
        at = own.argmax(axis=0)
        peak = own[at, columns]
        # What is constant but for round-off keeps its place.
        better = peak - best > ROUND_OFF * size
        error = np.abs(peak - best)
        where = np.where(better, inside[at, columns], where)
        best = np.where(better, peak, best)
        width = (high - low) / (_INSIDE - 1)
        low, high = np.maximum(low, where - width), np.minimum(high, where + width)
    # What rounding leaves of the quantity is no less.
    error = np.maximum(error, ROUND_OFF * size)
    turn = 2 * np.pi
    where = where + turn * ((where < angles[0]) & joined) - turn * ((where > angles[-1]) & joined)
    return Peaks(best, where, error)


def _first_peak(heights: FloatArray) -> FloatArray:
    """Number of the first greatest value of each column but for round-off."""
    top = heights.max(axis=0)
    return np.asarray(np.argmax(heights >= top - ROUND_OFF * np.abs(top), axis=0))


def _vertices(values: FloatArray) -> FloatArray:
    """Heights of the parabolas through neighbours at peaks; the values themselves elsewhere."""
    heights = values.copy()
    if len(values) < 3:
        return heights
    before, here, after = values[:-2], values[1:-1], values[2:]
    bend = before - 2 * here + after
    is_peak = (here >= before) & (here >= after) & (bend < 0)
    rise = (after - before) ** 2 / np.where(is_peak, -8 * bend, 1.0)
    heights[1:-1] += np.where(is_peak, rise, 0.0)
    return heights


def is_whole(angle: float) -> bool:
    """Whether an angle in rad is one turn or several."""
    turns = angle / (2 * np.pi)
    return bool(turns > 0.5 and abs(turns - round(turns)) <= ROUND_OFF)


def mean_over_turns(
    value_at: Callable[[FloatArray], FloatArray], crank_angles: FloatArray
) -> tuple[float, float] | None:
    """Mean of a quantity over whole turns, and its error.

    By the trapezoidal rule, whose steps are halved until the mean holds still.

    Parameters
    ----------
    value_at : callable
        From crank angles (A,) in rad to the quantity there, (A,).
    crank_angles : ndarray, shape (A,)
        In rad, increasing: the first and the last of them count.

    Returns
    -------
    tuple of float, or None
        None where the angles are no whole turns, or the linkage cannot be moved through them.
    """
    first, last = float(crank_angles[0]), float(crank_angles[-1])
    if not is_whole(last - first):
        return None
    try:
        return _mean(value_at, first, last)
    except InputError:
        return None


def _mean(
    value_at: Callable[[FloatArray], FloatArray], first: float, last: float
) -> tuple[float, float]:
    steps = _FEWEST_STEPS * round((last - first) / (2 * np.pi))
    values = value_at(np.linspace(first, last, steps + 1))
    mean, error = np.trapezoid(values, dx=1 / steps), np.inf
    noise = ROUND_OFF * np.abs(values).max()
    for _ in range(_HALVINGS):
        middle = first + (last - first) * (np.arange(steps) + 0.5) / steps
        finer = (mean + value_at(middle).mean()) / 2
        error, mean, steps = abs(finer - mean), finer, 2 * steps
        if error <= noise:
            break
    return float(mean), float(max(error, noise))
