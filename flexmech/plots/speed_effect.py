"""What each inertial term of the moving linkage does to the natural frequencies."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from flexmech.errors import InputError
from flexmech.plots.panels import degrees, grid_height, panel_grid
from flexmech.plots.style import (
    MID_GREY,
    few_points,
    header_legend,
    mode_label,
    new_figure,
    plain_numbers,
    publication_style,
    series_style,
    speed_label,
)

__all__ = ["plot_speed_effect"]

TOTAL_WIDTH = 1.8
# Narrowest y axis in Hz: effects below it are round-off of the eigenvalue solution.
LEAST_BAND = 1e-6


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
        sizes = [1] * dataset.sizes["mode"]
        figure = new_figure(grid_height(sizes, unit=1.4, extra=0.95))
        panels = panel_grid(figure, sizes, angles, "Change of frequency (Hz)")
        marker = "." if few_points(angles) else ""
        for mode, axes in enumerate(panels):
            axes.set_title(mode_label([int(dataset["mode"].values[mode])]))
            axes.axhline(0.0, color=MID_GREY, lw=0.6, zorder=1)
            total = values[..., mode].sum(axis=0)
            axes.plot(angles, total, color="black", lw=TOTAL_WIDTH, marker=marker, zorder=2.2)
            for term in range(values.shape[0]):
                style = series_style(term)
                axes.plot(
                    angles,
                    values[term, :, mode],
                    color=style.color,
                    linestyle=style.linestyle,
                    marker=marker,
                )
            _scale_change(axes, np.concatenate([values[..., mode].ravel(), total, [0.0]]))
        header_legend(
            figure,
            _term_handles(dataset),
            title=f"Change of frequency from rest to {speed_label(float(speeds[fastest]))}, "
            "by term",
        )
    return figure


def _scale_change(axes: Axes, values: NDArray[np.float64]) -> None:
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    room = max(0.07 * (high - low), LEAST_BAND)
    axes.set_ylim(low - room, high + room)
    plain_numbers(axes)


def _term_handles(dataset: xr.Dataset) -> list[Artist]:
    handles: list[Artist] = [Line2D([], [], color="black", lw=TOTAL_WIDTH, label="total")]
    for number, term in enumerate(dataset["term"].values):
        style = series_style(number)
        # Coriolis is a name; the others are plain words.
        label = "Coriolis" if str(term) == "coriolis" else str(term)
        handles.append(Line2D([], [], color=style.color, linestyle=style.linestyle, label=label))
    return handles
