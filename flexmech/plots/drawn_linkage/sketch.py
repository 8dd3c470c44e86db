"""A linkage in one posture with all that belongs to it, for every figure that shows one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.transforms import Bbox

from flexmech.arrays import FloatArray
from flexmech.plots.drawn_linkage import symbols
from flexmech.plots.drawn_linkage.symbols import (
    OUTLINE,
    SAME_PLACE,
    Part,
    Posture,
    Symbol,
    add_symbols,
    joint_spring_symbols,
    parts_of,
    spring_symbols,
    wall_symbols,
)
from flexmech.plots.layout import round_length
from flexmech.plots.reading import values_of
from flexmech.plots.style import Look

RIGID: Look = {"color": "0.65", "lw": 0.9}
"""Look of undeformed links."""
JOINT: Look = {"ls": "", "marker": "o", "ms": 3.6, "mfc": "white", "mec": OUTLINE, "mew": 0.7}
"""Look of a pin; the driven shaft, to which its link is clamped, is filled."""
WELD: Look = {"marker": "s", "ms": 4.8, "mfc": OUTLINE, "mec": OUTLINE, "mew": 0.0, "zorder": 3.7}
GUIDE: Look = {"color": "0.5", "lw": 0.8, "ls": (0.0, (4.0, 2.0)), "zorder": 0.88}
MASS: Look = {"marker": "o", "mew": 0.0, "alpha": 0.75, "zorder": 3.0, "clip_on": False}
"""Look of a point mass."""
MASS_COLOR = "0.45"
# Size of marks of masses and bodies over those in a picture of one linkage, where several are
# beside each other.
SMALL = 0.6
# Area of the greatest point mass's mark in square points: twelve points wide, more hides links.
LARGEST_MARK = 144.0
# Least size of a point mass's mark: a ring of it is seen around the marks of pins and
# welds.
LEAST_MARK = 64.0
# Width of a rigid link over that of one that bends: distinct from it where both are thin.
THICK = 1.9

# Over the linkage's extent, as small as it can be seen on one column of a page: depth of a support,
# half its width, depth of the hatching; radius of the driven shaft; half the length of a line and
# of a block; radius of a torque; length of the arrow of the largest force, and distance of arrows
# from what they would cover; length of the arrow of gravity, and its distance from all else, for
# names of joints.
DEPTH, HALF_WIDTH, HATCHING, SHAFT = 0.05, 0.028, 0.03, 0.026
TRACK_LENGTH, BLOCK_SIZE, TORQUE = 0.12, 0.03, 0.06
ARROW, ASIDE, GRAVITY, NAMES = 0.17, 0.045, 0.14, 0.1
# A shorter arrow than this part of the largest one has no shaft beside its head.
LEAST_ARROW = 0.6
# Angle in rad that an arrow keeps from what is there: its head takes as much.
CLEAR = np.radians(20.0)
# Depth of the shaft's support over the radius of a hub: it is seen below it. Half its width over
# its depth at least, and half the width of a ground line over that of its support.
BELOW_HUB, SLENDER, GROUND_WIDTH = 1.4, 0.4, 1.7
# Room around the sketch, and below it for the scale bar, over the linkage's extent.
ROOM, BAR_ROOM = 0.02, 0.06


@dataclass(frozen=True)
class LinkageSketch(Posture):
    """A linkage in one posture, and how it is drawn.

    Parameters
    ----------
    links : ndarray, shape (link, station, 2)
        In m.
    parts : LinkageParts
        What belongs to it besides its links.
    mass_color : str
        Colour of point masses and attached bodies.
    mark_size : float
        Mark size of their marks over what it is in a picture of one linkage.
    joint_size : float
        Size of the marks of pins and welds over the usual one.
    travel : ndarray, shape (posture, link, station, 2), optional
        Postures over which the lines of sliders reach; this one alone if left out.
    around : ndarray, shape (n, 2), optional
        What else is drawn, in m: the arrow of gravity is to the left of it.
    """

    mass_color: str = MASS_COLOR
    mark_size: float = 1.0
    joint_size: float = 1.0
    travel: FloatArray | None = None
    around: FloatArray | None = None

    @classmethod
    def of(cls, dataset: xr.Dataset, mass_color: str = MASS_COLOR) -> LinkageSketch:
        """Sketch of a dataset with ``rigid_position`` (link, station, component) of one posture.

        Parameters
        ----------
        dataset : Dataset
        mass_color : str

        Returns
        -------
        LinkageSketch
        """
        links = values_of(dataset["rigid_position"], "link", "station", "component")
        held = np.zeros((len(links), 2), dtype=bool)
        return cls(links, parts_of(dataset, links[None], held), mass_color)

    @cached_property
    def shaft(self) -> FloatArray:
        """Axis of the driven shaft in m; the ground's origin where nothing is driven."""
        if self.parts.shaft is not None:
            return self.parts.shaft
        for clamp in self.parts.of_kind("clamp"):
            frame = self.turned(int(clamp["at"][0]))
            return np.asarray(self.place(clamp["at"]) - self.parts.hub * frame[:, 0])
        return np.zeros(2)

    @property
    def hub_radius(self) -> float:
        """Distance of the driven link's start from the shaft's axis, in m."""
        if self.parts.shaft is None:
            return self.parts.hub
        radius = float(np.hypot(*(self.links[0, 0] - self.shaft)))
        return radius if radius > SAME_PLACE * self.size else 0.0

    @property
    def shaft_radius(self) -> float:
        """Radius of the disc that shows the driven shaft, in m."""
        return max(self.hub_radius, SHAFT * self.size)

    def places(self, *kinds: str) -> FloatArray:
        """Where the joints of some kinds are; shape (n, 2)."""
        found = [self.place(joint["at"]) for joint in self.parts.of_kind(*kinds)]
        return np.reshape(found, (-1, 2))

    @cached_property
    def grounds(self) -> FloatArray:
        """Where the ground holds the linkage: a hub at its shaft, not where its link is clamped."""
        supports = self.places("clamp", "pivot")
        if not self.hub_radius:
            return supports
        apart = np.hypot(*(supports - self.shaft).T)
        beyond = apart > self.hub_radius + SAME_PLACE * self.size
        return np.vstack([self.shaft, supports[beyond]])

    def limits(self, points: FloatArray, bar_room: float = BAR_ROOM) -> Bbox:
        """Limits around points, the linkage, all that belongs to it, and a scale bar; in m.

        Parameters
        ----------
        points : ndarray, shape (..., 2)
        bar_room : float
            Room of the scale bar with its words over the linkage's size.

        Returns
        -------
        Bbox
        """
        inside = np.vstack([points.reshape(-1, 2), *self._drawn(*self.gravity())])
        room = ROOM * self.size
        (left, low), (right, high) = np.nanmin(inside, axis=0), np.nanmax(inside, axis=0)
        lowest = low - room - bar_room * self.size
        return Bbox.from_extents(left - room, lowest, right + room, high + room)

    @staticmethod
    def frame(axes: Axes, limits: Bbox) -> None:
        """Show what is within limits, at the same scale along x and y and without axes."""
        axes.set(xlim=limits.intervalx, ylim=limits.intervaly, aspect="equal", anchor="N")
        axes.set_axis_off()

    def ground(self) -> list[Symbol]:
        """Symbols of what stays in place: shaft, supports, lines of sliders, walls of springs."""
        found: list[Symbol] = []
        if self.parts.of_kind("clamp") or self.hub_radius:
            found += symbols.clamp(self.shaft, self.shaft_radius)
        for place in self.grounds:
            half, deep = self._support(place)
            wide = GROUND_WIDTH * half
            found += symbols.support(place, half, deep, wide, HATCHING * self.size)
        for slider in self.parts.of_kind("slider"):
            if slider["guide"] is None:
                found += self._rail(slider)
        return found + wall_symbols(self)

    def on_links(self) -> list[Symbol]:
        """Symbols of what moves with the links: always as many, in the same order."""
        return [
            *self._sliders(),
            *spring_symbols(self),
            *self._masses(),
            *symbols.marks("weld", list(self.places("weld")), self._sized(WELD)),
            *joint_spring_symbols(self, self.joint_size),
            *self._joints(),
            *(symbol for load in self.parts.loads for symbol in self._arrows(load)),
        ]

    def gravity(self) -> list[Symbol]:
        """Symbol of the direction of gravity, to the left of the linkage; none without gravity."""
        pull = np.array(self.parts.gravity)
        if not pull.any():
            return []
        along, length = pull / np.hypot(*pull), GRAVITY * self.size
        inside = np.vstack(self._drawn())
        low, high = np.nanmin(inside, axis=0), np.nanmax(inside, axis=0)
        left = low[0] - NAMES * self.size - length / 2 * abs(along[0])
        return symbols.gravity_arrow(np.array([left, (low[1] + high[1]) / 2]), along, length)

    def _drawn(self, *others: Symbol) -> list[FloatArray]:
        """Places of all that is drawn, with those of other symbols."""
        links = self.links if self.travel is None else self.travel
        drawn = (*self.ground(), *self.on_links(), *others)
        beside = [] if self.around is None else [self.around]
        return [links.reshape(-1, 2), *beside, *(symbol.places for symbol in drawn)]

    def draw_ground(self, axes: Axes) -> None:
        """Draw what stays in place, and the direction of gravity."""
        add_symbols(axes, [*self.ground(), *self.gravity()])

    def draw(self, axes: Axes, **links: Any) -> None:
        """Draw the ground, the links with properties of their own, and all that is on them."""
        self.draw_ground(axes)
        for link, look in zip(self.links, self.link_looks(RIGID | links), strict=True):
            axes.plot(*link.T, **look, zorder=1)
        add_symbols(axes, self.on_links())

    def link_looks(self, look: Look) -> list[Look]:
        """Look of each link, those that do not bend being wider."""
        return [look | ({"lw": THICK * look["lw"]} if rigid else {}) for rigid in self.parts.rigid]

    def draw_scale_bar(self, axes: Axes) -> None:
        """Draw a bar of a round length in mm below the linkage, within the axes' limits."""
        length = round_length(0.3 * self.size * 1e3)
        middle, height = sum(axes.get_xlim()) / 2, axes.get_ylim()[0] + 0.03 * self.size
        ends = [middle - length * 0.5e-3, middle + length * 0.5e-3]
        axes.plot(ends, [height, height], color="black", lw=1.6)
        look: Look = {"xytext": (0, 2), "textcoords": "offset points", "ha": "center"}
        axes.annotate(f"{length:g} mm", (middle, height), fontsize="small", **look)

    def taken(self, place: FloatArray, *, links_alone: bool = False) -> list[FloatArray]:
        """Directions in which there is something at a place.

        Parameters
        ----------
        place : ndarray, shape (2,)
        links_alone : bool
            Whether supports, springs and lines of sliders are left out.

        Returns
        -------
        list of ndarray, shape (2,)
        """
        found = []
        for link in self.links:
            for end, other in (link[[0, -1]], link[[-1, 0]]):
                if self._same(end, place):
                    found.append(other - end)
        if not links_alone:
            found += [np.array([0.0, -1.0]) for held in self.grounds if self._same(held, place)]
            for one in self.parts.springs:
                first, second = (self.spring_end(end) for end in one["ends"])
                found += [second - first] if self._same(first, place) else []
                found += [first - second] if self._same(second, place) else []
            for slider in self.parts.of_kind("slider"):
                if self._same(self.place(slider["at"]), place):
                    line = self.line(slider)
                    along = np.array([np.cos(line), np.sin(line)])
                    found += [along, -along, symbols.below(along)]
        return [each / np.hypot(*each) for each in found]

    def occupied(self, place: FloatArray) -> list[FloatArray]:
        """Directions in which there is something at a place, arrows of loads among it."""
        here = [one for one in self.parts.loads if self._same(self.place(one["at"]), place)]
        arrows = [symbol.places for load in here for symbol in self._arrows(load)]
        away = [np.nanmean(places, axis=0) - place for places in arrows]
        return [*self.taken(place), *(each / np.hypot(*each) for each in away)]

    def slides(self, place: FloatArray) -> bool:
        """Whether there is a block at a place."""
        return any(self._same(place, other) for other in self.places("slider"))

    def _same(self, one: FloatArray, other: FloatArray) -> bool:
        return bool(np.hypot(*(one - other)) <= SAME_PLACE * self.size)

    def _rail(self, slider: Part) -> list[Symbol]:
        """Line of the ground under a block, as far as the block goes."""
        place, line = self.place(slider["at"]), self.line(slider)
        reach = np.zeros(1)
        if self.travel is not None:
            link, far = int(slider["at"][0]), -1 if slider["at"][1] else 0
            along = np.array([np.cos(line), np.sin(line)])
            reach = (self.travel[:, link, far] - place) @ along
        half = TRACK_LENGTH * self.size
        ends = float(np.nanmin(reach)) - half, float(np.nanmax(reach)) + half
        return symbols.rail(place, line, ends, 0.6 * BLOCK_SIZE * self.size)

    def _sliders(self) -> list[Symbol]:
        """Blocks on their lines, with the line where a link carries it."""
        found = []
        for slider in self.parts.of_kind("slider"):
            place, line = self.place(slider["at"]), self.line(slider)
            if slider["guide"] is not None:
                along = TRACK_LENGTH * self.size * np.array([np.cos(line), np.sin(line)])
                found.append(Symbol("guide", np.array([place - along, place + along]), GUIDE))
            found.append(symbols.block(place, line, BLOCK_SIZE * self.size))
        return found

    def _masses(self) -> list[Symbol]:
        """Attached bodies, and point masses as discs with areas as the masses, if not small."""
        color: Look = {"color": self.mass_color}
        found = []
        for body in self.parts.bodies:
            place, centre = self.place(body["at"]), self.centre(body)
            outline = self.outline(body)
            found += symbols.body(place, centre, outline, color, self.mark_size)
        largest = max((mass["kg"] for mass in self.parts.masses), default=0.0)
        for mass in self.parts.masses:
            area = self.mark_size**2 * LARGEST_MARK * mass["kg"] / largest
            size = float(np.sqrt(max(area, self.mark_size * LEAST_MARK)))
            look: Look = MASS | color | {"ms": size}
            found += symbols.marks("mass", [self.place(mass["at"])], look)
        return found

    def _sized(self, look: Look) -> Look:
        return look | {"ms": self.joint_size * look["ms"]}

    def _joints(self) -> list[Symbol]:
        """Circles where links turn; the driven shaft's is filled."""
        places = np.vstack([self.grounds, self.places("pin", "slider")])
        driven = [self._same(place, self.shaft) for place in places]
        look = self._sized(JOINT) | {"zorder": 4}
        pins = [place for place, is_shaft in zip(places, driven, strict=True) if not is_shaft]
        shafts = [place for place, is_shaft in zip(places, driven, strict=True) if is_shaft]
        return [
            *symbols.marks("pin", pins, look),
            *symbols.marks("shaft", shafts, look | {"mfc": OUTLINE}),
        ]

    def _arrows(self, load: Part) -> list[Symbol]:
        """An arrow as long as the force is large, and a bent one of the torque."""
        largest = max(float(np.hypot(*one["force"])) for one in self.parts.loads)
        place, varies = self.place(load["at"]), load["over"] != "constant"
        force, found = self.force(load), []
        if (strength := float(np.hypot(*force))) > 0:
            share = LEAST_ARROW + (1 - LEAST_ARROW) * strength / largest
            length = share * ARROW * self.size
            tip = self._tip(place, force / strength, length)
            found += symbols.arrow(tip, force / strength, length, varies=varies)
        if load["torque"]:
            sign, radius = float(np.sign(load["torque"])), TORQUE * self.size
            found += symbols.torque_arrow(place, radius, sign, varies=varies)
        return found

    def _tip(self, place: FloatArray, along: FloatArray, length: float) -> FloatArray:
        """Where an arrow ends: at its place, or beyond it or beside it where there is room."""
        gap = (1.3 * BLOCK_SIZE if self.slides(place) else 0.014) * self.size * along
        taken = self.taken(place)
        if clearance(-along, taken) >= CLEAR:
            return np.asarray(place - gap)
        if clearance(along, taken) >= CLEAR:
            return np.asarray(place + gap + length * along)
        normal = np.array([-along[1], along[0]])
        # Lines of sliders are hatched below.
        side = max((normal, -normal), key=lambda one: (clearance(one, taken), one[1]))
        return np.asarray(place + ASIDE * self.size * side)

    def _support(self, place: FloatArray) -> tuple[float, float]:
        """Half the width of a support and its depth in m: that of the shaft is seen below a hub."""
        below = BELOW_HUB * self.hub_radius if np.array_equal(place, self.shaft) else 0.0
        deep = max(DEPTH * self.size, below)
        return max(HALF_WIDTH * self.size, SLENDER * deep), deep


def clearance(along: FloatArray, taken: Sequence[FloatArray]) -> float:
    """Least angle in rad between a direction and those in which there is something."""
    unit = along / np.hypot(*along)
    return float(min((np.arccos(np.clip(unit @ other, -1, 1)) for other in taken), default=np.pi))
