"""Mode shapes drawn on the linkage."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from flexmech.plots.reading import engine_label
from flexmech.plots.style import (
    FIGURE_WIDTH,
    LIGHT_GREY,
    TITLE_SIZE,
    header_height,
    header_legend,
    mode_label,
    new_figure,
    publication_style,
    series_handle,
    series_style,
    speed_label,
)
from flexmech.types import FloatArray

__all__ = ["plot_mode_shapes"]


PANELS_A_ROW = 4
POINTS_A_STATION = 4
# Largest displacement as drawn, as a fraction of the linkage's size.
ENLARGED_TO = 0.14
# Ends closer than this fraction of the linkage's size share a joint.
SAME_PLACE = 1e-6
# An end that moves less than this fraction of the largest displacement in every mode is held.
AT_REST = 1e-6


def plot_mode_shapes(dataset: xr.Dataset, check_angle: float | None = None) -> Figure:
    """Draw each mode on the linkage, with the shape at every crank speed on top of another.

    As Kumar and Chandrakar's Figures 1.7-1.9 and 2.3-2.8: the rigid linkage in grey and the
    deflected one, enlarged. A complex shape is turned in phase until its largest component
    is real, and its real part is drawn; signs are those that match the first speed.

    Parameters
    ----------
    dataset : Dataset
        Of a ``MovingFrequencies`` result. The first engine's shapes are drawn.
    check_angle : float, optional
        Crank angle in rad; the nearest angle with stored shapes is taken. Default the first.

    Returns
    -------
    Figure
    """
    angles = dataset["check_angle"].values.astype(float)
    nearest = 0 if check_angle is None else int(np.argmin(np.abs(angles - check_angle)))
    with publication_style():
        sketch = _Sketch.of(dataset, nearest)
        deflected = _smooth(sketch.rigid + ENLARGED_TO * sketch.size * sketch.shapes)
        frequency = dataset["frequency"].isel(engine=0)
        frequency = frequency.sel(crank_angle=angles[nearest], method="nearest")
        frequency = frequency.transpose("crank_speed", "mode")
        limits = _limits(deflected, sketch)
        handles = _handles(dataset)
        header = (
            f"Mode shapes at crank angle {np.degrees(angles[nearest]):.4g}° by "
            f"{engine_label(dataset, 0)}, displacement enlarged"
        )
        panels = _panels(limits, deflected.shape[1], deflected.shape[0])
        panels.figure.set_figheight(panels.figure.get_figheight() + header_height(handles, header))
        for mode, axes in enumerate(panels.axes):
            axes.set(xlim=limits[0], ylim=limits[1], aspect="equal", anchor="N")
            axes.set_axis_off()
            heading = mode_label([int(dataset["mode"].values[mode])])
            title = f"{heading}\n{_frequencies_text(frequency.values[:, mode])}"
            axes.set_title(title, loc="center", fontsize=TITLE_SIZE - 1, linespacing=1.3)
            _draw_rigid(axes, sketch)
            _draw_deflected(axes, deflected[:, mode], sketch)
        _draw_scale_bar(panels.axes[0], sketch.size, limits)
        header_legend(panels.figure, handles, header)
    return panels.figure


@dataclass(frozen=True)
class _Panels:
    figure: Figure
    axes: list[Axes]


@dataclass(frozen=True)
class _Sketch:
    """What there is to draw at one crank angle.

    Parameters
    ----------
    rigid : ndarray, shape (link, station, 2)
        In m.
    shapes : ndarray, shape (crank_speed, mode, link, station, 2)
        Real displacements, the largest of each shape 1.
    size : float
        Diagonal of the box around the linkage, in m.
    pins, supports : ndarray, shape (n, 2)
        Joints between links and joints with the ground, in m.
    hub_radius : float
        Distance of the first link's start from the shaft's axis, in m.
    """

    rigid: FloatArray
    shapes: FloatArray
    size: float
    pins: FloatArray
    supports: FloatArray
    hub_radius: float

    @classmethod
    def of(cls, dataset: xr.Dataset, check: int) -> _Sketch:
        rigid = dataset["rigid_position"].isel(check_angle=check)
        rigid_values = rigid.transpose("link", "station", "component").values.astype(float)
        stored = dataset["mode_shape"].isel(engine=0, check_angle=check)
        stored = stored.transpose("part", "crank_speed", "mode", "link", "station", "component")
        shapes = _real_shapes(
            stored.sel(part="real").values + 1j * stored.sel(part="imaginary").values
        )
        corners = rigid_values.reshape(-1, 2)
        size = float(np.hypot(*(corners.max(axis=0) - corners.min(axis=0))))
        pins, supports = _joints(rigid_values, shapes, size)
        # By convention the first link is the driven one, on a shaft at the ground's origin.
        hub_radius = float(np.hypot(*rigid_values[0, 0]))
        if hub_radius > SAME_PLACE * size:
            # The hub turns: the ground holds it at the axis, not where the link is clamped.
            supports = np.concatenate([np.zeros((1, 2)), supports[1:]])
        return cls(rigid_values, shapes, size, pins, supports, hub_radius)


def _real_shapes(complex_shapes: NDArray[np.complex128]) -> FloatArray:
    """Turn each shape's phase until its largest component is real; match the first speed.

    Shape (crank_speed, mode, ...) -> the same, real, with largest displacement 1.
    """
    n_speeds, n_modes = complex_shapes.shape[:2]
    flat = complex_shapes.reshape(n_speeds, n_modes, -1)
    place = np.argmax(np.abs(flat), axis=-1)[..., None]
    largest = np.take_along_axis(flat, place, axis=-1)
    magnitude = np.abs(largest)
    turn = np.where(magnitude > 0, np.conj(largest) / np.where(magnitude > 0, magnitude, 1), 1)
    real = (flat * turn).real
    signs = np.where(np.sum(real * real[:1], axis=-1, keepdims=True) < 0, -1.0, 1.0)
    shapes = (signs * real).reshape(complex_shapes.shape)
    longest = np.hypot(shapes[..., 0], shapes[..., 1]).max(axis=(-2, -1))
    scaled: FloatArray = shapes / np.where(longest > 0, longest, 1.0)[..., None, None, None]
    return scaled


def _smooth(deflected: FloatArray) -> FloatArray:
    """Cubic spline through the stations of each link, which stay among the points drawn."""
    stations = deflected.shape[-2]
    points = np.linspace(0, stations - 1, (stations - 1) * POINTS_A_STATION + 1)
    curve: FloatArray = CubicSpline(np.arange(stations), deflected, axis=-2)(points)
    return curve


def _joints(rigid: FloatArray, shapes: FloatArray, size: float) -> tuple[FloatArray, FloatArray]:
    """Where link ends meet (pins) and where one is held and moves in no mode (supports)."""
    ends = rigid[:, [0, -1]].reshape(-1, 2)
    moves = np.abs(shapes[..., [0, -1], :]).max(axis=(0, 1, -1)).ravel() > AT_REST
    pins: list[FloatArray] = []
    supports: list[FloatArray] = []
    for number, place in enumerate(ends):
        together = np.hypot(*(ends - place).T) <= SAME_PLACE * size
        if np.flatnonzero(together)[0] != number:
            continue
        if not moves[number]:
            supports.append(place)
        elif together.sum() > 1:
            pins.append(place)
    return np.reshape(pins, (-1, 2)), np.reshape(supports, (-1, 2))


def _limits(
    deflected: FloatArray, sketch: _Sketch
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Box around all that is drawn, with room for the supports and the scale bar below."""
    points = [deflected.reshape(-1, 2), sketch.rigid.reshape(-1, 2)]
    if sketch.hub_radius > SAME_PLACE * sketch.size:
        points.append(sketch.hub_radius * np.array([[-1.0, -1.0], [1.0, 1.0]]))
    corners = np.concatenate(points)
    (left, low), (right, high) = corners.min(axis=0), corners.max(axis=0)
    room = 0.05 * sketch.size
    return (left - room, right + room), (low - 3.4 * room, high + room)


def _panels(
    limits: tuple[tuple[float, float], tuple[float, float]], n_modes: int, n_speeds: int
) -> _Panels:
    """Figure whose height fits panels of equal scale, without the legend."""
    columns = min(n_modes, PANELS_A_ROW)
    if n_modes > PANELS_A_ROW:
        columns = PANELS_A_ROW if n_modes > 6 else 3
    rows = -(-n_modes // columns)
    (left, right), (low, high) = limits
    # Less the layout's padding between the panels.
    tall = (FIGURE_WIDTH / columns - 0.2) * (high - low) / (right - left)
    tall = min(max(tall, 0.7), 2.6)
    title = 0.2 + 0.17 * -(-n_speeds // 3)
    figure = new_figure(rows * (tall + title))
    grid = figure.add_gridspec(rows, columns)
    axes = [figure.add_subplot(grid[n // columns, n % columns]) for n in range(n_modes)]
    return _Panels(figure, axes)


def _frequencies_text(frequency: FloatArray) -> str:
    """Frequencies by speed in the legend's order, three a line."""
    largest = float(np.nanmax(np.abs(frequency), initial=1e-3))
    decimals = max(0, 3 - int(np.floor(np.log10(largest))))
    texts = [f"{value:.{decimals}f}" for value in frequency]
    lines = [" / ".join(texts[start : start + 3]) for start in range(0, len(texts), 3)]
    return " /\n".join(lines) + " Hz"


def _draw_rigid(axes: Axes, sketch: _Sketch) -> None:
    if sketch.hub_radius > SAME_PLACE * sketch.size:
        axes.add_patch(Circle((0, 0), sketch.hub_radius, color=LIGHT_GREY, lw=0, zorder=0.5))
    for link in sketch.rigid:
        axes.plot(link[:, 0], link[:, 1], color="0.65", lw=0.9, zorder=1)
    for place in sketch.supports:
        _draw_support(axes, place, sketch.size)
    # The driven shaft, to which its link is clamped, is filled; a pin is open.
    joints = np.concatenate([sketch.supports, sketch.pins])
    for place in joints:
        fill = "0.35" if np.hypot(*place) <= SAME_PLACE * sketch.size else "white"
        axes.plot(
            *place, "o", ms=3.6, markerfacecolor=fill, markeredgecolor="0.35", mew=0.7, zorder=4
        )


def _draw_support(axes: Axes, place: FloatArray, size: float) -> None:
    """Triangle on a hatched ground line, under the joint."""
    half, deep = 0.028 * size, 0.05 * size
    x, y = place
    axes.plot(
        [x, x - half, x + half, x], [y, y - deep, y - deep, y], color="0.35", lw=0.7, zorder=0.8
    )
    axes.plot([x - 1.7 * half, x + 1.7 * half], [y - deep] * 2, color="0.35", lw=0.9, zorder=0.8)
    for start in np.linspace(-1.2, 1.7, 5) * half:
        axes.plot(
            [x + start, x + start - 0.55 * half],
            [y - deep, y - deep - 0.6 * half],
            color="0.35",
            lw=0.5,
            zorder=0.8,
        )


def _draw_deflected(axes: Axes, deflected: FloatArray, sketch: _Sketch) -> None:
    """Deflected links by speed; shape (crank_speed, link, station, 2)."""
    for number, shape in enumerate(deflected):
        style = series_style(number)
        for link in shape:
            axes.plot(
                link[:, 0],
                link[:, 1],
                color=style.color,
                linestyle=style.linestyle,
                lw=_line_width(number, len(deflected)),
                zorder=2 + 0.1 * number,
            )


def _line_width(number: int, total: int) -> float:
    """Each speed thinner than the one before, so that coinciding shapes stay visible."""
    return float(np.linspace(min(1.2 + 0.8 * (total - 1), 3.6), 1.2, total)[number])


def _draw_scale_bar(
    axes: Axes, size: float, limits: tuple[tuple[float, float], tuple[float, float]]
) -> None:
    """Bar of a round length in mm, at the lower left."""
    wanted = 0.3 * size * 1e3
    decade = 10.0 ** np.floor(np.log10(wanted))
    length = decade * max(step for step in (1, 2, 5) if step * decade <= wanted * (1 + 1e-9))
    (left, right), (low, _) = limits
    start = (left + right - length * 1e-3) / 2
    height = low + 0.03 * size
    axes.plot([start, start + length * 1e-3], [height, height], color="black", lw=1.6)
    axes.text(
        start + length * 0.5e-3, height + 0.012 * size, f"{length:g} mm", fontsize=7, ha="center"
    )


def _handles(dataset: xr.Dataset) -> list[Artist]:
    speeds = dataset["crank_speed"].values
    handles: list[Artist] = [
        series_handle(n, speed_label(float(speed)), linewidth=_line_width(n, len(speeds)))
        for n, speed in enumerate(speeds)
    ]
    handles.append(Line2D([], [], color="0.65", lw=0.9, label="rigid linkage"))
    return handles
