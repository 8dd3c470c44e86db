"""The rigid linkage: a sketch of links, joints and supports for all figures, and one of its own."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon
from matplotlib.transforms import Bbox
from numpy.typing import NDArray

from flexmech.plots import style
from flexmech.plots.labels import mechanism_name
from flexmech.plots.layout import AxesLike, grid, sheet
from flexmech.plots.reading import names_of, values_of
from flexmech.plots.series import Look
from flexmech.types import FloatArray

__all__ = [
    "JOINT",
    "RIGID",
    "LinkageSketch",
    "extent_of",
    "height_of",
    "joint_ends",
    "name_joints",
    "places_of",
    "plot_linkage",
    "round_length",
    "shaft_of",
]

RIGID: Look = {"color": "0.65", "lw": 0.9}
"""Look of undeformed links."""
OUTLINE = "0.35"
JOINT: Look = {"ls": "", "marker": "o", "ms": 3.6, "mfc": "white", "mec": OUTLINE, "mew": 0.7}
"""Look of a pin; the driven shaft, to which its link is clamped, is filled."""

TRACK: Look = {"color": "0.6", "lw": 0.8, "ls": (0.0, (4.0, 2.0)), "zorder": 0.7}
"""Look of the line on which a point slides."""
BLOCK: Look = {"fc": "white", "ec": OUTLINE, "lw": 0.7, "zorder": 2.9}
"""Look of what slides."""
WELD: Look = {"ls": "", "marker": "s", "ms": 3.2, "mfc": OUTLINE, "mec": OUTLINE, "zorder": 4}
"""Look of a weld between links."""
# Half the length of a line and of a block over the linkage's extent.
TRACK_LENGTH, BLOCK_SIZE = 0.12, 0.03
# Width of a rigid link over that of one that bends.
THICK = 1.8

# Places closer than this part of the linkage's extent are the same place.
SAME_PLACE = 1e-6
# Of a support over the linkage's extent: depth, half its width, depth of the hatching.
DEPTH, HALF_WIDTH, HATCHING = 0.05, 0.028, 0.03
# Depth of the shaft's support over the radius of a hub: it is seen below it. Half its width over
# its depth at least, and half the width of a ground line over that of its support.
BELOW_HUB, SLENDER, GROUND_WIDTH = 1.4, 0.4, 1.7
# Room around the sketch, and below it for the scale bar, over the linkage's extent.
ROOM, BAR_ROOM = 0.02, 0.06

LEAST_HEIGHT, MOST_HEIGHT = 1.6, 3.6
# Distance of a name from its joint in points.
AWAY = np.array([12.0, 9.0])
# Room for the names around the joints over the linkage's size.
NAME_ROOM = 0.06

Ends = list[tuple[int, int]]
"""Ends of links: numbers of link and station (0 or -1)."""


def extent_of(links: FloatArray) -> float:
    """Diagonal of the box around the ends of links; shape (..., link, station, 2)."""
    ends = links[..., [0, -1], :].reshape(*links.shape[:-3], -1, 2)
    return float(np.hypot(*np.ptp(ends, axis=-2).T).max())


def height_of(limits: Bbox, width: float, least: float, most: float) -> float:
    """Height of a panel of a width that shows what is within limits at one scale.

    Parameters
    ----------
    limits : Bbox
    width, least, most : float
        Width of the panel, and what its height may be, in inches.

    Returns
    -------
    float
    """
    return float(min(max(width * limits.height / limits.width, least), most))


def places_of(links: FloatArray, ends: Ends) -> FloatArray:
    """Where ends of links are: shape (link, station, 2) -> (end, 2)."""
    return np.reshape([links[end] for end in ends], (-1, 2))


def joint_ends(positions: FloatArray, held: NDArray[np.bool_]) -> tuple[Ends, Ends]:
    """Link ends at which there are joints, one end of each joint.

    Parameters
    ----------
    positions : ndarray, shape (configuration, link, station, 2)
        Of the rigid linkage in m.
    held : ndarray of bool, shape (link, 2)
        Whether the start and the end of each link are held by the ground.

    Returns
    -------
    list of (int, int), list of (int, int)
        Link and station (0 or -1) of the pins between links, and of the supports.
    """
    near = SAME_PLACE * extent_of(positions)
    ends = [(link, station) for link in range(positions.shape[1]) for station in (0, -1)]
    pins, supports = [], []
    for end in ends:
        place = positions[:, *end]
        together = [other for other in ends if np.abs(positions[:, *other] - place).max() <= near]
        if end == together[0] and held[end]:
            supports.append(end)
        elif end == together[0] and len(together) > 1:
            pins.append(end)
    return pins, supports


def shaft_of(positions: FloatArray) -> FloatArray:
    """Where the driven shaft is: the crank's start if it stays, or the middle of its hub.

    Parameters
    ----------
    positions : ndarray, shape (configuration, link, station, 2)
        Of the rigid linkage in m; the first link is the driven one.

    Returns
    -------
    ndarray, shape (2,)
    """
    starts = positions[:, 0, 0]
    stays = len(starts) > 1 and np.ptp(starts, axis=0).max() <= SAME_PLACE * extent_of(positions)
    return starts[0] if stays else np.zeros(2)


@dataclass(frozen=True)
class LinkageSketch:
    """A linkage in one configuration.

    Parameters
    ----------
    links : ndarray, shape (link, station, 2)
        In m. By convention the first link is the driven one; where it starts away from the
        shaft, it stands on a hub.
    pins, supports : ndarray, shape (n, 2)
        Joints between links, and joints with the ground, in m.
    shaft : ndarray, shape (2,)
        Axis of the driven shaft in m; the ground's origin if left out.
    sliders : ndarray, shape (n, 3)
        Points that slide, in m, and the angles of their lines in rad.
    welds : ndarray, shape (n, 2)
        Where links are welded to each other, in m.
    rigid : ndarray of bool, shape (link,)
        Which links do not bend; none if left out.
    """

    links: FloatArray
    pins: FloatArray
    supports: FloatArray
    shaft: FloatArray = field(default_factory=lambda: np.zeros(2))
    sliders: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    welds: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    rigid: NDArray[np.bool_] | None = None

    @classmethod
    def of(cls, dataset: xr.Dataset) -> LinkageSketch:
        """Sketch of a dataset of :func:`flexmech.linkages.linkage_positions`."""
        links = values_of(dataset["rigid_position"], "link", "station", "component")
        places = values_of(dataset["joint_position"], "joint", "component")
        kinds = dataset["joint_kind"].values
        lines = np.full(len(places), np.nan)
        if "joint_direction" in dataset:
            lines = values_of(dataset["joint_direction"], "joint")
        slides = kinds == "slider"
        known = "shaft_position" in dataset
        return cls(
            links,
            places[(kinds == "pin") | slides],
            places[(kinds == "clamp") | (kinds == "pivot")],
            values_of(dataset["shaft_position"], "component") if known else np.zeros(2),
            np.column_stack([places, lines])[slides],
            places[kinds == "weld"],
            dataset["rigid"].values.astype(bool) if "rigid" in dataset else None,
        )

    @property
    def size(self) -> float:
        """Diagonal of the box around the linkage, in m."""
        return extent_of(self.links)

    @property
    def hub_radius(self) -> float:
        """Distance of the driven link's start from the shaft's axis, in m."""
        radius = float(np.hypot(*(self.links[0, 0] - self.shaft)))
        return radius if radius > SAME_PLACE * self.size else 0.0

    @property
    def grounds(self) -> FloatArray:
        """Where the ground holds the linkage: a hub at its shaft, not where its link is clamped."""
        if not self.hub_radius:
            return self.supports
        apart = np.hypot(*(self.supports - self.shaft).T)
        beyond = apart > self.hub_radius + SAME_PLACE * self.size
        return np.vstack([self.shaft, self.supports[beyond]])

    def limits(self, points: FloatArray) -> Bbox:
        """Limits around points, the linkage, its hub and supports, and a scale bar; in m."""
        corners = [self.links.reshape(-1, 2), points.reshape(-1, 2)]
        corners.append(self.shaft + self.hub_radius * np.array([[-1.0, -1.0], [1.0, 1.0]]))
        corners += [np.array(self._track(slider)) for slider in self.sliders]
        for place in self.grounds:
            half, deep = self._support(place)
            wide, deep = GROUND_WIDTH * half, deep + HATCHING * self.size
            corners.append(place - [[wide, deep], [-wide, 0.0]])
        inside, room = np.vstack(corners), ROOM * self.size
        (left, low), (right, high) = np.nanmin(inside, axis=0), np.nanmax(inside, axis=0)
        lowest = low - room - BAR_ROOM * self.size
        return Bbox.from_extents(left - room, lowest, right + room, high + room)

    @staticmethod
    def frame(axes: Axes, limits: Bbox) -> None:
        """Show what is within limits, at the same scale along x and y and without axes."""
        axes.set(xlim=limits.intervalx, ylim=limits.intervaly, aspect="equal", anchor="N")
        axes.set_axis_off()

    def draw_ground(self, axes: Axes) -> None:
        """Draw the hub, and under each support a triangle on a hatched ground line."""
        hub = Circle(tuple(self.shaft), self.hub_radius, color=style.LIGHT_GREY, lw=0, zorder=0.5)
        axes.add_patch(hub)
        for slider in self.sliders:
            axes.plot(*np.transpose(self._track(slider)), **TRACK)
        for place in self.grounds:
            half, deep = self._support(place)
            wide, hatch = GROUND_WIDTH * half, HATCHING * self.size
            x, low = place - [0.0, deep]
            foot = [(x - half, low), (x + half, low)]
            axes.add_patch(Polygon([place, *foot], fc="white", ec=OUTLINE, lw=0.7, zorder=0.8))
            axes.plot([x - wide, x + wide], [low, low], color=OUTLINE, lw=0.9, zorder=0.8)
            starts = np.linspace(x - 0.7 * wide, x + wide, 5)
            strokes = [starts, starts - 0.5 * hatch], [[low] * 5, [low - hatch] * 5]
            axes.plot(*strokes, color=OUTLINE, lw=0.5, zorder=0.8)

    def draw(self, axes: Axes, **links: Any) -> None:
        """Draw the ground, the links with properties of their own, and the joints."""
        self.draw_ground(axes)
        stiff = np.zeros(len(self.links), dtype=bool) if self.rigid is None else self.rigid
        for link, thick in zip(self.links, stiff, strict=True):
            look = RIGID | links
            wide: Look = {"lw": THICK * look["lw"]} if thick else {}
            axes.plot(*link.T, **(look | wide), zorder=1)
        for slider in self.sliders:
            axes.add_patch(Polygon(self._block(slider), **BLOCK))
        axes.plot(*self.welds.T, **WELD)
        places = np.vstack([self.grounds, self.pins])
        is_shaft = np.hypot(*(places - self.shaft).T) <= SAME_PLACE * self.size
        axes.plot(*places[~is_shaft].T, **JOINT, zorder=4)
        axes.plot(*places[is_shaft].T, **(JOINT | {"mfc": OUTLINE}), zorder=4)

    def draw_scale_bar(self, axes: Axes) -> None:
        """Draw a bar of a round length in mm below the linkage, within the axes' limits."""
        length = round_length(0.3 * self.size * 1e3)
        middle, height = sum(axes.get_xlim()) / 2, axes.get_ylim()[0] + 0.03 * self.size
        ends = [middle - length * 0.5e-3, middle + length * 0.5e-3]
        axes.plot(ends, [height, height], color="black", lw=1.6)
        look: Look = {"xytext": (0, 2), "textcoords": "offset points", "ha": "center"}
        axes.annotate(f"{length:g} mm", (middle, height), fontsize=7, **look)

    def _track(self, slider: FloatArray) -> list[FloatArray]:
        """Ends of a piece of a slider's line."""
        along = TRACK_LENGTH * self.size * np.array([np.cos(slider[2]), np.sin(slider[2])])
        return [slider[:2] - along, slider[:2] + along]

    def _block(self, slider: FloatArray) -> list[FloatArray]:
        """Corners of the block that slides on a line."""
        along = np.array([np.cos(slider[2]), np.sin(slider[2])])
        across = np.array([-along[1], along[0]])
        half = BLOCK_SIZE * self.size
        signs = ((1, 1), (-1, 1), (-1, -1), (1, -1))
        return [slider[:2] + half * (x * along + 0.6 * y * across) for x, y in signs]

    def _support(self, place: FloatArray) -> tuple[float, float]:
        """Half the width of a support and its depth in m: that of the shaft is seen below a hub."""
        below = BELOW_HUB * self.hub_radius if np.array_equal(place, self.shaft) else 0.0
        deep = max(DEPTH * self.size, below)
        return max(HALF_WIDTH * self.size, SLENDER * deep), deep


def plot_linkage(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the rigid linkage with the names of its joints, and its supports on the ground.

    Parameters
    ----------
    dataset : Dataset
        With ``rigid_position`` (link, station, component) and ``joint_position`` (joint,
        component) in m, the coordinate ``joint_kind`` (clamp, pivot, pin, weld or slider), and
        the name of the mechanism; ``joint_direction`` (joint) of sliders in rad, ``rigid``
        (link) and ``shaft_position`` (component) where they are known.
    ax : Axes, optional
        The user's. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    joints = values_of(dataset["joint_position"], "joint", "component")
    is_pin = ~np.isin(dataset["joint_kind"].values, ["clamp", "pivot"])
    sketch = LinkageSketch.of(dataset)
    room = NAME_ROOM * sketch.size
    limits = sketch.limits(np.vstack([joints - room, joints + room]))
    height = height_of(limits, style.figure_width(), LEAST_HEIGHT, MOST_HEIGHT)
    with sheet(grid(1, 1, height), ax=ax) as drawn:
        (axes,) = drawn.panels
        sketch.frame(axes, limits)
        sketch.draw(axes, color="0.5", lw=2.0)
        sketch.draw_scale_bar(axes)
        axes.set_title(mechanism_name(dataset), loc="center")
        name_joints(axes, sketch, names_of(dataset, "joint"), joints, is_pin)
    return drawn.figure


def name_joints(
    axes: Axes,
    sketch: LinkageSketch,
    names: list[str],
    places: FloatArray,
    is_pin: NDArray[np.bool_],
) -> None:
    """Write names beside joints, away from links and supports.

    Parameters
    ----------
    axes : Axes
    sketch : LinkageSketch
    names : list of str
    places : ndarray, shape (joint, 2)
        In m.
    is_pin : ndarray of bool, shape (joint,)
        Whether a joint is one between links; the others are held by the ground.
    """
    for number, (name, place, pinned) in enumerate(zip(names, places, is_pin, strict=True)):
        here = np.hypot(*(places - place).T) <= SAME_PLACE * sketch.size
        # Of several joints in one place the one that has the place's own name.
        if min(np.flatnonzero(here), key=lambda other: len(names[other])) != number:
            continue
        offset = AWAY * _away(sketch, place, held=not pinned)
        look: Look = {"textcoords": "offset points", "ha": "center", "va": "center", "zorder": 6}
        look["bbox"] = {"fc": "white", "lw": 0, "alpha": 0.75, "pad": 0.5}
        axes.annotate(name, place, tuple(offset), **look)


def round_length(most: float) -> float:
    """Longest of 1, 2 and 5 times a power of ten that is not above a length."""
    decade = 10.0 ** np.floor(np.log10(most))
    return float(decade * max(step for step in (1, 2, 5) if step * decade <= most * (1 + 1e-9)))


def _away(sketch: LinkageSketch, place: FloatArray, *, held: bool) -> FloatArray:
    """Direction away from the links at a joint, and from a support below it."""
    directions = [np.array([0.0, -1.0])] if held else []
    for link in sketch.links:
        for end, other in (link[[0, -1]], link[[-1, 0]]):
            if np.hypot(*(end - place)) <= SAME_PLACE * sketch.size:
                directions.append((other - end) / np.hypot(*(other - end)))
    pull = np.sum(directions, axis=0)
    if np.hypot(*pull) <= SAME_PLACE:
        # Between two in one line there is room on both sides.
        pull = directions[0][::-1] * [1.0, -1.0]
    return np.asarray(-pull / np.hypot(*pull))
