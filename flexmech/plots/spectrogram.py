"""How the spectra of the running linkage move in time with its natural frequencies."""

from __future__ import annotations

from typing import Any

import matplotlib.patheffects as effects
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure

from flexmech.errors import InputError
from flexmech.plots.reading import (
    cell_edges,
    engine_label,
    link_label,
    names_of,
    run_title,
    values_of,
)
from flexmech.plots.sheet import AxesLike, sheet
from flexmech.plots.spectra import ONE_LINK, highest_frequency, link_layout
from flexmech.plots.style import line_handle, plain_numbers
from flexmech.plots.time_axis import angle_axis

__all__ = ["plot_spectrogram"]

DECIBELS = 60.0
"""Levels this far below the maximum are drawn as the darkest."""
# White with a dark rim is seen on any colour, and the ridges between the dashes.
_PREDICTION: dict[str, Any] = {
    "color": "white",
    "linewidth": 0.8,
    "linestyle": (0.0, (4.0, 5.0)),
    "path_effects": [
        effects.Stroke(linewidth=2.0, foreground="black", alpha=0.6),
        effects.Normal(),
    ],
}


def plot_spectrogram(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw how the spectrum of each link's deflection moves in time, one panel a link.

    Parameters
    ----------
    dataset : Dataset
        Of a ``Response`` result with ``spectrogram``. Its first engine is drawn.
    ax : Axes or sequence of Axes, optional
        The user's, one a link. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If the dataset has no spectrogram.
    """
    if "spectrogram" not in dataset:
        raise InputError("this response is too short for a spectrogram: ask for more revolutions")
    first, links = dataset.isel(engine=0), names_of(dataset, "link")
    time = first["window_time"].values
    predicted = values_of(first["natural_frequency"], "mode", "window_time")
    with sheet(link_layout(len(links), 1.75, 2.4), ax=ax, fewer=ONE_LINK) as drawn:
        title = f"{run_title(dataset)}, by {engine_label(dataset)}"
        drawn.header([line_handle("predicted natural frequencies", **_PREDICTION)], title)
        for axes, link in zip(drawn.panels, links, strict=True):
            mesh = _draw_levels(axes, first["spectrogram"].sel(link=link))
            for values in predicted:
                axes.plot(time, values, **_PREDICTION, marker="." if time.size == 1 else "")
            axes.set_ylim(0.0, highest_frequency(dataset, "window_frequency"))
            plain_numbers(axes)
            axes.set_ylabel(f"{link_label(dataset, link)}\nfrequency (Hz)")
        angle_axis(drawn.panels[0], dataset)
        drawn.label_x("Time (s)")
        panels = drawn.panels
        bar = drawn.figure.colorbar(
            mesh, ax=panels, extend="min", pad=0.015, aspect=14 * len(panels)
        )
        of_what = "each panel's maximum" if len(panels) > 1 else "maximum"
        bar.set_label(f"Level relative to {of_what} (dB)")
        bar.outline.set_linewidth(0.6)
    return drawn.figure


def _draw_levels(axes: Axes, amplitude: xr.DataArray) -> QuadMesh:
    """Level in dB below the panel's maximum; the mesh, for the colour bar."""
    values = values_of(amplitude, "window_frequency", "window_time")
    highest = float(np.nanmax(values, initial=0.0)) or 1.0
    level = 20 * np.log10(np.maximum(values / highest, 10.0 ** (-2 * DECIBELS / 20)))
    time, frequency = (
        cell_edges(amplitude[f"window_{name}"].values) for name in ("time", "frequency")
    )
    look: dict[str, Any] = {"vmin": -DECIBELS, "vmax": 0.0, "cmap": "viridis", "rasterized": True}
    mesh = axes.pcolormesh(time, frequency, level, **look)
    axes.set_xlim(time[0], time[-1])
    return mesh
