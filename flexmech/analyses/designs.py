"""Designs of one mechanism, computed together where they differ in numbers alone."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

import numpy as np

from flexmech.arrays import IntArray
from flexmech.errors import FlexmechError
from flexmech.linear_system import Engine, UnlikeDesignsError, likeness, stack_engines

Found = TypeVar("Found")
MOST_AT_ONCE = 16
"""Designs of a stack. Memory alone, and speed: fewer share what each call takes, and the matrices
of more do not stay near the processor."""

Compute = Callable[[Engine, IntArray], Sequence[Found]]
"""Takes the engine of a stack and the numbers of its designs, and gives what is found of each."""


def of_designs(engines: Sequence[Engine], compute: Compute[Found]) -> list[Found | FlexmechError]:
    """Compute something of every design, of those that are alike at once.

    A design that fails changes no other one.

    Parameters
    ----------
    engines : sequence of Engine
    compute : callable
        Takes one engine, of a single design or of a stack, and the numbers of its designs, and
        gives what is found of each of these.

    Returns
    -------
    list
        What is found of each design, or why nothing is.
    """
    found: list[Found | FlexmechError] = [FlexmechError("nothing was computed")] * len(engines)
    for numbers, stacked in _groups(engines):
        for number, each in zip(
            numbers, _of_group(engines, numbers, stacked, compute), strict=True
        ):
            found[number] = each
    return found


def _groups(engines: Sequence[Engine]) -> Iterator[tuple[IntArray, bool]]:
    """Numbers of the designs of each stack, and of those that are computed by themselves."""
    alike: dict[object, list[int]] = {}
    for number, engine in enumerate(engines):
        if (key := likeness(engine)) is None:
            yield np.array([number]), False
        else:
            alike.setdefault(key, []).append(number)
    for numbers in alike.values():
        for first in range(0, len(numbers), MOST_AT_ONCE):
            yield np.array(numbers[first : first + MOST_AT_ONCE]), True


def _of_group(
    engines: Sequence[Engine], numbers: IntArray, stacked: bool, compute: Compute[Found]
) -> list[Found | FlexmechError]:
    own = [engines[number] for number in numbers]
    try:
        return [*compute(stack_engines(own) if stacked else own[0], numbers)]
    except UnlikeDesignsError as unlike:
        kind = unlike.kind
    except FlexmechError as error:
        if len(numbers) == 1:
            return [error]
        # Which of them fails is found by halves.
        kind = np.arange(len(numbers)) // -(-len(numbers) // 2)
    found: list[Found | FlexmechError] = [UnlikeDesignsError(kind)] * len(numbers)
    for one in np.unique(kind):
        places = np.flatnonzero(kind == one)
        part = _of_group(engines, numbers[places], stacked, compute)
        for place, each in zip(places, part, strict=True):
            found[place] = each
    return found
