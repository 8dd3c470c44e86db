"""Typed values of options as SI values: unit, limits and remedy."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from flexmech import choices, units
from flexmech import crank_values as crank
from flexmech.choices import PICTURE_FORMATS, REPORT_PARTS
from flexmech.crank_values import GREATEST
from flexmech.crank_values import Speeds as Speeds
from flexmech.errors import InputError, known_words, naming
from flexmech.plausible import RUN_UP as RUN_UPS
from flexmech.plausible import Plausible, check_plausible, of_dimension
from flexmech.quantity_lists import parse_counts, parse_modes

if TYPE_CHECKING:
    from flexmech.arrays import FloatArray as FloatArray
    from flexmech.hygrothermal import Environment as Environment
    from flexmech.linkages import CouplerPoint as CouplerPoint
    from flexmech.linkages import Shaping as Shaping
    from flexmech.mechanics import LinkPoint as LinkPoint
    from flexmech.mechanics import RotationTerms as RotationTerms
else:  # Their rooms are imported where one of them is asked for.
    CouplerPoint = Environment = FloatArray = LinkPoint = RotationTerms = Shaping = Any

# What --step and --steps take where the analysis chooses.
_AUTO = "auto"


# What ``--running`` is without a value: the speed of the model file.
OWN = "model"


@dataclass(frozen=True)
class Typed:
    """How the value of an option is typed.

    Parameters
    ----------
    option : str
        Its name, which messages give.
    read : callable
        Takes the text; raises InputError where it cannot be read.
    metavar : str
        What stands for the value in the help; empty where its type is enough.
    how : str
        End of the first sentence of the help: units and lists, as in ": rad/s unless a unit is
        given."; a full stop alone if empty.
    also : str
        Another name of the option; empty where it has one.
    """

    option: str
    read: Callable[[str], Any]
    metavar: str = ""
    how: str = ""
    also: str = ""

    def __call__(self, text: str | None) -> Any:
        """Value of the text; None where the option was left out."""
        if text is None:
            return None
        with naming(self.option):
            return self.read(text)


@dataclass(frozen=True)
class TypedSpeeds(Typed):
    """Crank speeds as they are typed, and those of a mechanism where they are left out.

    Parameters
    ----------
    option, read, metavar, how, also
        As of :class:`Typed`.
    usual : callable
        Takes a mechanism, and gives the speeds in rad/s that are taken where they are left out.
    """

    usual: Callable[[Any], FloatArray] = GREATEST


@dataclass(frozen=True)
class Plain:
    """An option whose type says how it is typed: a word of a list, a whole number or a flag.

    Parameters
    ----------
    option : str
        Empty of an argument, which has no name on a command line.
    least, most : int, optional
        Between which a whole number lies.
    metavar : str
        What stands for the value in the help; empty where its type is enough.
    kind : type, optional
        What is typed, where that is another type than the field's.
    """

    option: str
    least: int | None = None
    most: int | None = None
    metavar: str = ""
    kind: Any = None


@dataclass(frozen=True)
class Together:
    """Options of which one value is made: the parameters of a function that makes it.

    Parameters
    ----------
    make : callable
        A function, or a class of :mod:`flexmech.analyses.options`, whose fields that are options
        are handed on by name.
    defaults : mapping
        Defaults of a command, where they are not those of the class.
    """

    make: Callable[..., Any]
    defaults: Mapping[str, Any] = field(default_factory=dict)


def _quantity(
    option: str,
    dimension: units.Dimension,
    unit: str | None = None,
    can_be: Callable[[float], bool] = math.isfinite,
    refusal: str = "",
    plausible: Plausible | None = None,
    *,
    metavar: str = "",
    how: str = "",
) -> Typed:
    """An option of one quantity, in SI units.

    A bare number is in ``unit``, and refused without one. ``refusal``, with ``{!r}`` for what was
    typed, is said of what it cannot be. Sizes are those of the dimension unless given.
    """

    def read(text: str) -> float:
        value = units.parse_quantity(text, dimension, default_unit=unit)
        if not can_be(value):
            raise InputError(refusal.format(text))
        if (sizes := plausible or of_dimension(dimension)) is not None:
            check_plausible(value, text, sizes)
        return value

    return Typed(option, read, metavar, how)


def _positive(
    option: str, dimension: units.Dimension, unit: str | None = None, metavar: str = ""
) -> Typed:
    refusal = "must be positive, got {!r}"
    return _quantity(option, dimension, unit, (0.0).__lt__, refusal, metavar=metavar)


def _in_radians(typed: Typed) -> Typed:
    """The same angle in rad."""
    return replace(typed, read=lambda text: math.radians(typed.read(text)))


def _or_auto(typed: Typed, remedy: str = "") -> Typed:
    """A number, or None for ``"auto"``."""

    def read(text: str) -> float | None:
        try:
            return None if text.strip() == _AUTO else typed.read(text)
        except InputError as error:
            raise InputError(f"{error}{remedy}, or {_AUTO}") from error

    return replace(typed, read=read)


def _by_its_room(kind: str) -> Callable[[str], Any]:
    """How a kind of thing is read by the room that it lives in, which is imported then."""

    def read(text: str) -> Any:
        from flexmech.linkages import CouplerPoint
        from flexmech.mechanics import LinkPoint, RotationTerms

        terms, place, point = RotationTerms.parse, LinkPoint.parse, CouplerPoint.parse
        return {"terms": terms, "place": place, "point": point}[kind](text)

    return read


def radians(text: str) -> FloatArray:
    """Crank angles that are typed in degrees: a comma list, START:STOP:STEP, or both; in rad."""
    import numpy as np

    return np.radians(crank.parse_crank_angles(text))


def _whole(text: str) -> int:
    number = units.parse_number(text)
    if number != int(number):
        raise InputError(f"got {text!r}, which is no whole number")
    return int(number)


def _each(read: Callable[[str], float]) -> Callable[[str], tuple[float, ...]]:
    """A comma list, of which each entry is read so."""
    return lambda text: tuple(read(part) for part in text.split(","))


def _file(text: str) -> str:
    if not text:
        raise InputError("it is empty; name a file")
    return text


def _place(text: str) -> tuple[float, ...]:
    if len(place := _LENGTHS(text)) != 2:
        raise InputError(f'got {text!r}; give x and y in ground axes, as in "127 mm,0 mm"')
    return place


_LENGTHS = _each(partial(units.parse_quantity, dimension=units.LENGTH))
WEIGHTS = Typed(
    "--weights",
    _each(lambda text: float(units.parse_number(text))),
    "F,M,T",
    ", as in 1,0.5,0.5.",
)
RADIUS = Typed("--radius", _LENGTHS, "LIST", ', as in "40 mm,80 mm", or one for both.')
MOMENT_POINT = Typed("--moment-point", _place, "X,Y", ", as in '127 mm,0 mm'.")
ANGLES = Typed(
    "--angles",
    radians,
    how=' in degrees: START:STOP:STEP, a comma list, or both, as in "10:170:10,190:350:10".',
)
LOCKED_ANGLES = Typed(
    "--angle", radians, "LIST", how=" in degrees: START:STOP:STEP, or a comma list."
)
SHAPES_AT = Typed("--shapes-at", radians, "LIST", ", in degrees.")
SPEEDS = Typed("--speeds", partial(crank.typed_speeds, option="--speeds"))
CAMPBELL_SPEEDS = Typed(
    "--campbell-speeds", partial(crank.typed_speeds, option="--campbell-speeds"), "LIST"
)
SPEED = Typed("--speed", partial(crank.typed_speed, option="--speed", turns=True))
SPEED_OR_REST = Typed("--speed", partial(crank.typed_speed, option="--speed", turns=False), "W")


def speeds(usual: Callable[[Any], FloatArray], *, example: str) -> TypedSpeeds:
    """The crank speeds of an analysis.

    Parameters
    ----------
    usual : callable
        Gives the speeds of a mechanism that are taken where they are left out.
    example : str

    Returns
    -------
    TypedSpeeds
    """
    how = (
        f': START:STOP:STEP or a comma list with one unit at the end, as in "{example}"; rad/s if '
        "there is none."
    )
    return TypedSpeeds(SPEEDS.option, SPEEDS.read, "LIST", how, usual=usual)


def speed(usual: Callable[[Any], FloatArray], *, turns: bool) -> TypedSpeeds:
    """The one crank speed of an analysis.

    Parameters
    ----------
    usual : callable
        Gives the speed of a mechanism that is taken where it is left out.
    turns : bool
        Whether a speed of zero is refused.

    Returns
    -------
    TypedSpeeds
    """
    read = partial(crank.typed_speed, option="--speed", turns=turns)
    how = ': rad/s unless a unit is given, as in "190 rpm".'
    return TypedSpeeds("--speed", read, "W", how, usual=usual)


_TURNING = partial(crank.typed_speed, option="--running", turns=True)
RUNNING = TypedSpeeds(
    "--running", lambda text: Speeds(()) if text == OWN else _TURNING(text), "SPEED"
)
ORDERS = Typed(
    "--orders", crank.parse_orders, "LIST", ': START:STOP, or a comma list such as "1,2,4".'
)
ROTATION_TERMS = Typed("--rotation-terms", _by_its_room("terms"), "LIST")
LUMPED = Typed("--lumped", parse_counts, "LIST", ", as in 1,4,4; or one number for all.")
POINT = Typed("--point", _by_its_room("point"), "e,gamma")
IMPACT = Typed("--impact", _by_its_room("place"), "LINK:FRACTION")
RESPONSE = Typed("--response", _by_its_room("place"), "LINK:FRACTION")
REVOLUTIONS = Typed("--revolutions", crank.parse_revolutions, "NUMBER")
AGAINST = Plain("--against", metavar="PARAMETER RANGE", kind=tuple[str, str] | None)
RECORD = Plain("", metavar="RECORD", kind=Path)
SHAPED_MODES = Typed("--shaped-modes", parse_modes, "LIST")
CRANK_ACCELERATION = _quantity(
    "--crank-acceleration",
    units.ANGULAR_ACCELERATION,
    "rad/s^2",
    how=": rad/s^2 unless a unit is given.",
)
STEPS = _or_auto(Typed("--steps", _whole, "auto|N"), "; write a multiple of 16, such as 256")
_STEP_REFUSED = f"got {{!r}}, which is not positive; write a time, for example {units.TIME.example}"
STEP = _or_auto(
    _quantity("--step", units.TIME, "s", (0.0).__lt__, _STEP_REFUSED, metavar=f"{_AUTO}|SECONDS")
)
MOISTURE = Typed("--moisture", units.parse_percent, "PERCENT")
RELATIVE_HUMIDITY = Typed("--relative-humidity", units.parse_percent, "PERCENT")
_PICTURES = "format of pictures", ", as in --format pdf,svg"
FORMATS = Typed("--format", lambda text: known_words(text, PICTURE_FORMATS, *_PICTURES))
INCLUDE = Typed(
    "--include", lambda text: known_words(text, REPORT_PARTS, "part of a report"), "LIST"
)
MOTORS = Typed("--motors", _file, "FILE")
FIT = Typed("--fit", lambda text: tuple(name.strip() for name in text.split(",")), "LIST")

BANDWIDTH = _positive("--bandwidth", units.FREQUENCY, "Hz", "HZ")
DURATION = _positive("--duration", units.TIME, "s", "SECONDS")
PULSE = _positive("--pulse", units.TIME, "s", "SECONDS")
GROUND = _positive("--ground", units.LENGTH)
NOISE = _quantity("--noise", units.RATIO, metavar="RMS_FRACTION")
SHARE = _quantity("--share", units.RATIO, metavar="PERCENT")
TOLERATED = _quantity("--tolerated", units.RATIO, metavar="RATIO")
TEMPERATURE_RISE = _quantity("--temperature-rise", units.TEMPERATURE_DIFFERENCE, "K", metavar="C")
_BELOW_ZERO = "must be above absolute zero, got {!r}"
TEMPERATURE = _quantity(
    "--temperature", units.TEMPERATURE, "degC", (0.0).__lt__, _BELOW_ZERO, metavar="C"
)
EXPOSURE_TIME = replace(
    _quantity("--time", units.TIME, None, (0.0).__le__, "must be zero or positive, got {!r}"),
    metavar="T",
    also="--exposure-time",
)
RUN_UP = _quantity(
    "--run-up",
    units.TIME,
    "s",
    (0.0).__le__,
    "got {!r}, which is negative; write how long the crank takes to reach its speed, for example "
    '"0.2 s"',
    RUN_UPS,
    metavar="SECONDS",
)
DAMPING_RATIO = _quantity(
    "--damping-ratio",
    units.RATIO,
    None,
    lambda ratio: 0 <= ratio < 1,
    'must be at least 0 and less than 1, got {!r}; write "0.1%" or 0.001 for a tenth of a percent',
    metavar="Z",
)
POSTURE_ANGLE = _in_radians(
    _quantity(
        "--angle",
        crank.CRANK_ANGLE,
        "deg",
        lambda angle: abs(angle) <= crank.MOST_DEGREES,
        crank.BEYOND,
        metavar="DEG",
    )
)
RECORD_ANGLE = _in_radians(
    _quantity(
        "--angle",
        crank.CRANK_ANGLE,
        "deg",
        lambda angle: abs(angle) <= 360,
        "got {!r}; give an angle from 0 to 360 deg",
        metavar="DEG",
    )
)


def asked_environment(
    temperature_rise: Annotated[float | None, TEMPERATURE_RISE] = None,
    moisture: Annotated[float | None, MOISTURE] = None,
    relative_humidity: Annotated[float | None, RELATIVE_HUMIDITY] = None,
    time: Annotated[float | None, EXPOSURE_TIME] = None,
) -> Environment | None:
    """Heat and moisture, or the exposure to them; None if nothing is asked for.

    Parameters
    ----------
    temperature_rise : float, optional
        Temperature over the model's reference temperature: degrees Celsius unless a unit is given.
    moisture : float, optional
        Moisture of every resin: mass of water over its dry mass, in percent.
    relative_humidity : float, optional
        Instead of --moisture: humidity of the surrounding air in percent, with --time.
    time : float, optional
        Time of exposure since the links were dry, such as "30 day".
    """
    if (temperature_rise, moisture, relative_humidity, time) == (None,) * 4:
        return None
    from flexmech.hygrothermal import environment_of

    return environment_of(temperature_rise or 0.0, moisture, relative_humidity, time)


ENVIRONMENT = Together(asked_environment)


def asked_shaping(
    shaper: Annotated[choices.ShaperName | None, Plain("--shaper")] = None,
    shaped_modes: Annotated[tuple[int, ...] | None, SHAPED_MODES] = None,
    shaped_for: Annotated[choices.ShapedFor, Plain("--shaped-for")] = "end",
    tolerated: Annotated[float | None, TOLERATED] = None,
) -> Shaping | None:
    """A shaper of the law of motion; None if none is asked for.

    Parameters
    ----------
    shaper : {"zv", "zvd", "ei"}, optional
        Run a law that stops shaped as well, beside the plain one: zv (zero vibration), zvd (zero
        vibration and derivative) or ei (extra insensitive).
    shaped_modes : tuple of int, optional
        Modes for which the law is shaped, as in 1,2. Left out: modes that ring by at least a tenth
        of the greatest.
    shaped_for : {"end", "path"}
        Frequencies for which the law is shaped: end, where the crank stops; path, along its path.
    tolerated : float, optional
        For ei: residual vibration at the frequency over that by the plain law; 5% if left out.
    """
    if shaper is None:
        if shaped_modes is not None or shaped_for != "end" or tolerated is not None:
            raise InputError(
                "--shaped-modes, --shaped-for, --tolerated need --shaper; add --shaper"
            )
        return None
    from flexmech.linkages import Shaping

    with naming("--shaper, --shaped-modes, --tolerated"):
        return Shaping(shaper, shaped_modes, shaped_for, tolerated)


SHAPING = Together(asked_shaping)
