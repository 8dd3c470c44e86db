"""Through the thickness of links: strain and stress under unit loads, and moisture."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import groupby

import matplotlib as mpl
import numpy as np
import xarray as xr

from flexmech.arrays import FloatArray
from flexmech.plots import scales, style
from flexmech.plots.drawing import figure
from flexmech.plots.layout import grid
from flexmech.plots.picture import Curve, Note, Pane, Picture, Span
from flexmech.plots.reading import names_of, spread, values_of
from flexmech.plots.style import LABEL_POINTS, TIMES, Look, series_line
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
# Greys of the plies: light enough for the lines on them, apart enough to be distinguished.
LIGHTEST, DARKEST = 0.96, 0.80
# A line between layers that have one shade and different angles.
BETWEEN_LAYERS: Look = {"edgecolor": "0.70", "lw": 0.3, "zorder": 0.5}
# Two lines closer than this fraction of the largest value are one: they would be drawn as one.
SAME = 1e-6
# Right edge of the drawn stack and left edge of its names, over the panel's width: names take most.
STACK_EDGE, NAME_EDGE = 0.20, 0.30
# Numbers of the styles of lines.
COUPLED, UNCOUPLED, THIRD_ORDER = 0, 1, 2
PLAIN = "classical theory, shear by equilibrium"
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

# Height of a link's two panels in inches, four of which fit a page; on a narrow page they stand
# under each other, and six do.
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


@figure
def plot_section(dataset: xr.Dataset) -> Picture:
    """Draw strain and stress of a link under unit loads against the place in its thickness.

    An axial force along the pins' axis, a bending moment and a shear force, each alone. Where
    the section is unsymmetric the dashed lines leave its axial-bending coupling out. The
    shear stress is the one that balances the normal stress; where the third-order theory has
    another one, it is drawn too. The layers are shaded by ply and named from the stack. Layers
    across the width, which all reach through the thickness, have a line for each kind of ply.

    Parameters
    ----------
    dataset : Dataset
        Dataset of one link, named by the coordinate ``link``, over (coupling, load, layer, point):
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
    dataset = _with_places(dataset)
    runs, across = _runs(dataset), dataset["direction_of_layers"] == "across width"
    named, place = len(runs) <= MOST_NAMES, 1e3 * dataset["place"].values
    zero = Span(0.0, 0.0, {"color": style.MID_GREY, "lw": 0.5, "zorder": 2}, upright=True)
    neutral = 1e3 * float(dataset["neutral_axis"])
    thin: Look = {"color": style.MID_GREY, "ls": NEUTRAL_AXIS["ls"], "lw": 0.7, "zorder": 2}
    spans = [zero, Span(neutral, neutral, thin), *([] if across else _shades(runs, 1.0))]
    panes, legend = list[Pane](), dict[str, Look]()
    for name, load in PROFILES:
        curves = profile_curves(dataset, name, load)
        legend |= {one.name: one.look for one in curves}
        factor, unit = _scaled(dataset, name, load)
        turned = [
            replace(one, x=factor * one.y, y=one.x, look=one.look | {"zorder": 3}) for one in curves
        ]
        ends = np.concatenate([[0.0], *(one.x for one in turned)])
        low, high = float(ends.min()), float(ends.max())
        room, what = 0.08 * ((high - low) or 1.0), name.replace("_", " ").capitalize()
        panes.append(
            Pane(
                "",
                turned,
                title=f"{what}, {LOADS[load]}",
                spans=spans,
                along=f"{what} ({unit})",
                x_limits=(low - room * (low < 0), high + room * (high > 0)),
                x_ticks=scales.ticks_within(low, high, 5),
            )
        )
    panes.insert(LAYERS_PANEL, _stack(dataset, runs, across=bool(across), named=named))
    limits = float(place.min()), float(place.max())
    legend |= {words: look for words, (_, look) in _axes_of(dataset).items()}
    for run in [] if named else runs:
        grey: Look = {"facecolor": run.shade, "edgecolor": style.MID_GREY, "lw": 0.6}
        legend[_short(run.ply, LONGEST_NAME)] = grey
    return Picture(
        [replace(pane, limits=limits) for pane in panes],
        "",
        dataset,
        f"{str(dataset['link'].item()).capitalize()}: through the thickness under unit loads on "
        "the pins' axis",
        "Place y from the pins' axis (mm)",
        layout=grid(
            2, 3, 2 * PANEL_HEIGHT + 0.9, narrow=2, sharey=True, gridspec_kw={"wspace": 0.06}
        ),
        legend=legend,
    )


def _shades(runs: list[_Run], edge: float) -> list[Span]:
    """Layers on each other, up to a part of the width of a pane."""
    looks = [{"facecolor": run.shade, "xmax": edge, **BETWEEN_LAYERS} for run in runs]
    return [Span(run.low, run.high, look) for run, look in zip(runs, looks, strict=True)]


def _stack(dataset: xr.Dataset, runs: list[_Run], *, across: bool, named: bool) -> Pane:
    """The layers with their names, the neutral axis and the mass axis."""
    curves, edge = list[Curve](), np.array([0.0, STACK_EDGE])
    for place, look in _axes_of(dataset).values():
        curves.append(Curve(edge, np.full(2, place), look | {"zorder": 3}))
    spans, notes = [] if across else _shades(runs, STACK_EDGE), list[Note]()
    low, high = runs[0].low, runs[-1].high
    if across:
        # Side by side, the names of their kinds beside them.
        for run in runs:
            left, right = (STACK_EDGE * (x - low) / (high - low) for x in (run.low, run.high))
            grey = {"facecolor": run.shade, **BETWEEN_LAYERS}
            spans.append(Span(left, right, grey, upright=True))
        text = "\n".join(["From left to right:", *(run.text for run in runs[:MOST_NAMES])])
        notes = [Note(NAME_EDGE, 0.0, text, {"fontsize": LABEL_POINTS, "va": "center"})]
    elif named:
        size = min(LABEL_POINTS, INSIDE / (LINE * len(runs)))
        step = LINE * size / INSIDE * (high - low)  # a line of text in mm of the link
        middles = np.array([(run.low + run.high) / 2 for run in runs])
        # First apart, then inside: what is pushed in at one end pushes its neighbours.
        rows = step * np.arange(len(runs))
        inside = low + step / 2, high - step / 2 - rows[-1]
        names = np.clip(spread(middles, step) - rows, *inside) + rows
        leader: Look = {"color": style.MID_GREY, "lw": 0.5}
        for run, middle, name in zip(runs, middles, names.tolist(), strict=True):
            x = np.array([STACK_EDGE, NAME_EDGE - 0.02])
            curves.append(Curve(x, np.array([middle, name]), leader))
            notes.append(Note(NAME_EDGE, name, run.text, {"fontsize": size, "va": "center"}))
    layers: Look = {"title": "Layers", "x_limits": (0.0, 1.0), "apart": "none"}
    return Pane("", curves, spans=spans, notes=notes, **layers)


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


def profile_curves(dataset: xr.Dataset, name: str, load: str) -> list[Curve]:
    """A quantity under a unit load over the place in mm: what there is to tell apart of it.

    With and without axial-bending coupling, and the shear stress by the third-order theory; of
    layers across the width a line for each kind of ply. What would lie on the main line, the last,
    is left out.

    Parameters
    ----------
    dataset : Dataset
        As of :func:`plot_section`.
    name : {"strain", "normal_stress", "shear_stress"}
    load : {"axial_force", "bending_moment", "shear_force"}

    Returns
    -------
    list of Curve
        In the SI unit.
    """
    dataset = _with_places(dataset)
    under = dataset.sel(load=load)
    if dataset["direction_of_layers"] == "across width":
        kinds = _kinds(_runs(dataset))
        rows = values_of(under[name].sel(coupling="with"), "layer", "point")[[*kinds.values()]]
        same = np.abs(rows - rows[0]).max() <= SAME * np.abs(rows).max()
        place = 1e3 * values_of(dataset["place"], "layer", "point")[0]
        names = [PLAIN] if same else list(kinds)
        return [
            Curve(place, row, series_line(number), words)
            for number, (row, words) in enumerate(zip(rows, names, strict=False))
        ]
    coupled = _flat(under[name].sel(coupling="with"))
    lines = {UNCOUPLED: _flat(under[name].sel(coupling="without"))}
    if name == "shear_stress":
        third_order = _flat(under["third_order_shear_stress"].sel(coupling="with"))
        lines = {THIRD_ORDER: third_order} | lines
    least = SAME * np.abs(coupled).max()
    apart = {n: values for n, values in lines.items() if np.abs(values - coupled).max() > least}
    labels = {UNCOUPLED: "without coupling", THIRD_ORDER: "shear stress by third-order theory"}
    labels[COUPLED] = "with coupling" if _is_coupled(dataset) else PLAIN
    return [
        Curve(1e3 * _flat(dataset["place"]), values, series_line(number), labels[number])
        for number, values in (apart | {COUPLED: coupled}).items()
    ]


def _with_places(dataset: xr.Dataset) -> xr.Dataset:
    """The part of a dataset whose layers and points have a place."""
    for dimension in ("layer", "point"):
        dataset = dataset.dropna(dimension, how="all", subset=["place"])
    return dataset


def _is_coupled(dataset: xr.Dataset) -> bool:
    """Whether the axial-bending coupling changes the stress in the section."""
    stress = dataset["normal_stress"]
    apart = abs(stress.sel(coupling="with") - stress.sel(coupling="without")).max(
        ("layer", "point")
    )
    largest = abs(stress.sel(coupling="with")).max(("layer", "point"))
    return bool((apart > SAME * largest).any())


def _kinds(runs: list[_Run]) -> dict[str, int]:
    """First layer of each kind of ply."""
    first: dict[str, int] = {}
    for run in runs:
        first.setdefault(run.text.split(f" {TIMES} ")[0], run.first)
    return first


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


def _axes_of(dataset: xr.Dataset) -> dict[str, tuple[float, Look]]:
    """Places in mm and looks of the neutral axis and the mass axis, or of both in one."""
    neutral, mass = (1e3 * float(dataset[name]) for name in ("neutral_axis", "mass_axis"))
    if neutral == mass:
        return {"neutral axis and centre of mass": (neutral, NEUTRAL_AXIS)}
    return {"neutral axis": (neutral, NEUTRAL_AXIS), "centre of mass": (mass, MASS_AXIS)}


@figure
def plot_moisture(dataset: xr.Dataset) -> Picture:
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
    layout = grid(len(links), 2, row * len(links) + 0.5, sharex="col")
    return Picture(panes, "", dataset, title, layout=layout)


def _time_unit(dataset: xr.Dataset) -> str:
    end = float(dataset["time"].max())
    return next((name for name in TIME_UNITS if from_si(end, name) >= 1), "second")


def _after(dataset: xr.Dataset) -> list[str]:
    """Times of the profiles in words."""
    unit = _time_unit(dataset)
    times = from_si(1.0, unit) * dataset["profile_time"].values
    return [f"{time:.0f} {unit[0]}" if time >= 1000 else f"{time:.3g} {unit[0]}" for time in times]


def _colours(dataset: xr.Dataset) -> list[tuple[float, float, float, float]]:
    """Dark to light with time, distinct in grey as well."""
    places = np.linspace(0.0, 0.85, dataset.sizes["profile_time"])
    return [mpl.colormaps["viridis"](place) for place in places]


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
        if own[name].count():
            curves.append(Curve(root, own[name].values, series_line(number), words))
    return Pane(
        "Share of equilibrium",
        curves,
        title=f"{link.capitalize()}: uptake",
        spans=(Span(1.0, 1.0, {"color": style.MID_GREY, "lw": 0.6, "zorder": 1}),),
        limits=(0.0, 1.08),
        along=f"Root of time (√{unit})",
    )
