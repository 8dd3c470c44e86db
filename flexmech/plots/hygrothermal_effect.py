"""Natural frequencies in two states of heat and moisture."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from flexmech.errors import InputError
from flexmech.plots import angle_panels, scales, style
from flexmech.plots.labels import speed_texts
from flexmech.plots.layout import AxesLike
from flexmech.plots.reading import degrees, names_of, values_of
from flexmech.plots.series import Look, line_handle, series_line, series_style
from flexmech.plots.speed_colours import colour_bar, has_many_speeds, speed_lines

LINES: tuple[Look, ...] = (
    {"linestyle": "-", "linewidth": 1.2},
    {"linestyle": (0.0, (4.0, 1.5)), "linewidth": 1.5},
)


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
    drawn_at, lines = angles, frequency
    if "frequency_between" in dataset:
        between = values_of(dataset["frequency_between"], *order[:-1], "between_angle")
        drawn_at = np.append(angles, degrees(dataset["between_angle"]))
        sequence = np.argsort(drawn_at, kind="stable")
        drawn_at = drawn_at[sequence]
        lines = np.concatenate([frequency, between], axis=-1)[..., sequence]
    with angle_panels.mode_panels(dataset, "Natural frequency (Hz)", ax=ax) as drawn:
        handles = [
            line_handle(label, color=style.MID_GREY, **line)
            for label, line in zip(names_of(dataset, "state"), LINES, strict=True)
        ]
        many = has_many_speeds(dataset)
        looks = speed_lines(dataset) if many else []
        for number, text in enumerate([] if many else speed_texts(dataset)):
            handles.append(line_handle(text, color=series_style(number).color, linewidth=1.5))
            looks.append(series_line(number, angles))
        title = "Natural frequencies in two states of heat and moisture"
        drawn.header(handles, title, of=dataset)
        for axes, speeds in zip(drawn.panels, lines, strict=True):
            for states, look in zip(speeds, looks, strict=True):
                for values, line in zip(states, LINES, strict=True):
                    axes.plot(drawn_at, values, **(look | line))
            scales.scale_y(axes, speeds, least_part=scales.FREQUENCY_BAND)
        if many:
            colour_bar(drawn, dataset)
    return drawn.figure
