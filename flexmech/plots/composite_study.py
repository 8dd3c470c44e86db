"""The study of composite crank-rockers in bars, beside what the paper prints."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from flexmech.plots.labels import names_of
from flexmech.plots.reading import values_of
from flexmech.plots.scales import plain_numbers
from flexmech.plots.series import Look, line_handle, series_handle, series_line, series_style
from flexmech.plots.sheet import AxesLike, grid, sheet
from flexmech.types import FloatArray

__all__ = ["plot_composite_damping", "plot_composite_frequencies", "plot_laminate_factors"]

PANEL = 1.9
# From dark to light, so that the order shows without colour as well.
SHADES = ("#08306b", "#08519c", "#2171b5", "#4292c6", "#9ecae1", "#deebf7")
BAR_WIDTH = 0.8 / len(SHADES)
EDGE: Look = {"edgecolor": "black", "linewidth": 0.4}
POSITIONS = {
    "min": "Least transmission angle",
    "90": "Transmission angle 90 deg",
    "max": "Greatest transmission angle",
}

Marks = tuple[xr.DataArray, str, str, str]
"""Values drawn as markers on the bars, with their marker, colour and fill."""


def plot_composite_frequencies(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw fundamental frequencies by laminate, case and position as ratios.

    Elamy et al. 2023, Figure 8 and Tables 4 to 6.

    Parameters
    ----------
    dataset : Dataset
        Of :func:`flexmech.studies.study_composites`.
    ax : sequence of Axes, optional
        The user's, one for each of three positions. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    one = {"laminate": "C1", "case": 1, "position": "min"}
    computed = dataset["frequency"].sel(plies="unidirectional", beams="converged")
    marks: dict[str, Marks] = {
        "FE, published": (dataset["finite_element"], "D", "#D55E00", "#D55E00"),
        "measured": (dataset["measured"], "_", "black", "black"),
    }
    title = "Frequency over that of C1, case 1, least transmission angle (bars: computed)"
    return _bars(computed, marks, one, title, "Ratio of frequencies (-)", ax)


def plot_composite_damping(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw damping by laminate, case and position as ratios.

    Elamy et al. 2023, Figure 9 and Tables 4 to 6. Bars are beams that only bend; open circles
    are beams that shear too.

    Parameters
    ----------
    dataset : Dataset
        Of :func:`flexmech.studies.study_composites`.
    ax : sequence of Axes, optional
        The user's, one for each of three positions. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    one = {"laminate": "C6", "case": 1, "position": "min"}
    computed = dataset["strain_energy_damping"].sel(plies="unidirectional")
    marks: dict[str, Marks] = {
        "with shear": (computed.sel(beams="with shear"), "o", "black", "white"),
        "measured": (dataset["damping"], "D", "#D55E00", "#D55E00"),
    }
    title = "Damping over that of C6, case 1, least transmission angle (bars: computed, bending)"
    return _bars(computed.sel(beams="converged"), marks, one, title, "Ratio of damping (-)", ax)


def plot_laminate_factors(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw how the frequency changes with the laminate, by model of plies and beams.

    Parameters
    ----------
    dataset : Dataset
        Of :func:`flexmech.studies.study_composites`, with ``laminate_factor`` (plies, beams,
        laminate) and ``published_laminate_factor`` (laminate); C1 is 1.
    ax : Axes, optional
        The user's. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    factor = dataset["laminate_factor"]
    bent = factor.sel(beams="converged")
    curves = {
        "unidirectional plies": bent.sel(plies="unidirectional"),
        "woven plies": bent.sel(plies="woven"),
        "one modulus a laminate, Table 2": bent.sel(plies="table 2"),
        "published, Tables 5 and 6": dataset["published_laminate_factor"],
        "unidirectional plies, with shear": factor.sel(plies="unidirectional", beams="with shear"),
    }
    with sheet(grid(1, 1, 2.6), ax=ax) as drawn:
        (axes,) = drawn.panels
        handles: list[Artist] = []
        for number, (label, values) in enumerate(curves.items()):
            line = series_line(number) | {"marker": series_style(number).marker, "markersize": 4}
            axes.plot(names_of(dataset, "laminate"), values.values, **line)
            handles.append(series_handle(number, label, **line))
        drawn.header(handles, "Frequency of each laminate over that of C1")
        axes.set_ylim(0.0, 1.05)
        axes.set(xlabel="Laminate", ylabel="Ratio of frequencies (-)")
    return drawn.figure


def _bars(
    computed: xr.DataArray,
    marks: dict[str, Marks],
    one: dict[str, object],
    title: str,
    y_label: str,
    ax: AxesLike | None,
) -> Figure:
    """One panel a position, one group of bars a case, over the value at ``one`` place."""
    cases = [f"case {case}" for case in computed["case"].values]
    looks = [_mark(*look) for _, *look in marks.values()]
    with sheet(grid(3, 1, 3 * PANEL + 0.2, sharex=True, sharey=True), ax=ax) as drawn:
        handles: list[Artist] = [
            Patch(facecolor=shade, label=str(laminate), **EDGE)
            for shade, laminate in zip(SHADES, computed["laminate"].values, strict=True)
        ]
        handles += [line_handle(label, **look) for label, look in zip(marks, looks, strict=True)]
        drawn.header(handles, title)
        for axes, (position, words) in zip(drawn.panels, POSITIONS.items(), strict=True):
            axes.set_title(words)
            _group(axes, _ratio(computed, one, position))
            for (values, *_), look in zip(marks.values(), looks, strict=True):
                shown = _ratio(values, one, position)
                axes.plot(_places(len(cases)).ravel(), shown.ravel(), **look)
            plain_numbers(axes)
            axes.set_xticks(np.arange(len(cases)), cases)
        # Only now: the panels share the axis, and a limit ends its fitting to what is drawn.
        for axes in drawn.panels:
            axes.set_ylim(bottom=0.0)
        drawn.label_x("Proportions of the linkage")
        drawn.label_y(y_label)
    return drawn.figure


def _mark(marker: str, color: str, fill: str) -> Look:
    return {"ls": "", "marker": marker, "color": color, "mfc": fill, "ms": 3.8, "mew": 0.9}


def _ratio(values: xr.DataArray, one: dict[str, object], position: str) -> FloatArray:
    """Values at a position over that at one place; shape (case, laminate)."""
    return values_of((values / values.sel(one)).sel(position=position), "case", "laminate")


def _places(cases: int) -> FloatArray:
    """Middle of each bar; shape (case, laminate)."""
    offset = (np.arange(len(SHADES)) - (len(SHADES) - 1) / 2) * BAR_WIDTH
    return np.arange(cases)[:, None] + offset


def _group(axes: Axes, ratio: FloatArray) -> None:
    """Bars of a position; shape (case, laminate)."""
    for places, heights, shade in zip(_places(len(ratio)).T, ratio.T, SHADES, strict=True):
        axes.bar(places, heights, BAR_WIDTH, color=shade, **EDGE)
