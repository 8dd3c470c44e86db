"""Batches of positions by memory, and checks of an engine's arguments."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from flexmech.arrays import IntArray
from flexmech.choices import MOST_ELEMENTS
from flexmech.errors import InputError
from flexmech.mechanism import Mechanism

# Working memory of a batch. Memory alone: what is alive at a time is independent of the map's size.
BATCH_BYTES = 32_000_000
# Speed alone: fewer positions take as long as these, however large their matrices are.
LEAST_BATCH = 4

# Positions of each design of a stack in a batch. Memory alone, and speed: the memory of more is
# given back to the system after every step, and asked for anew. As many of a small stack, so that
# its numbers are those of a large one to the last bit.
STACK_POSITIONS = 12


def stack_batches(count: int, designs: int) -> list[IntArray]:
    """Batches of positions of several designs, as many of each design in every batch.

    Parameters
    ----------
    count : int
        Positions, as many of each design, one after the other.
    designs : int

    Returns
    -------
    list of ndarray of int
        Numbers of the positions.
    """
    places = np.arange(count).reshape(designs, -1)
    parts = equal_batches(places.shape[1], STACK_POSITIONS)
    return [places[:, part].ravel() for part in parts]


def equal_batches(count: int, size: int) -> list[slice]:
    """Batches of equal size for a number of positions.

    A batch may exceed the requested size by a quarter, which avoids a small last one: each batch
    takes some time however small it is.

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


def checked_mechanism(mechanism: object) -> Mechanism:
    """Return a mechanism; refuse what is none: a path, a linkage, another engine."""
    if isinstance(mechanism, Mechanism):
        return mechanism
    given = f"an object of type {type(mechanism).__name__}"
    remedy = "read one by flexmech.load_mechanism(path)"
    if hasattr(mechanism, "__fspath__") or isinstance(mechanism, str):
        given = f"the path {str(mechanism)!r}"
        remedy = f"read the file first: flexmech.load_mechanism({str(mechanism)!r})"
    elif hasattr(mechanism, "mechanism"):
        remedy = "give its attribute mechanism"
    elif hasattr(mechanism, "topology"):
        remedy = "a linkage needs a section for each link: flexmech.Mechanism(linkage, sections)"
    raise InputError(f"mechanism must be a flexmech.Mechanism, got {given}; {remedy}")


def check_elastic(mechanism: Mechanism) -> None:
    """Refuse a mechanism whose links are all rigid: what engines compute is of elastic links."""
    if not all(link.rigid for link in mechanism.linkage.topology.links):
        return
    # Rigid links vibrate too where springs hold them; engines compute it beside one stiff link.
    stiff = ""
    if mechanism.springs or mechanism.joint_springs or mechanism.shaft_inertia:
        stiff = "as stiff as you like where springs, bearings or the shaft alone shall yield, "
    raise InputError(
        "links: every link is rigid, and what is computed here is the vibration of elastic "
        f"links; leave out rigid = true for one of them and give it a section, {stiff}or ask for "
        "the rigid motion and its forces by 'flexmech kinematics'"
    )


def checked_elements(count: object) -> int:
    """Return a number of elements a link; refuse fractions, truth values, text and too many."""
    if (
        isinstance(count, int | np.integer)
        and not isinstance(count, bool)
        and 1 <= count <= MOST_ELEMENTS
    ):
        return int(count)
    raise InputError(
        f"elements must be a whole number from 1 to {MOST_ELEMENTS} (the matrices of more do not "
        f"fit into memory), such as 8; got {count!r}"
    )
