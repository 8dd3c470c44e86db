"""The study of composite crank-rockers in bars, beside what the paper prints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from flexmech.plots.style import (
    LABEL_SIZE,
    header_height,
    header_legend,
    new_figure,
    plain_numbers,
    publication_style,
    series_handle,
    series_style,
)
from flexmech.types import FloatArray

__all__ = ["plot_composite_damping", "plot_composite_frequencies", "plot_laminate_factors"]

PANEL = 1.9
MARK_SIZE = 3.8
# From dark to light, so that the order shows without colour as well.
SHADES = ("#08306b", "#08519c", "#2171b5", "#4292c6", "#9ecae1", "#deebf7")
POSITIONS = {
    "min": "Least transmission angle",
    "90": "Transmission angle 90 deg",
    "max": "Greatest transmission angle",
}


@dataclass(frozen=True)
class _Points:
    """Values drawn as markers on the bars."""

    label: str
    values: xr.DataArray
    marker: str
    color: str
    fill: str

    def handle(self) -> Line2D:
        return Line2D([], [], label=self.label, **self.properties())

    def properties(self) -> dict[str, Any]:
        return {
            "linestyle": "",
            "marker": self.marker,
            "color": self.color,
            "markerfacecolor": self.fill,
            "markersize": MARK_SIZE,
            "markeredgewidth": 0.9,
        }


def plot_composite_frequencies(study: xr.Dataset) -> Figure:
    """Draw fundamental frequencies by laminate, case and position as ratios.

    Elamy et al. 2023, Figure 8 and Tables 4 to 6.

    Parameters
    ----------
    study : Dataset
        Of :func:`flexmech.studies.study_composites`.

    Returns
    -------
    Figure
    """
    one = {"laminate": "C1", "case": 1, "position": "min"}
    ours = study["frequency"].sel(plies="unidirectional", beams="converged")
    points = [
        _Points("FE, published", study["finite_element"], "D", "#D55E00", "#D55E00"),
        _Points("measured", study["measured"], "_", "black", "black"),
    ]
    title = "Frequency over that of C1, case 1, least transmission angle (bars: computed)"
    return _bars(ours, points, title, "Ratio of frequencies (-)", one)


def plot_composite_damping(study: xr.Dataset) -> Figure:
    """Draw damping by laminate, case and position as ratios.

    Elamy et al. 2023, Figure 9 and Tables 4 to 6. Bars are beams that only bend; open circles
    are beams that shear too.

    Parameters
    ----------
    study : Dataset
        Of :func:`flexmech.studies.study_composites`.

    Returns
    -------
    Figure
    """
    one = {"laminate": "C6", "case": 1, "position": "min"}
    damping = study["strain_energy_damping"].sel(plies="unidirectional")
    points = [
        _Points("with shear", damping.sel(beams="with shear"), "o", "black", "white"),
        _Points("measured", study["damping"], "D", "#D55E00", "#D55E00"),
    ]
    title = "Damping over that of C6, case 1, least transmission angle (bars: computed, bending)"
    return _bars(damping.sel(beams="converged"), points, title, "Ratio of damping (-)", one)


def plot_laminate_factors(factors: xr.DataArray, published: xr.DataArray) -> Figure:
    """Draw how the frequency changes with the laminate, by model of plies and beams.

    Parameters
    ----------
    factors : DataArray
        Over ``plies``, ``beams`` and ``laminate``; C1 is 1.
    published : DataArray
        The same from printed tables, over ``laminate``.

    Returns
    -------
    Figure
    """
    bent = factors.sel(beams="converged")
    curves = {
        "unidirectional plies": bent.sel(plies="unidirectional"),
        "woven plies": bent.sel(plies="woven"),
        "one modulus a laminate, Table 2": bent.sel(plies="table 2"),
        "published, Tables 5 and 6": published,
        "unidirectional plies, with shear": factors.sel(plies="unidirectional", beams="with shear"),
    }
    with publication_style():
        handles: list[Artist] = [
            series_handle(n, name, marker=series_style(n).marker, markersize=4)
            for n, name in enumerate(curves)
        ]
        title = "Frequency of each laminate over that of C1"
        figure = new_figure(2.6 + header_height(handles, title))
        axes = figure.subplots()
        laminates = [str(name) for name in factors["laminate"].values]
        for number, values in enumerate(curves.values()):
            style = series_style(number)
            axes.plot(
                laminates,
                values.values,
                color=style.color,
                linestyle=style.linestyle,
                marker=style.marker,
                markersize=4,
            )
        axes.set_ylim(0.0, 1.05)
        axes.set_xlabel("Laminate")
        axes.set_ylabel("Ratio of frequencies (-)")
        header_legend(figure, handles, title)
    return figure


def _bars(
    ours: xr.DataArray, points: list[_Points], title: str, label: str, one: dict[str, object]
) -> Figure:
    """One panel a position, one group of bars a case; markers for other values."""
    laminates = [str(name) for name in ours["laminate"].values]
    cases = ours["case"].values
    with publication_style():
        handles: list[Artist] = [
            Patch(facecolor=shade, edgecolor="black", linewidth=0.4, label=name)
            for shade, name in zip(SHADES, laminates, strict=True)
        ]
        handles += [each.handle() for each in points]
        figure = new_figure(3 * PANEL + 0.2 + header_height(handles, title))
        panels = figure.subplots(3, 1, sharex=True, sharey=True)
        bars = ours / ours.sel(one)
        marks = [each.values / each.values.sel(one) for each in points]
        for axes, (position, words) in zip(panels, POSITIONS.items(), strict=True):
            axes.set_title(words)
            _group(axes, bars.sel(position=position))
            for each, values in zip(points, marks, strict=True):
                shown = values.sel(position=position).transpose("case", "laminate")
                axes.plot(_places(len(cases)).ravel(), shown.values.ravel(), **each.properties())
        panels[0].set_ylim(bottom=0.0)
        plain_numbers(panels[0])
        panels[-1].set_xticks(np.arange(len(cases)), [f"case {case}" for case in cases])
        panels[-1].set_xlabel("Proportions of the linkage")
        figure.supylabel(label, fontsize=LABEL_SIZE)
        header_legend(figure, handles, title)
    return figure


def _places(cases: int) -> FloatArray:
    """Middle of each bar, (cases, laminates)."""
    width = 0.8 / len(SHADES)
    offset = (np.arange(len(SHADES)) - (len(SHADES) - 1) / 2) * width
    return np.arange(cases)[:, None] + offset


def _group(axes: Axes, ratio: xr.DataArray) -> None:
    places = _places(ratio.sizes["case"])
    for number, shade in enumerate(SHADES):
        heights = ratio.isel(laminate=number).values
        axes.bar(
            places[:, number],
            heights,
            0.8 / len(SHADES),
            color=shade,
            edgecolor="black",
            linewidth=0.4,
        )
