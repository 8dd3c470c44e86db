"""Natural frequencies in two states of heat and moisture."""

from __future__ import annotations

from typing import Any

import xarray as xr
from matplotlib.artist import Artist
from matplotlib.figure import Figure

from flexmech.errors import InputError
from flexmech.plots.angle_panels import mode_panels
from flexmech.plots.labels import names_of, speed_texts
from flexmech.plots.reading import degrees, values_of
from flexmech.plots.scales import scale_y
from flexmech.plots.series import line_handle, series_line, series_style
from flexmech.plots.sheet import AxesLike
from flexmech.plots.style import MID_GREY

__all__ = ["plot_hygrothermal_effect"]

LINES: tuple[dict[str, Any], ...] = (
    {"linestyle": "-", "linewidth": 1.2},
    {"linestyle": (0.0, (4.0, 1.5)), "linewidth": 1.5},
)
# Narrowest y axis as a part of the frequency: below it one would look at round-off.
LEAST_BAND = 4e-3


def plot_hygrothermal_effect(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the frequencies of both states against crank angle, one panel a mode.

    Parameters
    ----------
    dataset : Dataset
        Of a ``MovingFrequencies`` result in two states; Hz and rad. Its first engine is drawn,
        at every speed.
    ax : Axes or sequence of Axes, optional
        The user's, one a mode. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If the dataset does not hold two states.
    """
    if dataset.sizes.get("state") != len(LINES):
        raise InputError("the effect of heat and moisture needs frequencies in two states")
    dataset = dataset.sortby("crank_angle")
    angles = degrees(dataset["crank_angle"])
    order = ("mode", "crank_speed", "state", "crank_angle")
    frequency = values_of(dataset["frequency"].isel(engine=0), *order)
    with mode_panels(dataset, "Natural frequency (Hz)", ax=ax) as drawn:
        handles: list[Artist] = [
            line_handle(label, color=MID_GREY, **line)
            for label, line in zip(names_of(dataset, "state"), LINES, strict=True)
        ]
        for number, text in enumerate(speed_texts(dataset)):
            handles.append(line_handle(text, color=series_style(number).color, linewidth=1.5))
        drawn.header(handles, "Natural frequencies in two states of heat and moisture")
        for axes, speeds in zip(drawn.panels, frequency, strict=True):
            for number, states in enumerate(speeds):
                for values, line in zip(states, LINES, strict=True):
                    axes.plot(angles, values, **(series_line(number, angles) | line))
            scale_y(axes, speeds, least_part=LEAST_BAND)
    return drawn.figure
