"""What users type after each option, to SI values: its unit, its limits and the remedy."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from flexmech import units
from flexmech.choices import PICTURE_FORMATS, REPORT_PARTS
from flexmech.cli.failures import naming
from flexmech.cli.reading import Typed
from flexmech.errors import InputError, suggestion
from flexmech.plausible import RUN_UP as RUN_UPS
from flexmech.plausible import Plausible, check_plausible, of_dimension

if TYPE_CHECKING:
    from flexmech.arrays import FloatArray
    from flexmech.hygrothermal import Environment as Environment
    from flexmech.linear_system import LinkPoint as LinkPoint
    from flexmech.linear_system import RotationTerms as RotationTerms
    from flexmech.linkages import CouplerPoint as CouplerPoint
    from flexmech.mechanism import Mechanism
else:  # Their rooms are imported where one of them is asked for.
    CouplerPoint = Environment = LinkPoint = RotationTerms = Any

MOST_ANGLES = 100_000
"""More crank angles than this, every 0.004 deg of a turn, are taken for a slip of the keyboard."""
MOST_SPEEDS = 10_000
"""And more crank speeds than this: at a tenth of a second each they take a quarter of an hour."""
# Eight turns: positions repeat every turn.
_MOST_DEGREES = 2880
_BEYOND = (
    f"got {{!r}}, which goes beyond {_MOST_DEGREES} deg; positions repeat every turn, so give an "
    "angle of the first eight turns"
)
# Of the crank's speed in a Campbell diagram; higher ones excite nothing: a slip of the keyboard.
_MOST_ORDER = 1000
# In rad/s, 1,900 rpm, at which few linkages run: a bare number beyond may be meant in rpm.
_DOUBTFUL_SPEED = 200.0
# Speeds nearer to each other than this, relatively, are one speed in two units: they differ by the
# round-off of the conversion.
_SAME_SPEED = 1e-12
# What --step and --steps take where the analysis chooses.
_AUTO = "auto"

# Whole degrees stay exact if they do not pass through radians.
_CRANK_ANGLE = units.Dimension("an angle", "deg", ("0:360:5", "45 deg", "0.785 rad"))


@dataclass(frozen=True)
class Speeds:
    """Crank speeds as typed.

    Parameters
    ----------
    values : tuple of float
        In rad/s, ascending.
    unit : str
        In which they were typed.
    remark : str
        How many turns a minute a bare number is that is large for rad/s; else empty.
    """

    values: tuple[float, ...]
    unit: str = "rad/s"
    remark: str = ""

    @property
    def single(self) -> float:
        """The speed of an option that takes one."""
        [speed] = self.values
        return speed


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


def _within(degrees: float) -> Callable[[float], bool]:
    return lambda angle: abs(angle) <= degrees


def _or_auto(typed: Typed, remedy: str = "") -> Typed:
    """A number, or None for ``"auto"``."""

    def read(text: str) -> float | None:
        try:
            return None if text.strip() == _AUTO else typed.read(text)
        except InputError as error:
            raise InputError(f"{error}{remedy}, or {_AUTO}") from error

    return Typed(typed.option, read)


def _speeds(text: str, option: str) -> Speeds:
    """A comma list or START:STOP:STEP, sorted; no speed twice."""
    found = units.parse_quantities(text, units.ANGULAR_SPEED, "rad/s", most=MOST_SPEEDS)
    speeds = sorted(found.values)
    sizes = of_dimension(units.ANGULAR_SPEED)
    assert sizes is not None
    if not (sizes.holds(speeds[0]) and sizes.holds(speeds[-1])):
        raise InputError(
            f"got {text!r}, but {sizes.words}, 9.5e6 rpm; a bare number is in rad/s, check its unit"
        )
    for lower, upper in pairwise(speeds):
        if math.isclose(lower, upper, rel_tol=_SAME_SPEED):
            twice = f"{units.from_si(upper, found.unit):g} {found.unit}"
            raise InputError(f"got {text!r}, in which {twice} appears twice; give each speed once")
    return Speeds(tuple(speeds), found.unit, _remark(option, text, speeds))


def _one_speed(text: str, option: str, *, turns: bool) -> Speeds:
    """One crank speed; negative turns backwards, and what must turn has a speed other than zero."""
    speed = _quantity("", units.ANGULAR_SPEED, "rad/s").read(text)
    if turns and speed == 0:
        raise InputError(
            f"got {text!r}, at which nothing turns; give a crank speed other than zero, "
            f"for example {units.ANGULAR_SPEED.example} (a negative one turns backwards)"
        )
    unit = units.parse_quantities(text, units.ANGULAR_SPEED, "rad/s").unit
    return Speeds((speed,), unit, _remark(option, text, [speed]))


def _remark(option: str, text: str, speeds: Collection[float]) -> str:
    """Say how many turns a minute a bare number is that is large for rad/s."""
    fastest = max(map(abs, speeds))
    # An exponent is no unit.
    if fastest < _DOUBTFUL_SPEED or re.search(r"[a-df-zA-DF-Z]", text):
        return ""
    return (
        f"remark: {fastest:.6g} rad/s is {units.from_si(fastest, 'rpm'):.5g} rpm; for turns a "
        f'minute write {option} "{text.strip()} rpm"'
    )


def _angles(text: str) -> list[float]:
    """A comma list or START:STOP:STEP in degrees, increasing."""
    angles = units.parse_quantities(text, _CRANK_ANGLE, "deg", most=MOST_ANGLES).values
    if max(map(abs, angles)) > _MOST_DEGREES:
        raise InputError(_BEYOND.format(text).replace("an angle", "angles"))
    for before, after in pairwise(angles):
        if not after > before:
            raise InputError(
                f"got {text!r}, in which {after:g} follows {before:g}; modes are tracked from "
                "angle to angle, so give each angle once, in increasing order (beyond 360 if "
                "need be)"
            )
    return list(angles)


def _orders(text: str) -> list[int]:
    """START:STOP, START:STOP:STEP or a comma list of whole numbers, sorted."""
    remedy = 'write whole numbers from 1 on: "1:10", or with a step "2:12:2", or a list "1,2,4"'
    separator = ":" if ":" in text else ","
    parts = [units.parse_number(part) for part in text.split(separator)]
    if any(part != int(part) or not 1 <= part <= _MOST_ORDER for part in parts):
        raise InputError(f"got {text!r}; {remedy} (up to {_MOST_ORDER})")
    whole = [int(part) for part in parts]
    if separator == ":":
        if len(whole) not in (2, 3) or whole[1] < whole[0]:
            raise InputError(f"got {text!r}, which is no range; {remedy}")
        return list(range(whole[0], whole[1] + 1, *whole[2:]))
    if len(set(whole)) < len(whole):
        raise InputError(f"got {text!r}, which repeats an order; give each one once")
    return sorted(whole)


def _point(text: str) -> CouplerPoint:
    """Distance and angle of a coupler point, each with its unit."""
    from flexmech.linkages import CouplerPoint

    parts = [part.strip() for part in text.split(",")]
    try:
        if len(parts) != 2:
            raise InputError(f"got {text!r}, which has {len(parts)} parts")
        distance, angle = _quantity("", units.LENGTH), _quantity("", units.ANGLE)
        return CouplerPoint(distance.read(parts[0]), angle.read(parts[1]))
    except InputError as error:
        raise InputError(
            f'{error}; write distance and angle, each with its unit, as in "33 mm,320 deg"'
        ) from error


def _link_point(text: str) -> LinkPoint:
    from flexmech.linear_system import LinkPoint

    return LinkPoint.parse(text)


def _rotation_terms(text: str) -> RotationTerms:
    from flexmech.linear_system import RotationTerms

    return RotationTerms.parse(text)


def _lumped(text: str) -> tuple[int, ...]:
    counts = [part.strip() for part in text.split(",")]
    if not all(re.fullmatch(r"0*[1-9][0-9]{0,3}", count, re.ASCII) for count in counts):
        raise InputError(
            f"got {text!r}; give the elements of each link, whole numbers of one or "
            "more with commas between them, for example 1,4,4"
        )
    return tuple(map(int, counts))


def _revolutions(text: str) -> float:
    revolutions = float(units.parse_number(text))
    if revolutions <= 0:
        raise InputError(
            f"got {text!r}, which is not positive; write how many turns to run, for example "
            "4 or 0.5 (a negative --speed turns backwards)"
        )
    return revolutions


def _whole(text: str) -> int:
    number = units.parse_number(text)
    if number != int(number):
        raise InputError(f"got {text!r}, which is no whole number")
    return int(number)


def _percent(text: str) -> float:
    """Fraction in percent, ``"7"`` or ``"7 %"``: 0.07."""
    unit = next((unit for unit in ("percent", "%") if text.strip().endswith(unit)), "")
    try:
        percent = float(units.parse_number(text.strip().removesuffix(unit)))
    except InputError as error:
        raise InputError(f"{error} (in percent)") from error
    if not 0 <= percent <= 100:
        raise InputError(f"must lie between 0 and 100 percent, got {text!r}")
    return percent / 100


def _words(option: str, known: Collection[str], wrong: str, example: str = "") -> Typed:
    """A comma list of known words, in their own order."""

    def read(text: str) -> tuple[str, ...]:
        asked = [each.strip().lower().removeprefix(".") for each in text.split(",")]
        for each in asked:
            if each not in known:
                raise InputError(
                    f"got {text!r}, in which {each!r} is no {wrong}; choose from "
                    f"{', '.join(known)}{example}"
                )
        return tuple(word for word in known if word in asked)

    return Typed(option, read)


ANGLES = Typed("--angles", _angles)
LOCKED_ANGLES = Typed("--angle", _angles)
SHAPES_AT = Typed("--shapes-at", _angles)
SPEEDS = Typed("--speeds", partial(_speeds, option="--speeds"))
CAMPBELL_SPEEDS = Typed("--campbell-speeds", partial(_speeds, option="--campbell-speeds"))
SPEED = Typed("--speed", partial(_one_speed, option="--speed", turns=True))
SPEED_OR_REST = Typed("--speed", partial(_one_speed, option="--speed", turns=False))
RUNNING = Typed("--running", partial(_one_speed, option="--running", turns=True))
ORDERS = Typed("--orders", _orders)
ROTATION_TERMS = Typed("--rotation-terms", _rotation_terms)
LUMPED = Typed("--lumped", _lumped)
POINT = Typed("--point", _point)
IMPACT = Typed("--impact", _link_point)
RESPONSE = Typed("--response", _link_point)
REVOLUTIONS = Typed("--revolutions", _revolutions)
CRANK_ACCELERATION = _quantity("--crank-acceleration", units.ANGULAR_ACCELERATION, "rad/s^2")
STEPS = _or_auto(Typed("--steps", _whole), "; write a multiple of 16, such as 256")
_STEP_REFUSED = f"got {{!r}}, which is not positive; write a time, for example {units.TIME.example}"
STEP = _or_auto(_quantity("--step", units.TIME, "s", (0.0).__lt__, _STEP_REFUSED))
MOISTURE = Typed("--moisture", _percent)
RELATIVE_HUMIDITY = Typed("--relative-humidity", _percent)
_AS_IN = ", as in --format pdf,svg"
FORMATS = _words("--format", PICTURE_FORMATS, "format of pictures", _AS_IN)
INCLUDE = _words("--include", REPORT_PARTS, "part of a report")
FIT = Typed("--fit", lambda text: tuple(name.strip() for name in text.split(",")))

BANDWIDTH = _positive("--bandwidth", units.FREQUENCY, "Hz")
DURATION = _positive("--duration", units.TIME, "s")
PULSE = _positive("--pulse", units.TIME, "s")
GROUND = _positive("--ground", units.LENGTH)
NOISE = _quantity("--noise", units.RATIO)
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
POSTURE_ANGLE = _quantity("--angle", _CRANK_ANGLE, "deg", _within(_MOST_DEGREES), _BEYOND)
RECORD_ANGLE = _quantity(
    "--angle", _CRANK_ANGLE, "deg", _within(360), "got {!r}; give an angle from 0 to 360 deg"
)


def radians(degrees: list[float]) -> FloatArray:
    """Crank angles in rad, as the library takes them."""
    import numpy as np

    return np.radians(degrees)


def parameter_range(
    mechanism: Mechanism, typed: tuple[str, str] | None
) -> tuple[str, list[float]] | None:
    """Parameter and SI values of ``--against``; None where nothing was typed.

    After the parameter come START:STOP:STEPS, which are STEPS equal steps from START to STOP, both
    included, or a comma list. One unit at the end of STOP covers START too. Bare numbers are
    ratios, kelvins, percent of moisture, or SI values of what needs no unit.
    """
    if typed is None:
        return None
    from flexmech.analyses.stability.against import parameters_of, values_of

    parameter, text = typed
    known = parameters_of(mechanism)
    with naming("--against"):
        if parameter not in known:
            raise InputError(
                f"there is no parameter {parameter!r}; {suggestion(parameter, list(known))}"
            )
        dimension = known[parameter]
        default = None if dimension.unit else ""
        if dimension is units.TEMPERATURE_DIFFERENCE:
            default = "K"
        # As --moisture is.
        default = "%" if parameter == "moisture" else default
        return parameter, values_of(text, dimension, default)
