"""Lowest and highest frequency of each mode over the crank angles, found between the angles.

A grid of crank angles passes an extreme by. The three angles around the grid's extreme bracket
it. The quartic through them and one more on each side predicts where it is and how far it goes. A
solution there that is nearly as predicted is the extreme: an error of the angle changes it by its
square alone. Else each round solves at the vertex of the parabola through the three and a little
to both sides of it, which leaves a bracket an eighth as wide or less: no more than a few rounds
for the bend of a curve where modes veer.

The minimum of a curve between five of its points, predicted by the quartic through them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from flexmech.analyses.frequencies.frequency_map import frequencies_along
from flexmech.analyses.requests import without_end
from flexmech.arrays import FloatArray, IntArray
from flexmech.solvers.formulation import Systems

# Abscissae between the second and the fourth node at which quartics are looked at: the parabola
# through three of them is the quartic to a ten-thousandth of the step.
SAMPLES = 65
# Nearest distance of a trial to the middle node, over the width between its neighbours: nearer, the
# solution there tells nothing of the slope; farther, nothing of the minimum.
NEAREST = 1 / 32
# Greatest difference of the quartic from the cubics through four of its nodes, over its rise. More
# shows a bend that the nodes do not resolve: there a quartic may be right at a trial by accident.
MOST_ROUGH = 0.1


class PredictedMinimum(NamedTuple):
    """Minima of b curves by quartics; not a number where there is none or it is not to be trusted.

    Parameters
    ----------
    at : ndarray, shape (b,)
        Where to try: at the minimum, or a little beside the middle node where it is nearer to that.
    value : ndarray, shape (b,)
        Value of the quartic there.
    remainder : ndarray, shape (b,)
        By how much the quartic is lower at its minimum than at the trial and at the middle node.
    reach : ndarray, shape (b,)
        Greatest error of the quartic between the neighbours of the middle node over that at the
        trial. It goes as the product of the distances to all nodes.
    rise : ndarray, shape (b,)
        By how much the quartic rises, with its curvature at the minimum, over a step of the nodes.
    """

    at: FloatArray
    value: FloatArray
    remainder: FloatArray
    reach: FloatArray
    rise: FloatArray

    def missed(self, these: IntArray, solved: FloatArray) -> FloatArray:
        """By how much the minima of some smooth curves may be below what is known of them.

        A slope that is wrong by e' moves the minimum of a parabola of curvature k and lowers it by
        e'^2 / 2 k; in the middle e' is up to 2.8 times the greatest error over the step.

        Parameters
        ----------
        these : ndarray of int, shape (t,)
            Numbers of the curves.
        solved : ndarray, shape (t,)
            Their values at ``at``.

        Returns
        -------
        ndarray, shape (t,)
        """
        error = self.reach[these] * np.abs(solved - self.value[these])
        lowered = error * np.minimum(1.0, 2 * error / self.rise[these])
        return np.asarray(lowered + self.remainder[these], dtype=float)


def predicted_minimum(nodes: FloatArray, values: FloatArray) -> PredictedMinimum:
    """Minima of the quartics between the second and the fourth of five nodes.

    Parameters
    ----------
    nodes : ndarray, shape (5, b)
        Increasing.
    values : ndarray, shape (5, b)

    Returns
    -------
    PredictedMinimum

    Examples
    --------
    >>> nodes = np.arange(5.0)[:, None]
    >>> found = predicted_minimum(nodes, (nodes - 2.3) ** 2)
    >>> found.at.round(3).tolist(), abs(found.value).round(4).tolist()
    ([2.3], [0.0])
    """
    before, middle, behind = nodes[1:4]
    steps = np.linspace(0.0, 1.0, SAMPLES)[:, None]
    samples = before + steps * (behind - before)
    quartic = _through(nodes, values, samples)
    lowest = np.argmin(quartic, axis=0)
    inside = (lowest > 0) & (lowest < SAMPLES - 1) & np.isfinite(nodes + values).all(axis=0)
    # The parabola through three of so many samples is the quartic.
    three = np.clip(lowest, 1, SAMPLES - 2) + np.array([-1, 0, 1])[:, None]
    left, least, right = np.take_along_axis(quartic, three, axis=0)
    bend = np.where(inside, left - 2 * least + right, 1.0)
    inside &= bend > 0
    bend = np.where(inside, bend, 1.0)
    step = (behind - before) / (SAMPLES - 1)
    centre = np.take_along_axis(samples, three[1:2], axis=0)[0]
    vertex = centre - step * (right - left) / (2 * bend)
    minimum = least - (right - left) ** 2 / (8 * bend)
    nearest = NEAREST * (behind - before)
    side = np.where(vertex < middle, -1.0, 1.0)
    at = np.where(np.abs(vertex - middle) < nearest, middle + side * nearest, vertex)
    value = _through(nodes, values, at[None])[0]
    error, error_here = np.abs(_distances(nodes, samples)), np.abs(_distances(nodes, at[None]))[0]
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = error.max(axis=0) / error_here
    rise = bend / 2 * ((SAMPLES - 1) / 2) ** 2
    for four in (slice(0, 4), slice(1, 5)):
        rough = np.abs(quartic - _through(nodes[four], values[four], samples)).max(axis=0)
        inside &= rough <= MOST_ROUGH * rise
    found = (at, value, np.minimum(value, values[2]) - minimum, reach, rise)
    return PredictedMinimum(*(np.where(inside, part, np.nan) for part in found))


def _through(nodes: FloatArray, values: FloatArray, at: FloatArray) -> FloatArray:
    """Polynomials through nodes (n, b) at abscissae (k, b), shape (k, b)."""
    total = np.zeros(at.shape)
    with np.errstate(divide="ignore", invalid="ignore"):
        for n, (node, value) in enumerate(zip(nodes, values, strict=True)):
            others = nodes[np.arange(len(nodes)) != n]
            total += value * _distances(others, at) / np.prod(node - others, axis=0)
    return total


def _distances(nodes: FloatArray, at: FloatArray) -> FloatArray:
    """Products of the distances of abscissae (k, b) to nodes (n, b), shape (k, b)."""
    return np.asarray(np.prod(at[:, None] - nodes, axis=1), dtype=float)


# The change of an extreme by the last round over the error that is reported of it: a tenth leaves
# the first digit of that error right.
SHARE_OF_ERROR = 0.1
# Round-off of a frequency: no extreme is refined further, however small its error is said to be.
LEAST_ERROR = 1e-8
# A bound of work: each leaves an eighth of the bracket, and a dozen are beyond what a
# float can tell.
MOST_ROUNDS = 12
# Distance of the angles to both sides over the width of the bracket, of which an eighth is left
# then.
ASIDE = 1 / 16
# Crank angles further apart than this, in rad, are single positions rather than a curve: a little
# more than 15 deg, in steps of which maps are usually asked for at the coarsest.
MOST_STEP = np.radians(15.5)


@dataclass(frozen=True)
class Extremes:
    """Lowest and highest frequencies of m modes, at one crank speed or at several.

    Parameters
    ----------
    lowest_frequency, highest_frequency : ndarray, shape (..., m)
        Hz.
    lowest_angle, highest_angle : ndarray, shape (..., m)
        rad, within the crank angles asked for; of a full turn, within the turn from the first.
    """

    lowest_frequency: FloatArray
    lowest_angle: FloatArray
    highest_frequency: FloatArray
    highest_angle: FloatArray

    def of_speed(self, number: int) -> Extremes:
        """Brackets at one of several crank speeds, (m,)."""
        return Extremes(
            self.lowest_frequency[number],
            self.lowest_angle[number],
            self.highest_frequency[number],
            self.highest_angle[number],
        )


def known_error(dataset: xr.Dataset) -> xr.DataArray:
    """Relative error of each mode's frequencies by mesh and component modes, greatest of a turn.

    Parameters
    ----------
    dataset : xarray.Dataset
        ``discretisation_error`` and ``reduction_error`` over ``check_angle`` and others.

    Returns
    -------
    xarray.DataArray
        Over the others.
    """
    return (dataset["discretisation_error"] + dataset["reduction_error"]).max("check_angle")


def error_of_model(dataset: xr.Dataset) -> xr.DataArray:
    """:func:`known_error`, and what lumped masses are off by, in the place of distributed ones.

    Digits are those of the model that was solved; whether engines agree depends on what their
    models leave out too.

    Parameters
    ----------
    dataset : xarray.Dataset
        As in :func:`known_error`, with ``lumping_error`` where masses are lumped.

    Returns
    -------
    xarray.DataArray
    """
    if "lumping_error" not in dataset:
        return known_error(dataset)
    return known_error(dataset) + dataset["lumping_error"].max("check_angle")


def extremes_between(
    systems: Systems,
    crank_angles: FloatArray,
    crank_speeds: FloatArray,
    frequency: FloatArray,
    error: FloatArray,
    *,
    full_turn: bool,
    wanted: NDArray[np.bool_] | None = None,
) -> Extremes:
    """Extremes over a range of crank angles at several crank speeds at once.

    Parameters
    ----------
    systems : Systems
        As those of the grid.
    crank_angles : ndarray, shape (A,)
        Increasing, rad.
    crank_speeds : ndarray, shape (S,)
        rad/s.
    frequency : ndarray, shape (S, A, m)
        At these angles, ascending, in Hz.
    error : ndarray, shape (m,)
        Relative error of the frequencies: extremes are refined until they change by a tenth of
        it.
    full_turn : bool
        Whether the last angle leads back to the first.
    wanted : ndarray of bool, shape (2, m), optional
        Which lowest and highest frequencies are sought between the angles; all by default. Others
        are the extremes at the angles.

    Returns
    -------
    Extremes
        Arrays of shape (S, m).
    """
    speeds, _, count = frequency.shape
    # The highest frequency is the lowest of the negative ones.
    shape = (2, speeds, count)
    sign, row, mode = (
        np.broadcast_to(each, shape).ravel()
        for each in (
            np.array([1.0, -1.0])[:, None, None],
            np.arange(speeds)[:, None],
            np.arange(count),
        )
    )
    brackets = _Brackets.on_grid(crank_angles, sign * frequency[row, :, mode].T, full_turn)
    sign, row, mode = (each[brackets.curve] for each in (sign, row, mode))
    allowed = SHARE_OF_ERROR * np.maximum(error, LEAST_ERROR)[mode] * np.abs(brackets.value[1])
    # A parabola over whole steps may be wrong: each is tried once, unless the curve is flat.
    gained = np.where(brackets.has_width & brackets.may_fall(), np.inf, 0.0)
    if wanted is not None:
        sought = wanted[(sign < 0).astype(int), mode]
        gained, allowed = np.where(sought, gained, 0.0), np.where(sought, allowed, np.inf)

    def solved(these: IntArray, trial: FloatArray) -> FloatArray:
        """Values (k, t) of the curves of t brackets at angles (k, t)."""
        speed = np.broadcast_to(crank_speeds[row[these]], trial.shape)
        found = frequencies_along(systems, trial.ravel(), speed.ravel()).reshape(*trial.shape, -1)
        value = found[:, np.arange(len(these)), mode[these]]
        return np.asarray(sign[these] * value, dtype=float)

    predicted = predicted_minimum(brackets.grid_angle, brackets.grid_value)
    these = np.flatnonzero(
        (gained > 0) & brackets.may_be_lowest() & (predicted.remainder <= allowed)
    )
    found_already = np.zeros(len(gained), dtype=bool)
    if len(these):
        trial = predicted.at[None, these]
        value = solved(these, trial)
        brackets.narrow(these, trial, value)
        found_already[these] = predicted.missed(these, value[0]) <= allowed[these]
    for _ in range(MOST_ROUNDS):
        vertex, gain = brackets.parabola()
        moving = ~found_already & (np.maximum(gain, gained) > allowed)
        these = np.flatnonzero(moving & brackets.may_be_lowest())
        if not len(these):
            break
        trial = brackets.angles_near(vertex)[:, these]
        known = brackets.value[1].copy()
        brackets.narrow(these, trial, solved(these, trial))
        gained = known - brackets.value[1]
    where = brackets.angle[1, brackets.first_lowest()]
    extreme = (sign * brackets.value[1])[brackets.lowest()]
    if full_turn:
        where = crank_angles[0] + np.mod(where - crank_angles[0], 2 * np.pi)
    (low, high), (low_angle, high_angle) = extreme.reshape(shape), where.reshape(shape)
    return Extremes(low, low_angle, high, high_angle)


@dataclass
class _Brackets:
    """Three angles around each of b minima of t curves, and the values there.

    An extreme that is not bracketed, a minimum at an end of the angles or between angles that are
    far apart, has one angle three times.

    Parameters
    ----------
    angle, value : ndarray, shape (3, b)
    curve : ndarray of int, shape (b,)
        To which of the curves a minimum belongs.
    grid_angle, grid_value : ndarray, shape (5, b)
        On the grid around it; not a number beyond an end of the angles.
    """

    angle: FloatArray
    value: FloatArray
    curve: IntArray
    grid_angle: FloatArray
    grid_value: FloatArray

    @classmethod
    def on_grid(cls, angle: FloatArray, value: FloatArray, full_turn: bool) -> _Brackets:
        """Around those minima of values (A, t) at angles (A,) that may be a curve's lowest.

        The lowest value on the grid need not be that of the lowest minimum: where modes veer a
        curve turns round within a step. A minimum is left out if the curve, falling and rising
        inside it as steeply as in the four steps around it, stays above the lowest value.
        """
        if full_turn:
            angle = without_end(angle)
            value = value[: len(angle)]
            around = np.arange(-2, len(angle) + 2)
            turns, around = np.divmod(around, len(angle))
            angle, value = angle[around] + 2 * np.pi * turns, value[around]
        else:
            angle = np.pad(angle, 2, constant_values=np.nan)
            value = np.pad(value, ((2, 2), (0, 0)), constant_values=np.nan)
        least = np.nanmin(value, axis=0)
        middle = np.arange(2, len(angle) - 2)
        five = middle + np.arange(-2, 3)[:, None]
        steepest = _steepest(angle[five][:, :, None], value[five])
        before, here, behind = (value[middle + n] for n in (-1, 0, 1))
        angles = angle[middle[:, None] + [-1, 0, 1]].T[:, :, None]
        bound = _lower_bound(before, behind, steepest, angles)
        # At an end of the angles a comparison with nothing is no obstacle.
        minimum = ~(here > before) & ~(here > behind)
        place, curve = np.nonzero(minimum & (~(bound > least) | (here == least)))
        chosen = middle[place] + np.array([-1, 0, 1])[:, None]
        wide = ~(np.diff(angle[chosen], axis=0).max(axis=0) < MOST_STEP)  # or there is no step
        chosen = np.where(wide, middle[place], chosen)
        around = five[:, place]
        return cls(angle[chosen], value[chosen, curve], curve, angle[around], value[around, curve])

    @cached_property
    def slope(self) -> FloatArray:
        """The steepest in the grid's four steps around each, shape (b,)."""
        return _steepest(self.grid_angle, self.grid_value)

    def lowest(self) -> IntArray:
        """Number of the lowest minimum of each curve, shape (t,)."""
        return self._first_of_each(self.value[1])

    def first_lowest(self) -> IntArray:
        """The first of each curve's minima that are as low as the lowest, shape (t,).

        Round-off is not to choose between two of a symmetric linkage.
        """
        value, least = self.value[1], self.value[1, self.lowest()][self.curve]
        higher = value > least + LEAST_ERROR * np.abs(least)
        return self._first_of_each(self.angle[1], higher)

    def _first_of_each(self, *keys: NDArray[Any]) -> IntArray:
        """Number of each curve's first minimum, (t,), by keys (b,); the last counts most."""
        order = np.lexsort((*keys, self.curve))
        return np.asarray(order[np.unique(self.curve[order], return_index=True)[1]])

    def may_be_lowest(self) -> NDArray[np.bool_]:
        """Whether brackets may fall below the least of their curve, at slopes as around; (b,)."""
        least = self.value[1, self.lowest()][self.curve]
        bound = _lower_bound(self.value[0], self.value[2], self.slope, self.angle)
        return np.asarray(np.minimum(bound, self.value[1]) <= least)

    def may_fall(self) -> NDArray[np.bool_]:
        """Whether brackets may fall below their value by more than round-off; (b,)."""
        here = self.value[1]
        bound = _lower_bound(self.value[0], self.value[2], self.slope, self.angle)
        return np.asarray(bound < here - LEAST_ERROR * np.abs(here))

    @property
    def has_width(self) -> NDArray[np.bool_]:
        """Whether brackets are around a minimum, and not at an end of the angles; shape (b,)."""
        return np.asarray(self.angle[2] > self.angle[0])

    def parabola(self) -> tuple[FloatArray, FloatArray]:
        """Vertex of the parabola through each bracket, and how far it is below the middle.

        Where the three do not bend upwards or have no width there is nothing below the middle.
        """
        (a, b, c), (fa, fb, fc) = self.angle, self.value
        with np.errstate(divide="ignore", invalid="ignore"):
            left, right = (fb - fa) / (b - a), (fc - fb) / (c - b)
            curvature = 2 * (right - left) / (c - a)
            slope = left + curvature * (b - a) / 2
            vertex, gain = b - slope / curvature, slope**2 / (2 * curvature)
        bends = self.has_width & (curvature > 0)
        return np.where(bends, vertex, b), np.where(bends, gain, 0.0)

    def angles_near(self, vertex: FloatArray) -> FloatArray:
        """Three angles in each bracket around a vertex, none of them the middle; (3, b)."""
        aside = ASIDE * (self.angle[2] - self.angle[0])
        centre = np.clip(vertex, self.angle[0] + 2 * aside, self.angle[2] - 2 * aside)
        near = np.abs(np.abs(centre - self.angle[1]) - [[0.0], [1.0]] * aside).min(axis=0)
        centre = np.where(near < aside / 4, centre + aside / 2, centre)
        return np.asarray(centre + np.array([-1, 0, 1])[:, None] * aside, dtype=float)

    def narrow(self, of: IntArray, angle: FloatArray, value: FloatArray) -> None:
        """Take in values (k, m) at angles (k, m) inside m of the brackets."""
        every = np.concatenate([self.angle[:, of], angle])
        values = np.concatenate([self.value[:, of], value])
        order = np.argsort(every, axis=0)
        every = np.take_along_axis(every, order, axis=0)
        values = np.take_along_axis(values, order, axis=0)
        middle = np.clip(np.argmin(values, axis=0), 1, len(every) - 2)
        around = middle + np.array([-1, 0, 1])[:, None]
        self.angle[:, of] = np.take_along_axis(every, around, axis=0)
        self.value[:, of] = np.take_along_axis(values, around, axis=0)


def _steepest(angle: FloatArray, value: FloatArray) -> FloatArray:
    """Greatest slope of the steps between angles (k, ...) with values (k, ...), in size."""
    # A single angle has no slope: not a number, and nothing to warn of.
    return np.asarray(np.fmax.reduce(np.abs(np.diff(value, axis=0) / np.diff(angle, axis=0))))


def _lower_bound(
    before: FloatArray, behind: FloatArray, slope: FloatArray, angle: FloatArray
) -> FloatArray:
    """Least value between the ends of brackets at angles (3, ...), falling at most at a slope."""
    return np.asarray((before + behind - slope * (angle[2] - angle[0])) / 2, dtype=float)
