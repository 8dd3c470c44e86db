"""Symbols of dampers, between points and in joints: a piston in an open cup."""

from __future__ import annotations

import numpy as np

from flexmech.plots.linkage_symbols import Symbol, below
from flexmech.plots.series import Look
from flexmech.types import FloatArray

LOOK: Look = {"color": "0.25", "lw": 0.9}
# Half the length of a cup over its half width, and the most of the whole length that it takes.
SLENDER, MOST = 1.5, 0.25
# Where a damper beside a spring joins its line, and how far it is from that in half widths.
JOINED, BESIDE = 0.12, 2.4
# Angles in rad between which a damper lies around a joint, and half its depth over its radius.
FIRST, LAST, DEEP = np.radians(25.0), np.radians(155.0), 0.22


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
