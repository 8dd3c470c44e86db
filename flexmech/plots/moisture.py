"""Moisture through the thickness of links, and their uptake over the root of time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from flexmech.errors import InputError
from flexmech.plots.style import (
    MID_GREY,
    header_height,
    header_legend,
    new_figure,
    publication_style,
    series_style,
)
from flexmech.types import FloatArray

__all__ = ["DrawnMoisture", "plot_moisture"]


ROW_HEIGHT = 2.1


class TimeUnit(NamedTuple):
    """Unit of a time axis."""

    name: str
    symbol: str
    seconds: float


UNITS = (TimeUnit("day", "d", 86400.0), TimeUnit("hour", "h", 3600.0), TimeUnit("second", "s", 1.0))


@dataclass(frozen=True)
class DrawnMoisture:
    """What is drawn of the water in a link.

    Parameters
    ----------
    place : ndarray, shape (n,)
        Through the thickness in m.
    profile_time : ndarray, shape (p,)
        In s.
    profile : ndarray, shape (p, n)
        Moisture of the resin, mass of water over its dry mass.
    time : ndarray, shape (t,)
        In s.
    uptake : ndarray, shape (t,)
        Water in the link over what it takes up in the end in these surroundings.
    short_time, shen_springer : ndarray, shape (t,), or None
        The same by the law of the root of time and by Shen & Springer's formula; None for
        links of several materials, of which they say nothing.
    over_width : bool
        Whether profiles are means over the width, where water enters through the sides too.
    """

    place: FloatArray
    profile_time: FloatArray
    profile: FloatArray
    time: FloatArray
    uptake: FloatArray
    short_time: FloatArray | None = None
    shen_springer: FloatArray | None = None
    over_width: bool = False


def plot_moisture(links: Mapping[str, DrawnMoisture], title: str = "") -> Figure:
    """Draw moisture profiles of links and their uptake against the root of time.

    Parameters
    ----------
    links : mapping of str to DrawnMoisture
        By the links' names; all with the same profile times.
    title : str

    Returns
    -------
    Figure
        One row a link: profiles on the left, uptake on the right.

    Raises
    ------
    InputError
        If there are no links.
    """
    if not links:
        raise InputError("at least one link is needed to draw moisture, got none")
    first = next(iter(links.values()))
    with publication_style():
        unit = next((unit for unit in UNITS if first.time[-1] >= unit.seconds), UNITS[-1])
        handles = _time_handles(first.profile_time, unit) + _law_handles(links)
        figure = new_figure(ROW_HEIGHT * len(links) + 0.5 + header_height(handles, title))
        panels = figure.subplots(len(links), 2, squeeze=False, sharex="col")
        for row, (name, link) in zip(panels, links.items(), strict=True):
            _draw_profiles(row[0], link)
            _draw_uptake(row[1], link, unit)
            what = "mean over the width" if link.over_width else "through the thickness"
            row[0].set_title(f"{name.capitalize()}: {what}")
            row[1].set_title(f"{name.capitalize()}: uptake")
        panels[-1, 0].set_xlabel("Distance from the middle (mm)")
        panels[-1, 1].set_xlabel(rf"Root of time ($\sqrt{{\mathrm{{{unit.name}}}}}$)")
        header_legend(figure, handles, title)
    return figure


def _colours(count: int) -> list[tuple[float, float, float, float]]:
    """Dark to light with time, told apart in grey as well."""
    return [mpl.colormaps["viridis"](x) for x in np.linspace(0.0, 0.85, count)]


def _time_handles(times: FloatArray, unit: TimeUnit) -> list[Artist]:
    return [
        Line2D([], [], color=colour, label=_time_label(time, unit))
        for colour, time in zip(_colours(len(times)), times, strict=True)
    ]


def _time_label(time: float, unit: TimeUnit) -> str:
    value = time / unit.seconds
    return f"{value:.0f} {unit.symbol}" if value >= 1000 else f"{value:.3g} {unit.symbol}"


def _law_handles(links: Mapping[str, DrawnMoisture]) -> list[Artist]:
    handles: list[Artist] = [Line2D([], [], color="black", label="finite volumes")]
    if any(link.short_time is not None for link in links.values()):
        for number, label in ((1, "root of time"), (3, "Shen & Springer")):
            style = series_style(number)
            handles.append(
                Line2D([], [], color=style.color, linestyle=style.linestyle, label=label)
            )
    return handles


def _draw_profiles(axes: Axes, link: DrawnMoisture) -> None:
    for colour, profile in zip(_colours(len(link.profile)), link.profile, strict=True):
        axes.plot(1e3 * link.place, 100 * profile, color=colour)
    axes.set_ylabel("Moisture of the resin (%)")
    axes.set_ylim(bottom=0.0)
    axes.margins(x=0.0)


def _draw_uptake(axes: Axes, link: DrawnMoisture, unit: TimeUnit) -> None:
    root = np.sqrt(link.time / unit.seconds)
    axes.axhline(1.0, color=MID_GREY, lw=0.6, zorder=1)
    axes.plot(root, link.uptake, color="black")
    if link.short_time is not None and link.shen_springer is not None:
        for number, values in ((1, link.short_time), (3, link.shen_springer)):
            style = series_style(number)
            axes.plot(root, values, color=style.color, linestyle=style.linestyle)
    axes.set_ylabel("Share of equilibrium")
    axes.set_ylim(0.0, 1.08)
    axes.margins(x=0.02)
