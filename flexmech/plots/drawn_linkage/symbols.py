"""Symbols of what belongs to a linkage: each is a line or a polygon of places in m."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon
from matplotlib.transforms import Transform

from flexmech.arrays import FloatArray
from flexmech.plots.style import Look

OUTLINE = "0.35"
GRAVITY_COLOR = "0.5"
THIN: Look = {"color": OUTLINE, "lw": 0.5}
# Of the strokes of the driven shaft in rad: those of the ground below it lean alike.
HATCH_ANGLE = np.radians(-135.0)
# Turns of a spring between points and of one in a joint, as many as are told at its size, and share
# of a spring that is straight at either end.
COILS, SPIRAL_TURNS, STRAIGHT = 6, 2.0, 0.15


@dataclass(frozen=True)
class Symbol:
    """A line, a set of marks or a polygon.

    Parameters
    ----------
    what : str
        What it shows, such as ``"pin"`` or ``"spring"``.
    places : ndarray, shape (n, 2)
        In m; a line breaks where they are not numbers.
    look : dict
        Properties of a ``Line2D`` or, of a polygon, of a ``Polygon``.
    filled : bool
        Whether it is a polygon.
    """

    what: str
    places: FloatArray
    look: Look
    filled: bool = False

    @property
    def artist(self) -> Line2D | Polygon:
        """A new artist that shows it."""
        if self.filled:
            return Polygon(self.places, **self.look)
        return Line2D(*self.places.T, **self.look)


def add_symbols(
    axes: Axes, symbols: Iterable[Symbol], transform: Transform | None = None
) -> list[Artist]:
    """Draw symbols within the limits that the axes have.

    Parameters
    ----------
    axes : Axes
    symbols : iterable of Symbol
    transform : Transform, optional
        From m to the units of the axes; these are in m if it is left out.

    Returns
    -------
    list of Artist
        One a symbol.
    """
    artists: list[Artist] = []
    for symbol in symbols:
        artist = symbol.artist
        artist.set_transform(transform + axes.transData if transform else axes.transData)
        if isinstance(artist, Polygon):
            axes.add_patch(artist)
        else:
            axes.add_line(artist)
        artists.append(artist)
    return artists


def move_symbols(artists: Iterable[Artist], symbols: Iterable[Symbol]) -> None:
    """Move what :func:`add_symbols` drew to where the same symbols are in another posture."""
    for artist, symbol in zip(artists, symbols, strict=True):
        if isinstance(artist, Polygon):
            artist.set_xy(symbol.places)
        elif isinstance(artist, Line2D):
            artist.set_data(*symbol.places.T)


def marks(what: str, places: list[FloatArray], look: Look) -> list[Symbol]:
    """A mark at each place; none where there is no place.

    Parameters
    ----------
    what : str
    places : list of ndarray, shape (2,)
        In m.
    look : dict

    Returns
    -------
    list of Symbol
    """
    return [Symbol(what, np.array(places), {"ls": ""} | look)] if len(places) else []


def clamp(place: FloatArray, radius: float) -> list[Symbol]:
    """A hatched disc: the driven shaft, to which a link is clamped."""
    turn = np.linspace(0.0, 2 * np.pi, 49)
    rim = place + radius * np.column_stack([np.cos(turn), np.sin(turn)])
    across = np.array([np.cos(HATCH_ANGLE), np.sin(HATCH_ANGLE)])
    strokes = []
    for height in radius * np.linspace(-0.8, 0.8, 5):
        half = np.sqrt(radius**2 - height**2)
        middle = place + height * np.array([-across[1], across[0]])
        strokes += [middle - half * across, middle + half * across, np.full(2, np.nan)]
    return [
        Symbol("clamp", rim, {"fc": "0.92", "ec": OUTLINE, "lw": 0.6, "zorder": 0.85}, filled=True),
        Symbol("clamp", np.array(strokes), {"color": "0.55", "lw": 0.5, "zorder": 0.86}),
    ]


def support(place: FloatArray, half: float, deep: float, wide: float, hatch: float) -> list[Symbol]:
    """A triangle on a hatched ground line, its tip at a place; sizes in m.

    Parameters
    ----------
    place : ndarray, shape (2,)
    half, deep : float
        Half the width of the triangle and its depth in m.
    wide, hatch : float
        Half the length of the ground line and the depth of its hatching in m.

    Returns
    -------
    list of Symbol
    """
    foot = place - [0.0, deep]
    along = np.array([1.0, 0.0])
    corners = np.array([place, foot - half * along, foot + half * along])
    look: Look = {"fc": "white", "ec": OUTLINE, "lw": 0.7, "zorder": 0.8}
    ends = np.array([foot - wide * along, foot + wide * along])
    return [Symbol("support", corners, look, filled=True), *_ground("support", ends, hatch)]


def wall(place: FloatArray, away: FloatArray, half: float, hatch: float) -> list[Symbol]:
    """A hatched ground line across a direction, hatched on the side to which that points.

    Parameters
    ----------
    place, away : ndarray, shape (2,)
        Middle of the line in m, and the unit vector that points into the ground.
    half, hatch : float
        Half the length of the line and the depth of its hatching in m.

    Returns
    -------
    list of Symbol
    """
    across = np.array([away[1], -away[0]])
    ends = np.array([place - half * across, place + half * across])
    return _ground("wall", ends, hatch)


def rail(place: FloatArray, line: float, reach: tuple[float, float], aside: float) -> list[Symbol]:
    """A hatched line of the ground along which a block slides, below the block.

    Parameters
    ----------
    place : ndarray, shape (2,)
        A point of the line in m.
    line : float
        Angle of the line in rad.
    reach : tuple of float
        From and to where it is drawn along the line from the place, in m.
    aside : float
        Distance of what is drawn from the line in m.

    Returns
    -------
    list of Symbol
    """
    along = np.array([np.cos(line), np.sin(line)])
    ends = place + aside * below(along) + np.outer(reach, along)
    if below(along) @ [along[1], -along[0]] < 0:
        ends = ends[::-1]
    return _ground("rail", ends, 0.8 * aside)


def below(along: FloatArray) -> FloatArray:
    """Normal to a direction that points down, or to the right of an upright line."""
    normal = np.array([along[1], -along[0]])
    if normal[1] > 1e-9 or (abs(normal[1]) <= 1e-9 and normal[0] < 0):
        normal = -normal
    return normal


def _ground(what: str, ends: FloatArray, hatch: float) -> list[Symbol]:
    """A line with strokes at its right-hand side, seen from its first to its second end."""
    along = ends[1] - ends[0]
    length = np.hypot(*along)
    along = along / length
    right = np.array([along[1], -along[0]])
    count = max(5, round(float(length / (0.9 * hatch))))
    starts = ends[0] + np.outer(np.linspace(0.5 * hatch, length, count), along)
    feet = starts + hatch * (right - 0.5 * along)
    strokes = np.stack([starts, feet, np.full_like(starts, np.nan)], axis=1).reshape(-1, 2)
    return [
        Symbol(what, ends, {"color": OUTLINE, "lw": 0.9, "zorder": 0.8}),
        Symbol(what, strokes, THIN | {"zorder": 0.8}),
    ]


def block(place: FloatArray, line: float, half: float) -> Symbol:
    """What slides on a line: a rectangle on it, of half a length and 0.6 times that in height.

    Parameters
    ----------
    place : ndarray, shape (2,)
        In m.
    line : float
        Angle of the line in rad.
    half : float
        In m.

    Returns
    -------
    Symbol
    """
    along = np.array([np.cos(line), np.sin(line)])
    across = np.array([-along[1], along[0]])
    signs = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    corners = np.array([place + half * (x * along + 0.6 * y * across) for x, y in signs])
    look: Look = {"fc": "white", "ec": OUTLINE, "lw": 0.7, "zorder": 0.9}
    return Symbol("block", corners, look, filled=True)


def zigzag(first: FloatArray, second: FloatArray, half: float) -> Symbol:
    """A spring between two places, as wide as twice a half width in m.

    Parameters
    ----------
    first, second : ndarray, shape (2,)
        In m.
    half : float
        In m.

    Returns
    -------
    Symbol
    """
    along = second - first
    length = np.hypot(*along)
    normal = np.array([-along[1], along[0]]) / length if length else np.zeros(2)
    turns = np.linspace(STRAIGHT, 1 - STRAIGHT, 2 * COILS + 1)
    aside = half * np.where(np.arange(turns.size) % 2, 1.0, -1.0)
    aside[[0, -1]] = 0.0
    parts, aside = np.r_[0.0, turns, 1.0], np.r_[0.0, aside, 0.0]
    places = first + np.outer(parts, along) + np.outer(aside, normal)
    return Symbol("spring", places, {"color": "0.25", "lw": 0.9, "zorder": 1.5})


def spiral(place: FloatArray, radius: float) -> Symbol:
    """A torsional spring around a joint."""
    turn = np.linspace(0.0, 2 * np.pi * SPIRAL_TURNS, 60)
    out = radius * (0.4 + 0.6 * turn / turn[-1])
    places = place + out[:, None] * np.column_stack([np.cos(turn), np.sin(turn)])
    return Symbol("torsional spring", places, {"color": "0.25", "lw": 0.7, "zorder": 3.8})


def body(place: FloatArray, centre: FloatArray, look: Look, size: float) -> list[Symbol]:
    """An attached body: a crossed circle at its centre of mass, joined to its section.

    Parameters
    ----------
    place, centre : ndarray, shape (2,)
        Where the body is fixed, and its centre of mass, in m.
    look : dict
        With its ``color``.
    size : float
        Of the mark over the usual one.

    Returns
    -------
    list of Symbol
    """
    mark: Look = {"ls": "", "ms": 7.0 * size, "mew": 0.9, "zorder": 3.5}
    circle, cross = mark | {"marker": "o", "mfc": "white"}, mark | {"marker": "+"}
    return [
        Symbol("body", np.array([place, centre]), {"lw": 1.6, "zorder": 1.4} | look),
        Symbol("body", centre[None], circle | {"mec": look["color"]}),
        Symbol("body", centre[None], cross | {"mec": look["color"]}),
    ]


def arrow(tip: FloatArray, along: FloatArray, length: float, *, varies: bool) -> list[Symbol]:
    """A force: an arrow in a direction up to its tip, dashed and hollow if it varies.

    Parameters
    ----------
    tip, along : ndarray, shape (2,)
        In m, and a unit vector.
    length : float
        In m.
    varies : bool

    Returns
    -------
    list of Symbol
    """
    head = min(0.38 * length, 0.05 * length / 0.12)
    across = np.array([-along[1], along[0]])
    back = tip - head * along
    corners = np.array([tip, back + 0.35 * head * across, back - 0.35 * head * across])
    return _arrow(np.array([tip - length * along, back]), corners, varies=varies)


def gravity_arrow(middle: FloatArray, along: FloatArray, length: float) -> list[Symbol]:
    """The direction of gravity: a grey arrow in the open.

    Parameters
    ----------
    middle, along : ndarray, shape (2,)
        In m, and a unit vector.
    length : float
        In m.

    Returns
    -------
    list of Symbol
    """
    tip, tail = middle + length / 2 * along, middle - length / 2 * along
    across, back = np.array([-along[1], along[0]]), tip - 0.35 * length * along
    corners = np.array([tip, back + 0.12 * length * across, back - 0.12 * length * across])
    filled: Look = {"fc": GRAVITY_COLOR, "ec": GRAVITY_COLOR, "lw": 0.6, "zorder": 0.8}
    return [
        Symbol("gravity", np.array([tail, back]), {"color": GRAVITY_COLOR, "lw": 1.2}),
        Symbol("gravity", corners, filled, filled=True),
    ]


def torque_arrow(place: FloatArray, radius: float, sign: float, *, varies: bool) -> list[Symbol]:
    """A torque: three quarters of a circle around a place, positive to the left.

    Parameters
    ----------
    place : ndarray, shape (2,)
        In m.
    radius : float
        In m.
    sign : float
    varies : bool

    Returns
    -------
    list of Symbol
    """
    turn = sign * np.radians(np.linspace(-60.0, 180.0, 40))
    out = np.column_stack([np.cos(turn), np.sin(turn)])
    along = sign * np.array([-out[-1, 1], out[-1, 0]])
    back, head = place + radius * out[-1], 0.7 * radius
    corners = np.array([back + head * along, back + 0.3 * radius * out[-1], back])
    corners[2] = back - 0.3 * radius * out[-1]
    return _arrow(place + radius * out, corners, varies=varies)


def _arrow(shaft: FloatArray, head: FloatArray, *, varies: bool) -> list[Symbol]:
    dashes: Look = {"ls": (0.0, (3.0, 1.5))} if varies else {}
    filled: Look = {"fc": "white" if varies else "black", "ec": "black", "lw": 0.8, "zorder": 4.6}
    name = "varying load" if varies else "load"
    return [
        Symbol(name, shaft, {"color": "black", "lw": 1.2, "zorder": 4.5} | dashes),
        Symbol(name, head, filled, filled=True),
    ]
