"""Damping ratio by modal strain energy against crank angle."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from flexmech.errors import InputError
from flexmech.plots.frequencies import engine_label
from flexmech.plots.panels import contiguous_runs, degrees, grid_height, panel_grid
from flexmech.plots.style import (
    MID_GREY,
    POINT_SIZE,
    few_points,
    header_height,
    header_legend,
    new_figure,
    plain_numbers,
    publication_style,
    series_handle,
    series_style,
    speed_label,
)
from flexmech.types import FloatArray, IntArray

__all__ = ["plot_modal_damping"]


# The second engine's markers: enough to judge by, few enough to see the lines through.
MARKERS_ALONG_ANGLE = 12
MARK_SIZE = 4.2
# More panels than these are too many to compare.
MOST_SPEEDS = 6
# Narrowest y axis as a fraction of the largest ratio: below it one would look at round-off.
LEAST_BAND = 0.02


def plot_modal_damping(dataset: xr.Dataset) -> Figure:
    """Draw the damping ratio by modal strain energy, one panel a speed, one line a mode.

    Modes are in order of frequency at each angle. Where two of them change places a line
    breaks off and goes on elsewhere: it does not join the damping of different vibrations.
    The first engine is drawn as lines, the others as markers. Of more than six speeds, six
    are drawn, evenly spread.

    Parameters
    ----------
    dataset : Dataset
        Of a ``MovingFrequencies`` result of a mechanism with specific damping.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If the dataset has no ``strain_energy_damping``.
    """
    if "strain_energy_damping" not in dataset:
        raise InputError(
            "this result has no damping by modal strain energy: give the mechanism sections "
            "with specific damping, then compute moving_frequencies"
        )
    with publication_style():
        dataset = _few_speeds(dataset.sortby("crank_angle"))
        order = ("engine", "crank_speed", "crank_angle", "mode")
        percent = 100.0 * dataset["strain_energy_damping"].transpose(*order).values
        branch = dataset["branch_of_mode"].transpose(*order).values
        angles = degrees(dataset["crank_angle"])
        handles = _handles(dataset)
        sizes = [1] * dataset.sizes["crank_speed"]
        title = "Damping by modal strain energy"
        figure = new_figure(grid_height(sizes) + header_height(handles, title))
        panels = panel_grid(figure, sizes, angles, "Damping ratio (%)", share_y=True)
        _scale(panels[0], percent)
        for speed, axes in enumerate(panels):
            axes.set_title(speed_label(float(dataset["crank_speed"].values[speed])))
            _draw_lines(axes, angles, percent[0, speed], branch[0, speed])
            _draw_markers(axes, angles, percent[1:, speed])
        header_legend(figure, handles, title)
    return figure


def _few_speeds(dataset: xr.Dataset) -> xr.Dataset:
    """At most so many speeds, the first and the last among them."""
    count = dataset.sizes["crank_speed"]
    places = np.round(np.linspace(0, count - 1, min(count, MOST_SPEEDS))).astype(int)
    return dataset.isel(crank_speed=places)


def _scale(axes: Axes, percent: FloatArray) -> None:
    low, high = float(np.nanmin(percent)), float(np.nanmax(percent))
    span = max(high - low, LEAST_BAND * high, 1e-9)
    axes.set_ylim((low + high) / 2 - 0.58 * span, (low + high) / 2 + 0.58 * span)
    plain_numbers(axes)


def _runs(branch: IntArray) -> Iterator[slice]:
    """Stretches of neighbouring angles where a mode stays on one branch."""
    for number in np.unique(branch):
        for first, last in contiguous_runs(branch == number):
            yield slice(first, last + 1)


def _draw_lines(axes: Axes, angles: FloatArray, percent: FloatArray, branch: IntArray) -> None:
    """First engine; shape (crank_angle, mode)."""
    marked = few_points(angles)
    for mode in range(percent.shape[1]):
        style = series_style(mode)
        for run in _runs(branch[:, mode]):
            alone = run.stop - run.start == 1
            axes.plot(
                angles[run],
                percent[run, mode],
                color=style.color,
                linestyle=style.linestyle,
                marker=style.marker if marked else "." if alone else "",
                markersize=POINT_SIZE,
                zorder=2.5,
            )


def _draw_markers(axes: Axes, angles: FloatArray, percent: FloatArray) -> None:
    """Further engines: open markers at some angles; shape (engine, crank_angle, mode)."""
    coarse = few_points(angles)
    step = 1 if coarse else max(1, -(-angles.size // MARKERS_ALONG_ANGLE))
    n_modes = percent.shape[2]
    for engine, values in enumerate(percent):
        for mode in range(n_modes):
            style = series_style(mode)
            chosen = np.arange((mode * step) // n_modes, angles.size, step)
            axes.plot(
                angles[chosen],
                values[chosen, mode],
                linestyle="",
                marker=style.marker,
                # On a coarse map the first engine has marks too: ring them.
                markersize=1.5 * MARK_SIZE if coarse else MARK_SIZE,
                markerfacecolor="white" if engine == 0 else style.color,
                markeredgecolor=style.color,
                markeredgewidth=0.9,
                clip_on=False,
                zorder=2.4,
            )


def _handles(dataset: xr.Dataset) -> list[Artist]:
    """Legend entries of the modes, then of the engines where there are several."""
    several = dataset.sizes["engine"] > 1
    marked = several or few_points(dataset["crank_angle"].values)
    handles: list[Artist] = [
        series_handle(
            number,
            f"mode {mode}",
            marker=series_style(number).marker if marked else "",
            markersize=MARK_SIZE,
            markerfacecolor="white" if several else None,
            markeredgewidth=0.9,
        )
        for number, mode in enumerate(dataset["mode"].values)
    ]
    for engine in range(dataset.sizes["engine"]):
        fill = "white" if engine == 1 else MID_GREY
        mark = Line2D([], [], color=MID_GREY, ls="", marker="o", ms=MARK_SIZE, mfc=fill)
        if engine == 0:
            mark.set(linestyle="-", marker="")
        mark.set_label(engine_label(dataset, engine))
        handles.append(mark)
    return handles
