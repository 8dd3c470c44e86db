"""Bands between solved speeds: cubics, and the bends where two extremes change places.

The lowest frequency over the crank angle is the least of several smooth functions of speed, one
for each of its minima. Where another one becomes the least, the curve has a bend that no
polynomial follows. Elsewhere, of the cubics through the two nearest nodes and two more, that with
the least third difference is taken: one that does not reach over a bend (essentially
non-oscillatory interpolation; Harten et al. 1987, Journal of Computational Physics 71, 231-303).
In the interval of the bend the curves from the left and the right are continued to where they
cross.
"""

from __future__ import annotations

import numpy as np

from flexmech.types import FloatArray, IntArray

NODES_OF_A_CUBIC = 4
# Relative distance by which curves continued from both sides miss the node beyond a bend.
BEND = 3e-5
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
