"""The study of composite crank-rockers in bars, beside what the paper prints."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from flexmech.plots.style import (
    header_height,
    header_legend,
    new_figure,
    plain_numbers,
    publication_style,
    series_handle,
    series_style,
)

__all__ = ["plot_composite_damping", "plot_composite_frequencies", "plot_laminate_factors"]

PANEL = 2.0
# From dark to light, so that the order shows without colour as well.
SHADES = ("#08306b", "#08519c", "#2171b5", "#4292c6", "#9ecae1", "#deebf7")
POSITIONS = {
    "min": "least transmission angle",
    "90": "transmission angle 90 deg",
    "max": "greatest transmission angle",
}


def plot_composite_frequencies(study: xr.Dataset) -> Figure:
    """Draw fundamental frequencies by laminate, case and position as ratios.

    Elamy et al. 2023, Figure 8 and Tables 4 to 6.

    Parameters
    ----------
    study : Dataset
        Of :func:`flexmech.analyses.studies.study_composites`.

    Returns
    -------
    Figure
    """
    ours = study["frequency"].sel(plies="unidirectional").isel(mesh=0)
    return _bars(
        ours,
        {"finite elements, published": study["finite_element"], "measured": study["measured"]},
        "Fundamental frequency over that of C1, case 1, least transmission angle; bars: computed",
        {"laminate": "C1", "case": 1, "position": "min"},
    )


def plot_composite_damping(study: xr.Dataset) -> Figure:
    """Draw damping by laminate, case and position as ratios.

    Elamy et al. 2023, Figure 9 and Tables 4 to 6.

    Parameters
    ----------
    study : Dataset
        Of :func:`flexmech.analyses.studies.study_composites`.

    Returns
    -------
    Figure
    """
    return _bars(
        study["strain_energy_damping"],
        {"measured": study["damping"]},
        "Damping over that of C6, case 1, least transmission angle; bars: computed",
        {"laminate": "C6", "case": 1, "position": "min"},
    )


def plot_laminate_factors(factors: xr.DataArray, published: xr.DataArray) -> Figure:
    """Draw how the frequency changes with the laminate, by model of the plies.

    Parameters
    ----------
    factors : DataArray
        Over ``plies`` and ``laminate``; C1 is 1.
    published : DataArray
        The same from printed tables, over ``laminate``.

    Returns
    -------
    Figure
    """
    with publication_style():
        names = [f"{name} plies" for name in factors["plies"].values[:2]]
        names += ["one modulus a laminate, Table 2", "published, Tables 5 and 6"]
        handles: list[Artist] = [
            series_handle(n, name, marker=series_style(n).marker, markersize=4)
            for n, name in enumerate(names)
        ]
        title = "Frequency of each laminate over that of C1"
        figure = new_figure(2.6 + header_height(handles, title))
        axes = figure.subplots()
        laminates = [str(name) for name in factors["laminate"].values]
        for number, values in enumerate([*factors.values, published.values]):
            style = series_style(number)
            axes.plot(
                laminates,
                values,
                color=style.color,
                linestyle=style.linestyle,
                marker=style.marker,
                markersize=4,
            )
        axes.set_ylim(0.0, 1.05)
        axes.set_xlabel("Laminate")
        axes.set_ylabel("Ratio")
        header_legend(figure, handles, title)
    return figure


def _bars(
    ours: xr.DataArray, published: dict[str, xr.DataArray], title: str, one: dict[str, object]
) -> Figure:
    """One panel a position, one group of bars a case; markers for published values."""
    with publication_style():
        laminates = [str(name) for name in ours["laminate"].values]
        handles: list[Artist] = [
            Patch(facecolor=shade, edgecolor="black", linewidth=0.4, label=name)
            for shade, name in zip(SHADES, laminates, strict=True)
        ]
        styles = dict(zip(published, (("D", "#D55E00"), ("_", "black")), strict=False))
        for name, (marker, color) in styles.items():
            handles.append(
                Line2D([], [], linestyle="", marker=marker, color=color, ms=4, label=name)
            )
        figure = new_figure(3 * PANEL + header_height(handles, title))
        panels = figure.subplots(3, 1, sharex=True, sharey=True)
        relative = {name: values / values.sel(one) for name, values in published.items()}
        for axes, (position, words) in zip(panels, POSITIONS.items(), strict=True):
            axes.set_title(words)
            _group(axes, (ours / ours.sel(one)).sel(position=position), relative, position, styles)
            axes.set_ylabel("Ratio")
            plain_numbers(axes)
        panels[-1].set_xlabel("Proportions of the linkage")
        header_legend(figure, handles, title)
    return figure


def _group(
    axes: Axes,
    ours: xr.DataArray,
    published: dict[str, xr.DataArray],
    position: str,
    styles: dict[str, tuple[str, str]],
) -> None:
    cases = ours["case"].values
    width = 0.8 / ours.sizes["laminate"]
    for number, shade in enumerate(SHADES):
        place = np.arange(len(cases)) + (number - 2.5) * width
        heights = ours.isel(laminate=number).values
        axes.bar(place, heights, width, color=shade, edgecolor="black", linewidth=0.4)
        for name, values in published.items():
            marker, color = styles[name]
            heights = values.sel(position=position).isel(laminate=number).values
            axes.plot(place, heights, linestyle="", marker=marker, color=color, markersize=3.5)
    axes.set_xticks(np.arange(len(cases)), [f"case {case}" for case in cases])
