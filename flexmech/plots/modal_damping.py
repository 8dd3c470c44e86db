"""Damping ratios against crank angle: by modal strain energy, and of Kelvin-Voigt damping."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from flexmech.errors import InputError
from flexmech.plots import angle_panels, scales
from flexmech.plots.labels import speed_texts
from flexmech.plots.layout import AxesLike, sheet
from flexmech.plots.reading import MAP, degrees, values_of

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
    return _draw(dataset, "strain_energy_damping", "Damping by modal strain energy", ax)


def plot_damping_ratio(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the damping ratio -Re(lambda)/abs(lambda) of Kelvin-Voigt damping, one panel a speed.

    As :func:`plot_modal_damping`. With rotation terms frozen eigenvalues have damping ratios of
    either sign that are no damping; an undamped mechanism has these alone.

    Parameters
    ----------
    dataset : Dataset
        Of a ``MovingFrequencies`` result.
    ax : Axes or sequence of Axes, optional
        The user's, one a speed. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    return _draw(dataset, "damping_ratio", "Kelvin-Voigt damping of frozen positions", ax)


def _draw(dataset: xr.Dataset, name: str, title: str, ax: AxesLike | None) -> Figure:
    dataset = _few_speeds(dataset.sortby("crank_angle"))
    percent = 100.0 * values_of(dataset[name], *MAP)
    branch = values_of(dataset["branch_of_mode"], *MAP)[0]
    _, n_speeds, _, n_modes = percent.shape
    angles = degrees(dataset["crank_angle"])
    layout = angle_panels.angle_layout([1] * n_speeds, share_y=True)
    with sheet(layout, ax=ax, fewer="choose one speed (speeds=...)") as drawn:
        modes = [f"mode {mode}" for mode in dataset["mode"].values]
        handles = angle_panels.series_and_engines(dataset, modes)
        drawn.header(handles, title, of=dataset)
        angle_panels.label_angles(drawn, angles, "Damping ratio (%)")
        for speed, (axes, text) in enumerate(zip(drawn.panels, speed_texts(dataset), strict=True)):
            axes.set_title(text)
            scales.scale_y(axes, percent, least_part=LEAST_BAND)
            for mode in range(n_modes):
                one = slice(mode, mode + 1)
                values, along = percent[:, speed, :, one], branch[speed, :, one]
                angle_panels.draw_series(axes, angles, values, along, mode, n_modes)
    return drawn.figure


def _few_speeds(dataset: xr.Dataset) -> xr.Dataset:
    """At most so many speeds, the first and the last among them."""
    count = dataset.sizes["crank_speed"]
    places = np.round(np.linspace(0, count - 1, min(count, MOST_SPEEDS))).astype(int)
    return dataset.isel(crank_speed=places)
