"""Checks of requests where they come in: angles, engines, links, modes."""

from __future__ import annotations

import functools
import inspect
import reprlib
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from typing import Any, Generic, ParamSpec, Protocol, TypeVar, cast, overload

import numpy as np
from numpy.typing import ArrayLike

from flexmech.analyses.default_engines import chosen_engines, engine_for
from flexmech.analyses.options import Options
from flexmech.arrays import FloatArray
from flexmech.choices import MODES
from flexmech.docstrings import entries, with_entries
from flexmech.errors import InputError, suggestion
from flexmech.hygrothermal import Environment, Exposure, HygrothermalState
from flexmech.mechanics import Engine, OverdampedError, TooManyModesError, check_elastic
from flexmech.mechanism import Mechanism
from flexmech.validation import check_instance, checked_array

# Beyond so many radians, eight turns, an angle is taken for degrees.
MOST_RADIANS = 16 * np.pi

ENGINE = (
    "flexmech.load_mechanism(path), flexmech.ReferenceEngine(mechanism) or "
    "flexmech.ExudynEngine(mechanism)"
)
ENVIRONMENT = (
    "flexmech.HygrothermalState(temperature_rise, moisture) or "
    "flexmech.Exposure(temperature_rise, relative_humidity, time)"
)
T = TypeVar("T")


def in_radians(name: str, values: ArrayLike) -> FloatArray:
    """Angles in rad; those that can only be degrees are refused.

    Parameters
    ----------
    name : str
        Name of the argument, for messages.
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


def check_list(
    name: str, values: FloatArray, *, one: str = "value", increasing: bool = False
) -> None:
    """Refuse what is no list of one number or more, and numbers that repeat or do not increase.

    Parameters
    ----------
    name : str
        Name of the argument, for messages.
    values : ndarray
    one : str
        What one of them is.
    increasing : bool
        Whether they have to increase; else none may be there twice.

    Raises
    ------
    InputError
    """
    if values.ndim != 1 or not len(values):
        raise InputError(f"{name} must be a list of one value or more")
    if increasing and np.any(np.diff(values) <= 0):
        raise InputError(f"{name} must increase; sort them and leave out repetitions")
    if len(np.unique(values)) != len(values):
        raise InputError(f"{name} repeats a {one}; give each one once")


def engine_of(value: Engine | Mechanism, *, elastic: bool = True) -> Engine:
    """The engine, or the reference engine of a mechanism; anything else is refused.

    Parameters
    ----------
    value : Engine or Mechanism
        One of rigid links alone is refused with what to write.
    elastic : bool
        Whether a link at least has to be elastic.

    Returns
    -------
    Engine

    Raises
    ------
    InputError
    """
    engine = _one_of(engine_for(value), (Engine,), "an engine or a mechanism", ENGINE)
    if elastic:
        check_elastic(engine.mechanism)
    return engine


Engines = Engine | Mechanism | Sequence[Engine | Mechanism]
"""Input of analyses: for a mechanism, or each of several, the reference engine is made."""


def engines_of(
    value: Engines,
    asked: Options | None = None,
    modes: int | None = None,
    *,
    elastic: bool = True,
) -> list[Engine]:
    """One engine or several as a list of one or more.

    Parameters
    ----------
    value : Engine, Mechanism or sequence of them
        A mechanism gets the engines that the options name.
    asked : Options, optional
        Where it has them: engine, element, elements, mass and shaft.
    modes : int, optional
        Natural frequencies that elements which were not asked for must be fit for.
    elastic : bool
        Whether a link at least has to be elastic.

    Returns
    -------
    list of Engine

    Raises
    ------
    InputError
        If there is none, or something else is among them, all links are rigid, the shaft is
        unknown, or what makes an engine is asked for beside one.
    """
    named = {name: getattr(asked, name, None) for name in ("engine", "element", "elements", "mass")}
    if isinstance(value, Mechanism):
        value = chosen_engines(
            value, **cast(Any, named | {"engine": named["engine"] or "reference"})
        )
    # Elements that have a default are places along the links of an engine too.
    elif given := [
        name
        for name, wanted in named.items()
        if wanted is not None and getattr(type(asked), name, None) is None
    ]:
        raise InputError(
            f"{given[0]}: an engine is given already; leave {given[0]} out, or give the mechanism "
            "in place of the engine"
        )
    engines = value if isinstance(value, Sequence) and not isinstance(value, str) else [value]
    if not engines:
        raise InputError("an analysis needs an engine, got an empty list")
    found = [engine_of(engine, elastic=elastic) for engine in engines]
    shaft = getattr(asked, "shaft", None)
    if shaft is not None:
        found = [e if e.shaft == shaft else e.with_(shaft=shaft) for e in found]
    return found if modes is None else [engine.fit_for(modes) for engine in found]


Subject = TypeVar("Subject", contravariant=True)
Request = TypeVar("Request", contravariant=True)
Answer = TypeVar("Answer", covariant=True)
Keywords = ParamSpec("Keywords")


class Analysis(Protocol, Generic[Subject, Keywords, Request, Answer]):
    """A function that takes what is asked by keyword, or as a request that these make."""

    @overload
    def __call__(self, mechanism: Subject, request: Request, /, **changes: Any) -> Answer: ...
    @overload
    def __call__(
        self, mechanism: Subject, /, *fields: Keywords.args, **named: Keywords.kwargs
    ) -> Answer: ...


def asks(
    request: Callable[Keywords, Request],
) -> Callable[[Callable[[Subject, Request], Answer]], Analysis[Subject, Keywords, Request, Answer]]:
    """Let a function of a mechanism and a request take the fields of the request by keyword.

    Parameters
    ----------
    request : type
        A dataclass, whose fields and their entries in the docstring become those of the function.

    Returns
    -------
    callable
        The decorator. A request that is ready can be given too; keywords beside it change it.
    """

    def decorated(
        compute: Callable[[Subject, Request], Answer],
    ) -> Analysis[Subject, Keywords, Request, Answer]:
        mechanism = next(iter(inspect.signature(compute).parameters.values()))
        fields = inspect.signature(request).parameters.values()
        signature = inspect.Signature([mechanism, *fields])

        @functools.wraps(compute)
        def answer(*given: Any, **named: Any) -> Answer:
            if len(given) == 2 and isinstance(given[1], cast(type, request)):
                ready: Any = given[1]
                return compute(given[0], replace(ready, **named) if named else ready)
            values = signature.bind(*given, **named).arguments
            return compute(values.pop(mechanism.name), request(**values))  # type: ignore[call-arg]

        answer.__signature__ = signature  # type: ignore[attr-defined]
        answer.__doc__ = with_entries(compute.__doc__ or "", entries(request.__doc__ or ""))
        return cast(Analysis[Subject, Keywords, Request, Answer], answer)

    return decorated


def link_of(value: str, names: Collection[str]) -> str:
    """A link's name; one that is not among the names is refused with those that are."""
    check_instance(value, str, "link", f"give one of {', '.join(names)}")
    if value not in names:
        raise InputError(f"link: there is no link {value!r}; {suggestion(value, list(names))}")
    return value


def environment_of(value: Environment) -> Environment:
    """The environment; anything else is refused with what to write."""
    return _one_of(value, (HygrothermalState, Exposure), "an environment", ENVIRONMENT)


def _one_of(value: T, kinds: tuple[type, ...], what: str, remedy: str) -> T:
    if not isinstance(value, kinds):
        raise InputError(f"{what} is needed, got {reprlib.repr(value)}; write {remedy}")
    return value


# At which the error of a map over crank speeds is estimated, each a map of its own: at both ends
# and in the middle, since the error changes steadily with the speed.
CHECKED_SPEEDS = 3
# Every 15 degrees: natural frequencies move slowly enough for bounds at these angles.
ANGLES = 24


def sampled_turn(start_angle: float = 0.0) -> FloatArray:
    """Evenly spaced crank angles of a turn in rad, shape (24,); its end is left out."""
    return np.asarray(start_angle + np.linspace(0.0, 2 * np.pi, ANGLES, endpoint=False))


def without_end(crank_angles: FloatArray) -> FloatArray:
    """Increasing angles of a full turn without its end, which is its start again.

    Parameters
    ----------
    crank_angles : ndarray, shape (A,)
        In rad.

    Returns
    -------
    ndarray
        The first angles, A or one less.
    """
    before_end = crank_angles < crank_angles[0] + 2 * np.pi * (1 - 1e-9)
    return np.asarray(crank_angles[before_end], dtype=float)


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
                reason = error.in_unit(speed_unit).partition(";")[0]
            continue
        said = f"modes: {count} in the place of the usual {MODES}, since {reason}" if reason else ""
        return found, {FEWER_MODES: said} if said else {}


def fewer_modes_lines(attributes: Mapping[Any, Any]) -> list[str]:
    """One line where a result has fewer modes than usual, with the reason."""
    return [str(attributes[FEWER_MODES])] if FEWER_MODES in attributes else []
