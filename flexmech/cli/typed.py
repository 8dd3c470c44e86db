"""What users type after each option, to SI values: its unit, its limits and the remedy."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from flexmech import crank_values as crank
from flexmech import units
from flexmech.choices import PICTURE_FORMATS, REPORT_PARTS
from flexmech.cli.failures import naming
from flexmech.cli.reading import OWN, Typed
from flexmech.crank_values import Speeds as Speeds
from flexmech.errors import InputError, known_words
from flexmech.plausible import RUN_UP as RUN_UPS
from flexmech.plausible import Plausible, check_plausible, of_dimension
from flexmech.quantity_lists import parse_counts, parse_modes

if TYPE_CHECKING:
    from flexmech.arrays import FloatArray
    from flexmech.hygrothermal import Environment as Environment
    from flexmech.linkages import CouplerPoint as CouplerPoint
    from flexmech.mechanics import LinkPoint as LinkPoint
    from flexmech.mechanics import RotationTerms as RotationTerms
    from flexmech.mechanism import Mechanism
else:  # Their rooms are imported where one of them is asked for.
    CouplerPoint = Environment = LinkPoint = RotationTerms = Any

# What --step and --steps take where the analysis chooses.
_AUTO = "auto"


def speeds_or_own(
    typed: Speeds | None,
    mechanism: Mechanism,
    option: str,
    usual: Callable[[Mechanism], FloatArray],
) -> Speeds:
    """The speeds of an option; where it is left out, those of the mechanism.

    Parameters
    ----------
    typed : Speeds or None
    mechanism : Mechanism
    option : str
    usual : callable
        Takes the mechanism, and gives the speeds in rad/s that are usual.

    Returns
    -------
    Speeds
        With a remark where they are the mechanism's.
    """
    from flexmech.analyses.crank_speeds import own_speeds

    with naming(option):
        return own_speeds(mechanism, usual) if typed is None else typed


def _quantity(
    option: str,
    dimension: units.Dimension,
    unit: str | None = None,
    can_be: Callable[[float], bool] = math.isfinite,
    refusal: str = "",
    plausible: Plausible | None = None,
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

    return Typed(option, read)


def _positive(option: str, dimension: units.Dimension, unit: str | None = None) -> Typed:
    return _quantity(option, dimension, unit, (0.0).__lt__, "must be positive, got {!r}")


def _or_auto(typed: Typed, remedy: str = "") -> Typed:
    """A number, or None for ``"auto"``."""

    def read(text: str) -> float | None:
        try:
            return None if text.strip() == _AUTO else typed.read(text)
        except InputError as error:
            raise InputError(f"{error}{remedy}, or {_AUTO}") from error

    return Typed(typed.option, read)


def _by_its_room(kind: str) -> Callable[[str], Any]:
    """How a kind of thing is read by the room that it lives in, which is imported then."""

    def read(text: str) -> Any:
        from flexmech.analyses.campbell.request import parse_orders
        from flexmech.linkages import CouplerPoint
        from flexmech.mechanics import LinkPoint, RotationTerms

        terms, place, point = RotationTerms.parse, LinkPoint.parse, CouplerPoint.parse
        return {"orders": parse_orders, "terms": terms, "place": place, "point": point}[kind](text)

    return read


def _whole(text: str) -> int:
    number = units.parse_number(text)
    if number != int(number):
        raise InputError(f"got {text!r}, which is no whole number")
    return int(number)


def _each(read: Callable[[str], float]) -> Callable[[str], tuple[float, ...]]:
    """A comma list, of which each entry is read so."""
    return lambda text: tuple(read(part) for part in text.split(","))


def _place(text: str) -> tuple[float, ...]:
    if len(place := _LENGTHS(text)) != 2:
        raise InputError(f'got {text!r}; give x and y in ground axes, as in "127 mm,0 mm"')
    return place


_LENGTHS = _each(partial(units.parse_quantity, dimension=units.LENGTH))
WEIGHTS = Typed("--weights", _each(lambda text: float(units.parse_number(text))))
RADIUS = Typed("--radius", _LENGTHS)
MOMENT_POINT = Typed("--moment-point", _place)
ANGLES = Typed("--angles", crank.parse_crank_angles)
LOCKED_ANGLES = Typed("--angle", crank.parse_crank_angles)
SHAPES_AT = Typed("--shapes-at", crank.parse_crank_angles)
SPEEDS = Typed("--speeds", partial(crank.typed_speeds, option="--speeds"))
CAMPBELL_SPEEDS = Typed(
    "--campbell-speeds", partial(crank.typed_speeds, option="--campbell-speeds")
)
SPEED = Typed("--speed", partial(crank.typed_speed, option="--speed", turns=True))
SPEED_OR_REST = Typed("--speed", partial(crank.typed_speed, option="--speed", turns=False))
_TURNING = partial(crank.typed_speed, option="--running", turns=True)
RUNNING = Typed("--running", lambda text: Speeds(()) if text == OWN else _TURNING(text))
ORDERS = Typed("--orders", _by_its_room("orders"))
ROTATION_TERMS = Typed("--rotation-terms", _by_its_room("terms"))
LUMPED = Typed("--lumped", parse_counts)
POINT = Typed("--point", _by_its_room("point"))
IMPACT = Typed("--impact", _by_its_room("place"))
RESPONSE = Typed("--response", _by_its_room("place"))
REVOLUTIONS = Typed("--revolutions", crank.parse_revolutions)
SHAPED_MODES = Typed("--shaped-modes", parse_modes)
CRANK_ACCELERATION = _quantity("--crank-acceleration", units.ANGULAR_ACCELERATION, "rad/s^2")
STEPS = _or_auto(Typed("--steps", _whole), "; write a multiple of 16, such as 256")
_STEP_REFUSED = f"got {{!r}}, which is not positive; write a time, for example {units.TIME.example}"
STEP = _or_auto(_quantity("--step", units.TIME, "s", (0.0).__lt__, _STEP_REFUSED))
MOISTURE = Typed("--moisture", units.parse_percent)
RELATIVE_HUMIDITY = Typed("--relative-humidity", units.parse_percent)
_PICTURES = "format of pictures", ", as in --format pdf,svg"
FORMATS = Typed("--format", lambda text: known_words(text, PICTURE_FORMATS, *_PICTURES))
INCLUDE = Typed("--include", lambda text: known_words(text, REPORT_PARTS, "part of a report"))
FIT = Typed("--fit", lambda text: tuple(name.strip() for name in text.split(",")))

BANDWIDTH = _positive("--bandwidth", units.FREQUENCY, "Hz")
DURATION = _positive("--duration", units.TIME, "s")
PULSE = _positive("--pulse", units.TIME, "s")
GROUND = _positive("--ground", units.LENGTH)
NOISE = _quantity("--noise", units.RATIO)
SHARE = _quantity("--share", units.RATIO)
TOLERATED = _quantity("--tolerated", units.RATIO)
TEMPERATURE_RISE = _quantity("--temperature-rise", units.TEMPERATURE_DIFFERENCE, "K")
_BELOW_ZERO = "must be above absolute zero, got {!r}"
TEMPERATURE = _quantity("--temperature", units.TEMPERATURE, "degC", (0.0).__lt__, _BELOW_ZERO)
EXPOSURE_TIME = _quantity(
    "--time", units.TIME, None, (0.0).__le__, "must be zero or positive, got {!r}"
)
RUN_UP = _quantity(
    "--run-up",
    units.TIME,
    "s",
    (0.0).__le__,
    "got {!r}, which is negative; write how long the crank takes to reach its speed, for example "
    '"0.2 s"',
    RUN_UPS,
)
DAMPING_RATIO = _quantity(
    "--damping-ratio",
    units.RATIO,
    None,
    lambda ratio: 0 <= ratio < 1,
    'must be at least 0 and less than 1, got {!r}; write "0.1%" or 0.001 for a tenth of a percent',
)
POSTURE_ANGLE = _quantity(
    "--angle",
    crank.CRANK_ANGLE,
    "deg",
    lambda angle: abs(angle) <= crank.MOST_DEGREES,
    crank.BEYOND,
)
RECORD_ANGLE = _quantity(
    "--angle",
    crank.CRANK_ANGLE,
    "deg",
    lambda angle: abs(angle) <= 360,
    "got {!r}; give an angle from 0 to 360 deg",
)


def radians(degrees: list[float]) -> FloatArray:
    """Crank angles in rad, as the library takes them."""
    import numpy as np

    return np.radians(degrees)
