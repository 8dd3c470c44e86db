"""The linkage by itself and with its mode shapes; names of joints and legend of parts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr
from matplotlib import rcParams
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.path import Path
from matplotlib.transforms import Affine2D, Bbox
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from flexmech.arrays import FloatArray
from flexmech.plots import angle_panels, style
from flexmech.plots.angle_panels import has_many_speeds
from flexmech.plots.drawn_linkage import symbols
from flexmech.plots.drawn_linkage.sketch import MASS, RIGID, SMALL, LinkageSketch, clearance
from flexmech.plots.drawn_linkage.symbols import SAME_PLACE, dashpot, parts_of, rotary_dashpot
from flexmech.plots.layout import AxesLike, Layout, grid, height_of, sheet, tiles
from flexmech.plots.reading import (
    engine_label,
    highest_speed,
    mechanism_name,
    mode_label,
    names_of,
    speed_texts,
    values_of,
)
from flexmech.plots.style import Look, line_handle, series_handle, series_line

# Heights of a figure in inches: a flat linkage has room for names, a tall one fits on half a page.
LEAST_HEIGHT, MOST_HEIGHT = 1.6, 3.6
# Distance of a name from its joint in points, more across than up, as names are wider than high;
# farther from what slides and the shaft, whose symbols are larger than a pin's.
AWAY, BEYOND_BLOCK, BEYOND_SHAFT = np.array([12.0, 9.0]), 1.5, 1.3
# Room for the names around the joints over the linkage's size: twice a letter's height in a
# picture of that of half a page.
NAME_ROOM = 0.06
JOINT = ("joint", "component")
# Directions that are tried for a name where more than links is in the way: two neighbours put it in
# places that differ by less than half a letter.
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

# Panels a row on a wide and on a narrow page, each some 4 cm wide, and points drawn between two
# stations of a link, which look like a curve.
PANELS_A_ROW, NARROW_ROW, POINTS_A_STATION = 4, 2, 4
# Largest displacement as drawn, over the linkage's size: more than in larger pictures.
ENLARGED_TO = 0.14
# Room of the scale bar with its words over the linkage's size, which is small beside its
# letters.
BAR_ROOM = 0.14
# An end that moves less than this part of the largest displacement in every mode is held: it moves
# by round-off.
AT_REST = 1e-6
NOT_SHOWN = ["crank_angle", "check_angle", "shape_angle", "place"]
SHAPE = ("crank_speed", "mode", "link", "station", "component")


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
        # Among several joints in one place, the one that has the place's own name is written.
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
    """Legend entries of the parts that their symbols alone do not identify.

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


def plot_mode_shapes(
    dataset: xr.Dataset,
    *,
    ax: AxesLike | None = None,
    check_angle: float | None = None,
    shape_angle: float | None = None,
) -> Figure:
    """Draw each mode on the linkage, with the shape at every crank speed on top of another.

    As Kumar and Chandrakar's Figures 1.7-1.9 and 2.3-2.8: the rigid linkage in grey and the
    deflected one, enlarged; of more than five speeds that at the highest. A complex shape is
    turned in phase until its largest component is real, and its real part is drawn; signs are
    those that match the first speed.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``MovingFrequencies`` result. The first engine's shapes are drawn.
    ax : Axes or sequence of Axes, optional
        The user's, one a mode. Left out: a new figure is made.
    check_angle : float, optional
        Crank angle in rad; the nearest angle with stored shapes is taken. Default the first.
    shape_angle : float, optional
        Instead: the nearest of the crank angles in rad at which shapes were asked for.

    Returns
    -------
    Figure
    """
    speed = ""
    if has_many_speeds(dataset):
        place, text = highest_speed(dataset)
        dataset = dataset.isel(crank_speed=[place])
        speed = f"{text} and "
    shown = _stored(dataset, check_angle) if shape_angle is None else _asked(dataset, shape_angle)
    frequency, stored = shown["frequency"], shown["shape"]
    real, imaginary = (values_of(stored.sel(part=part), *SHAPE) for part in ("real", "imaginary"))
    shapes = real_shapes(real + 1j * imaginary)
    # As the first speed's, whose phases may differ by half a turn.
    overlap = np.sum(shapes * shapes[:1], axis=(-3, -2, -1), keepdims=True)
    shapes *= np.where(overlap < 0, -1.0, 1.0)
    rigid = values_of(shown["position"], "place", *SHAPE[2:])
    held = np.abs(shapes[..., [0, -1], :]).max(axis=(0, 1, -1)) <= AT_REST
    sketch = LinkageSketch(rigid[0], parts_of(dataset, rigid, held), mark_size=SMALL)
    deflected = _smooth(sketch.links + ENLARGED_TO * sketch.size * shapes)
    sketch = replace(sketch, around=deflected.reshape(-1, 2))
    limits = sketch.limits(deflected, BAR_ROOM)
    n_speeds, n_modes = shapes.shape[:2]
    widths = _line_widths(n_speeds)
    with sheet(_layout(limits, n_modes, n_speeds), ax=ax, fewer=angle_panels.ONE_MODE) as drawn:
        handles = [
            series_handle(number, text, linewidth=widths[number])
            for number, text in enumerate(speed_texts(dataset))
        ]
        title = (
            f"Mode shapes at {speed}crank angle {np.degrees(shown.attrs['angle']):.4g}° by "
            f"{engine_label(dataset)}, displacement enlarged"
        )
        handles += [line_handle("rigid linkage", **RIGID), *part_handles(sketch)]
        drawn.header(handles, title, of=dataset)
        texts = [_frequencies_text(one) for one in values_of(frequency, "mode", "crank_speed")]
        for mode, axes in enumerate(drawn.panels):
            sketch.frame(axes, limits)
            heading = f"{mode_label(dataset['mode'].values[[mode]].tolist())}\n{texts[mode]}"
            drawn.title(
                axes, heading, loc="center", fontsize=rcParams["legend.fontsize"], linespacing=1.3
            )
            sketch.draw(axes)
            for number, links in enumerate(deflected[:, mode]):
                line = series_line(number) | {"lw": widths[number], "zorder": 2 + 0.1 * number}
                for link in links:
                    axes.plot(*link.T, **line)
        sketch.draw_scale_bar(drawn.panels[0])
    return drawn.figure


def _stored(dataset: xr.Dataset, check_angle: float | None) -> xr.Dataset:
    """Shapes of the first engine at one of the map's check angles, that position first."""
    angles = dataset["check_angle"].values.astype(float)
    nearest = 0 if check_angle is None else int(np.argmin(np.abs(angles - check_angle)))
    first = dataset.isel(engine=0)
    order = [nearest, *(n for n in range(len(angles)) if n != nearest)]
    position = first["rigid_position"].isel(check_angle=order).rename(check_angle="place")
    frequency = first["frequency"].sel(crank_angle=angles[nearest], method="nearest")
    shape = first["mode_shape"].isel(check_angle=nearest)
    shown = {"frequency": frequency, "shape": shape, "position": position}
    dropped = {name: each.drop_vars(NOT_SHOWN, errors="ignore") for name, each in shown.items()}
    return xr.Dataset(dropped, attrs={"angle": angles[nearest]})


def _asked(dataset: xr.Dataset, shape_angle: float) -> xr.Dataset:
    """Shapes at one of the angles at which they were asked for, that position first."""
    angles = dataset["shape_angle"].values.astype(float)
    here = dataset.isel(shape_angle=int(np.argmin(np.abs(angles - shape_angle))))
    others = dataset["rigid_position"].rename(check_angle="place").drop_vars("place")
    position = xr.concat(
        [here["asked_position"].drop_vars(NOT_SHOWN, errors="ignore"), others], "place"
    )
    return xr.Dataset(
        {"frequency": here["asked_frequency"], "shape": here["asked_shape"], "position": position},
        attrs={"angle": float(here["shape_angle"])},
    )


def real_shapes(shapes: NDArray[np.complex128]) -> FloatArray:
    """Real parts of shapes, each in the phase in which its largest component is real.

    Parameters
    ----------
    shapes : ndarray of complex, shape (m, n, link, station, 2)

    Returns
    -------
    ndarray, shape (m, n, link, station, 2)
        Real, with largest displacement 1.
    """
    flat = shapes.reshape(*shapes.shape[:2], -1)
    place = np.argmax(np.abs(flat), axis=-1)[..., None]
    phase = np.angle(np.take_along_axis(flat, place, axis=-1))
    real = (flat * np.exp(-1j * phase)).real.reshape(shapes.shape)
    longest = np.hypot(real[..., 0], real[..., 1]).max(axis=(-2, -1))
    return np.asarray(real / np.where(longest > 0, longest, 1.0)[..., None, None, None])


def _smooth(deflected: FloatArray) -> FloatArray:
    """Cubic spline through the stations of each link, which stay among the points drawn."""
    stations = deflected.shape[-2]
    points = np.linspace(0, stations - 1, (stations - 1) * POINTS_A_STATION + 1)
    return np.asarray(CubicSpline(np.arange(stations), deflected, axis=-2)(points))


def _layout(limits: Bbox, n_modes: int, n_speeds: int) -> Layout:
    """Panels of equal scale, with room for the frequencies in their headings."""
    columns = 3 if n_modes in (5, 6) else min(n_modes, PANELS_A_ROW)
    if style.is_narrow():
        columns = min(columns, NARROW_ROW)
    # Less the layout's padding between the panels.
    panel = height_of(limits, style.figure_width() / columns - 0.2, 0.7, 2.6)
    title = 0.2 + 0.17 * -(-n_speeds // 3)
    return tiles(n_modes, columns, panel + title, narrow=columns)


def _frequencies_text(frequency: FloatArray) -> str:
    """Frequencies by speed in the legend's order, three a line."""
    largest = float(np.nanmax(np.abs(frequency), initial=1e-3))
    decimals = max(0, 3 - int(np.floor(np.log10(largest))))
    texts = [f"{value:.{decimals}f}" for value in frequency]
    lines = [" / ".join(texts[start : start + 3]) for start in range(0, len(texts), 3)]
    return " /\n".join(lines) + " Hz"


def _line_widths(total: int) -> list[float]:
    """Each speed thinner than the one before, so that coinciding shapes stay visible."""
    widths: list[float] = np.linspace(min(1.2 + 0.8 * (total - 1), 3.6), 1.2, total).tolist()
    return widths
