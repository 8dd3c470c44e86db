"""How far the links' own vibration moves the natural frequencies."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from flexmech.plots.frequencies import engine_label
from flexmech.plots.panels import degrees
from flexmech.plots.style import (
    MID_GREY,
    SERIES_STYLES,
    crank_angle_axis,
    few_points,
    header_height,
    header_legend,
    mode_label,
    new_figure,
    plain_numbers,
    publication_style,
    series_style,
    speed_label,
)
from flexmech.types import FloatArray

__all__ = ["plot_vibration_effect"]


# Markers that tell the lines of the lowest panel, or the engines, apart without colour.
MARKERS_ALONG_ANGLE = 10
MARK_SIZE = 3.6
# Narrowest axes, of frequency as a fraction and of the difference in percent: below them
# one would look at round-off.
LEAST_BAND = 4e-3
LEAST_DIFFERENCE = 1e-3
SAME = 1e-12


def plot_vibration_effect(dataset: xr.Dataset) -> Figure:
    """Draw natural frequencies of the running linkage next to the quasi-static ones.

    For the highest crank speed: a panel a mode with the frequencies about the states that a
    simulation runs through (solid) and about the quasi-static equilibrium (dashed), and at
    the bottom their relative difference. Only engines in which the two differ are drawn; in
    a linear model vibration changes nothing. If none differs, the first engine is drawn.

    Parameters
    ----------
    dataset : Dataset
        With ``frequency`` and ``quasi_static_frequency`` (engine, crank_speed, crank_angle,
        mode) in Hz, angles in rad and speeds in rad/s.

    Returns
    -------
    Figure
    """
    with publication_style():
        dataset = dataset.sortby("crank_angle")
        fastest = int(np.argmax(np.abs(dataset["crank_speed"].values)))
        speed = float(dataset["crank_speed"].values[fastest])
        order = ("engine", "crank_angle", "mode")
        at_speed = dataset.isel(crank_speed=fastest)
        running = at_speed["frequency"].transpose(*order).values.astype(float)
        still = at_speed["quasi_static_frequency"].transpose(*order).values.astype(float)
        engines = _affected(running, still)
        names = [engine_label(dataset, engine) for engine in engines]
        angles = degrees(dataset["crank_angle"])
        modes = [int(number) for number in dataset["mode"].values]
        title = f"Natural frequencies at {speed_label(speed)}, {' and '.join(names)}"
        handles = _handles(modes, names)
        tall = max(0.85, 1.5 - 0.1 * len(modes))
        figure = new_figure(tall * len(modes) + 1.9 + header_height(handles, title))
        ratios = [tall] * len(modes) + [1.4]
        grid = figure.subplots(len(ratios), 1, sharex=True, height_ratios=ratios)
        for mode, axes in enumerate(grid[:-1]):
            axes.set_title(mode_label([modes[mode]]))
            axes.set_ylabel("Frequency\n(Hz)")
            drawn = running[engines, :, mode], still[engines, :, mode]
            _draw_frequencies(axes, angles, *drawn, series_style(mode).color)
        _draw_difference(grid[-1], angles, running[engines], still[engines])
        crank_angle_axis(grid[-1], angles)
        grid[-1].set_xlabel("Crank angle (deg)")
        figure.align_ylabels()
        header_legend(figure, handles, title)
    return figure


def _affected(running: FloatArray, still: FloatArray) -> list[int]:
    """Engines whose two frequencies differ, or the first engine."""
    differ = ~np.isclose(running, still, rtol=SAME, atol=0.0, equal_nan=True)
    numbers = np.flatnonzero(differ.any(axis=(1, 2)))
    return [int(number) for number in numbers] or [0]


def _marks(angles: FloatArray, number: int, total: int) -> slice:
    """Every so many points a marker, staggered from line to line."""
    step = 1 if few_points(angles) else max(1, angles.size // MARKERS_ALONG_ANGLE)
    # In the middle of its share, so that no mark is cut off by the axis.
    return slice(((2 * number + 1) * step) // (2 * total), None, step)


def _draw_frequencies(
    axes: Axes, angles: FloatArray, running: FloatArray, still: FloatArray, color: str
) -> None:
    """Both frequencies of a mode; shape (engine, crank_angle)."""
    coarse = few_points(angles)
    for number in range(len(running)):
        # One engine needs no marks to be told from others.
        mark = "so^D"[number % 4] if coarse or len(running) > 1 else ""
        every = _marks(angles, number, len(running))
        axes.plot(
            angles, running[number], color=color, marker=mark, ms=MARK_SIZE, markevery=every, lw=1.1
        )
        axes.plot(
            angles,
            still[number],
            color="0.2",
            ls=(0, (4.0, 2.0)),
            lw=0.9,
            marker=mark,
            ms=MARK_SIZE,
            mfc="white",
            markevery=every,
        )
    both = np.stack([running, still])
    low, high = float(np.nanmin(both)), float(np.nanmax(both))
    span = max(high - low, LEAST_BAND * abs(low + high) / 2, 1e-9)
    axes.set_ylim((low + high) / 2 - 0.58 * span, (low + high) / 2 + 0.58 * span)
    plain_numbers(axes)


def _draw_difference(
    axes: Axes, angles: FloatArray, running: FloatArray, still: FloatArray
) -> None:
    """Relative differences in percent; shape (engine, crank_angle, mode)."""
    percent = 100.0 * (running / still - 1.0)
    n_engines, _, n_modes = percent.shape
    axes.axhline(0.0, color=MID_GREY, lw=0.6, zorder=0)
    for engine in range(n_engines):
        for mode in range(n_modes):
            style = series_style(mode)
            axes.plot(
                angles,
                percent[engine, :, mode],
                color=style.color,
                lw=1.1,
                marker=style.marker,
                ms=MARK_SIZE,
                mfc=_fill(mode),
                ls="-" if engine == 0 else ":",
                markevery=_marks(angles, mode, n_modes),
            )
    low, high = min(float(np.nanmin(percent)), 0.0), max(float(np.nanmax(percent)), 0.0)
    span = max(high - low, LEAST_DIFFERENCE)
    axes.set_ylim((low + high) / 2 - 0.58 * span, (low + high) / 2 + 0.58 * span)
    axes.set_title("Running against quasi-static")
    axes.set_ylabel("Difference\n(%)")
    plain_numbers(axes)


def _fill(number: int) -> str:
    """Fill of a mode's marks: where the series' styles repeat, the marks are open."""
    return series_style(number).color if number < len(SERIES_STYLES) else "white"


def _handles(modes: list[int], names: list[str]) -> list[Artist]:
    """Legend entries: the two lines of the upper panels, then a colour and mark a mode."""
    handles: list[Artist] = [
        Line2D([], [], color="0.2", lw=1.1, label="running"),
        Line2D([], [], color="0.2", ls=(0, (4.0, 2.0)), lw=0.9, label="quasi-static"),
    ]
    if len(names) > 1:
        for number, name in enumerate(names):
            marker = "so^D"[number % 4]
            handles.append(
                Line2D([], [], color="0.2", ls="", marker=marker, ms=MARK_SIZE, label=name)
            )
    for number, mode in enumerate(modes):
        style = series_style(number)
        line = Line2D([], [], color=style.color, marker=style.marker, ms=MARK_SIZE)
        line.set(label=f"mode {mode}", markerfacecolor=_fill(number))
        handles.append(line)
    return handles
