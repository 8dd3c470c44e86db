"""Computations of the verification cases, by the names that their files use.

A method is a public function of a file of this room that takes keyword arguments alone, which the
files of the cases give, and returns numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from inspect import Parameter, getmembers, isfunction, signature
from types import ModuleType

from flexmech.arrays import FloatArray
from flexmech.verification.methods import (
    composites,
    floating_rod,
    frequencies,
    linkages,
    moisture,
    periodic_systems,
    running,
    still_frames,
)

__all__ = ["METHODS"]


def _methods_of(module: ModuleType) -> Iterator[tuple[str, Callable[..., FloatArray]]]:
    for name, found in getmembers(module, isfunction):
        own = found.__module__ == module.__name__ and not name.startswith("_")
        kinds = {parameter.kind for parameter in signature(found).parameters.values()}
        if own and kinds <= {Parameter.KEYWORD_ONLY, Parameter.VAR_KEYWORD}:
            yield name, found


METHODS: dict[str, Callable[..., FloatArray]] = {
    name: method
    for module in (
        *(composites, floating_rod, frequencies, linkages),
        *(moisture, periodic_systems, running, still_frames),
    )
    for name, method in _methods_of(module)
}
"""Methods by name."""
