"""Designs of one mechanism, computed together where they differ in numbers alone."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import TypeVar

import numpy as np

from flexmech.arrays import IntArray
from flexmech.errors import FlexmechError
from flexmech.linear_system import Engine, among_alike, likeness, stack_engines

Found = TypeVar("Found")
MOST_AT_ONCE = 32
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
    found: dict[int, Found | FlexmechError] = {}
    at_once = partial(_at_once, engines, compute)
    for numbers in _groups(engines):
        found |= dict(zip(numbers.tolist(), among_alike(numbers, at_once), strict=True))
    return [found[number] for number in range(len(engines))]


def _at_once(
    engines: Sequence[Engine], compute: Compute[Found], numbers: IntArray
) -> list[Found | FlexmechError]:
    """What is found of the designs of one stack; which of them fails is found by halves."""
    own = [engines[number] for number in numbers]
    stacked = likeness(own[0]) is not None
    try:
        return [*compute(stack_engines(own) if stacked else own[0], numbers)]
    except FlexmechError as error:
        if len(numbers) == 1:
            return [error]
    half, again = len(numbers) // 2, partial(_at_once, engines, compute)
    return [*among_alike(numbers[:half], again), *among_alike(numbers[half:], again)]


def _groups(engines: Sequence[Engine]) -> Iterator[IntArray]:
    """Numbers of the designs of each stack; those that are computed by themselves are alone."""
    alike: dict[object, list[int]] = {}
    for number, engine in enumerate(engines):
        if (key := likeness(engine)) is None:
            yield np.array([number])
        else:
            alike.setdefault(key, []).append(number)
    for numbers in alike.values():
        for first in range(0, len(numbers), MOST_AT_ONCE):
            yield np.array(numbers[first : first + MOST_AT_ONCE])
