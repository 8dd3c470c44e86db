"""Symbols of a linkage in one posture: joints, masses, bodies, springs, dampers and loads.

A symbol is a line or a polygon of places in m.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon
from matplotlib.transforms import Transform
from numpy.typing import ArrayLike, NDArray

from flexmech.arrays import FloatArray
from flexmech.plots.drawn_linkage import symbols
from flexmech.plots.style import Look

OUTLINE = "0.35"
GRAVITY_COLOR = "0.5"
THIN: Look = {"color": OUTLINE, "lw": 0.5}
# Angle of the strokes of the driven shaft in rad: those of the ground below it lean alike.
HATCH_ANGLE = np.radians(-135.0)
# Turns of a spring between points and of one in a joint, as many as can be seen at its size, and
# share of a spring that is straight at either end.
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
    """Block that slides on a line: a rectangle of half a length and 0.6 times that in height.

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


def body(
    place: FloatArray, centre: FloatArray, outline: FloatArray, look: Look, size: float
) -> list[Symbol]:
    """An attached body: a crossed circle at its centre of mass, joined to its section.

    Parameters
    ----------
    place, centre : ndarray, shape (2,)
        Where the body is fixed, and its centre of mass, in m.
    outline : ndarray, shape (n, 2)
        Its corners in m; empty of a body without an outline.
    look : dict
        With its ``color``.
    size : float
        Size of the mark over the usual one.

    Returns
    -------
    list of Symbol
    """
    mark: Look = {"ls": "", "ms": 7.0 * size, "mew": 0.9, "zorder": 3.5}
    circle, cross = mark | {"marker": "o", "mfc": "white"}, mark | {"marker": "+"}
    plate: Look = {"fc": look["color"], "ec": look["color"], "alpha": 0.25, "zorder": 0.7}
    return [
        *([Symbol("plate", outline, plate, filled=True)] if len(outline) else []),
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


# Places closer than this part of the linkage's extent are the same place: far above round-off, far
# below what a picture shows.
SAME_PLACE = 1e-6

Part = dict[str, Any]
"""One part as the attribute ``drawing`` of a dataset tells it."""


def extent_of(links: FloatArray) -> float:
    """Diagonal of the box around the ends of links; shape (..., link, station, 2)."""
    ends = links[..., [0, -1], :].reshape(*links.shape[:-3], -1, 2)
    return float(np.hypot(*np.ptp(ends, axis=-2).T).max())


@dataclass(frozen=True)
class LinkageParts:
    """Parts of a linkage besides its links.

    Parameters
    ----------
    rigid : ndarray of bool, shape (link,)
        Which links do not bend.
    joints, masses, bodies, springs, joint_springs, loads : list of dict
        As ``flexmech.mechanism.drawn_parts`` gives them.
    hub : float
        Distance of the driven link's end from the axis of the shaft, in m.
    shaft : ndarray of shape (2,), optional
        Axis of the driven shaft in m; by its clamp if left out.
    gravity : tuple of float
        Along x and y in m/s^2.
    """

    rigid: NDArray[np.bool_]
    joints: list[Part] = field(default_factory=list)
    masses: list[Part] = field(default_factory=list)
    bodies: list[Part] = field(default_factory=list)
    springs: list[Part] = field(default_factory=list)
    joint_springs: list[Part] = field(default_factory=list)
    loads: list[Part] = field(default_factory=list)
    hub: float = 0.0
    shaft: FloatArray | None = None
    gravity: tuple[float, float] = (0.0, 0.0)

    def of_kind(self, *kinds: str) -> list[Part]:
        """Joints of some kinds."""
        return [joint for joint in self.joints if joint["kind"] in kinds]

    def springs_with(self, what: str) -> list[Part]:
        """Springs between points and in joints of which a word holds.

        Parameters
        ----------
        what : str
            ``"stiff"`` or ``"damped"`` of springs between points, ``"torsional"``, ``"radial"``,
            ``"torsion_damped"`` or ``"radially_damped"`` of those in joints. Files of earlier
            versions tell nothing of dampers, and every spring between points in them is stiff.

        Returns
        -------
        list of dict
        """
        known = [{"stiff": True} | spring for spring in self.springs]
        return [one for one in (*known, *self.joint_springs) if one.get(what)]


def parts_of(dataset: xr.Dataset, positions: FloatArray, held: NDArray[np.bool_]) -> LinkageParts:
    """Parts by the attribute ``drawing`` of a dataset, else by where ends of links are together.

    Parameters
    ----------
    dataset : Dataset
        Files of earlier versions have no such attribute.
    positions : ndarray, shape (configuration, link, station, 2)
        Positions of the rigid linkage in m.
    held : ndarray of bool, shape (link, 2)
        Whether the start and the end of each link stay in place.

    Returns
    -------
    LinkageParts
    """
    if "drawing" not in dataset.attrs:
        return _by_places(positions, held)
    return _linkage_parts(json.loads(dataset.attrs["drawing"]))


def drawn_posture(dataset: xr.Dataset) -> tuple[FloatArray, LinkageParts, float] | None:
    """Links, parts and crank angle of the posture that the attribute ``drawing`` holds.

    Parameters
    ----------
    dataset : Dataset

    Returns
    -------
    ndarray, shape (link, 2, 2), LinkageParts, float
        In m and rad; None where the attribute holds no posture.
    """
    drawing = json.loads(dataset.attrs.get("drawing", "{}"))
    if "posture" not in drawing:
        return None
    posture = drawing["posture"]
    return np.array(posture["ends"]), _linkage_parts(drawing), float(posture["crank_angle"])


def _linkage_parts(drawing: Part) -> LinkageParts:
    rigid = np.array([link["rigid"] for link in drawing["links"]], dtype=bool)
    others = {name: part for name, part in drawing.items() if name not in ("links", "posture")}
    if "gravity" in others:
        others["gravity"] = tuple(others["gravity"])
    return LinkageParts(rigid, **others)


def _by_places(positions: FloatArray, held: NDArray[np.bool_]) -> LinkageParts:
    """Ends that stay are held by the ground, ends that are together in each posture are pinned."""
    near = SAME_PLACE * extent_of(positions)
    ends = [(link, station) for link in range(positions.shape[1]) for station in (0, -1)]
    joints: list[Part] = []
    for end in ends:
        place = positions[:, *end]
        together = [other for other in ends if np.abs(positions[:, *other] - place).max() <= near]
        at = [end[0], float(end[1] == -1)]
        if end == together[0] and held[end]:
            # The first link is the driven one.
            joints.append({"name": "", "kind": "pivot" if any(end) else "clamp", "at": at})
        elif end == together[0] and len(together) > 1:
            joints.append({"name": "", "kind": "pin", "at": at})
    starts = positions[:, 0, 0]
    stays = len(starts) > 1 and np.ptp(starts, axis=0).max() <= near
    shaft = starts[0] if stays else np.zeros(2)
    return LinkageParts(np.zeros(positions.shape[1], dtype=bool), joints, shaft=shaft)


@dataclass(frozen=True)
class Posture:
    """Links in one posture, straight or bent, and what belongs to them.

    Parameters
    ----------
    links : ndarray, shape (link, station, 2)
        Evenly spaced stations along each link, in m.
    parts : LinkageParts
    """

    links: FloatArray
    parts: LinkageParts

    @cached_property
    def size(self) -> float:
        """Diagonal of the box around the ends of the links, in m."""
        return extent_of(self.links)

    def place(self, at: list[float]) -> FloatArray:
        """Where a point is: number of a link, and how far along it from 0 to 1."""
        link = self.links[int(at[0])]
        along = np.linspace(0.0, 1.0, len(link))
        return np.array([np.interp(at[1], along, component) for component in link.T])

    def turned(self, link: int) -> FloatArray:
        """Axes of the frame of a link as columns, x from its start to its end."""
        along = self.links[link, -1] - self.links[link, 0]
        x, y = along / np.hypot(*along)
        return np.array([[x, -y], [y, x]])

    def line(self, slider: Part) -> float:
        """Angle of the line of a slider to the ground's x axis in rad."""
        guide = slider["guide"]
        frame = np.eye(2) if guide is None else self.turned(int(guide))
        return float(slider["direction"] + np.arctan2(frame[1, 0], frame[0, 0]))

    def spring_end(self, end: Part) -> FloatArray:
        """Where an end of a spring is."""
        return np.array(end["ground"], dtype=float) if "ground" in end else self.place(end["at"])

    def carried(self, body: Part, points: ArrayLike) -> FloatArray:
        """Where points (..., 2) are that an attached body has along and across its link."""
        frame = self.turned(int(body["at"][0]))
        return np.asarray(self.place(body["at"]) + np.asarray(points) @ frame.T)

    def centre(self, body: Part) -> FloatArray:
        """Where the centre of mass of an attached body is."""
        return self.carried(body, body["offset"])

    def outline(self, body: Part) -> FloatArray:
        """Where the corners (n, 2) of an attached body are; none of one without an outline."""
        return self.carried(body, np.reshape(body.get("outline", []), (-1, 2)))

    def force(self, load: Part) -> FloatArray:
        """Force of a load in ground axes."""
        frame = self.turned(int(load["at"][0])) if load["axes"] == "link" else np.eye(2)
        return np.asarray(frame @ np.array(load["force"]))


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
# Radius of the ring around a bearing with a damper over that without: both are seen.
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
    """Supports of springs and dampers on the ground."""
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
        Size of the rings of bearings over the usual one.

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
