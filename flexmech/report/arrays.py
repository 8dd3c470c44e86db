"""Numbers on their way into a page: as small as a screen needs them, and as text."""

from __future__ import annotations

from base64 import b64encode

import numpy as np
from numpy.typing import ArrayLike

from flexmech.types import IntArray

MOST_POINTS = 400
"""Points of a line over a turn: a screen shows no more of it in a plot of that width."""


class Arrays:
    """Arrays of a page, each once; what shows them refers to them by number."""

    def __init__(self) -> None:
        self._numbers: dict[bytes, int] = {}
        self.encoded: list[str] = []
        """Little-endian numbers of 4 bytes, as text by base64."""

    def add(self, values: ArrayLike) -> int:
        """Keep an array, and give its number."""
        content = np.asarray(values, dtype="<f4").tobytes()
        if content not in self._numbers:
            self._numbers[content] = len(self.encoded)
            self.encoded.append(b64encode(content).decode("ascii"))
        return self._numbers[content]


def thinning(size: int, most: int = MOST_POINTS) -> IntArray:
    """Which of evenly spaced samples are kept: every n-th, and the last one.

    Parameters
    ----------
    size : int
    most : int

    Returns
    -------
    ndarray of int
    """
    step = max(1, -(-(size - 1) // most))
    kept = np.arange(0, size, step)
    return kept if kept.size and kept[-1] == size - 1 else np.append(kept, size - 1)
