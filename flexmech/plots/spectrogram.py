"""How the spectra of the running linkage move in time with its natural frequencies."""

from __future__ import annotations

from typing import Any

import matplotlib.patheffects as effects
import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from flexmech.errors import InputError
from flexmech.plots.frequencies import engine_label
from flexmech.plots.response import link_label, run_title
from flexmech.plots.spectra import highest_frequency
from flexmech.plots.style import (
    LABEL_SIZE,
    header_height,
    header_legend,
    new_figure,
    plain_numbers,
    publication_style,
)
from flexmech.plots.time_axis import angle_axis
from flexmech.types import FloatArray

__all__ = ["plot_spectrogram"]


PANEL_HEIGHT = 1.75
LEAST_HEIGHT = 2.4
# What the axes of time and of crank angle take, in inches.
AXES_HEIGHT = 0.9
DECIBELS = 60.0
"""Levels this far below the maximum are drawn as the darkest."""
# White with a dark rim is seen on any colour, and the ridges between the dashes.
_PREDICTION: Any = {
    "color": "white",
    "linewidth": 0.8,
    "linestyle": (0.0, (4.0, 5.0)),
    "path_effects": [
        effects.Stroke(linewidth=2.0, foreground="black", alpha=0.6),
        effects.Normal(),
    ],
}


def plot_spectrogram(dataset: xr.Dataset, engine: str | None = None) -> Figure:
    """Draw how the spectrum of each link's deflection moves in time, one panel a link.

    Parameters
    ----------
    dataset : Dataset
        Of a ``Response`` result with ``spectrogram``.
    engine : str, optional
        Name of the engine; default the first.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If the dataset has no spectrogram or no such engine.
    """
    if "spectrogram" not in dataset:
        raise InputError("this response is too short for a spectrogram: ask for more revolutions")
    number = _engine_number(dataset, engine)
    with publication_style():
        limit = highest_frequency(dataset, "window_frequency")
        line = Line2D([], [], **_PREDICTION, label="predicted natural frequencies")
        handles: list[Artist] = [line]
        title = f"{run_title(dataset)}, by {engine_label(dataset, number)}"
        links = [str(name) for name in dataset["link"].values]
        height = max(len(links) * PANEL_HEIGHT, LEAST_HEIGHT) + AXES_HEIGHT
        figure = new_figure(height + header_height(handles, title))
        panels = list(figure.subplots(len(links), 1, sharex=True, squeeze=False)[:, 0])
        predicted = dataset["natural_frequency"].isel(engine=number)
        for axes, link in zip(panels, links, strict=True):
            part = dataset["spectrogram"].isel(engine=number).sel(link=link)
            mesh = _draw_levels(axes, part)
            axes.set_ylim(0.0, limit)
            _draw_predictions(axes, predicted)
            plain_numbers(axes)
            axes.set_ylabel(f"{link_label(dataset, link)}\nfrequency (Hz)")
        angle_axis(panels[0], dataset)
        panels[-1].set_xlabel("Time (s)")
        figure.align_ylabels()
        bar = figure.colorbar(mesh, ax=panels, extend="min", pad=0.015, aspect=14 * len(panels))
        of_what = "each panel's maximum" if len(panels) > 1 else "maximum"
        bar.set_label(f"Level relative to {of_what} (dB)", fontsize=LABEL_SIZE)
        bar.outline.set_linewidth(0.6)
        header_legend(figure, handles, title)
    return figure


def _engine_number(dataset: xr.Dataset, engine: str | None) -> int:
    """Position of an engine of a dataset; the first where none is named."""
    names = [str(name) for name in dataset["engine"].values]
    if engine is None:
        return 0
    if engine not in names:
        raise InputError(f"this result has no engine {engine!r}, only {', '.join(names)}")
    return names.index(engine)


def _draw_levels(axes: Axes, amplitude: xr.DataArray) -> QuadMesh:
    """Level in dB below the panel's maximum; the mesh, for the colour bar."""
    values = amplitude.transpose("window_frequency", "window_time").values
    highest = float(np.nanmax(values, initial=0.0)) or 1.0
    level = 20 * np.log10(np.maximum(values / highest, 10.0 ** (-2 * DECIBELS / 20)))
    time = _edges(amplitude["window_time"].values)
    mesh = axes.pcolormesh(
        time,
        _edges(amplitude["window_frequency"].values),
        level,
        vmin=-DECIBELS,
        vmax=0.0,
        cmap="viridis",
        rasterized=True,
    )
    axes.set_xlim(time[0], time[-1])
    return mesh


def _edges(centres: FloatArray) -> FloatArray:
    """Edges of cells around ascending centres; one alone gets a width of its own value."""
    if centres.size == 1:
        half = abs(float(centres[0])) / 2 or 0.5
        return np.array([centres[0] - half, centres[0] + half])
    middle = (centres[1:] + centres[:-1]) / 2
    ends = 2 * centres[[0, -1]] - middle[[0, -1]]
    return np.concatenate([ends[:1], middle, ends[1:]])


def _draw_predictions(axes: Axes, frequency: xr.DataArray) -> None:
    time = frequency["window_time"].values
    marker = "." if time.size == 1 else ""
    for values in frequency.transpose("mode", "window_time").values:
        axes.plot(time, values, **_PREDICTION, marker=marker)
