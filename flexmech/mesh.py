"""Where a link's nodes are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from flexmech.errors import InputError

__all__ = ["node_positions", "pieces"]


def pieces(length: float, point_positions: Sequence[float]) -> NDArray[np.float64]:
    """Lengths of the pieces into which point masses divide a link."""
    slack = 1e-9 * length
    breaks = [0.0]
    for x in sorted(point_positions):
        if breaks[-1] + slack < x < length - slack:
            breaks.append(x)
    return np.diff([*breaks, length])


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
    if not point_positions:
        return np.linspace(0.0, length, elements + 1)
    parts = pieces(length, point_positions)
    if elements < len(parts):
        raise InputError(
            f"{elements} elements cannot put a node at each of {len(parts) - 1} point masses "
            f"along a link; ask for {len(parts)} elements or more"
        )
    counts = np.ones(len(parts), dtype=int)
    for _ in range(elements - len(parts)):
        counts[np.argmax(parts / counts)] += 1
    element_lengths = np.repeat(parts / counts, counts)
    return np.concatenate([[0.0], np.cumsum(element_lengths)[:-1], [length]])
