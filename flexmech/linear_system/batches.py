"""Batches of positions, whose matrices are in memory at a time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from flexmech.linear_system.chains import ChainMatrix
from flexmech.linear_system.link_model import LinkModel

# Working memory of a batch; keeps what is alive at a time independent of the map's size.
BATCH_BYTES = 32_000_000
LEAST_BATCH = 4
# A position of a link stored by elements takes memory as of so many columns of its matrix.
STORED_COLUMNS = 100


def batch_size(links: Sequence[LinkModel]) -> int:
    """Positions of a linkage to hold in memory at a time."""
    entries = 0
    for link in links:
        chain = isinstance(link.stiffness, ChainMatrix)
        entries += link.size * (min(STORED_COLUMNS, link.size) if chain else link.size)
    return max(LEAST_BATCH, BATCH_BYTES // (8 * 4 * entries))


def equal_batches(count: int, size: int) -> list[slice]:
    """Batches of so many positions, of equal size.

    A batch may exceed the size asked for by a quarter: it takes some time however small it is, and
    a small last one is spared.

    Parameters
    ----------
    count : int
        Positions.
    size : int
        That a batch should have at most.

    Returns
    -------
    list of slice
        One or more; empty ones only where there is no position.
    """
    number = max(1, math.ceil(count / size - 1 / 4))
    edges = [count * place // number for place in range(number + 1)]
    return [slice(*both) for both in pairwise(edges)]
