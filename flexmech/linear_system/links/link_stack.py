"""Designs of one mechanism that are computed together, along a leading dimension."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import IntArray

Found = TypeVar("Found")

# Links of more elements are computed design by design: memory, and speed, which is then as great.
MOST_STACKED = 16


class UnlikeDesignsError(Exception):
    """Designs of a stack that cannot be computed together: their matrices differ in size.

    Parameters
    ----------
    kind : ndarray of int, shape (D,)
        Designs of the same number can be computed together.
    """

    def __init__(self, kind: IntArray) -> None:
        super().__init__("designs that differ in more than numbers are not computed together")
        self.kind = kind


def same_of_all(values: ArrayLike) -> int:
    """The number or truth that all designs have in common.

    Parameters
    ----------
    values : array_like, shape () or (D,)

    Returns
    -------
    int

    Raises
    ------
    UnlikeDesignsError
        If there is none.
    """
    every = np.ravel(values)
    if (every != every[0]).any():
        raise UnlikeDesignsError(np.unique(every, return_inverse=True)[1])
    return int(every[0])


def among_alike(numbers: IntArray, compute: Callable[[IntArray], Sequence[Found]]) -> list[Found]:
    """Compute designs at once, and where they are found to be unlike those that are alike.

    Parameters
    ----------
    numbers : ndarray of int, shape (D,)
    compute : callable
        Takes the numbers of designs and gives what is found of each.

    Returns
    -------
    list
        What is found of each.
    """
    try:
        return [*compute(numbers)]
    except UnlikeDesignsError as unlike:
        kind = unlike.kind
    found: dict[int, Found] = {}
    for one in np.unique(kind):
        own = numbers[kind == one]
        found |= dict(zip(own.tolist(), among_alike(own, compute), strict=True))
    return [found[number] for number in numbers.tolist()]
