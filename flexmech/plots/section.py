"""Strain and stress through the thickness of a link under unit loads."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from matplotlib.ticker import MaxNLocator

from flexmech.plots.spectra import spread
from flexmech.plots.style import (
    LABEL_SIZE,
    MID_GREY,
    header_height,
    header_legend,
    new_figure,
    plain_numbers,
    publication_style,
    series_handle,
    series_style,
)
from flexmech.types import FloatArray

__all__ = ["plot_section"]


PANEL_HEIGHT = 2.2
# More layers than this are named by their shades in the legend, not one by one.
MOST_NAMES = 22
NAME_SIZE = 7.0
# Height of a panel's inside in points, and of a line of text over the size of its letters.
INSIDE = 140.0
LINE = 1.3
LONGEST_NAME = 24
# Greys of the plies: light enough for the lines on them, apart enough to be told.
LIGHTEST, DARKEST = 0.96, 0.80
LAYER_EDGE = "0.70"
TIMES = "\N{MULTIPLICATION SIGN}"
# Two lines closer than this fraction of the largest value are one.
SAME = 1e-6
# Right edge of the drawn stack and left edge of its names, over the panel's width.
STACK_EDGE, NAME_EDGE = 0.20, 0.30
COUPLED, UNCOUPLED, THIRD_ORDER = 0, 1, 2
NEUTRAL_AXIS = (0.0, (8.0, 2.0, 1.5, 2.0))
MASS_AXIS = (0.0, (1.5, 1.5))

_LOADS = {
    "axial_force": "N = 1 N",
    "bending_moment": "M = 1 N m",
    "shear_force": "V = 1 N",
}


@dataclass(frozen=True)
class _Run:
    """Neighbouring layers of one ply and angle: name, faces in mm and how many they are."""

    ply: str
    text: str
    low: float
    high: float


def plot_section(dataset: xr.Dataset) -> Figure:
    """Draw strain and stress of a link under unit loads against the place in its thickness.

    An axial force along the pins' axis, a bending moment and a shear force, each alone. Where
    the section is unsymmetric the dashed lines leave its axial-bending coupling out. The
    shear stress is the one that balances the normal stress; where the third-order theory has
    another one, it is drawn too. The layers are shaded by ply and named from the stack.

    Parameters
    ----------
    dataset : Dataset
        Over (coupling, load, layer, point): ``place`` in m, ``strain``, ``normal_stress``,
        ``shear_stress`` and ``third_order_shear_stress`` in Pa under 1 N or 1 N m, with
        ``ply`` and ``angle`` (rad) of the layers, ``neutral_axis`` and ``mass_axis`` in m,
        and the link's name as the attribute ``link``.

    Returns
    -------
    Figure
    """
    with publication_style():
        runs = _runs(dataset)
        shades = _shades(runs)
        named = len(runs) <= MOST_NAMES
        handles = _handles(dataset, {} if named else shades)
        link = str(dataset.attrs["link"]).capitalize()
        title = f"{link}: through the thickness under unit loads on the pins' axis"
        figure = new_figure(2 * PANEL_HEIGHT + 0.9 + header_height(handles, title))
        grid = figure.add_gridspec(2, 3, wspace=0.06)
        first = figure.add_subplot(grid[0, 0])
        panels = {(0, 0): first}
        for row, column in ((0, 1), (0, 2), (1, 0), (1, 1), (1, 2)):
            panels[row, column] = figure.add_subplot(grid[row, column], sharey=first)
        for (_, column), axes in panels.items():
            _shade(axes, runs, shades, STACK_EDGE if axes is panels[0, 2] else None)
            axes.tick_params(labelleft=column == 0)
        _draw_profile(panels[0, 0], dataset, "strain", "axial_force")
        _draw_profile(panels[0, 1], dataset, "normal_stress", "axial_force")
        _draw_profile(panels[1, 0], dataset, "strain", "bending_moment")
        _draw_profile(panels[1, 1], dataset, "normal_stress", "bending_moment")
        _draw_profile(panels[1, 2], dataset, "shear_stress", "shear_force")
        _draw_stack(panels[0, 2], dataset, runs if named else [])
        first.set_ylim(runs[0].low, runs[-1].high)
        plain_numbers(first)
        figure.align_xlabels([panels[1, column] for column in range(3)])
        figure.align_xlabels([panels[0, column] for column in range(2)])
        figure.supylabel("Place y from the pins' axis (mm)", fontsize=LABEL_SIZE)
        header_legend(figure, handles, title)
    return figure


def _runs(dataset: xr.Dataset) -> list[_Run]:
    place = 1e3 * dataset["place"].transpose("layer", "point").values
    degrees = np.round(np.degrees(dataset["angle"].values.astype(float)), 6)
    layers = list(zip(dataset["ply"].values.tolist(), degrees.tolist(), strict=True))
    runs, start = [], 0
    for (ply, angle), group in groupby(layers):
        count = len(list(group))
        turned = f" {angle:.4g}°".replace("-", "\N{MINUS SIGN}") if np.any(degrees != 0) else ""
        tail = turned + (f" {TIMES} {count}" if count > 1 else "")
        text = _short(ply, LONGEST_NAME - len(tail)) + tail if ply else "one material"
        end = start + count
        runs.append(_Run(ply, text, place[start, 0], place[end - 1, -1]))
        start = end
    return runs


def _short(name: str, longest: int = LONGEST_NAME) -> str:
    """Cut a name to a length; its dollar signs stay, where matplotlib would see a formula."""
    cut = name if len(name) <= longest else f"{name[: longest - 1]}…"
    return cut.replace("$", r"\$")


def _shades(runs: list[_Run]) -> dict[str, str]:
    """Grey of each ply, evenly spaced."""
    plies = list(dict.fromkeys(run.ply for run in runs))
    greys = np.linspace(LIGHTEST, DARKEST, max(len(plies), 2))
    return {ply: f"{grey:.3f}" for ply, grey in zip(plies, greys, strict=False)}


def _shade(axes: Axes, runs: list[_Run], shades: dict[str, str], edge: float | None) -> None:
    """Fill the layers over the panel's width, or to an edge of it."""
    for run in runs:
        axes.add_patch(
            Rectangle(
                (0.0, run.low),
                edge or 1.0,
                run.high - run.low,
                transform=axes.get_yaxis_transform(),
                facecolor=shades[run.ply],
                # A line between layers that have one shade and different angles.
                edgecolor=LAYER_EDGE,
                linewidth=0.3,
                zorder=0.5,
            )
        )


def _draw_profile(axes: Axes, dataset: xr.Dataset, name: str, load: str) -> None:
    """One quantity under one load; jumps at interfaces are drawn along them."""
    what = name.replace("_", " ")
    factor, unit = _scaled(dataset, name, load)
    place = 1e3 * _flat(dataset["place"])
    lines = _lines(dataset, name, load)
    for style_number, values in lines.items():
        series = series_style(style_number)
        axes.plot(factor * values, place, color=series.color, linestyle=series.linestyle, zorder=3)
    axes.axvline(0.0, color=MID_GREY, lw=0.5, zorder=2)
    _, neutral, style = _axes_of(dataset)[0]
    axes.axhline(neutral, color=MID_GREY, ls=style, lw=0.7, zorder=2)
    ends = factor * np.array([f(v) for v in lines.values() for f in (np.min, np.max)] + [0.0])
    low, high = float(ends.min()), float(ends.max())
    room = 0.08 * ((high - low) or 1.0)
    axes.set_xlim(low - room * (low < 0), high + room * (high > 0))
    axes.xaxis.set_major_locator(MaxNLocator(nbins=5, steps=[1, 2, 2.5, 5, 10]))
    axes.set_title(f"{what.capitalize()}, {_LOADS[load]}")
    axes.set_xlabel(f"{what.capitalize()} ({unit})")


def _lines(dataset: xr.Dataset, name: str, load: str) -> dict[int, FloatArray]:
    """What there is to draw of a quantity, by the number of its style."""
    under = dataset.sel(load=load)
    coupled = _flat(under[name].sel(coupling="with"))
    lines = {COUPLED: coupled}
    others = {UNCOUPLED: _flat(under[name].sel(coupling="without"))}
    if name == "shear_stress":
        others[THIRD_ORDER] = _flat(under["third_order_shear_stress"].sel(coupling="with"))
    for number, values in others.items():
        if np.max(np.abs(values - coupled)) > SAME * np.max(np.abs(coupled)):
            lines[number] = values
    return dict(sorted(lines.items(), reverse=True))


def _flat(values: xr.DataArray) -> FloatArray:
    return np.asarray(values.transpose("layer", "point").values.ravel(), dtype=float)


def _scaled(dataset: xr.Dataset, name: str, load: str) -> tuple[float, str]:
    """Factor and unit that make the largest value a number between 1 and 1000."""
    largest = float(np.abs(dataset[name].sel(load=load)).max())
    power = 3 * int(np.floor(np.log10(largest) / 3)) if largest > 0 else 0
    if name != "strain" and -3 <= power <= 9:
        prefix = {-3: "m", 0: "", 3: "k", 6: "M", 9: "G"}[power]
        return 10.0**-power, f"{prefix}Pa"
    unit = "" if name == "strain" else " Pa"
    return 10.0**-power, f"$10^{{{power}}}$" + unit if power else unit.strip() or "1"


def _draw_stack(axes: Axes, dataset: xr.Dataset, runs: list[_Run]) -> None:
    """Names of the layers beside their shades, the neutral axis and the mass axis."""
    axes.set_title("Layers")
    axes.set_xlim(0.0, 1.0)
    axes.xaxis.set_visible(False)
    axes.spines["bottom"].set_visible(False)
    for _, y, style in _axes_of(dataset):
        axes.plot([0.0, STACK_EDGE], [y, y], color="black", ls=style, lw=0.9, zorder=3)
    if not runs:
        return
    middles = np.array([(run.low + run.high) / 2 for run in runs])
    height = runs[-1].high - runs[0].low
    size = min(NAME_SIZE, INSIDE / (LINE * len(runs)))
    step = LINE * size / INSIDE * height  # a line of text in mm of the link
    # First apart, then inside: what is pushed in at one end pushes its neighbours.
    rows = step * np.arange(len(runs))
    names = spread(middles, step)
    names = np.maximum.accumulate(np.maximum(names, runs[0].low + step / 2) - rows) + rows
    rows = rows[::-1]
    names = np.minimum(names, runs[-1].high - step / 2) + rows
    names = np.minimum.accumulate(names[::-1])[::-1] - rows
    for run, middle, name in zip(runs, middles, names, strict=True):
        axes.plot([STACK_EDGE, NAME_EDGE - 0.02], [middle, name], color=MID_GREY, lw=0.5)
        axes.text(NAME_EDGE, name, run.text, fontsize=size, va="center")


def _axes_of(dataset: xr.Dataset) -> list[tuple[str, float, tuple[float, tuple[float, ...]]]]:
    """Label, place in mm and dashes of the neutral axis and the mass axis, or of both in one."""
    neutral, mass = (1e3 * float(dataset[name]) for name in ("neutral_axis", "mass_axis"))
    if neutral == mass:
        return [("neutral axis and centre of mass", neutral, NEUTRAL_AXIS)]
    return [("neutral axis", neutral, NEUTRAL_AXIS), ("centre of mass", mass, MASS_AXIS)]


def _handles(dataset: xr.Dataset, shades: dict[str, str]) -> list[Artist]:
    drawn = {
        number
        for name, load in (
            ("strain", "axial_force"),
            ("strain", "bending_moment"),
            ("normal_stress", "bending_moment"),
            ("shear_stress", "shear_force"),
        )
        for number in _lines(dataset, name, load)
    }
    labels = {
        COUPLED: "with coupling"
        if UNCOUPLED in drawn
        else "classical theory, shear by equilibrium",
        UNCOUPLED: "without coupling",
        THIRD_ORDER: "shear stress by third-order theory",
    }
    handles: list[Artist] = [series_handle(n, labels[n]) for n in sorted(drawn)]
    for label, _, style in _axes_of(dataset):
        handles.append(Line2D([], [], color="black", ls=style, lw=0.9, label=label))
    outline = mpl.rcParams["axes.linewidth"]
    for ply, shade in shades.items():
        handles.append(Patch(facecolor=shade, edgecolor=MID_GREY, lw=outline, label=_short(ply)))
    return handles
