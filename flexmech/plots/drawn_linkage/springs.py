"""Springs and dampers of a linkage in one posture: their symbols, between points and in joints."""

from __future__ import annotations

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.plots.drawn_linkage import symbols
from flexmech.plots.drawn_linkage.parts import Posture
from flexmech.plots.drawn_linkage.symbols import OUTLINE, Symbol, below
from flexmech.plots.style import Look

LOOK: Look = {"color": "0.25", "lw": 0.9}
# Half the length of a cup over its half width, as in textbooks, and the most of the whole length
# that it takes, so that rod and stem are left.
SLENDER, MOST = 1.5, 0.25
# Where a damper beside a spring joins its line, on the straight ends of that, and how far it is
# from it in half widths: some of one is between them.
JOINED, BESIDE = 0.12, 2.4
# Angles in rad between which a damper lies around a joint, above it, and half its depth over its
# radius.
FIRST, LAST, DEEP = np.radians(25.0), np.radians(155.0), 0.22

BEARING: Look = {"ms": 7.0, "marker": "o", "mfc": "none", "mec": OUTLINE, "mew": 0.6, "zorder": 3.9}
# Of the ring around a bearing with a damper over that without: both are told.
DAMPED = 1.4
# Over the linkage's extent: half the width of a spring between points and of the wall that holds
# it, which is wider; radius of a spring and of a damper in a joint, which is around it.
SPRING, WALL, SPIRAL, BENT = 0.018, 0.03, 0.04, 0.065


def dashpot(first: FloatArray, second: FloatArray, half: float, *, beside: bool) -> Symbol:
    """A damper between two places, its cup as wide as twice a half width.

    Parameters
    ----------
    first, second : ndarray, shape (2,)
        In m.
    half : float
        In m.
    beside : bool
        Whether a spring has the straight line from place to place: the damper is below it, since
        arrows of loads are above.

    Returns
    -------
    Symbol
    """
    along = second - first
    length = float(np.hypot(*along))
    normal = below(along / length) if length else np.zeros(2)
    from_, to = (JOINED, 1 - JOINED) if beside else (0.0, 1.0)
    cup = min(SLENDER * half / length if length else 0.0, MOST)
    parts, aside = _outline(from_, to, cup)
    if beside:
        rungs = (np.array([from_, from_, np.nan]), np.array([to, to, np.nan]))
        parts = np.r_[rungs[0], rungs[1], parts]
        aside = np.r_[-BESIDE, 0.0, np.nan, -BESIDE, 0.0, np.nan, aside] + BESIDE
    places = first + np.outer(parts, along) + half * np.outer(aside, normal)
    return Symbol("damper", places, LOOK | {"zorder": 1.5})


def rotary_dashpot(place: FloatArray, radius: float) -> Symbol:
    """A damper that is bent around a joint, above it.

    Parameters
    ----------
    place : ndarray, shape (2,)
        In m.
    radius : float
        In m.

    Returns
    -------
    Symbol
    """
    parts, aside = _outline(0.0, 1.0, 0.2)
    # Along a circle; the piece of an arc between two corners is drawn by points between them.
    steps = np.linspace(0.0, 1.0, 9)[:-1]
    parts, aside = (
        np.r_[(values[:-1, None] + steps * np.diff(values)[:, None]).ravel(), values[-1]]
        for values in (parts, aside)
    )
    turn, out = FIRST + (LAST - FIRST) * parts, radius * (1 + DEEP * aside)
    places = place + out[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])
    return Symbol("torsional damper", places, LOOK | {"lw": 0.7, "zorder": 3.8})


def _outline(from_: float, to: float, cup: float) -> tuple[FloatArray, FloatArray]:
    """Rod, piston, cup and stem: places along a line, and across it in half widths of the cup."""
    middle, gap = (from_ + to) / 2, np.nan
    rod = [(from_, 0.0), (middle, 0.0), (gap, gap)]
    piston = [(middle, -0.7), (middle, 0.7), (gap, gap)]
    bottom = middle + cup
    walls = [(middle - cup, -1.0), (bottom, -1.0), (bottom, 1.0), (middle - cup, 1.0), (gap, gap)]
    stem = [(bottom, 0.0), (to, 0.0)]
    corners = np.array([*rod, *piston, *walls, *stem])
    return corners[:, 0], corners[:, 1]


def spring_symbols(posture: Posture) -> list[Symbol]:
    """Springs and dampers between points; a damper is beside its spring."""
    found, half = [], SPRING * posture.size
    for spring in posture.parts.springs:
        first, second = map(posture.spring_end, spring["ends"])
        if stiff := spring.get("stiff", True):
            found.append(symbols.zigzag(first, second, half))
        if spring.get("damped"):
            found.append(dashpot(first, second, half, beside=stiff))
    return found


def wall_symbols(posture: Posture) -> list[Symbol]:
    """What holds springs and dampers on the ground."""
    found, half = [], WALL * posture.size
    for spring in posture.parts.springs:
        places = [posture.spring_end(end) for end in spring["ends"]]
        for end, place, other in zip(spring["ends"], places, places[::-1], strict=True):
            if "ground" in end and (length := np.hypot(*(place - other))):
                found += symbols.wall(place, (place - other) / length, half, 0.6 * half)
    return found


def joint_spring_symbols(posture: Posture, mark_size: float) -> list[Symbol]:
    """Springs and dampers in joints.

    Parameters
    ----------
    posture : Posture
    mark_size : float
        Of the rings of bearings over the usual one.

    Returns
    -------
    list of Symbol
    """
    at = {joint["name"]: joint["at"] for joint in posture.parts.joints}
    found = []
    for one in posture.parts.joint_springs:
        place, ring = posture.place(at[one["joint"]]), mark_size * BEARING["ms"]
        if one["torsional"]:
            found.append(symbols.spiral(place, SPIRAL * posture.size))
        if one["radial"]:
            found += symbols.marks("bearing", [place], BEARING | {"ms": ring})
        if one.get("torsion_damped"):
            found.append(rotary_dashpot(place, BENT * posture.size))
        if one.get("radially_damped"):
            found += symbols.marks("damped bearing", [place], BEARING | {"ms": DAMPED * ring})
    return found
