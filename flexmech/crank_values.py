"""Lists of crank angles and crank speeds as users write them."""

from __future__ import annotations

import math
from itertools import pairwise

from flexmech import units
from flexmech.errors import InputError
from flexmech.plausible import of_dimension
from flexmech.quantity_lists import Quantities, parse_quantities

MOST_ANGLES = 100_000
"""More crank angles than this, every 0.004 deg of a turn, are taken for a slip of the keyboard."""
MOST_SPEEDS = 10_000
"""And more crank speeds than this: at a tenth of a second each they take a quarter of an hour."""
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
