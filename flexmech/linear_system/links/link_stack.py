"""Links of several designs of one mechanism, stacked along a leading dimension."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from flexmech.arrays import IntArray
from flexmech.errors import FlexmechError


class UnlikeDesignsError(FlexmechError):
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
