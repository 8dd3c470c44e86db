"""Unbroken runs of what holds along a line."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["unbroken_runs"]


def unbroken_runs(flags: NDArray[np.bool_]) -> list[range]:
    """Places of each unbroken run of true values, in order.

    Parameters
    ----------
    flags : ndarray of bool, shape (N,)

    Returns
    -------
    list of range

    Examples
    --------
    >>> from flexmech.runs import unbroken_runs
    >>> unbroken_runs(np.array([True, False, True, True]))
    [range(0, 1), range(2, 4)]
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    return [range(start, stop) for start, stop in edges.reshape(-1, 2).tolist()]
