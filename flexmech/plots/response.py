"""Deflections and strains of the running linkage against time."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexmech.plots.reading import (
    LENGTH_UNITS,
    Units,
    engine_label,
    fitting_unit,
    link_label,
    names_of,
    run_title,
    values_of,
)
from flexmech.plots.sheet import AxesLike, sheet
from flexmech.plots.style import LIGHT_GREY, plain_numbers, series_handle, series_line
from flexmech.plots.time_axis import label_times, time_layout
from flexmech.types import FloatArray

__all__ = ["draw_engines", "engine_lines", "plot_response"]

STRAIN_UNITS: Units = ((1e6, "µm/m"),)

# Width of a line with at most so many turning points in a panel.
LINE_WIDTHS = ((80, 1.1), (350, 0.7), (np.inf, 0.5))
# Opacity of a line that turns at more than this part of its samples, which are many.
VEIL = 0.6
MOST_TURNING = 0.33
LEAST_VEILED = 100


def plot_response(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the deflection of each link, and bending strains in the middle, against time.

    One panel a link for the deflections: of a link's middle from the line between its pins,
    or of a clamped link's tip. Under them the bending strain of those links whose middle is
    watched. The axis on top gives the crank angle.

    Parameters
    ----------
    dataset : Dataset
        Of a ``Response`` result; m, s and rad.
    ax : Axes or sequence of Axes, optional
        The user's, one a panel. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    links = names_of(dataset, "link")
    strained = [name for name in links if dataset["probe"].sel(link=name) == "middle"]
    shown = [("deflection", name, LENGTH_UNITS) for name in links]
    shown += [("strain", name, STRAIN_UNITS) for name in strained]
    fewer = "choose one link that is watched at its tip (links=...)"
    with sheet(time_layout(len(shown)), ax=ax, fewer=fewer) as drawn:
        drawn.header(engine_lines(dataset), run_title(dataset))
        label_times(drawn, dataset)
        for axes, (quantity, link, units) in zip(drawn.panels, shown, strict=True):
            what = f"{link_label(dataset, link)}\n{quantity}"
            draw_engines(axes, dataset[quantity].sel(link=link), units, what)
    return drawn.figure


def engine_lines(dataset: xr.Dataset) -> list[Artist]:
    """Legend entries of engines that are all drawn as lines."""
    return [
        series_handle(number, engine_label(dataset, number))
        for number in range(dataset.sizes["engine"])
    ]


def draw_engines(axes: Axes, quantity: xr.DataArray, units: Units, what: str) -> float:
    """Draw a quantity of all engines against time, and scale the y axis to all of it.

    Lines become thinner the more vibrations stand side by side, and translucent where they
    are faster than the samples tell apart: a band through which other lines can be seen.

    Parameters
    ----------
    axes : Axes
    quantity : DataArray
        With dims engine and time, in its SI unit.
    units : tuple of (float, str)
        Factors and names of units that the axis may have.
    what : str
        Label of the axis, without the unit.

    Returns
    -------
    float
        Factor from the SI unit to that of the axis.
    """
    factor, unit = fitting_unit(quantity.values, units)
    lines = factor * values_of(quantity, "engine", "time")
    axes.axhline(0.0, color=LIGHT_GREY, lw=0.6, zorder=0)
    for number, line in enumerate(lines):
        width, opacity = _line_look(line)
        # What lies under a line must be seen between its dashes and beside them.
        wider = 1.4 if number < len(lines) - 1 and opacity == 1.0 else 1.0
        look = series_line(number)
        axes.plot(quantity["time"].values, line, **look, lw=wider * width, alpha=opacity)
    plain_numbers(axes)
    axes.set_ylabel(f"{what} ({unit})")
    return factor


def _line_look(line: FloatArray) -> tuple[float, float]:
    """Width and opacity of a line, by how often it turns."""
    turning_points = np.count_nonzero(np.diff(np.sign(np.diff(line))))
    width = next(width for most, width in LINE_WIDTHS if turning_points <= most)
    return width, VEIL if turning_points > max(MOST_TURNING * line.size, LEAST_VEILED) else 1.0
