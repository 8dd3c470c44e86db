"""Crank angles, crank speeds and turns as users write them."""

from __future__ import annotations

import math
import re
from collections.abc import Collection
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from flexmech import units
from flexmech.errors import InputError
from flexmech.plausible import check_plausible, of_dimension
from flexmech.quantity_lists import Quantities, parse_quantities

if TYPE_CHECKING:
    from flexmech.arrays import FloatArray

MOST_ANGLES = 100_000
"""More crank angles than this, every 0.004 deg of a turn, are taken for a slip of the keyboard."""
MOST_SPEEDS = 10_000
"""And more crank speeds than this: at a tenth of a second each they take a quarter of an hour."""
"""And more times of a move than this, each of which is a run."""
MOST_DEGREES = 2880
"""Eight turns: positions repeat every turn."""
BEYOND = (
    f"got {{!r}}, which goes beyond {MOST_DEGREES} deg; positions repeat every turn, so give an "
    "angle of the first eight turns"
)
CRANK_ANGLE = units.Dimension("an angle", "deg", ("0:360:5", "45 deg", "0.785 rad"))
"""In degrees: whole ones stay exact if they do not pass through radians."""
# Speeds nearer to each other than this, relatively, are one speed in two units: they differ by the
# round-off of the conversion.
_SAME_SPEED = 1e-12
# In rad/s, 1,900 rpm, at which few linkages run: a bare number beyond may be meant in rpm.
_DOUBTFUL_SPEED = 200.0


@dataclass(frozen=True)
class Speeds:
    """Crank speeds as typed, or as the model file names them.

    Parameters
    ----------
    numbers : tuple of float
        In ``unit``, ascending.
    unit : str
    remark : str
        How many turns a minute a bare number is that is large for rad/s, or that the speeds are
        those of the model file; else empty.
    drive : Drive, optional
        Drive of the model file, in place of a speed.
    """

    numbers: tuple[float, ...]
    unit: str = "rad/s"
    remark: str = ""
    drive: Any = None

    @property
    def single(self) -> float:
        """The speed of an option that takes one."""
        [speed] = self.numbers
        return speed

    def keywords(self, name: str = "speed") -> dict[str, Any]:
        """Numbers for an analysis in their unit, of ``"speed"`` one, or the drive."""
        if self.drive is not None:
            return {name: self.drive}
        return {name: self.single if name == "speed" else self.numbers, "speed_unit": self.unit}


@dataclass(frozen=True)
class UsualSpeeds:
    """Evenly spaced crank speeds that an analysis takes where none are asked for.

    Parameters
    ----------
    first, last : float
        Over the greatest speed at which the mechanism operates.
    count : int
    or_rest : bool
        Whether a mechanism that names no speed stands still.
    or_drive : bool
        Whether the drive of a mechanism that has one is taken in place of speeds.
    """

    first: float
    last: float
    count: int
    or_rest: bool = False
    or_drive: bool = False

    def __call__(self, mechanism: Any) -> FloatArray:
        """Speeds of a mechanism in rad/s; refused where it names no speed at which it turns."""
        import numpy as np

        greatest = max(mechanism.operating_speeds, key=abs, default=0.0)
        if not greatest and not self.or_rest:
            raise InputError(
                "is left out, and the model names no crank speed; give it, or write in the model "
                'file, under [operation], crank_speeds = ["300 rpm"]'
            )
        return np.asarray(greatest * np.linspace(self.first, self.last, self.count))


# Beyond the greatest speed by a half: the range into which a machine may be made faster. The
# numbers of steps alone are of speed; with both of them the greatest speed is one of the steps.
CAMPBELL = UsualSpeeds(0.0, 1.5, 61)
# At standstill there is no period.
STABILITY = UsualSpeeds(0.5, 1.5, 41)
GREATEST = UsualSpeeds(1.0, 1.0, 1)
GREATEST_OR_REST = UsualSpeeds(1.0, 1.0, 1, or_rest=True)
DRIVE_OR_GREATEST = UsualSpeeds(1.0, 1.0, 1, or_drive=True)
DRIVE_OR_REST = UsualSpeeds(1.0, 1.0, 1, or_rest=True, or_drive=True)


# Speeds of linkages whose file names no speed: standstill, and the speeds of the first examples.
SPEEDS = (0.0, 10.0, 20.0)


def operating_speeds(mechanism: Any) -> FloatArray:
    """Standstill and the speeds in rad/s at which a mechanism operates, ascending.

    0, 10 and 20 rad/s, the speeds of Kumar & Chandrakar, if it names none.
    """
    import numpy as np

    return np.array(
        sorted({0.0, *mechanism.operating_speeds}) if mechanism.operating_speeds else SPEEDS
    )


def typed_speeds(text: str, option: str) -> Speeds:
    """Read the crank speeds of an option, as :func:`parse_crank_speeds`.

    Parameters
    ----------
    text : str
    option : str
        That a remark names.

    Returns
    -------
    Speeds

    Raises
    ------
    InputError
        As :func:`parse_crank_speeds`.
    """
    found = parse_crank_speeds(text)
    return Speeds(found.numbers, found.unit, _remark(option, text, found.values))


def typed_speed(text: str, option: str, *, turns: bool) -> Speeds:
    """Read the one crank speed of an option; a negative one turns backwards.

    Parameters
    ----------
    text : str
        In rad/s unless it has a unit.
    option : str
        That a remark names.
    turns : bool
        Whether a speed of zero is refused.

    Returns
    -------
    Speeds

    Raises
    ------
    InputError
        If it is no speed, is beyond what can be, or is zero.
    """
    speed = units.parse_quantity(text, units.ANGULAR_SPEED, default_unit="rad/s")
    sizes = of_dimension(units.ANGULAR_SPEED)
    assert sizes is not None
    check_plausible(speed, text, sizes)
    if turns and speed == 0:
        raise InputError(
            f"got {text!r}, at which nothing turns; give a crank speed other than zero, "
            f"for example {units.ANGULAR_SPEED.example} (a negative one turns backwards)"
        )
    found = parse_quantities(text, units.ANGULAR_SPEED, "rad/s")
    return Speeds(found.numbers, found.unit, _remark(option, text, [speed]))


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


def parse_revolutions(text: str) -> float:
    """Read a number of turns.

    Parameters
    ----------
    text : str

    Returns
    -------
    float

    Raises
    ------
    InputError
        If it is no positive number.
    """
    revolutions = float(units.parse_number(text))
    if revolutions <= 0:
        raise InputError(
            f"got {text!r}, which is not positive; write how many turns to run, for example "
            "4 or 0.5 (a negative --speed turns backwards)"
        )
    return revolutions


def parse_crank_speeds(text: str) -> Quantities:
    """Read crank speeds from a comma list or START:STOP:STEP.

    Parameters
    ----------
    text : str
        With one unit at the end, such as ``"0:300:10 rpm"``; rad/s if there is none.

    Returns
    -------
    Quantities
        Ascending.

    Raises
    ------
    InputError
        If it is neither, a speed is beyond what can be, or appears twice.
    """
    found = parse_quantities(text, units.ANGULAR_SPEED, "rad/s", most=MOST_SPEEDS)
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
    return Quantities(tuple(speeds), found.unit, tuple(sorted(found.numbers)))


def parse_crank_angles(text: str) -> list[float]:
    """Read crank angles in degrees from a comma list or START:STOP:STEP.

    Parameters
    ----------
    text : str

    Returns
    -------
    list of float
        Increasing.

    Raises
    ------
    InputError
        If it is neither, an angle is beyond eight turns, or the angles do not increase.
    """
    angles = parse_quantities(text, CRANK_ANGLE, "deg", most=MOST_ANGLES).values
    if max(map(abs, angles)) > MOST_DEGREES:
        raise InputError(BEYOND.format(text).replace("an angle", "angles"))
    for before, after in pairwise(angles):
        if not after > before:
            raise InputError(
                f"got {text!r}, in which {after:g} follows {before:g}; modes are tracked from "
                "angle to angle, so give each angle once, in increasing order (beyond 360 if "
                "need be)"
            )
    return list(angles)


# More are taken for a slip: a thousand rays are drawn as one surface.
MOST_ORDER = 1000


def parse_orders(text: str) -> list[int]:
    """Orders as a user writes them: a comma list, START:STOP or START:STOP:STEP; sorted.

    Parameters
    ----------
    text : str

    Returns
    -------
    list of int

    Raises
    ------
    InputError
        If it is anything else, or an order is there twice.
    """
    remedy = 'write whole numbers from 1 on: "1:10", or with a step "2:12:2", or a list "1,2,4"'
    separator = ":" if ":" in text else ","
    parts = [units.parse_number(part) for part in text.split(separator)]
    if any(part != int(part) or not 1 <= part <= MOST_ORDER for part in parts):
        raise InputError(f"got {text!r}; {remedy} (up to {MOST_ORDER})")
    whole = [int(part) for part in parts]
    if separator == ":":
        if len(whole) not in (2, 3) or whole[1] < whole[0]:
            raise InputError(f"got {text!r}, which is no range; {remedy}")
        return list(range(whole[0], whole[1] + 1, *whole[2:]))
    if len(set(whole)) < len(whole):
        raise InputError(f"got {text!r}, which repeats an order; give each one once")
    return sorted(whole)
