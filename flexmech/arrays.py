"""Types of arrays and of progress reports, each spelt once, and unbroken runs in an array."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

ComplexArray = NDArray[np.complexfloating[Any, Any]]
FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]
"""Array of indices."""

ROUND_OFF = 1e-12
"""Part of the terms of a sum below which their difference is rounding: some thousand operations
in double precision leave less of numbers that cancel, and nothing that anybody states is so near
to another."""
SAME_PLACE = 1e-9
"""Part of a length below which two places or two lengths are one: what the digits of coordinates
and conversions between units leave is less, and no part is made so exactly."""
StepProgress = Callable[[int, int], None]
"""Called with the steps done and the steps to do."""
LabelledProgress = Callable[[str, int, int], None]
"""Called with what is being done, the steps done and the steps to do."""


def silent(*report: object) -> None:
    """Progress of either kind that is reported to nobody."""


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
    >>> from flexmech.arrays import unbroken_runs
    >>> unbroken_runs(np.array([True, False, True, True]))
    [range(0, 1), range(2, 4)]
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    return [range(start, stop) for start, stop in edges.reshape(-1, 2).tolist()]


def row_products(first: FloatArray, second: FloatArray) -> FloatArray:
    """Scalar products of vectors (m, n) row by row, (m,)."""
    return np.asarray(np.einsum("mi,mi->m", first, second))
