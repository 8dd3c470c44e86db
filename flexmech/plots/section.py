"""Through the thickness of links: strain and stress under unit loads, and moisture."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import groupby

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from flexmech.arrays import FloatArray
from flexmech.plots import scales, style
from flexmech.plots.drawing import draw
from flexmech.plots.layout import AxesLike, grid, sheet
from flexmech.plots.picture import Curve, Pane, Picture, Span
from flexmech.plots.reading import names_of, spread, values_of
from flexmech.plots.style import LABEL_POINTS, TIMES, Look, line_handle, series_handle, series_line
from flexmech.units import ZERO_CELSIUS, from_si

# Two rows and the legend fill half a page, in inches.
PANEL_HEIGHT = 2.2
# Height of a panel's inside in points, and of a line of text over the size of its letters.
INSIDE, LINE = 140.0, 1.3
# More layers than this are named by their shades in the legend, not one by one: letters would be
# smaller than five points.
MOST_NAMES = 22
# Letters of a name that the panel of layers holds beside the stack.
LONGEST_NAME = 24
# Greys of the plies: light enough for the lines on them, apart enough to be told.
LIGHTEST, DARKEST = 0.96, 0.80
# A line between layers that have one shade and different angles.
BETWEEN_LAYERS: Look = {"ec": "0.70", "lw": 0.3, "zorder": 0.5}
# Two lines closer than this fraction of the largest value are one: they would be drawn as one.
SAME = 1e-6
# Right edge of the drawn stack and left edge of its names, over the panel's width: names take most.
STACK_EDGE, NAME_EDGE = 0.20, 0.30
# Numbers of the styles of lines.
COUPLED, UNCOUPLED, THIRD_ORDER = 0, 1, 2
NEUTRAL_AXIS: Look = {"ls": (0.0, (8.0, 2.0, 1.5, 2.0)), "color": "black", "lw": 0.9}
MASS_AXIS = NEUTRAL_AXIS | {"ls": (0.0, (1.5, 1.5))}

LOADS = {"axial_force": "N = 1 N", "bending_moment": "M = 1 N m", "shear_force": "V = 1 N"}
# Quantity and load of each panel; the layers stand in the third one.
PROFILES = (
    ("strain", "axial_force"),
    ("normal_stress", "axial_force"),
    ("strain", "bending_moment"),
    ("normal_stress", "bending_moment"),
    ("shear_stress", "shear_force"),
)
LAYERS_PANEL = 2
PASCAL = {-3: "mPa", 0: "Pa", 3: "kPa", 6: "MPa", 9: "GPa"}

# Of a link's two panels in inches, four of which fit a page; on a narrow page they stand under each
# other, and six do.
ROW_HEIGHT, NARROW_ROW_HEIGHT = 2.1, 1.6
# Formulas beside the finite volumes, by the numbers of their styles.
LAWS = {1: ("short_time_uptake", "root of time"), 3: ("shen_springer_uptake", "Shen & Springer")}
TIME_UNITS = ("day", "hour", "second")


@dataclass(frozen=True)
class _Run:
    """Neighbouring layers of one ply and angle: name, faces in mm along the stack and grey."""

    ply: str
    text: str
    low: float
    high: float
    shade: str
    first: int
    """Number of its first layer."""


def plot_section(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw strain and stress of a link under unit loads against the place in its thickness.

    An axial force along the pins' axis, a bending moment and a shear force, each alone. Where
    the section is unsymmetric the dashed lines leave its axial-bending coupling out. The
    shear stress is the one that balances the normal stress; where the third-order theory has
    another one, it is drawn too. The layers are shaded by ply and named from the stack. Layers
    across the width, which all reach through the thickness, have a line for each kind of ply.

    Parameters
    ----------
    dataset : Dataset
        Of one link, named by the coordinate ``link``, over (coupling, load, layer, point):
        ``place`` in m, ``strain``, ``normal_stress``, ``shear_stress`` and
        ``third_order_shear_stress`` in Pa under 1 N or 1 N m, with ``ply`` and ``angle`` (rad)
        of the layers, ``neutral_axis`` and ``mass_axis`` in m. Layers and points without a
        place are left out. ``direction_of_layers`` and ``layer_thickness`` (layer) in m tell how
        the layers are stacked.
    ax : sequence of Axes, optional
        The user's six. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    for dimension in ("layer", "point"):
        dataset = dataset.dropna(dimension, how="all", subset=["place"])
    runs, across = _runs(dataset), dataset["direction_of_layers"] == "across width"
    kinds = _kinds(runs) if across else {}
    profiles = [
        _lines_of_kinds(dataset, list(kinds.values()), *profile)
        if across
        else _lines(dataset, *profile)
        for profile in PROFILES
    ]
    place = 1e3 * dataset["place"].values
    named = len(runs) <= MOST_NAMES
    layout = grid(2, 3, 2 * PANEL_HEIGHT + 0.9, narrow=2, sharey=True, gridspec_kw={"wspace": 0.06})
    with sheet(layout, ax=ax) as drawn:
        link = str(dataset["link"].item()).capitalize()
        handles = _handles(dataset, set().union(*profiles), [] if named else runs, kinds)
        title = f"{link}: through the thickness under unit loads on the pins' axis"
        drawn.header(handles, title, of=dataset)
        stack = drawn.panels[LAYERS_PANEL]
        for axes in drawn.panels:
            edge = STACK_EDGE if axes is stack else 1.0
            for run in () if across else runs:
                axes.axhspan(run.low, run.high, xmax=edge, fc=run.shade, **BETWEEN_LAYERS)
            axes.set_ylim(place.min(), place.max())
            scales.plain_numbers(axes)
        of_profiles = [axes for axes in drawn.panels if axes is not stack]
        for axes, lines, profile in zip(of_profiles, profiles, PROFILES, strict=True):
            _draw_profile(axes, dataset, lines, *profile)
        _draw_axes_of_section(stack, dataset)
        if across:
            _stand_layers(stack, runs)
        elif named:
            _name_layers(stack, runs)
        drawn.label_y("Place y from the pins' axis (mm)")
        if drawn.is_new:
            drawn.figure.align_xlabels(of_profiles)
    return drawn.figure


def _runs(dataset: xr.Dataset) -> list[_Run]:
    thickness = 1e3 * dataset["layer_thickness"].values
    faces = np.concatenate([[0.0], np.cumsum(thickness)]) - thickness.sum() / 2
    degrees = np.round(np.degrees(dataset["angle"].values.astype(float)), 6)
    layers = list(zip(dataset["ply"].values.tolist(), degrees.tolist(), strict=True))
    plies = list(dict.fromkeys(ply for ply, _ in layers))
    greys = dict(zip(plies, np.linspace(LIGHTEST, DARKEST, max(len(plies), 2)), strict=False))
    runs, start = [], 0
    for (ply, angle), group in groupby(layers):
        end = start + len(list(group))
        turned = f" {angle:.4g}°".replace("-", "\N{MINUS SIGN}") if np.any(degrees != 0) else ""
        tail = turned + (f" {TIMES} {end - start}" if end - start > 1 else "")
        text = _short(ply, LONGEST_NAME - len(tail)) + tail if ply else "one material"
        runs.append(_Run(ply, text, faces[start], faces[end], f"{greys[ply]:.3f}", start))
        start = end
    return runs


def _short(name: str, longest: int) -> str:
    """Cut a name to a length; its dollar signs stay, where matplotlib would see a formula."""
    cut = name if len(name) <= longest else f"{name[: longest - 1]}…"
    return cut.replace("$", r"\$")


def _draw_profile(
    axes: Axes, dataset: xr.Dataset, lines: dict[int, FloatArray], name: str, load: str
) -> None:
    """One quantity under one load; jumps at interfaces are drawn along them."""
    what = name.replace("_", " ").capitalize()
    factor, unit = _scaled(dataset, name, load)
    for number, values in lines.items():
        place = 1e3 * _flat(dataset["place"])[: len(values)]
        axes.plot(factor * values, place, **series_line(number), zorder=3)
    axes.axvline(0.0, color=style.MID_GREY, lw=0.5, zorder=2)
    neutral = 1e3 * float(dataset["neutral_axis"])
    axes.axhline(neutral, color=style.MID_GREY, ls=NEUTRAL_AXIS["ls"], lw=0.7, zorder=2)
    ends = factor * np.concatenate([[0.0], *lines.values()])
    low, high = float(ends.min()), float(ends.max())
    room = 0.08 * ((high - low) or 1.0)
    axes.set_xlim(low - room * (low < 0), high + room * (high > 0))
    axes.xaxis.set_major_locator(MaxNLocator(nbins=5, steps=[1, 2, 2.5, 5, 10]))
    axes.set(title=f"{what}, {LOADS[load]}", xlabel=f"{what} ({unit})")


def _lines(dataset: xr.Dataset, name: str, load: str) -> dict[int, FloatArray]:
    """What there is to draw of a quantity, by the number of its style, the main line last."""
    under = dataset.sel(load=load)
    coupled = _flat(under[name].sel(coupling="with"))
    others = {UNCOUPLED: _flat(under[name].sel(coupling="without"))}
    if name == "shear_stress":
        third_order = _flat(under["third_order_shear_stress"].sel(coupling="with"))
        others = {THIRD_ORDER: third_order} | others
    least = SAME * np.abs(coupled).max()
    apart = {n: values for n, values in others.items() if np.abs(values - coupled).max() > least}
    return apart | {COUPLED: coupled}


def _kinds(runs: list[_Run]) -> dict[str, int]:
    """First layer of each kind of ply."""
    first: dict[str, int] = {}
    for run in runs:
        first.setdefault(run.text.split(f" {TIMES} ")[0], run.first)
    return first


def _lines_of_kinds(
    dataset: xr.Dataset, layers: list[int], name: str, load: str
) -> dict[int, FloatArray]:
    """Of layers across the width: a line for one of each kind, or one where all are alike."""
    rows = values_of(dataset[name].sel(load=load, coupling="with"), "layer", "point")[layers]
    if np.abs(rows - rows[0]).max() <= SAME * np.abs(rows).max():
        rows = rows[:1]
    return dict(enumerate(rows))


def _flat(values: xr.DataArray) -> FloatArray:
    return values_of(values, "layer", "point").ravel()


def _scaled(dataset: xr.Dataset, name: str, load: str) -> tuple[float, str]:
    """Factor and unit that make the largest value a number between 1 and 1000."""
    largest = float(np.abs(dataset[name].sel(load=load)).max())
    power = 3 * int(np.floor(np.log10(largest) / 3)) if largest > 0 else 0
    ten = f"$10^{{{power}}}$"
    if name == "strain":
        return 10.0**-power, ten if power else "1"
    return 10.0**-power, PASCAL.get(power, f"{ten} Pa")


def _draw_axes_of_section(axes: Axes, dataset: xr.Dataset) -> None:
    """The neutral axis and the mass axis, across the stack of layers."""
    axes.set(title="Layers", xlim=(0.0, 1.0))
    axes.xaxis.set_visible(False)
    axes.spines["bottom"].set_visible(False)
    for place, look in _axes_of(dataset).values():
        axes.plot([0.0, STACK_EDGE], [place, place], **look, zorder=3)


def _name_layers(axes: Axes, runs: list[_Run]) -> None:
    """Names of the layers beside their shades."""
    middles = np.array([(run.low + run.high) / 2 for run in runs])
    low, high = runs[0].low, runs[-1].high
    size = min(LABEL_POINTS, INSIDE / (LINE * len(runs)))
    step = LINE * size / INSIDE * (high - low)  # a line of text in mm of the link
    # First apart, then inside: what is pushed in at one end pushes its neighbours.
    rows = step * np.arange(len(runs))
    inside = low + step / 2, high - step / 2 - rows[-1]
    names = np.clip(spread(middles, step) - rows, *inside) + rows
    for run, middle, name in zip(runs, middles, names, strict=True):
        axes.plot([STACK_EDGE, NAME_EDGE - 0.02], [middle, name], color=style.MID_GREY, lw=0.5)
        axes.text(NAME_EDGE, name, run.text, fontsize=size, va="center")


def _stand_layers(axes: Axes, runs: list[_Run]) -> None:
    """Layers across the width side by side, the names of their kinds beside them."""
    low, high = runs[0].low, runs[-1].high
    for run in runs:
        left, right = (STACK_EDGE * (x - low) / (high - low) for x in (run.low, run.high))
        axes.axvspan(left, right, fc=run.shade, **BETWEEN_LAYERS)
    text = "\n".join(run.text for run in runs[:MOST_NAMES])
    axes.text(NAME_EDGE, 0.0, f"From left to right:\n{text}", fontsize=LABEL_POINTS, va="center")


def _axes_of(dataset: xr.Dataset) -> dict[str, tuple[float, Look]]:
    """Places in mm and looks of the neutral axis and the mass axis, or of both in one."""
    neutral, mass = (1e3 * float(dataset[name]) for name in ("neutral_axis", "mass_axis"))
    if neutral == mass:
        return {"neutral axis and centre of mass": (neutral, NEUTRAL_AXIS)}
    return {"neutral axis": (neutral, NEUTRAL_AXIS), "centre of mass": (mass, MASS_AXIS)}


def _handles(
    dataset: xr.Dataset, numbers: set[int], runs: list[_Run], kinds: dict[str, int]
) -> list[Artist]:
    """Legend entries of lines by the numbers of their styles, of axes, and of plies."""
    labels = {UNCOUPLED: "without coupling", THIRD_ORDER: "shear stress by third-order theory"}
    alone = "classical theory, shear by equilibrium"
    labels[COUPLED] = "with coupling" if UNCOUPLED in numbers else alone
    if len(kinds) > 1:
        labels = dict(enumerate(kinds))
    handles = [series_handle(n, labels[n]) for n in sorted(numbers)]
    handles += [line_handle(label, **look) for label, (_, look) in _axes_of(dataset).items()]
    for ply, shade in dict.fromkeys((run.ply, run.shade) for run in runs):
        handles.append(Patch(fc=shade, ec=style.MID_GREY, lw=0.6, label=_short(ply, LONGEST_NAME)))
    return handles


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
    unit = _time_unit(dataset)
    attrs = dataset.attrs
    title = (
        f"Moisture at {100 * attrs['relative_humidity']:.4g} % relative humidity, "
        f"{attrs['temperature'] - ZERO_CELSIUS:.4g} °C"
    )
    links = names_of(dataset, "link")
    panes = [make(dataset, link) for link in links for make in (profile_pane, uptake_pane)]
    if not style.is_narrow():
        # The axes of a column are labelled below the last of them.
        panes = [replace(pane, along="") for pane in panes[:-2]] + panes[-2:]
    row = NARROW_ROW_HEIGHT if style.is_narrow() else ROW_HEIGHT
    return draw(
        Picture(panes, "", dataset, title),
        grid(len(links), 2, row * len(links) + 0.5, sharex="col"),
        ax=ax,
        legend=_moisture_handles(dataset, unit),
    )


def _time_unit(dataset: xr.Dataset) -> str:
    end = float(dataset["time"].max())
    return next((name for name in TIME_UNITS if from_si(end, name) >= 1), "second")


def _after(dataset: xr.Dataset) -> list[str]:
    """Times of the profiles in words."""
    unit = _time_unit(dataset)
    times = from_si(1.0, unit) * dataset["profile_time"].values
    return [f"{time:.0f} {unit[0]}" if time >= 1000 else f"{time:.3g} {unit[0]}" for time in times]


def _colours(dataset: xr.Dataset) -> list[tuple[float, float, float, float]]:
    """Dark to light with time, told apart in grey as well."""
    places = np.linspace(0.0, 0.85, dataset.sizes["profile_time"])
    return [mpl.colormaps["viridis"](place) for place in places]


def _moisture_handles(dataset: xr.Dataset, unit: str) -> list[Artist]:
    handles = [
        line_handle(words, color=colour)
        for words, colour in zip(_after(dataset), _colours(dataset), strict=True)
    ]
    handles.append(line_handle("finite volumes", color="black"))
    laws = {n: label for n, (name, label) in LAWS.items() if dataset[name].count()}
    return [*handles, *(series_handle(number, label) for number, label in laws.items())]


def profile_pane(dataset: xr.Dataset, link: str) -> Pane:
    """Moisture of a link's resin through its thickness after each of the times."""
    own = dataset.sel(link=link)
    known = np.isfinite(own["place"].values)
    place, profiles = 1e3 * own["place"].values[known], own["profile"].transpose(..., "cell")
    curves = [
        Curve(place, 100 * profile[known], {"color": colour}, words)
        for profile, colour, words in zip(
            profiles.values, _colours(dataset), _after(dataset), strict=True
        )
    ]
    what = "mean over the width" if own["over_width"] else "through the thickness"
    return Pane(
        "Moisture of the resin (%)",
        curves,
        title=f"{link.capitalize()}: {what}",
        limits=(0.0, 1.05 * max(float(np.nanmax(one.y)) for one in curves)),
        along="Distance from the middle (mm)",
    )


def uptake_pane(dataset: xr.Dataset, link: str) -> Pane:
    """Uptake of a link over that in the end, against the root of time."""
    own, unit = dataset.sel(link=link), _time_unit(dataset)
    root = np.sqrt(own["time"].values * from_si(1.0, unit))
    curves = [Curve(root, own["uptake"].values, {"color": "black"}, "finite volumes")]
    for number, (name, words) in LAWS.items():
        curves.append(Curve(root, own[name].values, series_line(number), words))
    return Pane(
        "Share of equilibrium",
        curves,
        title=f"{link.capitalize()}: uptake",
        spans=(Span(1.0, 1.0, {"color": style.MID_GREY, "lw": 0.6, "zorder": 1}),),
        limits=(0.0, 1.08),
        along=f"Root of time (√{unit})",
    )
