"""Printed lines compared: words as words, numbers within what round-off may change."""

from __future__ import annotations

import re
from itertools import zip_longest

__all__ = ["difference"]

# Relative to the number, and in units of its last printed digit.
RELATIVE = 1e-3
LAST_DIGITS = 1.01
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
FRAMES = re.compile("[\u2500-\u257f]")
ANGLE = re.compile(r"\d{1,3}\.\d")


def difference(page: str, today: str, *, symmetric: bool = False) -> str:
    """The first word or number that differs, and empty text if none does.

    Parameters
    ----------
    page, today : str
        Printed lines. The frames of tables, as wide as what they hold, do not count.
    symmetric : bool
        Whether extremes are equal at several crank angles, so that round-off decides which is
        named: mirrored in the line, turned by half a turn, or both.
    """
    ours, theirs = (FRAMES.sub(" ", text).split() for text in (page, today))
    for one, other in zip_longest(ours, theirs, fillvalue=""):
        if not (_alike(one, other) or (symmetric and _tied(one, other))):
            return f"{one!r} is printed as {other!r}"
    return ""


def _alike(one: str, other: str) -> bool:
    if NUMBER.sub("#", one) != NUMBER.sub("#", other):
        return False
    pairs = zip(NUMBER.findall(one), NUMBER.findall(other), strict=True)
    return all(_close(a, b) for a, b in pairs)


def _close(one: str, other: str) -> bool:
    a, b = float(one), float(other)
    if "." not in one + other:
        # Counts, names and settings; a rounded number has a point or an exponent.
        return a == b or ("e" in one.lower() and abs(a - b) <= RELATIVE * abs(a))
    mantissa, _, exponent = one.lower().partition("e")
    digits = len(mantissa.partition(".")[2])
    last = 10.0 ** (int(exponent or 0) - digits)
    return abs(a - b) <= max(RELATIVE * abs(a), LAST_DIGITS * last)


def _tied(one: str, other: str) -> bool:
    if not (ANGLE.fullmatch(one) and ANGLE.fullmatch(other)):
        return False
    a, b = float(one), float(other)
    return any(abs((gap + 90) % 180 - 90) < 0.051 for gap in (a - b, a + b))
