"""Where a link's nodes are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flexmech.errors import InputError

__all__ = ["node_positions"]


def node_positions(
    length: float, elements: int, point_positions: Sequence[float] = ()
) -> NDArray[np.float64]:
    """Nodes along a link, one at each point mass.

    A point mass inside an element would put a kink into the shear force that the element
    cannot follow, and cost an order of convergence.

    Parameters
    ----------
    length : float
        In m.
    elements : int
        Total number of elements.
    point_positions : sequence of float
        Where point masses sit, m from the start; ends and repetitions do no harm.

    Returns
    -------
    ndarray, shape (elements + 1,)

    Raises
    ------
    InputError
        If there are fewer elements than pieces between point masses.
    """
    slack = 1e-9 * length
    inner = sorted({x for x in point_positions if slack < x < length - slack})
    breaks = np.array([0.0, *inner, length])
    pieces = np.diff(breaks)
    if elements < len(pieces):
        raise InputError(
            f"{elements} elements cannot put a node at each of {len(inner)} point masses along "
            f"a link; ask for {len(pieces)} elements or more"
        )
    counts = np.ones(len(pieces), dtype=int)
    for _ in range(elements - len(pieces)):
        counts[np.argmax(pieces / counts)] += 1
    parts = [
        np.linspace(a, b, n, endpoint=False)
        for a, b, n in zip(breaks[:-1], breaks[1:], counts, strict=True)
    ]
    return np.concatenate([*parts, [length]])
