"""The look of crank speeds: a style for each of a few, a colour map for many."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize

from flexmech.plots.labels import speed_unit
from flexmech.plots.layout import Sheet
from flexmech.plots.series import Look
from flexmech.units import from_si

FEW_SPEEDS = 5
"""More crank speeds than these are told by a colour map rather than by styles."""
# Of viridis, which is perceptually uniform and grows lighter throughout; its yellow end cannot be
# seen on white.
LIGHTEST = 0.9
COLOURS = LinearSegmentedColormap.from_list(
    "speeds", mpl.colormaps["viridis"](np.linspace(0.0, LIGHTEST, 256))
)
LINE: Look = {"linestyle": "-", "linewidth": 0.9}


def has_many_speeds(dataset: xr.Dataset) -> bool:
    """Whether a dataset has too many crank speeds for each to have a style of its own."""
    return bool(dataset.sizes["crank_speed"] > FEW_SPEEDS)


def speed_lines(dataset: xr.Dataset) -> list[Look]:
    """Properties of the line of each of many crank speeds, without marks.

    Parameters
    ----------
    dataset : Dataset

    Returns
    -------
    list of dict
        For ``Axes.plot``; a single crank angle is a dot.
    """
    mark = {"marker": "." if dataset.sizes["crank_angle"] == 1 else ""}
    mapped = _mappable(dataset)
    return [
        {**LINE, **mark, "color": mapped.to_rgba(speed)}
        for speed in dataset["crank_speed"].values.astype(float).tolist()
    ]


def colour_bar(drawn: Sheet, dataset: xr.Dataset) -> None:
    """Put the scale of the crank speeds' colours beside the panels.

    Parameters
    ----------
    drawn : Sheet
    dataset : Dataset
    """
    factor, mapped = from_si(1.0, speed_unit(dataset)), _mappable(dataset)
    mapped.set_clim(*(factor * end for end in mapped.get_clim()))
    bar = drawn.figure.colorbar(mapped, ax=drawn.panels, pad=0.02, aspect=30)
    bar.set_label(f"Crank speed ({speed_unit(dataset)})")
    bar.outline.set_linewidth(0.6)


def _mappable(dataset: xr.Dataset) -> ScalarMappable:
    speeds = dataset["crank_speed"].values.astype(float)
    return ScalarMappable(Normalize(float(speeds.min()), float(speeds.max())), COLOURS)
