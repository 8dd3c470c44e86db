"""A number of modes that nobody asked for is a wish: as many are given as there are."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from flexmech.choices import MODES
from flexmech.linear_system import OverdampedError, TooManyModesError

FEWER_MODES = "fewer_modes"
Found = TypeVar("Found")


def as_many_modes(
    compute: Callable[[int], Found], modes: int | None, speed_unit: str = "rad/s"
) -> tuple[Found, dict[str, str]]:
    """Compute with the modes asked for, or with the usual number or as many as there are.

    Parameters
    ----------
    compute : callable
        Takes the number of modes.
    modes : int, optional
        As asked for; what has fewer is then refused. Left out: four, or as many as the model has
        and as oscillate at all positions.
    speed_unit : str
        In which the reason speaks of crank speeds.

    Returns
    -------
    object
        What ``compute`` gave.
    dict of str to str
        Attribute that says how many modes there are and why; empty where there are as many as
        usual.

    Raises
    ------
    InputError, ComputationError
        What ``compute`` raises, if no mode is left.
    """
    if modes is not None:
        return compute(modes), {}
    count, reason = MODES, ""
    while True:
        try:
            found = compute(count)
        except (OverdampedError, TooManyModesError) as error:
            if not 0 < error.most_modes < count:
                raise
            count = error.most_modes
            reason = f"the model has {count}"
            if isinstance(error, OverdampedError):
                reason = error.told(speed_unit).partition(";")[0]
            continue
        said = f"modes: {count} in the place of the usual {MODES}, since {reason}" if reason else ""
        return found, {FEWER_MODES: said} if said else {}


def fewer_modes_lines(attributes: Mapping[Any, Any]) -> list[str]:
    """One line where a result has fewer modes than usual, with the reason."""
    return [str(attributes[FEWER_MODES])] if FEWER_MODES in attributes else []
