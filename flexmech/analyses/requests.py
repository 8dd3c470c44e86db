"""What is asked of an analysis, checked where it comes in: angles, engines, mechanisms."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import ArrayLike

from flexmech.errors import InputError
from flexmech.hygrothermal import Environment, Exposure, HygrothermalState
from flexmech.linear_system import Engine
from flexmech.mechanism import Mechanism
from flexmech.modelfile.table import suggestion
from flexmech.numbers import checked_array
from flexmech.types import FloatArray

__all__ = [
    "engine_of",
    "engines_of",
    "environment_of",
    "in_radians",
    "link_of",
    "mechanism_of",
]

# Beyond so many radians, eight turns, an angle is taken for degrees.
MOST_RADIANS = 16 * np.pi


def in_radians(name: str, values: ArrayLike) -> FloatArray:
    """Angles in rad; those that can only be degrees are refused.

    Parameters
    ----------
    name : str
        Of the argument, for messages.
    values : array_like

    Returns
    -------
    ndarray

    Raises
    ------
    InputError
        If one is beyond eight turns, or three or more are whole numbers beyond a full turn.
    """
    angles = checked_array(values, name, "rad")
    greatest = float(np.abs(angles).max(initial=0.0))
    whole = angles.size >= 3 and greatest > 2 * np.pi and bool(np.all(angles == np.round(angles)))
    if greatest > MOST_RADIANS or whole:
        raise InputError(
            f"{name} must be in rad and reaches {greatest:g}; if these are degrees, write "
            f"np.radians({name})"
        )
    return angles


def engine_of(value: Engine) -> Engine:
    """The engine; anything else is refused with what to write."""
    if not isinstance(value, Engine):
        raise InputError(
            f"an engine is needed, got {value!r:.80}; write flexmech.ReferenceEngine(mechanism) or "
            "flexmech.ExudynEngine(mechanism)"
        )
    return value


def engines_of(value: Engine | Sequence[Engine]) -> list[Engine]:
    """One engine or several as a list of one or more.

    Parameters
    ----------
    value : Engine or sequence of Engine

    Returns
    -------
    list of Engine

    Raises
    ------
    InputError
        If there is none, or something else is among them.
    """
    engines = list(value) if isinstance(value, list | tuple) else [value]
    if not engines:
        raise InputError("an analysis needs an engine, got an empty list")
    return [engine_of(engine) for engine in engines]


def link_of(value: str, names: Collection[str]) -> str:
    """A link's name; one that is not among the names is refused with those that are."""
    if value not in names:
        raise InputError(f"link: there is no link {value!r}; {suggestion(value, list(names))}")
    return value


def mechanism_of(value: Mechanism) -> Mechanism:
    """The mechanism; anything else is refused with what to write."""
    if not isinstance(value, Mechanism):
        raise InputError(
            f"a mechanism is needed, got {value!r:.80}; write flexmech.load_mechanism(path)"
        )
    return value


def environment_of(value: Environment) -> Environment:
    """The environment; anything else is refused with what to write."""
    if not isinstance(value, HygrothermalState | Exposure):
        raise InputError(
            f"an environment is needed, got {value!r:.80}; write "
            "flexmech.HygrothermalState(temperature_rise, moisture) or "
            "flexmech.Exposure(temperature_rise, relative_humidity, time)"
        )
    return value
