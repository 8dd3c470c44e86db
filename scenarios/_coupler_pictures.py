"""Pictures of coupler curves dry and in heat and moisture."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from _neat_resin import RESINS, rise_of
from _neat_resin_claims import CLAIMS, Shape
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexmech import CouplerCurve, plots
from flexmech.arrays import FloatArray
from flexmech.linkages import DoublePoint

STATES = ("dry", *RESINS)
SATURATIONS = {"R-914": "7 %", "8551-7": "2 %"}
# Of half the extent of loops and bends in the close-up: room for the branches beyond them.
MARGIN = 0.4


def distance(curves: Mapping[str, CouplerCurve], turn: FloatArray) -> dict[str, FloatArray]:
    """How far from its dry place the point is at the same crank angle, in m."""
    places = {name: curve.position(turn) for name, curve in curves.items()}
    return {n: np.hypot(*(places[n] - places["dry"]).T) for n in places if n != "dry"}


def draw(
    figure: str, curves: Mapping[str, CouplerCurve], shapes: Mapping[str, Shape], turn: FloatArray
) -> Figure:
    """Curves of a figure; beside them where their number of crunodes changes, or how far they move.

    Parameters
    ----------
    figure : str
    curves : mapping of str to CouplerCurve
    shapes : mapping of str to Shape
        Of the curves; empty where a pin's path is drawn.
    turn : ndarray, shape (A,)
        Crank angles in rad.

    Returns
    -------
    Figure
    """
    changes = len({len(shape.crunodes) for shape in shapes.values()}) > 1
    with plots.sheet(plots.grid(1, 2, 3.3)) as drawn:
        left, right = drawn.panels
        _draw_curves(left, curves, turn)
        _mark_crunodes(left, shapes)
        left.set_title(f"Path of {_point_name(figure)}")
        if changes:
            _draw_curves(right, curves, _finer(shapes, turn))
            _mark_crunodes(right, shapes)
            _mark_bends(right, curves, shapes)
            _close_up(right, curves, shapes)
        else:
            _draw_distance(right, distance(curves, turn), turn)
        title = f"Figure {figure} of Singh & Sanyal 2022: {CLAIMS[figure]}"
        drawn.header(_handles(figure, shapes, bends=changes), title)
    return drawn.figure


def _point_name(figure: str) -> str:
    pins = {"3": "pin A", "4": "pin B"}
    return pins.get(figure, "the coupler point")


def _handles(figure: str, shapes: Mapping[str, Shape], *, bends: bool) -> list[Artist]:
    handles: list[Artist] = []
    for number, name in enumerate(STATES):
        label = name if name == "dry" else f"{name}, +{rise_of(figure):g} K, {SATURATIONS[name]}"
        if shapes:
            count = len(shapes[name].crunodes)
            label += f" ({count} crunode{'' if count == 1 else 's'})"
        handles.append(plots.series_handle(number, label))
    mark: Any = {"color": "black", "linestyle": "none", "markersize": 5}
    if any(shape.crunodes for shape in shapes.values()):
        handles.append(plots.line_handle("crunode", marker="o", fillstyle="none", **mark))
    if bends:
        handles.append(
            plots.line_handle("sharpest bend, where there is no crunode", marker="x", **mark)
        )
    return handles


def _draw_curves(axes: Axes, curves: Mapping[str, CouplerCurve], turn: FloatArray) -> None:
    for number, name in enumerate(STATES):
        axes.plot(*(1e3 * curves[name].position(turn).T), **plots.series_line(number))
    axes.set_xlabel("x (mm)")
    axes.set_ylabel("y (mm)")
    axes.set_aspect("equal", adjustable="datalim")


def _finer(shapes: Mapping[str, Shape], turn: FloatArray) -> FloatArray:
    """Crank angles with many more near the sharpest bends."""
    near = np.linspace(-0.05, 0.05, 801)
    return np.sort(np.concatenate([turn, *(shape.bend_angle + near for shape in shapes.values())]))


def _mark_crunodes(axes: Axes, shapes: Mapping[str, Shape]) -> None:
    for number, name in enumerate(STATES):
        for double in shapes[name].crunodes if shapes else ():
            axes.plot(
                *(1e3 * double.position),
                "o",
                fillstyle="none",
                color=plots.series_style(number).color,
                markersize=5,
            )


def _mark_bends(
    axes: Axes, curves: Mapping[str, CouplerCurve], shapes: Mapping[str, Shape]
) -> None:
    for number, name in enumerate(STATES):
        if not shapes[name].crunodes:
            x, y = 1e3 * curves[name].position(shapes[name].bend_angle)
            axes.plot(x, y, "x", color=plots.series_style(number).color, markersize=5)


def _close_up(axes: Axes, curves: Mapping[str, CouplerCurve], shapes: Mapping[str, Shape]) -> None:
    """Show loops and sharpest bends of all states."""
    parts = []
    for name, shape in shapes.items():
        spans = [_loop(double) for double in shape.crunodes] or [np.array([shape.bend_angle])]
        parts += [1e3 * curves[name].position(span) for span in spans]
    seen = np.concatenate(parts)
    middle, half = (seen.max(axis=0) + seen.min(axis=0)) / 2, np.ptp(seen, axis=0).max() / 2
    axes.set_aspect("equal", adjustable="box")
    axes.set_box_aspect(1)
    half *= 1 + MARGIN
    axes.set_xlim(middle[0] - half, middle[0] + half)
    axes.set_ylim(middle[1] - half, middle[1] + half)
    axes.set_title("Close-up")


def _loop(double: DoublePoint) -> FloatArray:
    """Crank angles of the shorter way between the two passages of a crunode."""
    first, second = double.crank_angles
    if second - first > np.pi:
        first, second = second, first + 2 * np.pi
    return np.linspace(first, second, 181)


def _draw_distance(axes: Axes, distance: Mapping[str, FloatArray], turn: FloatArray) -> None:
    degrees = np.degrees(turn)
    for number, name in enumerate(STATES):
        if name in distance:
            axes.plot(degrees, 1e3 * distance[name], **plots.series_line(number))
    axes.set_ylim(bottom=0.0)
    axes.set_xlabel("Crank angle (deg)")
    axes.set_ylabel("Distance from the dry place (mm)")
    axes.set_title("Moved at the same crank angle")
    plots.crank_angle_axis(axes, degrees, narrow=True)
