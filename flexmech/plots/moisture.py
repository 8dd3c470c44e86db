"""Moisture through the thickness of links, and their uptake over the root of time."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexmech.plots import style
from flexmech.plots.layout import AxesLike, grid, sheet
from flexmech.plots.reading import names_of
from flexmech.plots.style import line_handle, series_handle, series_line
from flexmech.units import ZERO_CELSIUS, from_si

# Of a link's two panels in inches; on a narrow page they stand under each other.
ROW_HEIGHT, NARROW_ROW_HEIGHT = 2.1, 1.6
# Formulas beside the finite volumes, by the numbers of their styles.
LAWS = {1: ("short_time_uptake", "root of time"), 3: ("shen_springer_uptake", "Shen & Springer")}
TIME_UNITS = ("day", "hour", "second")


def plot_moisture(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw moisture profiles of links and their uptake against the root of time.

    Parameters
    ----------
    dataset : Dataset
        With ``place`` (link, cell) in m, ``profile`` (link, profile_time, cell) as a part of the
        resin's dry mass, ``uptake``, ``short_time_uptake`` and ``shen_springer_uptake``
        (link, time) as parts of what a link takes up in the end, not a number where a law says
        nothing; ``over_width`` (link) tells whether profiles are means over the width.
    ax : Axes or sequence of Axes, optional
        The user's, two a link. Left out: a new figure is made.

    Returns
    -------
    Figure
        One row a link: profiles on the left, uptake on the right.
    """
    links, end = names_of(dataset, "link"), float(dataset["time"].max())
    unit = next((name for name in TIME_UNITS if from_si(end, name) >= 1), "second")
    attrs = dataset.attrs
    title = (
        f"Moisture at {100 * attrs['relative_humidity']:.4g} % relative humidity, "
        f"{attrs['temperature'] - ZERO_CELSIUS:.4g} °C"
    )
    row = NARROW_ROW_HEIGHT if style.is_narrow() else ROW_HEIGHT
    layout = grid(len(links), 2, row * len(links) + 0.5, sharex="col")
    with sheet(layout, ax=ax) as drawn:
        drawn.header(_handles(dataset, unit), title, of=dataset)
        drawn.label_x("Distance from the middle (mm)", slice(0, None, 2))
        drawn.label_x(rf"Root of time ($\sqrt{{\mathrm{{{unit}}}}}$)", slice(1, None, 2))
        for link, profile, uptake in zip(links, drawn.panels[::2], drawn.panels[1::2], strict=True):
            of_link = dataset.sel(link=link)
            _draw_profiles(profile, of_link)
            _draw_uptake(uptake, of_link, unit)
            what = "mean over the width" if of_link["over_width"] else "through the thickness"
            profile.set_title(f"{link.capitalize()}: {what}")
            uptake.set_title(f"{link.capitalize()}: uptake")
    return drawn.figure


def _colours(dataset: xr.Dataset) -> list[tuple[float, float, float, float]]:
    """Dark to light with time, told apart in grey as well."""
    places = np.linspace(0.0, 0.85, dataset.sizes["profile_time"])
    return [mpl.colormaps["viridis"](place) for place in places]


def _handles(dataset: xr.Dataset, unit: str) -> list[Artist]:
    handles = []
    times = dataset["profile_time"].values * from_si(1.0, unit)
    for time, colour in zip(times, _colours(dataset), strict=True):
        number = f"{time:.0f}" if time >= 1000 else f"{time:.3g}"
        handles.append(line_handle(f"{number} {unit[0]}", color=colour))
    handles.append(line_handle("finite volumes", color="black"))
    laws = {n: label for n, (name, label) in LAWS.items() if dataset[name].count()}
    return [*handles, *(series_handle(number, label) for number, label in laws.items())]


def _draw_profiles(axes: Axes, link: xr.Dataset) -> None:
    profiles = link["profile"].transpose("profile_time", "cell").values
    for colour, profile in zip(_colours(link), profiles, strict=True):
        axes.plot(1e3 * link["place"].values, 100 * profile, color=colour)
    axes.set(ylabel="Moisture of the resin (%)", xmargin=0.0)
    axes.set_ylim(bottom=0.0)


def _draw_uptake(axes: Axes, link: xr.Dataset, unit: str) -> None:
    root = np.sqrt(link["time"].values * from_si(1.0, unit))
    axes.axhline(1.0, color=style.MID_GREY, lw=0.6, zorder=1)
    axes.plot(root, link["uptake"].values, color="black")
    for number, (name, _) in LAWS.items():
        axes.plot(root, link[name].values, **series_line(number))
    axes.set(ylabel="Share of equilibrium", ylim=(0.0, 1.08), xmargin=0.02)
