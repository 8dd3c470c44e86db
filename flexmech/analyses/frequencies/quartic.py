"""The minimum of a curve between five of its points, predicted by the quartic through them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from flexmech.arrays import FloatArray, IntArray

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
    """What quartics say of b curves; not a number where one has no minimum or is not to be trusted.

    Parameters
    ----------
    at : ndarray, shape (b,)
        Where to try: at the minimum, or a little beside the middle node where it is nearer to that.
    value : ndarray, shape (b,)
        Of the quartic there.
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
    itself = np.eye(len(nodes), dtype=bool)[:, :, None]
    from_others = np.where(itself, 1.0, at[:, None, None] - nodes).prod(axis=2)
    between = np.where(itself, 1.0, nodes[:, None] - nodes).prod(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray((values * from_others / between).sum(axis=1))


def _distances(nodes: FloatArray, at: FloatArray) -> FloatArray:
    """Products of the distances of abscissae (k, b) to nodes (n, b), shape (k, b)."""
    return np.asarray(np.prod(at[:, None] - nodes, axis=1), dtype=float)
