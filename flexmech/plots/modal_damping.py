"""Damping ratio by modal strain energy against crank angle."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from flexmech.errors import InputError
from flexmech.plots.angle_lines import draw_line, draw_marks, engine_handles, marked_handles
from flexmech.plots.angle_panels import angle_layout, label_angles
from flexmech.plots.branches import MAP, branch_lines
from flexmech.plots.labels import speed_texts
from flexmech.plots.reading import degrees, values_of
from flexmech.plots.scales import scale_y
from flexmech.plots.sheet import AxesLike, sheet

__all__ = ["plot_modal_damping"]

# More panels than these are too many to compare.
MOST_SPEEDS = 6
# Narrowest y axis as a part of the mean ratio: below it one would look at round-off.
LEAST_BAND = 0.02


def plot_modal_damping(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the damping ratio by modal strain energy, one panel a speed, one line a mode.

    Modes are in order of frequency at each angle. Where two of them change places a line
    breaks off and goes on elsewhere: it does not join the damping of different vibrations.
    The first engine is drawn as lines, the others as markers. Of more than six speeds, six
    are drawn, evenly spread.

    Parameters
    ----------
    dataset : Dataset
        Of a ``MovingFrequencies`` result of a mechanism with specific damping.
    ax : Axes or sequence of Axes, optional
        The user's, one a speed. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If the dataset has no ``strain_energy_damping``.
    """
    if "strain_energy_damping" not in dataset:
        raise InputError(
            "this result has no damping by modal strain energy: give the mechanism sections "
            "with specific damping, then compute moving_frequencies"
        )
    dataset = _few_speeds(dataset.sortby("crank_angle"))
    percent = 100.0 * values_of(dataset["strain_energy_damping"], *MAP)
    branch = values_of(dataset["branch_of_mode"], *MAP)[0]
    n_engines, n_speeds, _, n_modes = percent.shape
    angles = degrees(dataset["crank_angle"])
    layout = angle_layout([1] * n_speeds, share_y=True)
    with sheet(layout, ax=ax, fewer="choose one speed (speeds=...)") as drawn:
        modes = [f"mode {mode}" for mode in dataset["mode"].values]
        handles = marked_handles(dataset, modes) + engine_handles(dataset)
        drawn.header(handles, "Damping by modal strain energy")
        label_angles(drawn, angles, "Damping ratio (%)")
        for speed, axes in enumerate(drawn.panels):
            axes.set_title(speed_texts(dataset)[speed])
            scale_y(axes, percent, least_part=LEAST_BAND)
            for mode in range(n_modes):
                one = slice(mode, mode + 1)
                for values in branch_lines(
                    percent[0, speed, :, one], branch[speed, :, one]
                ).values():
                    draw_line(axes, angles, values, mode)
                for engine in range(1, n_engines):
                    draw_marks(axes, angles, percent[engine, speed, :, mode], mode, n_modes, engine)
    return drawn.figure


def _few_speeds(dataset: xr.Dataset) -> xr.Dataset:
    """At most so many speeds, the first and the last among them."""
    count = dataset.sizes["crank_speed"]
    places = np.round(np.linspace(0, count - 1, min(count, MOST_SPEEDS))).astype(int)
    return dataset.isel(crank_speed=places)
