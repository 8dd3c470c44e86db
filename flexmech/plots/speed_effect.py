"""What each inertial term of the moving linkage does to the natural frequencies."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from flexmech.errors import InputError
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
    series_handle,
    series_style,
    speed_label,
)
from flexmech.types import FloatArray

__all__ = ["plot_speed_effect"]


TOTAL_MARKER = "*"
_TOTAL: Any = {"color": "black", "linewidth": 1.8, "markersize": 5}
# Narrowest y axis in Hz: far below what can be measured, far above round-off.
LEAST_BAND = 2e-4


def plot_speed_effect(dataset: xr.Dataset) -> Figure:
    """Draw the change of each frequency with crank speed, split by term, at the top speed.

    The terms are those of the linkage's equation of motion in link frames: geometric
    stiffness of the axial forces, shift of posture to the equilibrium, Coriolis,
    centripetal and tangential terms, switched on one after another; black is their sum, the
    frequency at speed minus that at rest.

    Parameters
    ----------
    dataset : Dataset
        Of a ``MovingFrequencies`` result made with ``speed_effect=True``; Hz and rad.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If the dataset has no ``speed_effect``.
    """
    if "speed_effect" not in dataset:
        raise InputError(
            "this result does not split the effect of speed by term: compute it with "
            "moving_frequencies(..., speed_effect=True)"
        )
    with publication_style():
        dataset = dataset.sortby("crank_angle")
        speeds = dataset["crank_speed"].values
        fastest = int(np.argmax(np.abs(speeds)))
        effect = dataset["speed_effect"].isel(crank_speed=fastest)
        values = effect.transpose("term", "crank_angle", "mode").values
        angles = degrees(dataset["crank_angle"])
        title = f"Change of frequency from rest to {speed_label(float(speeds[fastest]))}, by term"
        marked = few_points(angles)
        handles = _term_handles(dataset, marked)
        sizes = [1] * dataset.sizes["mode"]
        figure = new_figure(grid_height(sizes) + header_height(handles, title))
        panels = panel_grid(figure, sizes, angles, "Change of frequency (Hz)")
        for mode, axes in enumerate(panels):
            axes.set_title(mode_label([int(dataset["mode"].values[mode])]))
            axes.axhline(0.0, color=MID_GREY, lw=0.6, zorder=1)
            _draw_terms(axes, angles, values[..., mode], marked)
        header_legend(figure, handles, title)
    return figure


def _draw_terms(axes: Axes, angles: FloatArray, values: FloatArray, marked: bool) -> None:
    """One line a term and their sum; ``values`` has the shape (term, crank_angle)."""
    total = values.sum(axis=0)
    # Under the terms, so that a term which makes up the whole effect is seen on it.
    axes.plot(angles, total, **_TOTAL, marker=TOTAL_MARKER if marked else "", zorder=1.9)
    for term, change in enumerate(values):
        style = series_style(term)
        axes.plot(
            angles,
            change,
            color=style.color,
            linestyle=style.linestyle,
            marker=style.marker if marked else "",
            markersize=POINT_SIZE,
        )
    _scale_change(axes, np.concatenate([values.ravel(), total, [0.0]]))


def _scale_change(axes: Axes, values: FloatArray) -> None:
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    room = max(0.07 * (high - low), LEAST_BAND / 2)
    axes.set_ylim(low - room, high + room)
    plain_numbers(axes)


def _term_handles(dataset: xr.Dataset, marked: bool) -> list[Artist]:
    total = Line2D([], [], **_TOTAL, marker=TOTAL_MARKER if marked else "", label="total")
    handles: list[Artist] = [total]
    for number, term in enumerate(dataset["term"].values):
        # Coriolis is a name; the others are plain words.
        label = "Coriolis" if str(term) == "coriolis" else str(term)
        marker = series_style(number).marker if marked else ""
        handles.append(series_handle(number, label, marker=marker, markersize=POINT_SIZE))
    return handles
