"""Natural frequencies against crank angle, by crank speed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from flexmech.plots.panels import (
    contiguous_runs,
    degrees,
    grid_height,
    mode_groups,
    panel_grid,
)
from flexmech.plots.style import (
    MID_GREY,
    POINT_SIZE,
    few_points,
    header_height,
    header_legend,
    mode_label,
    new_figure,
    plain_numbers,
    publication_style,
    series_handle,
    series_style,
    speed_label,
)
from flexmech.types import FloatArray, IntArray

__all__ = ["engine_label", "plot_frequencies"]


# The second engine's markers: enough to judge by, few enough to see the lines through.
MARKERS_ALONG_ANGLE = 12
MARK_SIZE = 4.2
# Narrowest y axis as a fraction of the frequency: below it one would look at round-off.
LEAST_BAND = 4e-3
# Veering can last for a large part of the turn: a strip of this part of a mode's height.
VEERING_STRIP = 0.035
STRIP_GREY = "0.72"


def plot_frequencies(dataset: xr.Dataset) -> Figure:
    """Draw natural frequencies against crank angle, one panel a mode, one line a speed.

    Modes lie far apart and the crank speed moves them by about one per cent, so each mode
    has a panel with its own frequency axis. Modes between which a tracked branch passes
    (crossing or veering) share a panel, in which each line follows a branch and is numbered
    by it at its right end. The first engine is drawn as lines, the second as markers;
    a grey strip on the crank-angle axis shows where veering was flagged.

    Parameters
    ----------
    dataset : Dataset
        Of a ``MovingFrequencies`` result; frequencies in Hz, angles in rad, speeds in rad/s.

    Returns
    -------
    Figure
    """
    with publication_style():
        dataset = dataset.sortby("crank_angle")
        groups = mode_groups(dataset)
        sizes = [len(group) for group in groups]
        map_ = _FrequencyMap.of(dataset)
        handles = _speed_handles(dataset) + _engine_handles(dataset, bool(map_.veering[0].any()))
        figure = new_figure(grid_height(sizes) + header_height(handles))
        panels = panel_grid(figure, sizes, map_.angles, "Frequency (Hz)")
        numbers = [int(number) for number in dataset["mode"].values]
        for axes, group in zip(panels, groups, strict=True):
            axes.set_title(mode_label([numbers[mode] for mode in group]))
            _scale_frequency(axes, map_.frequency[..., group])
            _mark_veering(axes, map_, group)
            _draw_lines(axes, map_, group)
            _draw_markers(axes, map_, group)
            if len(group) > 1:
                _number_branches(axes, map_, group)
        header_legend(figure, handles)
    return figure


@dataclass(frozen=True)
class _FrequencyMap:
    """Arrays of the dataset in a known order of dimensions.

    ``angles`` are degrees; the other arrays have the dimensions engine, crank speed, crank
    angle, mode.
    """

    angles: FloatArray
    frequency: FloatArray
    branch: IntArray
    veering: NDArray[np.bool_]

    @classmethod
    def of(cls, dataset: xr.Dataset) -> _FrequencyMap:
        order = ("engine", "crank_speed", "crank_angle", "mode")
        return cls(
            angles=degrees(dataset["crank_angle"]),
            frequency=dataset["frequency"].transpose(*order).values,
            branch=dataset["branch_of_mode"].transpose(*order).values,
            veering=dataset["veering"].transpose(*order).values.astype(bool),
        )


def engine_label(dataset: xr.Dataset, engine: int) -> str:
    """Name of an engine with its element, for legends."""
    name = str(dataset["engine"].values[engine])
    if "element" in dataset.coords and dataset["element"].dims == ("engine",):
        return f"{name} ({dataset['element'].values[engine]})"
    return name


def _scale_frequency(axes: Axes, frequency: FloatArray) -> None:
    low, high = float(np.nanmin(frequency)), float(np.nanmax(frequency))
    middle = (low + high) / 2
    span = max(high - low, LEAST_BAND * abs(middle), 1e-9)
    axes.set_ylim(middle - 0.58 * span, middle + 0.58 * span)
    plain_numbers(axes)


def _mark_veering(axes: Axes, map_: _FrequencyMap, group: list[int]) -> None:
    """Grey strip along the axis where the first engine veers in these modes at any speed."""
    flags = np.any(map_.veering[0][..., group], axis=(0, 2))
    # A flagged angle stands for the interval half way to its neighbours.
    edges = np.concatenate(
        [map_.angles[:1], (map_.angles[1:] + map_.angles[:-1]) / 2, map_.angles[-1:]]
    )
    for first, last in contiguous_runs(flags):
        axes.axvspan(
            edges[first],
            edges[last + 1],
            ymax=VEERING_STRIP / len(group),
            color=STRIP_GREY,
            lw=0,
            zorder=0,
        )


def _lines_of(frequency: FloatArray, branch: IntArray, group: list[int]) -> dict[int, FloatArray]:
    """Frequency of each line in a panel over the angles, by branch where branches meet.

    A line that leaves the panel is nan there. With one mode in the panel there is one line,
    numbered 0: sorted frequencies do not jump.
    """
    if len(group) == 1:
        return {0: frequency[:, group[0]]}
    inside, numbers = frequency[:, group], branch[:, group]
    lines = {}
    for number in np.unique(numbers):
        here = numbers == number
        values = np.where(here, inside, 0.0).sum(axis=1)
        lines[int(number)] = np.where(here.any(axis=1), values, np.nan)
    return lines


def _draw_lines(axes: Axes, map_: _FrequencyMap, group: list[int]) -> None:
    """First engine: a line for each speed and branch, with a point where it is alone."""
    marked = few_points(map_.angles)
    for number in range(map_.frequency.shape[1]):
        style = series_style(number)
        lines = _lines_of(map_.frequency[0, number], map_.branch[0, number], group)
        for values in lines.values():
            axes.plot(
                map_.angles,
                values,
                color=style.color,
                linestyle=style.linestyle,
                marker=style.marker if marked else "",
                markersize=POINT_SIZE,
                zorder=2.5,
            )
            alone = _alone(values)
            if not marked and alone.any():
                axes.plot(map_.angles[alone], values[alone], ".", color=style.color, ms=3)


def _alone(values: FloatArray) -> NDArray[np.bool_]:
    """Points with a value whose neighbours have none: a line would not show them."""
    present = np.concatenate([[False], np.isfinite(values), [False]])
    isolated: NDArray[np.bool_] = present[1:-1] & ~present[:-2] & ~present[2:]
    return isolated


def _draw_markers(axes: Axes, map_: _FrequencyMap, group: list[int]) -> None:
    """Further engines: open markers at some angles, staggered from speed to speed."""
    n_engines, n_speeds, n_angles, _ = map_.frequency.shape
    coarse = few_points(map_.angles)
    step = 1 if coarse else max(1, -(-n_angles // MARKERS_ALONG_ANGLE))
    for engine in range(1, n_engines):
        for number in range(n_speeds):
            style = series_style(number)
            chosen = np.arange((number * step) // n_speeds, n_angles, step)
            values = map_.frequency[engine, number][chosen][:, group]
            axes.plot(
                np.repeat(map_.angles[chosen], len(group)),
                values.ravel(),
                linestyle="",
                marker=style.marker,
                # On a coarse map the first engine has marks too: ring them.
                markersize=1.5 * MARK_SIZE if coarse else MARK_SIZE,
                markerfacecolor="white" if engine == 1 else style.color,
                markeredgecolor=style.color,
                markeredgewidth=0.9,
                clip_on=False,
                zorder=2.4,
            )


def _number_branches(axes: Axes, map_: _FrequencyMap, group: list[int]) -> None:
    """Write each branch's number beside the right end of its lines, spread to be read."""
    lines = _lines_of(map_.frequency[0, 0], map_.branch[0, 0], group)
    ends = {number: values[-1] for number, values in lines.items() if np.isfinite(values[-1])}
    low, high = axes.get_ylim()
    least = (high - low) * 0.07
    height = -np.inf
    for number in sorted(ends, key=lambda key: float(ends[key])):
        height = max(float(ends[number]), height + least)
        axes.annotate(
            f"branch {number}",
            xy=(1.0, height),
            xycoords=("axes fraction", "data"),
            xytext=(6, 0),
            textcoords="offset points",
            va="center",
            fontsize=7,
            color=MID_GREY,
        )


def _speed_handles(dataset: xr.Dataset) -> list[Artist]:
    # The marks of the second engine if there is one, else of a coarse map.
    marked = dataset.sizes["engine"] > 1 or few_points(dataset["crank_angle"].values)
    fill = "white" if dataset.sizes["engine"] > 1 else None
    return [
        series_handle(
            number,
            speed_label(float(speed)),
            marker=series_style(number).marker if marked else "",
            markersize=MARK_SIZE,
            markerfacecolor=fill,
            markeredgewidth=0.9,
        )
        for number, speed in enumerate(dataset["crank_speed"].values)
    ]


def _engine_handles(dataset: xr.Dataset, veers: bool) -> list[Artist]:
    """Legend entries of the engines and of the veering strip, only as far as they are drawn."""
    dot = "o" if few_points(dataset["crank_angle"].values) else ""
    line = Line2D([], [], color=MID_GREY, marker=dot, ms=POINT_SIZE)
    line.set_label(engine_label(dataset, 0))
    handles: list[Artist] = [line]
    for engine in range(1, dataset.sizes["engine"]):
        fill = "white" if engine == 1 else MID_GREY
        marks = Line2D(
            [], [], color=MID_GREY, ls="", marker="o", ms=MARK_SIZE, markerfacecolor=fill
        )
        marks.set_label(engine_label(dataset, engine))
        handles.append(marks)
    if veers:
        handles.append(Patch(color=STRIP_GREY, lw=0, label="veering"))
    return handles
