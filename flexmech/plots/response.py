"""Deflections and strains of the running linkage against time."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexmech.plots.frequencies import engine_label
from flexmech.plots.style import (
    LIGHT_GREY,
    header_height,
    header_legend,
    new_figure,
    plain_numbers,
    publication_style,
    series_handle,
    series_style,
    speed_label,
)
from flexmech.plots.time_axis import time_panels, time_panels_height
from flexmech.types import FloatArray

__all__ = [
    "LENGTH_UNITS",
    "draw_engines",
    "engine_handles",
    "fitting_unit",
    "link_label",
    "plot_response",
    "run_title",
]

Units = tuple[tuple[float, str], ...]

LENGTH_UNITS: Units = ((1e3, "mm"), (1e6, "µm"), (1e9, "nm"))
"""Deflections are read in mm; an arm at constant speed hardly bends, and needs less."""
MICRO = 1e6
LEAST_NUMBER = 0.01

# Width of a line with at most so many turning points in a panel.
LINE_WIDTHS = ((80, 1.1), (350, 0.7), (np.inf, 0.5))
# Opacity of a line that turns at more than this part of its samples, which are many.
VEIL = 0.6
MOST_TURNING = 0.33
LEAST_VEILED = 100

STARTS = {
    "rigid": "from undeformed links",
    "equilibrium": "from the quasi-static equilibrium",
    "periodic": "on the periodic motion",
}


def plot_response(dataset: xr.Dataset) -> Figure:
    """Draw the deflection of each link, and bending strains in the middle, against time.

    One panel a link for the deflections: of a link's middle from the line between its pins,
    or of a clamped link's tip. Under them the bending strain of those links whose middle is
    watched. The axis on top gives the crank angle.

    Parameters
    ----------
    dataset : Dataset
        Of a ``Response`` result; m, s and rad.

    Returns
    -------
    Figure
    """
    with publication_style():
        links = [str(name) for name in dataset["link"].values]
        strained = [name for name in links if dataset["probe"].sel(link=name) == "middle"]
        handles, title = engine_handles(dataset), run_title(dataset)
        count = len(links) + len(strained)
        figure = new_figure(time_panels_height(count) + header_height(handles, title))
        panels = time_panels(figure, count, dataset)
        for axes, name in zip(panels, links, strict=False):
            deflection = dataset["deflection"].sel(link=name)
            factor, unit = fitting_unit(deflection.values, LENGTH_UNITS)
            draw_engines(axes, dataset, factor * deflection)
            axes.set_ylabel(f"{link_label(dataset, name)}\ndeflection ({unit})")
        for axes, name in zip(panels[len(links) :], strained, strict=True):
            draw_engines(axes, dataset, MICRO * dataset["strain"].sel(link=name))
            axes.set_ylabel(f"{link_label(dataset, name)}\nstrain (µm/m)")
        figure.align_ylabels()
        header_legend(figure, handles, title)
    return figure


def fitting_unit(values: FloatArray, units: Units) -> tuple[float, str]:
    """Unit in which values can be read: the first in which the largest is not too small.

    Parameters
    ----------
    values : ndarray
        In the base unit.
    units : tuple of (float, str)
        Factors from the base unit and names, the usual one first, smaller ones after it.

    Returns
    -------
    float, str
        Factor and name.
    """
    largest = float(np.nanmax(np.abs(values), initial=0.0))
    fitting = (unit for unit in units if largest * unit[0] >= LEAST_NUMBER)
    return next(fitting, units[0 if largest == 0 else -1])


def engine_handles(dataset: xr.Dataset) -> list[Artist]:
    """Legend entries of the engines."""
    return [
        series_handle(number, engine_label(dataset, number))
        for number in range(dataset.sizes["engine"])
    ]


def link_label(dataset: xr.Dataset, link: str) -> str:
    """Where on a link its deflection is watched, as in "Coupler middle"."""
    return f"{link.capitalize()} {dataset['probe'].sel(link=link).item()}"


def run_title(dataset: xr.Dataset) -> str:
    """Heading line that says what run is drawn: crank speed and start."""
    title = f"Response at {speed_label(float(dataset.attrs['crank_speed']))}"
    run_up = float(dataset.attrs.get("run_up_time", 0.0))
    if run_up > 0:
        title += f" after a run-up of {run_up:.3g} s"
    start = STARTS.get(str(dataset.attrs.get("start", "")))
    return f"{title}, {start}" if start else title


def draw_engines(axes: Axes, dataset: xr.Dataset, values: xr.DataArray) -> None:
    """Draw a quantity of all engines against time, and scale the y axis to all of it.

    Lines become thinner the more vibrations stand side by side, and translucent where they
    are faster than the samples tell apart: a band through which other lines can be seen.

    Parameters
    ----------
    axes : Axes
    dataset : Dataset
        With ``time``.
    values : DataArray
        With dims engine and time, in the panel's unit.
    """
    time = dataset["time"].values
    lines = values.transpose("engine", "time").values
    axes.axhline(0.0, color=LIGHT_GREY, lw=0.6, zorder=0)
    for number, line in enumerate(lines):
        style = series_style(number)
        turning_points = np.count_nonzero(np.diff(np.sign(np.diff(line))))
        width = next(width for most, width in LINE_WIDTHS if turning_points <= most)
        opacity = VEIL if turning_points > max(MOST_TURNING * line.size, LEAST_VEILED) else 1.0
        # What lies under a line must be seen between its dashes and beside them.
        wider = 1.4 if number < len(lines) - 1 and opacity == 1.0 else 1.0
        axes.plot(
            time,
            line,
            color=style.color,
            linestyle=style.linestyle,
            lw=wider * width,
            alpha=opacity,
        )
    plain_numbers(axes)
