"""How far two engines differ, against what each says of its own error."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter

from flexmech.errors import InputError
from flexmech.plots.frequencies import engine_label
from flexmech.plots.panels import degrees, grid_height, panel_grid
from flexmech.plots.style import (
    MID_GREY,
    POINT_SIZE,
    few_points,
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

__all__ = ["plot_agreement"]


# Zero has no place on a logarithmic axis: equal frequencies are drawn at about machine epsilon.
FLOOR = 1e-16
ERROR_MARKERS = ("x", "+")
ERROR_LINES = ((0.0, (4.0, 2.0)), (0.0, (1.0, 1.5)))


def plot_agreement(dataset: xr.Dataset) -> Figure:
    """Draw the relative difference of two engines against crank angle, one panel a mode.

    Grey are the discretisation errors that the engines estimate of themselves (the largest
    over the speeds): two engines on the same mesh can agree better than either is right, and
    they should not differ by much more than the sum of both.

    Parameters
    ----------
    dataset : Dataset
        Of a ``MovingFrequencies`` result with two engines.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If the dataset holds one engine only.
    """
    if dataset.sizes["engine"] < 2:
        raise InputError(
            "agreement needs two engines and this result has one "
            f"({engine_label(dataset, 0)}): compute with both"
        )
    with publication_style():
        dataset = dataset.sortby(["crank_angle", "check_angle"])
        difference = _relative_difference(dataset)
        angles = degrees(dataset["crank_angle"])
        marked = few_points(angles)
        title = f"Frequencies of {engine_label(dataset, 1)} against {engine_label(dataset, 0)}"
        handles = _handles(dataset, marked)
        sizes = [1] * dataset.sizes["mode"]
        figure = new_figure(grid_height(sizes) + header_height(handles, title))
        label = "Relative difference (-)"
        panels = panel_grid(figure, sizes, angles, label, share_y=True)
        for mode, axes in enumerate(panels):
            axes.set_title(mode_label([int(dataset["mode"].values[mode])]))
            for number in range(dataset.sizes["crank_speed"]):
                style = series_style(number)
                axes.plot(
                    angles,
                    difference[number, :, mode],
                    color=style.color,
                    linestyle=style.linestyle,
                    marker=style.marker if marked else "",
                    markersize=POINT_SIZE,
                )
            _draw_errors(axes, dataset, mode)
        _scale_logarithm(panels)
        header_legend(figure, handles, title)
    return figure


def _relative_difference(dataset: xr.Dataset) -> FloatArray:
    """|f_b / f_a - 1| of the first two engines; shape (speed, angle, mode)."""
    frequency = dataset["frequency"].transpose("engine", "crank_speed", "crank_angle", "mode")
    first, second = frequency.values[0], frequency.values[1]
    with np.errstate(divide="ignore", invalid="ignore"):
        difference: FloatArray = np.abs(second / first - 1)
    return np.where(np.isfinite(difference), np.maximum(difference, FLOOR), np.nan)


def _draw_errors(axes: Axes, dataset: xr.Dataset, mode: int) -> None:
    error = dataset["discretisation_error"].isel(mode=mode)
    error = error.transpose("engine", "crank_speed", "check_angle")
    # fmax ignores nan: an angle without an estimate at one speed may have it at another.
    largest = np.maximum(np.fmax.reduce(np.abs(error.values), axis=1), FLOOR)
    for engine in range(2):
        axes.plot(
            degrees(dataset["check_angle"]),
            largest[engine],
            color=MID_GREY,
            linestyle=ERROR_LINES[engine],
            lw=0.7,
            marker=ERROR_MARKERS[engine],
            markersize=4,
            markeredgewidth=0.8,
            zorder=1.5,
            clip_on=False,
        )


def _scale_logarithm(panels: list[Axes]) -> None:
    """Whole decades around all data of all panels, ticked at every one or every few."""
    values = np.concatenate(
        [[FLOOR], *(np.asarray(line.get_ydata(), dtype=float) for a in panels for line in a.lines)]
    )
    finite = np.isfinite(values)
    # The floor is there for a result without any finite value; else the data set the scale.
    decades = np.log10(values[finite][1:] if finite.sum() > 1 else values[:1])
    low, high = float(np.floor(decades.min())), float(np.ceil(decades.max()))
    high = max(high, low + 1)
    for axes in panels:
        axes.set_yscale("log")
        axes.set_ylim(10.0**low, 10.0**high)
        axes.yaxis.set_major_locator(LogLocator(base=10, numticks=7))
        axes.yaxis.set_minor_formatter(NullFormatter())


def _handles(dataset: xr.Dataset, marked: bool) -> list[Artist]:
    handles: list[Artist] = []
    for number, speed in enumerate(dataset["crank_speed"].values):
        marker = series_style(number).marker if marked else ""
        label = speed_label(float(speed))
        handles.append(series_handle(number, label, marker=marker, markersize=POINT_SIZE))
    for engine in range(2):
        error = Line2D([], [], color=MID_GREY, linestyle=ERROR_LINES[engine], lw=0.7)
        error.set_marker(ERROR_MARKERS[engine])
        error.set_markersize(4)
        error.set_label(f"estimated error of {dataset['engine'].values[engine]}")
        handles.append(error)
    return handles
