"""The linkage in a figure of its own; names of joints and legend of parts for all figures."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.path import Path
from matplotlib.transforms import Affine2D

from flexmech.arrays import FloatArray
from flexmech.plots import linkage_symbols as symbols
from flexmech.plots import style
from flexmech.plots.layout import AxesLike, grid, height_of, sheet
from flexmech.plots.linkage_parts import SAME_PLACE
from flexmech.plots.linkage_sketch import MASS, LinkageSketch, clearance
from flexmech.plots.linkage_springs import dashpot, rotary_dashpot
from flexmech.plots.reading import mechanism_name, names_of, values_of
from flexmech.plots.style import Look, line_handle

# Of a figure in inches: a flat linkage has room for names, a tall one fits on half a page.
LEAST_HEIGHT, MOST_HEIGHT = 1.6, 3.6
# Distance of a name from its joint in points; farther from what slides and the shaft.
AWAY, BEYOND_BLOCK, BEYOND_SHAFT = np.array([12.0, 9.0]), 1.5, 1.3
# Room for the names around the joints over the linkage's size: twice a letter's height in a
# picture of that of half a page.
NAME_ROOM = 0.06
JOINT = ("joint", "component")
# Directions that are tried for a name where more than links is in the way.
TRIED = np.radians(np.arange(0.0, 360.0, 15.0))

CROSSED = Path.make_compound_path(
    Path.unit_circle(), Path([[-1, 0], [1, 0]]), Path([[0, -1], [0, 1]])
)
# Along x, to be turned where gravity pulls.
ARROW = Path(
    np.array([[-1, 0], [0.3, 0], [0.3, 0.24], [1, 0], [0.3, -0.24], [0.3, 0]]),
    np.array([Path.MOVETO, *5 * [Path.LINETO]]),
)
OVER = {"constant": "load", "crank_angle": "load over the crank angle", "time": "load over time"}


def _path(symbol: symbols.Symbol) -> Path:
    """Path of a symbol of lines, which is broken where places are not numbers."""
    places = symbol.places
    kept = np.isfinite(places[:, 0])
    starts = np.r_[True, ~kept[:-1]]
    return Path(places[kept], np.where(starts, Path.MOVETO, Path.LINETO)[kept])


LEFT, RIGHT = np.array([-1.0, 0.0]), np.array([1.0, 0.0])
BENT_DASHPOT = rotary_dashpot(np.array([0.0, -0.5]), 1.0)
RINGS = Path.make_compound_path(
    Path.unit_circle(), Path.unit_circle().transformed(Affine2D().scale(0.7))
)
# Springs and dampers in a legend: which, in words, mark, its size and the width of its line.
SPRING_MARKS: tuple[tuple[str, str, Path, float, float], ...] = (
    ("stiff", "spring", _path(symbols.zigzag(LEFT, RIGHT, 0.22)), 16, 0.9),
    ("damped", "damper", _path(dashpot(LEFT, RIGHT, 0.3, beside=False)), 16, 0.9),
    ("torsional", "torsional spring", _path(symbols.spiral(np.zeros(2), 1.0)), 9, 0.7),
    ("torsion_damped", "torsional damper", _path(BENT_DASHPOT), 12, 0.7),
    ("radially_damped", "bearing with a damper", RINGS, 8, 0.6),
)


def plot_linkage(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the rigid linkage with the names of its joints, and its supports on the ground.

    Parameters
    ----------
    dataset : Dataset
        With ``rigid_position`` (link, station, component) and ``joint_position`` (joint,
        component) in m, the coordinate ``joint_kind`` (clamp, pivot, pin, weld or slider), the
        name of the mechanism, and the attribute ``drawing``.
    ax : Axes, optional
        The user's. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    sketch = LinkageSketch.of(dataset)
    limits = sketch.limits(named_places(sketch, dataset))
    height = height_of(limits, style.figure_width(), LEAST_HEIGHT, MOST_HEIGHT)
    with sheet(grid(1, 1, height), ax=ax) as drawn:
        (axes,) = drawn.panels
        sketch.frame(axes, limits)
        sketch.draw(axes, color="0.5", lw=2.0)
        sketch.draw_scale_bar(axes)
        axes.set_title(mechanism_name(dataset), loc="center")
        name_joints(axes, sketch, dataset)
    return drawn.figure


def named_places(sketch: LinkageSketch, dataset: xr.Dataset) -> FloatArray:
    """Places in m within which the names of joints stand; shape (n, 2)."""
    joints, room = values_of(dataset["joint_position"], *JOINT), NAME_ROOM * sketch.size
    return np.vstack([joints - room, joints + room])


def name_joints(axes: Axes, sketch: LinkageSketch, dataset: xr.Dataset) -> None:
    """Write names beside joints, away from links and supports.

    Parameters
    ----------
    axes : Axes
    sketch : LinkageSketch
    dataset : Dataset
        With ``joint_position`` (joint, component) in m and ``joint_kind``: clamps and pivots are
        held by the ground.
    """
    names, places = names_of(dataset, "joint"), values_of(dataset["joint_position"], *JOINT)
    held = np.isin(dataset["joint_kind"].values, ["clamp", "pivot"])
    for number, (name, place) in enumerate(zip(names, places, strict=True)):
        here = np.hypot(*(places - place).T) <= SAME_PLACE * sketch.size
        # Of several joints in one place the one that has the place's own name.
        if min(np.flatnonzero(here), key=lambda other: len(names[other])) != number:
            continue
        offset = AWAY * _away(sketch, place, held=bool(held[number]))
        if sketch.slides(place):
            offset *= BEYOND_BLOCK
        elif (
            np.hypot(*(place - sketch.shaft)) <= SAME_PLACE * sketch.size and not style.is_narrow()
        ):
            # On a narrow page the shaft's disc is within the usual distance.
            offset *= BEYOND_SHAFT
        look: Look = {"textcoords": "offset points", "ha": "center", "va": "center", "zorder": 6}
        look["bbox"] = {"fc": "white", "lw": 0, "alpha": 0.75, "pad": 0.5}
        axes.annotate(name, place, tuple(offset), **look)


def _away(sketch: LinkageSketch, place: FloatArray, *, held: bool) -> FloatArray:
    """Direction away from the links at a joint, from a support below it, and from all else."""
    links = sketch.taken(place, links_alone=True)
    directions = ([np.array([0.0, -1.0])] if held else []) + links
    if len(sketch.occupied(place)) > len(directions):
        tried = np.column_stack([np.cos(TRIED), np.sin(TRIED)])
        room = [round(clearance(each, sketch.occupied(place)), 6) for each in tried]
        return np.asarray(tried[int(np.argmax(room))])
    pull = np.sum(directions, axis=0)
    if np.hypot(*pull) <= SAME_PLACE:
        # Between two in one line there is room on both sides.
        pull = directions[0][::-1] * [1.0, -1.0]
    return np.asarray(-pull / np.hypot(*pull))


def part_handles(sketch: LinkageSketch) -> list[Artist]:
    """Legend entries of the parts that are not told by their symbols alone.

    Parameters
    ----------
    sketch : LinkageSketch

    Returns
    -------
    list of Artist
    """
    parts, found = sketch.parts, list[Artist]()
    if masses := [mass["kg"] for mass in parts.masses]:
        disc: Look = MASS | {"ls": "", "ms": 6, "color": sketch.mass_color}
        found.append(line_handle(f"point mass (largest {1e3 * max(masses):.4g} g)", **disc))
    for what, label, marker, size, width in SPRING_MARKS:
        if parts.springs_with(what):
            color = symbols.OUTLINE if what == "radially_damped" else "0.25"
            mark: Look = {"ls": "", "marker": marker, "ms": size, "mew": width, "mfc": "none"}
            found.append(line_handle(label, color=color, **mark))
    if parts.bodies:
        look: Look = {"ls": "", "marker": CROSSED, "ms": 7, "mew": 0.9, "mfc": "none"}
        found.append(line_handle("centre of a body", color=sketch.mass_color, **look))
    for over, words in OVER.items():
        if names := [load["name"] for load in parts.loads if load["over"] == over]:
            arrow: Look = {"color": "black", "lw": 1.2, "marker": ">", "ms": 5, "mew": 0.8}
            if over != "constant":
                arrow |= {"ls": (0.0, (3.0, 1.5)), "mfc": "white"}
            label = f"{words}: {', '.join(names)}".replace("$", r"\$")
            found.append(line_handle(label, **arrow))
    if strength := float(np.hypot(*parts.gravity)):
        turn = np.degrees(np.arctan2(parts.gravity[1], parts.gravity[0]))
        down: Look = {"ls": "", "marker": ARROW.transformed(Affine2D().rotate_deg(turn)), "ms": 10}
        down |= {"mew": 0.8, "color": symbols.GRAVITY_COLOR}
        found.append(line_handle(f"gravity ({strength:.4g} m/s\N{SUPERSCRIPT TWO})", **down))
    return found
