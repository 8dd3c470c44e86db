"""From the nodes of a link to its elements and back; arrays end with the batch of positions."""

from __future__ import annotations

import numpy as np

from flexmech.arrays import FloatArray


def element_ends(q: FloatArray, per_node: int) -> FloatArray:
    """Coordinates of both nodes of each element; (B, p (e + 1)) -> (B, e, 2 p)."""
    nodal = q.reshape(len(q), -1, per_node)
    return np.concatenate([nodal[:, :-1], nodal[:, 1:]], axis=2)


def relative_coordinates(q: FloatArray, per_node: int) -> FloatArray:
    """Relative coordinates of each element (see :mod:`flexmech.reference.corotational`).

    Parameters
    ----------
    q : ndarray, shape (p (e + 1), B)
    per_node : int

    Returns
    -------
    ndarray, shape (e, 2 (p - 1), B)
    """
    nodal = q.reshape(-1, per_node, q.shape[1])
    first, second = nodal[:-1], nodal[1:]
    return np.concatenate([second[:, :2] - first[:, :2], first[:, 2:], second[:, 2:]], axis=1)


def node_forces(force: FloatArray, per_node: int) -> FloatArray:
    """Forces on the nodes of a link from those by its elements' relative coordinates.

    Parameters
    ----------
    force : ndarray, shape (e, 2 (p - 1), B)
    per_node : int

    Returns
    -------
    ndarray, shape (p (e + 1), B)
    """
    count, _, batch = force.shape
    total = np.zeros((count + 1, per_node, batch))
    total[:-1, :2] -= force[:, :2]
    total[1:, :2] += force[:, :2]
    total[:-1, 2:] += force[:, 2:per_node]
    total[1:, 2:] += force[:, per_node:]
    return total.reshape(-1, batch)
