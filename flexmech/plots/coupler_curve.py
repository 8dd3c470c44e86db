"""Coupler curves with their double points, paths of the pins, and angles of the links."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Affine2D

from flexmech.arrays import FloatArray
from flexmech.plots import scales, style
from flexmech.plots.layout import AxesLike, grid, sheet
from flexmech.plots.linkage_parts import drawn_posture
from flexmech.plots.linkage_sketch import RIGID, LinkageSketch
from flexmech.plots.linkage_symbols import add_symbols
from flexmech.plots.reading import degrees, names_of, values_of
from flexmech.plots.style import line_handle, series_handles, series_line, series_style, told_apart

# Of two square panels beside each other, of three, and of four panels of angles, in inches.
HEIGHT, HEIGHT_OF_THREE, ANGLE_HEIGHT = 3.6, 2.45, 4.2
# Of a close-up over the extent of the loops: what leads into them is seen.
CLOSE_UP_ROOM = 1.5
# Marks of masses and bodies over those in a picture of one linkage.
SMALL = 0.6
# Above this extent in m a picture is in m, below it in mm.
METRES = 10.0
MARKS = {"crunode": "o", "cusp": "^"}


def plot_coupler_curve(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw coupler curves of one linkage in several states, their double points and the pins.

    As Singh & Sanyal 2022, Figures 3 to 12.

    Parameters
    ----------
    dataset : Dataset
        With ``position`` (state, crank_angle, component), ``pin_position`` (state, crank_angle,
        pin, component) and ``double_point_position`` (double_point, component) in m, the state
        and kind of each double point as coordinates, and the name of the mechanism. Where there
        are loops, ``close_up`` (state, window, point, component) are fine stretches of the
        paths around them and ``framed`` (framed_place, component) what must be seen, in m.
    ax : sequence of Axes, optional
        The user's, one a panel. Left out: a new figure is made.

    Returns
    -------
    Figure
        Curves; a close-up of their loops where there are any; paths of A and B.

    Raises
    ------
    InputError
        If there are no states, or more than there are styles to tell them apart.
    """
    states, angles = told_apart(names_of(dataset, "state")), degrees(dataset["crank_angle"])
    curves = values_of(dataset["position"], "state", "crank_angle", "component")[:, None]
    scale, unit = (1.0, "m") if np.ptp(curves, axis=2).max() > METRES else (1e3, "mm")
    pins = scale * values_of(dataset["pin_position"], "state", "pin", "crank_angle", "component")
    layout = grid(1, 3, HEIGHT_OF_THREE) if "close_up" in dataset else grid(1, 2, HEIGHT)
    with sheet(layout, ax=ax) as drawn:
        handles = series_handles(_counted(dataset, state) for state in states)
        # Beyond the crank angles drawn, marks stand off the lines.
        where = "" if np.ptp(angles) > 360.0 - 1e-4 else " of the whole curve"
        for kind, mark in MARKS.items():
            if kind in dataset["double_point_kind"].values:
                look = {"color": "black", "ls": "", "marker": mark, "mfc": "none"}
                handles.append(line_handle(kind + where, **look))
        curve = _is_curve(dataset)
        drawn.header(handles, "Coupler curve" if curve else "Path of a point", of=dataset)
        for axes in drawn.panels:
            axes.set_aspect("equal", adjustable="datalim")
            axes.set_box_aspect(1)
            axes.set(xlabel=f"x ({unit})", ylabel=f"y ({unit})", anchor="N")
        first, *middle, last = drawn.panels
        first.set_title("Coupler point" if curve else "Point")
        _draw_paths(first, scale * curves, angles)
        _draw_double_points(first, dataset, scale)
        for axes in middle:
            axes.set_title("Close-up of the loops")
            close = values_of(scale * dataset["close_up"], "state", "window", "point", "component")
            # Without marks: it is fine whatever the crank angles.
            _draw_paths(axes, close)
            _draw_double_points(axes, dataset, scale)
            _frame(axes, values_of(scale * dataset["framed"], "framed_place", "component"))
        names = names_of(dataset, "pin")
        pictured = "Pins A and B" if curve else "Ends of its link"
        last.set_title(pictured + _draw_linkage(last, dataset, scale))
        _draw_paths(last, pins, angles)
        _name_pins(last, names, pins[0])
    return drawn.figure


def plot_coupler_angles(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the angles of coupler and rocker against the crank's, and how they change.

    Parameters
    ----------
    dataset : Dataset
        With ``angle`` (state, crank_angle, link) in rad, unwrapped, of coupler and rocker, and
        the name of the mechanism. Changes are against the first state.
    ax : sequence of Axes, optional
        The user's, one a panel. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If there are no states, or more than there are styles to tell them apart.
    """
    states, angles = told_apart(names_of(dataset, "state")), degrees(dataset["crank_angle"])
    angle = np.degrees(values_of(dataset["angle"], "link", "state", "crank_angle"))
    change = angle - angle[:, :1]
    # Two unwrapped angles may be whole turns apart.
    change -= 360.0 * np.round(change.mean(axis=-1, keepdims=True) / 360.0)
    rows = 2 if len(states) > 1 else 1
    layout = grid(rows, 2, ANGLE_HEIGHT if rows > 1 else ANGLE_HEIGHT / 2 + 0.5, sharex=True)
    with sheet(layout, ax=ax) as drawn:
        drawn.header(series_handles(states), "Angles of coupler and rocker", of=dataset)
        for place, axes in enumerate(drawn.panels):
            row, link = divmod(place, 2)
            symbol = rf"$\theta_{link + 3}$"
            if row == 0:
                axes.set_title(f"{names_of(dataset, 'link')[link].capitalize()}, {symbol}")
            else:
                axes.axhline(0.0, color=style.MID_GREY, lw=0.6, zorder=1)
            for number in range(row, len(states)):
                values = (angle, change)[row][link, number]
                axes.plot(angles, values, **series_line(number, angles))
            scales.plain_numbers(axes)
            scales.crank_angle_axis(axes, angles)
            axes.set_ylabel(f"{('', 'Change of ')[row]}{symbol} (deg)")
        drawn.label_x("Crank angle (deg)")
    return drawn.figure


def _is_curve(dataset: xr.Dataset) -> bool:
    """Whether it is of a four-bar's coupler, between pins A and B."""
    return names_of(dataset, "pin") == ["A", "B"]


def _counted(dataset: xr.Dataset, state: str) -> str:
    """A state and how many double points of each kind its curve has."""
    if not _is_curve(dataset):
        return state
    of_state = dataset["double_point_state"].values == state
    kinds = dataset["double_point_kind"].values[of_state].tolist()
    counts = [(kinds.count(kind), kind) for kind in MARKS]
    return f"{state}: " + ", ".join(f"{n} {kind}{'' if n == 1 else 's'}" for n, kind in counts)


def _draw_paths(axes: Axes, paths: FloatArray, angles: FloatArray | None = None) -> None:
    """Paths of states in parts; shape (state, part, point, component)."""
    for number, parts in enumerate(paths):
        axes.plot(parts[..., 0].T, parts[..., 1].T, **series_line(number, angles))


def _draw_double_points(axes: Axes, dataset: xr.Dataset, scale: float) -> None:
    states = names_of(dataset, "state")
    places = values_of(scale * dataset["double_point_position"], "double_point", "component")
    names = (names_of(dataset, f"double_point_{what}") for what in ("state", "kind"))
    for state, kind, place in zip(*names, places, strict=True):
        color = series_style(states.index(state)).color
        axes.plot(*place, marker=MARKS[kind], ms=6, mfc="none", color=color, zorder=4)


def _name_pins(axes: Axes, names: list[str], paths: FloatArray) -> None:
    """Write A and B over their paths; shape (pin, point, component)."""
    axes.margins(0.15)
    for name, path in zip(names, paths, strict=True):
        top = path[path[:, 1].argmax()]
        axes.annotate(name, top, xytext=(0, 5), textcoords="offset points", ha="center")


def _draw_linkage(axes: Axes, dataset: xr.Dataset, scale: float) -> str:
    """The linkage behind the paths where the dataset knows it, and at which crank angle it is."""
    found = drawn_posture(dataset)
    if found is None:
        return ""
    links, parts, angle = found
    sketch = LinkageSketch(links, parts, mark_size=SMALL)
    to_axes = Affine2D().scale(scale)
    add_symbols(axes, sketch.ground(), to_axes)
    for link, look in zip(links, sketch.link_looks(RIGID), strict=True):
        axes.plot(*(scale * link).T, **look, zorder=1)
    add_symbols(axes, sketch.on_links(), to_axes)
    return f", crank at {np.degrees(angle):.4g}°"


def _frame(axes: Axes, places: FloatArray) -> None:
    """Show places, with room around them."""
    middle = (places.max(axis=0) + places.min(axis=0)) / 2
    to_edges = CLOSE_UP_ROOM * np.ptp(places, axis=0).max() / 2 * np.array([-1.0, 1.0])
    axes.set(xlim=middle[0] + to_edges, ylim=middle[1] + to_edges)
