"""Strength: margins on the drawn linkage, and internal forces along the links."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.plots import reading, scales, style
from flexmech.plots.drawn_linkage.parts import drawn_posture
from flexmech.plots.drawn_linkage.sketch import LinkageSketch, clearance
from flexmech.plots.layout import AxesLike, grid, height_of, sheet

# Without the palest, which are not seen beside white.
COLOURS = LinearSegmentedColormap.from_list(
    "strength used", mpl.colormaps["YlOrRd"](np.linspace(0.2, 1.0, 256))
)
NOT_JUDGED = "0.75"
# Load factor below which colours do not change: a link that cure alone breaks has none.
LEAST_FACTOR = 0.1
# Of links in points, wide enough for their colour to be seen.
WIDE = 5.0
LEAST_HEIGHT, MOST_HEIGHT = 2.2, 4.6
# Of a number beside its place, over the linkage's size; how far it stands off, in points, and in
# which directions beside a joint.
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

    That is one over the least load factor: 1 where the link fails. The worst place of each link is
    marked with its load factor. Links whose layers are not known are grey.

    Parameters
    ----------
    dataset : Dataset
        With ``margin_part``, ``margin_load_factor`` and ``margin_position`` (margin), ``length``
        (link), and the attributes ``drawing``, with a posture, and ``mechanism``.
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
    used = 100 / np.maximum(dataset["margin_load_factor"].values, LEAST_FACTOR)
    colours = ScalarMappable(Normalize(0.0, max(float(used.max()), np.finfo(float).tiny)), COLOURS)
    share = dict(zip(dataset["margin_part"].values.tolist(), used.tolist(), strict=True))
    room = NAME_ROOM * sketch.size
    places = np.concatenate(links)
    limits = sketch.limits(np.vstack([places - room, places + room]))
    height = height_of(limits, style.figure_width(), LEAST_HEIGHT, MOST_HEIGHT)
    with sheet(grid(1, 1, height), ax=ax) as drawn:
        (axes,) = drawn.panels
        sketch.frame(axes, limits)
        handles = [style.line_handle("worst place, with its load factor", **_MARK)]
        if set(names) - set(share):
            handles.append(style.line_handle("not judged", color=NOT_JUDGED, lw=WIDE))
        title = f"Margins of the links at {_drive_text(dataset)}"
        at = f"drawn at crank angle {np.degrees(angle):.4g}°"
        drawn.header(handles, f"{title}, {at}", of=dataset)
        sketch.draw(axes, color="0.3", lw=1.0)
        for name, link in zip(names, links, strict=True):
            colour = colours.to_rgba(share[name]) if name in share else NOT_JUDGED
            axes.plot(*link.T, color=colour, lw=WIDE, zorder=1.5, solid_capstyle="round")
        _mark_worst(axes, dataset, sketch, dict(zip(names, links, strict=True)))
        sketch.draw_scale_bar(axes)
        drawn.colour_bar(colours, "Strength that is used, 1 / load factor (%)")
    return drawn.figure


def _drive_text(dataset: xr.Dataset) -> str:
    """Crank speed, and whose internal forces they are."""
    source = str(dataset.attrs["source_of_loads"])
    engine = reading.names_of(dataset, "engine")[0]
    whose = "rigid links" if engine == "rigid" else f"{engine} engine"
    return f"{reading.drive_text(dataset)} ({source}, {whose})"


def _mark_worst(
    axes: Axes, dataset: xr.Dataset, sketch: LinkageSketch, links: dict[str, FloatArray]
) -> None:
    """Mark the worst place of each link, and write its load factor beside it."""
    middle = np.mean([link.mean(axis=0) for link in links.values()], axis=0)
    marked: list[FloatArray] = []
    for number, name in enumerate(dataset["margin_part"].values.tolist()):
        start, end = links[name][0], links[name][-1]
        length = float(dataset["length"].sel(link=name))
        place = start + (end - start) * float(dataset["margin_position"][number]) / length
        if any(np.hypot(*(place - other)) <= NEAR * sketch.size for other in marked):
            continue  # of two welded links the weaker one has the place
        marked.append(place)
        axes.plot(*place, **_MARK, zorder=5)
        across = np.array([start[1] - end[1], end[0] - start[0]]) / np.hypot(*(end - start))
        outward = across if across @ (place - middle) >= 0 else -across
        if any(np.hypot(*(place - own)) <= NEAR * sketch.size for own in (start, end)):
            # Away from all links that meet there, and from supports.
            room = [round(clearance(one, sketch.occupied(place)), 6) for one in TRIED]
            outward = TRIED[int(np.argmax(room))]
        factor = float(dataset["margin_load_factor"][number])
        look: style.Look = {"textcoords": "offset points", "ha": "center", "va": "center"}
        look["bbox"] = {"fc": "white", "lw": 0, "alpha": 0.8, "pad": 0.5}
        axes.annotate(f"{factor:.3g}", place, tuple(AWAY * outward), zorder=6, **look)


_MARK: style.Look = {"marker": "o", "ls": "", "mfc": "white", "mec": "black", "ms": 5.0}


def plot_internal_forces(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw axial force, shear force and bending moment along each link, with their envelopes.

    The envelope lies between the least and the greatest value of the turn at each place; a line
    shows them at the crank angle at which the link is nearest to failure.

    Parameters
    ----------
    dataset : Dataset
        With ``axial_force``, ``shear_force`` and ``bending_moment`` (engine, link, crank_angle,
        station), ``position`` (link, station) in m, ``margin_part`` and ``margin_crank_angle``
        (margin).
    ax : sequence of Axes, optional
        The user's: a row of three for each link. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    links = reading.names_of(dataset, "link")
    worst = dict(
        zip(
            dataset["margin_part"].values.tolist(),
            dataset["margin_crank_angle"].values.tolist(),
            strict=True,
        )
    )
    angles = dataset["crank_angle"].values
    columns = len(FORCES)
    height = PANEL * len(links) + 0.4
    layout = grid(len(links), columns, height, narrow=columns, sharex="row")
    with sheet(layout, ax=ax) as drawn:
        handles = [
            style.line_handle("envelope over the turn", color=_BAND, lw=6.0),
            style.line_handle("at the crank angle nearest to failure", **_LINE),
        ]
        title = f"Internal forces along the links at {_drive_text(dataset)}"
        drawn.header(handles, title, of=dataset)
        for column, (variable, words, units) in enumerate(FORCES):
            values = reading.values_of(dataset[variable][0], "link", "crank_angle", "station")
            factor, unit = reading.fitting_unit(values[np.isfinite(values)], units)
            symbol = words.split()[-1]
            drawn.panels[column].set_title(f"{symbol if style.is_narrow() else words} ({unit})")
            for row, link in enumerate(links):
                axes = drawn.panels[row * columns + column]
                place = 1e3 * dataset["position"].sel(link=link).values
                kept = np.isfinite(place)
                own = factor * values[row][:, kept]
                _draw_envelope(axes, place[kept], own)
                if link in worst:
                    number = int(np.abs(angles - worst[link]).argmin())
                    axes.plot(place[kept], own[number], **_LINE)
                if column == 0:
                    at = f"\n(line: {np.degrees(worst[link]):.4g}°)" if link in worst else ""
                    axes.set_ylabel(f"{link}{at}")
        drawn.label_x("Place (mm)", slice(-columns, None))
    return drawn.figure


def _draw_envelope(axes: Axes, place: FloatArray, values: FloatArray) -> None:
    """Draw the least and the greatest of values (A, k) at places (k,)."""
    low, high = values.min(axis=0), values.max(axis=0)
    axes.fill_between(place, low, high, color=_BAND, lw=0)
    for edge in (low, high):
        axes.plot(place, edge, color=style.MID_GREY, lw=0.7)
    scales.zero_line(axes)
    axes.xaxis.set_major_locator(MaxNLocator(NARROW_NUMBERS if style.is_narrow() else NUMBERS))
    axes.yaxis.set_major_locator(MaxNLocator(NUMBERS))
    scales.plain_numbers(axes)


_BAND = style.LIGHT_GREY
_LINE: style.Look = {"color": style.series_style(1).color, "lw": 1.4}
