"""Natural frequencies in heat and water beside the dry ones."""

from __future__ import annotations

from typing import Any

import xarray as xr
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from flexmech.plots.panels import degrees, grid_height, panel_grid
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
    series_style,
    speed_label,
)
from flexmech.types import FloatArray

__all__ = ["plot_hygrothermal_effect"]

_DRY: Any = {"linestyle": "-", "linewidth": 1.2}
_WET: Any = {"linestyle": (0.0, (4.0, 1.5)), "linewidth": 1.5}


def plot_hygrothermal_effect(dataset: xr.Dataset) -> Figure:
    """Draw the frequencies of both states against crank angle, one panel a mode.

    Parameters
    ----------
    dataset : Dataset
        Of a ``HygrothermalEffect``; Hz and rad. Its first engine is drawn, at every speed.

    Returns
    -------
    Figure
    """
    with publication_style():
        dataset = dataset.sortby("crank_angle").isel(engine=0)
        angles = degrees(dataset["crank_angle"])
        speeds = dataset["crank_speed"].values
        state = str(dataset.attrs.get("state", "wet"))
        title = f"Natural frequencies dry and in heat and moisture ({state})"
        marked = few_points(angles)
        handles = _handles(speeds)
        sizes = [1] * dataset.sizes["mode"]
        figure = new_figure(grid_height(sizes) + header_height(handles, title))
        panels = panel_grid(figure, sizes, angles, "Natural frequency (Hz)")
        for mode, axes in enumerate(panels):
            axes.set_title(mode_label([int(dataset["mode"].values[mode])]))
            for number in range(len(speeds)):
                place = dataset.isel(crank_speed=number, mode=mode)
                style = series_style(number)
                for name, how in (("dry_frequency", _DRY), ("frequency", _WET)):
                    axes.plot(
                        angles,
                        place[name].values,
                        color=style.color,
                        marker=style.marker if marked else "",
                        markersize=POINT_SIZE,
                        **how,
                    )
            axes.margins(y=0.08)
            plain_numbers(axes)
        header_legend(figure, handles, title)
    return figure


def _handles(speeds: FloatArray) -> list[Artist]:
    handles: list[Artist] = [
        Line2D([], [], color=MID_GREY, label=label, **how)
        for label, how in (("dry", _DRY), ("in heat and moisture", _WET))
    ]
    for number, speed in enumerate(speeds):
        color = series_style(number).color
        handles.append(Line2D([], [], color=color, linewidth=1.5, label=speed_label(float(speed))))
    return handles
