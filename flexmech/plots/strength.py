"""Strength: margins on the drawn linkage, and internal forces along the links."""

from __future__ import annotations

import math
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.plots import reading, scales, style
from flexmech.plots.drawing import figure
from flexmech.plots.drawn_linkage.sketch import LinkageSketch, clearance
from flexmech.plots.drawn_linkage.symbols import drawn_posture
from flexmech.plots.layout import AxesLike, grid, height_of, sheet
from flexmech.plots.picture import ZERO, Curve, Pane, Picture

# Without the palest, which are not seen beside white, and the darkest, which are near to that of
# parts that fail.
COLOURS = LinearSegmentedColormap.from_list(
    "strength used", mpl.colormaps["YlOrRd"](np.linspace(0.2, 0.85, 256))
).with_extremes(over="black")
# Scale in percent: at its end a part fails, whatever the loads of a figure.
FAILS, TICKS = 100.0, (0.0, 25.0, 50.0, 75.0, 100.0)
NOT_JUDGED = "0.75"
# What the marks of margins of each kind are of, in the legend.
WORST = {"link": "worst place", "fatigue": "worst place by fatigue", "pin": "pin"}
# What stands beside them, told of the first and of the others.
FIRST, OTHERS = "with its load factor", "likewise"
# Digits of a load factor: loads and strengths are known to fewer.
DIGITS = 3
# Width of links in points, wide enough for their colour to be seen.
WIDE = 5.0
LEAST_HEIGHT, MOST_HEIGHT = 2.2, 4.6
# Room of a number beside its place, over the linkage's size; how far it stands off, in points,
# and in which directions beside a joint.
NAME_ROOM = 0.08
AWAY = 17.0
_TURN = np.radians(np.arange(0.0, 360.0, 15.0))
TRIED = np.column_stack([np.cos(_TURN), np.sin(_TURN)])
# A place so near a joint is at it, over the linkage's size.
NEAR = 0.02
# Height of a row of panels in inches.
PANEL = 1.3
# Internal forces: variable, words, factors and units to choose from.
FORCES = (
    ("axial_force", "Axial force N", reading.FORCE_UNITS),
    ("shear_force", "Shear force V", reading.FORCE_UNITS),
    ("bending_moment", "Bending moment M", reading.TORQUE_UNITS),
)
# Numbers along the axes of a panel.
NUMBERS, NARROW_NUMBERS = 4, 2


def plot_strength(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the linkage, each link coloured by what part of its strength its loads take.

    That is one over its least load factor, for ever where its endurance is judged. The scale ends
    where a part fails; what fails is black. The worst place of each link is marked with its load
    factor, and so is each pin that is judged. Links whose layers are not known are grey.

    Parameters
    ----------
    dataset : Dataset
        With ``margin_part``, ``margin_kind``, ``margin_load_factor`` and ``margin_position``
        (margin), the weakest first, ``length`` (link), and the attributes ``drawing``, with a
        posture, and ``mechanism``.
    ax : Axes, optional
        The user's. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If the dataset holds no posture.
    """
    found = drawn_posture(dataset)
    if found is None:
        raise InputError("the result holds no posture to draw; compute it anew")
    links, parts, angle = found
    sketch = LinkageSketch(links, parts)
    names = reading.names_of(dataset, "link")
    weakest = _weakest(dataset, names)
    used = {mark.part: mark.used for mark in weakest if mark.kind != "pin"}
    colours = ScalarMappable(Normalize(0.0, FAILS), COLOURS)
    room = NAME_ROOM * sketch.size
    places = np.concatenate(links)
    limits = sketch.limits(np.vstack([places - room, places + room]))
    height = height_of(limits, style.figure_width(), LEAST_HEIGHT, MOST_HEIGHT)
    with sheet(grid(1, 1, height), ax=ax) as drawn:
        (axes,) = drawn.panels
        sketch.frame(axes, limits)
        drawn.header(
            _handles(weakest, names),
            f"Margins at {_drive_text(dataset)}, drawn at crank angle {np.degrees(angle):.4g}°",
            of=dataset,
        )
        sketch.draw(axes, color="0.3", lw=1.0)
        for name, link in zip(names, links, strict=True):
            colour = colours.to_rgba(np.array(used[name])) if name in used else NOT_JUDGED
            axes.plot(*link.T, color=colour, lw=WIDE, zorder=1.5, solid_capstyle="round")
        _mark_worst(axes, dataset, sketch, weakest, colours)
        sketch.draw_scale_bar(axes)
        beyond = max(mark.used for mark in weakest) > FAILS
        extend = "max" if beyond else "neither"
        drawn.colour_bar(colours, "1 / load factor (%)", ticks=TICKS, extend=extend)
    return drawn.figure


@dataclass(frozen=True)
class Mark:
    """Worst place of a link, or a pin.

    Parameters
    ----------
    part : str
        Link or joint.
    kind : str
        Kind of its least margin.
    factor : float
        Least load factor.
    position : float
        From the link's start in m; not a number of a pin.
    """

    part: str
    kind: str
    factor: float
    position: float

    @property
    def used(self) -> float:
        """Strength that loads take in percent; infinite where nothing is left for them."""
        return FAILS / self.factor if self.factor else math.inf


def _weakest(dataset: xr.Dataset, links: list[str]) -> list[Mark]:
    """Least margin of each link and of each pin, weakest first; a joint may have a link's name."""
    columns = (dataset[f"margin_{n}"].values for n in ("part", "kind", "load_factor", "position"))
    found: dict[tuple[str, bool], Mark] = {}
    for part, kind, factor, position in zip(*columns, strict=True):
        mark = Mark(str(part), str(kind), float(factor), float(position))
        if kind == "pin" or part in links:
            found.setdefault((mark.part, kind == "pin"), mark)
    return list(found.values())


def _handles(weakest: list[Mark], links: list[str]) -> list[Artist]:
    """Entries of the legend for what is in the figure."""
    kinds = {mark.kind for mark in weakest}
    judged = {mark.part for mark in weakest if mark.kind != "pin"}
    handles = [
        style.line_handle(f"{WORST[kind]}, {OTHERS if number else FIRST}", **_MARKS[kind])
        for number, kind in enumerate(kind for kind in WORST if kind in kinds)
    ]
    if max(mark.used for mark in weakest) > FAILS:
        handles.append(style.line_handle("fails (over 100 %)", color="black", lw=WIDE))
    if set(links) - judged:
        handles.append(style.line_handle("not judged", color=NOT_JUDGED, lw=WIDE))
    return handles


def _drive_text(dataset: xr.Dataset) -> str:
    """Crank speed, and whose internal forces they are."""
    source = str(dataset.attrs["source_of_loads"])
    engine = reading.names_of(dataset, "engine")[0]
    whose = "rigid links" if engine == "rigid" else f"{source}, {engine} engine"
    return f"{reading.drive_text(dataset)} ({whose})"


def _mark_worst(
    axes: Axes,
    dataset: xr.Dataset,
    sketch: LinkageSketch,
    weakest: list[Mark],
    colours: ScalarMappable,
) -> None:
    """Mark the worst place of each link and each pin, and write its load factor beside it."""
    links = dict(zip(reading.names_of(dataset, "link"), sketch.links, strict=True))
    joints = {joint["name"]: sketch.place(joint["at"]) for joint in sketch.parts.joints}
    middle = np.mean([link.mean(axis=0) for link in sketch.links], axis=0)
    marked: list[FloatArray] = []
    for mark in weakest:
        if mark.kind == "pin":
            place, along = joints[mark.part], np.zeros(2)
        else:
            start, end = links[mark.part][0], links[mark.part][-1]
            along = (end - start) / np.hypot(*(end - start))
            place = start + (end - start) * mark.position / float(
                dataset["length"].sel(link=mark.part)
            )
        if any(np.hypot(*(place - other)) <= NEAR * sketch.size for other in marked):
            continue  # of parts that are worst at one place the weakest one has it
        marked.append(place)
        look = _MARKS[mark.kind]
        if mark.kind == "pin":
            look = look | {"mfc": colours.to_rgba(np.array(mark.used))}
        axes.plot(*place, **look, zorder=5)
        outward = np.array([-along[1], along[0]])
        outward = outward if outward @ (place - middle) >= 0 else -outward
        ends = [place] if mark.kind == "pin" else [start, end]
        if any(np.hypot(*(place - own)) <= NEAR * sketch.size for own in ends):
            # Away from all links that meet there, and from supports.
            room = [round(clearance(one, sketch.occupied(place)), 6) for one in TRIED]
            outward = TRIED[int(np.argmax(room))]
        box: style.Look = {"textcoords": "offset points", "ha": "center", "va": "center"}
        box["bbox"] = {"fc": "white", "lw": 0, "alpha": 0.8, "pad": 0.5}
        axes.annotate(
            f"{mark.factor:.{DIGITS}g}",
            (place[0], place[1]),
            tuple(AWAY * outward),
            zorder=6,
            **box,
        )


_WHITE: style.Look = {"ls": "", "mfc": "white", "mec": "black"}
_MARKS: dict[str, style.Look] = {
    "link": {"marker": "o", "ms": 5.0} | _WHITE,
    "fatigue": {"marker": "s", "ms": 5.0} | _WHITE,
    "pin": {"marker": "D", "ms": 5.5} | _WHITE,
}


@figure
def plot_internal_forces(dataset: xr.Dataset) -> Picture:
    """Draw axial force, shear force and bending moment along each link, with their envelopes.

    The envelope lies between the least and the greatest value of the turn at each place; a line
    shows them at the crank angle at which the link is nearest to failure.

    Parameters
    ----------
    dataset : Dataset
        With ``axial_force``, ``shear_force`` and ``bending_moment`` (engine, link, crank_angle,
        station), ``position`` (link, station) in m, ``margin_part``, ``margin_kind`` and
        ``margin_crank_angle`` (margin).
    ax : sequence of Axes, optional
        The user's: a row of three for each link. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    links = reading.names_of(dataset, "link")
    margins = (dataset[f"margin_{name}"].values for name in ("part", "kind", "crank_angle"))
    worst: dict[str, float] = {}
    for part, kind, angle in zip(*margins, strict=True):
        if kind == "link":
            worst[str(part)] = float(angle)
    angles = dataset["crank_angle"].values
    panes, in_units = [], {name: _in_unit(dataset[name][0], units) for name, _, units in FORCES}
    for link in links:
        place = 1e3 * dataset["position"].sel(link=link).values
        known = np.isfinite(place)
        most = NARROW_NUMBERS if style.is_narrow() else NUMBERS
        ticks = scales.ticks_within(float(place[known].min()), float(place[known].max()), most)
        at = f"\n(line: {np.degrees(worst[link]):.4g}°)" if link in worst else ""
        for variable, words, _ in FORCES:
            values, unit = in_units[variable]
            of_link = values.sel(link=link).values[:, known]
            low, high = of_link.min(axis=0), of_link.max(axis=0)
            band: style.Look = {"color": style.LIGHT_GREY, "lw": 0.0}
            curves = [Curve(place[known], low, band, "envelope over the turn", upto=high)]
            curves += [Curve(place[known], edge, _EDGE) for edge in (low, high)]
            if link in worst:
                line = of_link[int(np.abs(angles - worst[link]).argmin())]
                curves.append(Curve(place[known], line, _LINE, "at the angle nearest to failure"))
            symbol = words.split()[-1] if style.is_narrow() else words
            panes.append(
                Pane(
                    f"{link}{at}" if variable == FORCES[0][0] else "",
                    curves,
                    title=f"{symbol} ({unit})" if link == links[0] else "",
                    spans=(ZERO,),
                    along="Place (mm)" if link == links[-1] else "",
                    x_ticks=ticks,
                )
            )
    columns = len(FORCES)
    layout = grid(len(links), columns, PANEL * len(links) + 0.4, narrow=columns, sharex="row")
    title = f"Internal forces along the links at {_drive_text(dataset)}"
    return Picture(panes, "", dataset, title, layout=layout)


def _in_unit(force: xr.DataArray, units: reading.Units) -> tuple[xr.DataArray, str]:
    """Internal forces (crank_angle, station) of links in one unit."""
    values = force.transpose("link", "crank_angle", "station")
    factor, unit = reading.fitting_unit(values.values[np.isfinite(values.values)], units)
    return factor * values, unit


_EDGE: style.Look = {"color": style.MID_GREY, "lw": 0.7}
_LINE: style.Look = {"color": style.series_style(1).color, "lw": 1.4}
