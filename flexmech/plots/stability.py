"""Stability over crank speed: growth rate, multipliers, unstable bands, Floquet modes.

A map may go over a second parameter as well. Floquet modes have frequencies.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Literal, NamedTuple

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, unbroken_runs
from flexmech.errors import InputError
from flexmech.plots import scales, style
from flexmech.plots.campbell import ROOM
from flexmech.plots.drawing import figure
from flexmech.plots.layout import AxesLike, grid, sheet
from flexmech.plots.picture import Choice, Curve, Note, Pane, Picture, Span
from flexmech.plots.reading import (
    cell_edges,
    engine_label,
    speed_unit,
    speeds_of,
    subscripts,
    values_of,
)
from flexmech.plots.style import Look, line_handle, series_line, series_style
from flexmech.units import from_si

# Kinds of bands: what meets in words, and a hatch, so that kinds differ without colour too.
KINDS = {
    "principal": ("twice a frequency", ""),
    "sum": ("sum of two frequencies", "--"),
    "difference": ("difference of two", "...."),
    "divergence": ("divergence", "||||"),
    "unnamed": ("unnamed band", "xx"),
}
GAP: Look = {"facecolor": "0.94", "edgecolor": "0.7", "hatch": "////", "lw": 0}
NO_EQUILIBRIUM = "no equilibrium"
UNSTABLE: Look = {"facecolor": "0.88", "edgecolor": "0.6", "hatch": "...."}
NOTHING = "this map has no Floquet multipliers: there is no equilibrium at any speed"
# Size of names of bands, in points: smaller than other words, as they stand upright side by
# side.
LABEL_POINTS = 6.5
# Names at most, as more would hide the curve under them, and the part of the axes' width that one
# takes upright: a letter's height with some room, on a wide and on a narrow page.
NAMES, NARROW_NAMES = (14, 0.024), (7, 0.045)
# Narrowest band that is drawn as one, as a part of the axes' width (two points): narrower ones are
# marks at the lower edge, of this part of the height, which hide no curve.
LEAST_WIDTH, MARK_HEIGHT = 0.004, 0.05
# Part of the greatest growth rate: bands that grow more slowly lie on the line of zero,
# without names.
LEAST_NAMED = 0.02

# Heights of the panels in inches: the upper one holds the names of bands too.
GROWTH_HEIGHT, MODULUS_HEIGHT = 2.6, 1.7
ZERO: Look = {"color": "0.55", "lw": 0.6, "zorder": 1}
# Height of the axis over that of the curve: names of bands, of eleven letters, stand above it.
BAND_ROOM = 1.55
# Least growth of the axis in 1/s: growth below it is round-off of multipliers that do not grow.
LEAST_GROWTH = 1e-3
# Greatest modulus on a linear axis; logarithm of the greatest drawn: some are beyond all numbers.
MOST_LINEAR, LARGEST_LOGARITHM = 1e3, 200.0
BOTH = "give two Axes: one for the growth rate and one for the modulus"


class UnstableBand(NamedTuple):
    """A range of crank speeds in which a vibration of the first engine grows.

    Parameters
    ----------
    low, high : float
        Edges in the user's unit.
    growth : float
        Largest growth rate in 1/s.
    kind : str
        What meets there: one of :data:`KINDS`.
    name : str
        The same as an equation, such as "f₁+f₃ = 11f" with f of the crank.
    """

    low: float
    high: float
    growth: float
    kind: str
    name: str


def unstable_bands(dataset: xr.Dataset) -> list[UnstableBand]:
    """Unstable bands of the first engine.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``StabilityMap`` result.

    Returns
    -------
    list of UnstableBand
    """
    factor, found = from_si(1.0, speed_unit(dataset)), []
    for place in np.flatnonzero(dataset["band_engine"] == dataset["engine"][0]).tolist():
        band = dataset.isel(band=place)
        low, high = sorted(factor * float(band[f"band_{end}"]) for end in ("lower", "upper"))
        growth = float(band["band_largest_growth_rate"])
        found.append(UnstableBand(low, high, growth, str(band["band_kind"].item()), _name(band)))
    return found


def growth_curve(dataset: xr.Dataset, engine: int = 0) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Growth rate and largest modulus over crank speed, wherever they are known.

    That is at the speeds asked for, at those between that were solved for, and at closed edges
    and peaks of bands.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``StabilityMap`` result.
    engine : int

    Returns
    -------
    ndarray, ndarray, ndarray, shape (n,)
        Crank speed in the user's unit, ascending; growth rate in 1/s; modulus of a multiplier, of
        7e86 at most.
    """
    own = dataset.isel(engine=engine)
    bands = dataset.isel(band=np.flatnonzero(dataset["band_engine"] == own["engine"]))
    curve = dataset.isel(curve=np.flatnonzero(dataset["curve_engine"] == own["engine"]))
    speed = [own["crank_speed"].values, curve["curve_speed"].values]
    rate = [own["growth_rate"].values, curve["curve_growth_rate"].values]
    for end in ("lower", "upper"):
        closed = ~bands[f"band_{end}_open"].values
        speed.append(bands[f"band_{end}"].values[closed])
        rate.append(np.zeros(int(closed.sum())))
    every = np.concatenate([*speed, bands["band_fastest_speed"].values])
    growth = np.concatenate([*rate, bands["band_largest_growth_rate"].values])
    # Stable: where a speed asked for is an edge, its own value comes first.
    order = np.argsort(every, kind="stable")
    every, growth = every[order], growth[order]
    modulus = np.exp(np.minimum(growth * 2 * np.pi / np.abs(every), LARGEST_LOGARITHM))
    return from_si(1.0, speed_unit(dataset)) * every, growth, modulus


def speed_spans(dataset: xr.Dataset) -> tuple[Span, ...]:
    """Unstable bands and speeds without equilibrium of the first engine.

    Narrow bands are marks at the lower edge; gaps reach half way to the next speeds.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``StabilityMap`` result.

    Returns
    -------
    tuple of Span
    """
    low, high = scales.speed_limits(dataset)
    spans = list[Span]()
    for band in sorted(unstable_bands(dataset), key=lambda one: list(KINDS).index(one.kind)):
        wide = band.high - band.low >= LEAST_WIDTH * (high - low)
        look = _look(band.kind) | {"ymax": 1.0 if wide else MARK_HEIGHT, "zorder": 0.5}
        spans.append(Span(band.low, band.high, look, KINDS[band.kind][0], upright=True))
    speed = speeds_of(dataset)
    edges = np.clip(cell_edges(speed), speed.min(), speed.max())
    for run in unbroken_runs(dataset["unstable"].values[0] == "no equilibrium"):
        ends = edges[run.start], edges[run.stop]
        spans.append(Span(*ends, GAP | {"zorder": 0}, NO_EQUILIBRIUM, upright=True))
    return tuple(spans)


def _names_of_bands(dataset: xr.Dataset) -> list[Note]:
    """Names of the fastest growing bands upright over them, at the top of axes.

    A band that has no room beside those that grow faster has no name: a name that stood beside its
    band would be read as its neighbour's.
    """
    most, part = NARROW_NAMES if style.is_narrow() else NAMES
    bands = sorted(unstable_bands(dataset), key=lambda band: -band.growth)
    low, high = scales.speed_limits(dataset)
    width, notes = part * (high - low), list[Note]()
    look: Look = {"rotation": 90, "ha": "center", "va": "top", "fontsize": LABEL_POINTS}
    look["bbox"] = {"facecolor": "white", "edgecolor": "none", "pad": 0.4, "alpha": 0.75}
    for band in bands:
        place = float(np.clip((band.low + band.high) / 2, low + width / 2, high - width / 2))
        slow = band.growth < LEAST_NAMED * bands[0].growth
        if slow or any(abs(place - other.x) < width for other in notes) or len(notes) == most:
            continue
        notes.append(Note(place, 0.98, band.name, look | {"zorder": 5}, high=True))
    return notes


def gap_handles(state: NDArray[np.str_]) -> list[Artist]:
    """Legend entry of gaps, where some state is that there is no equilibrium."""
    there = (state == "no equilibrium").any()
    return [Patch(**GAP, label="no equilibrium")] if there else []


def _look(kind: str) -> Look:
    color = series_style(list(KINDS).index(kind)).color if kind != "unnamed" else style.MID_GREY
    fill = f"{color}40" if color.startswith("#") else "0.85"
    return {"facecolor": fill, "edgecolor": color, "lw": 0.5, "hatch": KINDS[kind][1]}


def _name(band: xr.Dataset) -> str:
    """Resonance of a band, such as "f₁+f₃ = 11f" with f of the crank."""
    kind, branches = str(band["band_kind"].item()), str(band["band_branches"].item()).split()
    if not branches:
        return kind if kind == "divergence" else "?"
    one, other = (f"f{subscripts(branch)}" for branch in (branches[0], branches[-1]))
    order = int(band["band_order"])
    if kind == "principal":
        return f"2{one} = {order}f"
    sign = "+" if kind == "sum" else "\N{MINUS SIGN}"
    return f"{one}{sign}{other} = {order}f"


@figure
def plot_stability(dataset: xr.Dataset) -> Picture:
    """Draw growth rate and largest multiplier against crank speed, and name the unstable bands.

    Shaded are the unstable bands of the first engine, each with what meets there: f₁ and f₃ are
    Floquet frequencies, f is the crank's. Hatched are speeds without equilibrium. The curve runs
    through the speeds asked for, which are marked where they are few, through those between that
    were solved for, and through edges and fastest speed of each band. Further engines are drawn as
    curves alone.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``StabilityMap`` result.
    ax : Axes or sequence of Axes, optional
        The user's, two. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If there is an equilibrium at no speed.
    """
    if not np.isfinite(dataset["growth_rate"]).any():
        raise InputError(NOTHING)
    speeds, spans, panes = speeds_of(dataset), speed_spans(dataset), []
    names = _names_of_bands(dataset)
    for part, middle, label, notes in (
        (1, 0.0, "Growth rate (1/s)", names),
        (2, 1.0, "Largest modulus\nof a multiplier", ()),
    ):
        curves = []
        for number in range(dataset.sizes["engine"]):
            known = growth_curve(dataset, number)
            look = series_line(number, speeds) | {"zorder": 3}
            # Those asked for are marked.
            look["markevery"] = np.isin(known[0], speeds).nonzero()[0].tolist()
            name = engine_label(dataset, number)
            followed: Choice | None = None if number else {}
            curves.append(Curve(known[0], known[part], look, name, followed=followed))
        limits, scale = _scale(_with_equilibrium(dataset, part) - middle, middle)
        across = (*spans, Span(middle, middle, ZERO))
        look = {"limits": limits, "scale": scale, "height": 1.5}
        panes.append(Pane(label, curves, spans=across, notes=notes, **look))
    along, title = f"Crank speed ({speed_unit(dataset)})", "Stability of the running linkage"
    heights = [GROWTH_HEIGHT, MODULUS_HEIGHT]
    layout = grid(2, 1, sum(heights) + style.AXES_HEIGHT, sharex=True, height_ratios=heights)
    look = {"over": "speed", "places": speeds, "layout": layout, "fewer": BOTH}
    return Picture(panes, along, dataset, title, **look)


def _with_equilibrium(dataset: xr.Dataset, part: int) -> FloatArray:
    """Growth rates or moduli that are drawn, of all engines, at speeds with an equilibrium."""
    found = [np.zeros(0)]
    for number in range(dataset.sizes["engine"]):
        curve = growth_curve(dataset, number)
        states = dataset["unstable"].values[number] != "no equilibrium"
        nearest = np.abs(curve[0][:, None] - speeds_of(dataset)).argmin(axis=1)
        found.append(curve[part][states[nearest] & np.isfinite(curve[part])])
    return np.concatenate(found)


def _scale(
    values: FloatArray, middle: float
) -> tuple[tuple[float, float], Literal["linear", "log"]]:
    """Limits and kind of an axis for what there is with an equilibrium, and for names of bands.

    Beyond, where straight links buckle, the curve may leave the axes; so may strong decay.
    """
    high = max(LEAST_GROWTH, float(values.max(initial=0.0)))
    if middle and high > MOST_LINEAR:
        return (high**-0.06, high**BAND_ROOM), "log"
    low = float(values.min(initial=-high))
    if high > LEAST_GROWTH:
        low = max(float(values.min(initial=0.0)), -high)
    ends = middle + low - 0.06 * (high - low), middle + high + (BAND_ROOM - 1) * (high - low)
    return ends, "linear"


# Height of an engine's panel in inches: two fill two thirds of a page.
PANEL_HEIGHT = 2.9
# Grows darker throughout, and begins where it is distinct from white.
COLOURS = LinearSegmentedColormap.from_list(
    "growth", mpl.colormaps["YlOrBr"](np.linspace(0.15, 1.0, 256))
)
ZERO_GROWTH: Look = {"color": "0.1", "lw": 1.0}
# Numbers of parameters in the unit that they are read in.
READ: dict[str, tuple[float, str]] = {"m": (1e3, "mm"), "Pa": (1e-9, "GPa"), "s": (1e3, "ms")}
PERCENT = ("damping-ratio", "moisture")
# Crank speeds that are marked; more stand so near each other that a band between them is narrow.
FEW_SPEEDS = 60
COMPUTED: Look = {"ls": "", "marker": "|", "color": "0.1", "ms": 6.0, "mew": 1.0, "zorder": 6}
# Decay next to the zero line, as a part of the greatest growth: round-off makes no line.
DECAY = 1e-3


def plot_stability_against(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw where vibrations grow over crank speed and a second parameter, a panel an engine.

    The darker, the faster; white is stable, and the line between the two is that of growth rate
    zero. Hatched is where there is no equilibrium. Over the damping ratio the unstable bands
    between the crank speeds are shown too. Over other parameters few crank speeds are marked
    below: between them nothing is known.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``StabilityMap`` result that was asked for a second parameter.
    ax : Axes or sequence of Axes, optional
        The user's, one an engine. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If there is no second parameter.
    """
    if "against_growth_rate" not in dataset:
        raise InputError(
            "this map has no second parameter; ask for it, as in "
            'flexmech.stability(engine, speeds, against=("damping-ratio", ratios))'
        )
    speed, rate, state = _at_all_speeds(dataset)
    engines, data = dataset.sizes["engine"], dataset
    marked = len(speed) <= FEW_SPEEDS and "against_band_growth_rate" not in dataset
    factor, label = _parameter(dataset)
    parameter = factor * data["parameter"].values
    top = float(np.nanmax(np.where(state == "yes", rate, np.nan), initial=0.0))
    norm = Normalize(0.0, top or 1.0)
    with sheet(grid(engines, 1, engines * PANEL_HEIGHT + 0.5, sharex=True), ax=ax) as drawn:
        handles = [line_handle("growth rate zero", **ZERO_GROWTH), *gap_handles(state)]
        handles += [line_handle("computed; between: unknown", **COMPUTED)] if marked else []
        drawn.header(handles, f"Growth over crank speed and {_words(dataset)}", of=dataset)
        for number, axes in enumerate(drawn.panels):
            _draw_against(axes, speed, parameter, rate[number], state[number], norm)
            if marked:
                below = axes.get_xaxis_transform()
                axes.plot(speed, np.zeros(len(speed)), transform=below, clip_on=False, **COMPUTED)
            if engines > 1:
                axes.set_title(engine_label(dataset, number), loc="left")
        drawn.label_x(f"Crank speed ({speed_unit(dataset)})")
        drawn.label_y(label)
        drawn.colour_bar(ScalarMappable(norm, COLOURS), "Growth rate (1/s)")
    return drawn.figure


def _at_all_speeds(dataset: xr.Dataset) -> tuple[FloatArray, FloatArray, NDArray[np.str_]]:
    """Speeds (n,) in the user's unit, ascending, growth rates and states (engine, parameter, n)."""
    parts = [(speeds_of(dataset), "crank_speed", "against_")]
    if "against_band_growth_rate" in dataset:
        parts.append((speeds_of(dataset, "against_speed"), "against_speed", "against_band_"))
    speed = np.concatenate([values for values, _, _ in parts])
    rate, state = (
        np.concatenate(
            [
                dataset[prefix + name].transpose("engine", "parameter", along).values
                for _, along, prefix in parts
            ],
            axis=-1,
        )
        for name in ("growth_rate", "unstable")
    )
    order = np.argsort(speed)
    return speed[order], rate[..., order], state[..., order]


def _draw_against(
    axes: Axes,
    speed: FloatArray,
    parameter: FloatArray,
    rate: FloatArray,
    state: NDArray[np.str_],
    norm: Normalize,
) -> None:
    edges = cell_edges(speed), cell_edges(parameter)
    grows = np.where(state == "yes", rate, np.nan)
    axes.pcolormesh(*edges, np.ma.masked_invalid(grows), cmap=COLOURS, norm=norm, rasterized=True)
    missing = np.ma.masked_where(state != "no equilibrium", np.ones(rate.shape))
    if missing.count():
        cells = axes.pcolor(*edges, missing, cmap=ListedColormap([GAP["facecolor"]]), lw=0)
        cells.set(hatch=GAP["hatch"], edgecolor=GAP["edgecolor"])
    least = DECAY * norm.vmax if norm.vmax else DECAY
    signed = np.where(state == "no", np.minimum(rate, -least), rate)
    both = (state == "yes").any() and (state == "no").any()
    if both and min(rate.shape) > 1:
        known = np.ma.masked_where((state != "yes") & (state != "no"), signed)
        axes.contour(
            speed,
            parameter,
            known,
            [0.0],
            colors=[ZERO_GROWTH["color"]],
            linewidths=ZERO_GROWTH["lw"],
        )
    axes.set_xlim(*edges[0][[0, -1]])
    axes.set_ylim(*edges[1][[0, -1]])
    scales.plain_numbers(axes)


def _parameter(dataset: xr.Dataset) -> tuple[float, str]:
    """Factor and label of the parameter's axis, in the unit that it is read in."""
    name, unit = str(dataset.attrs["against"]), str(dataset["parameter"].attrs.get("units", "1"))
    if name in PERCENT:
        return 100.0, f"{_words(dataset).capitalize()} (%)"
    factor, unit = READ.get(unit, (1.0, unit))
    words = _words(dataset).capitalize()
    return factor, words if unit == "1" else f"{words} ({unit})"


def _words(dataset: xr.Dataset) -> str:
    return str(dataset["parameter"].attrs.get("long_name", "parameter"))


# Height of a figure on a wide page, and on a narrow one, where it is nearly square, in inches.
HEIGHT, NARROW_HEIGHT = 3.9, 3.2
# Points are seen on it.
FILL: Look = {"alpha": 0.22, "lw": 0}
# Size of marks, in points: they show where many branches lie close to each other.
POINT_SIZE = 2.2
# Part of the lowest mean frequency at which the axis begins: the linkage may be near to
# buckling, where the lowest frequency is zero, which has no place on a logarithmic axis.
LOWEST_PART = 0.4


@figure
def plot_floquet_frequencies(dataset: xr.Dataset) -> Picture:
    """Draw the Floquet frequencies of the first engine over the bands of moving frequencies.

    A point is the frequency of a Floquet mode's largest harmonic. Filled is each natural
    frequency from its lowest to its highest value over the turn, at the stress of the running
    links and without rotation terms. Where a point is outside the bands, another harmonic of its
    mode has become the largest.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``StabilityMap`` result.
    ax : Axes, optional
        The user's. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If there is an equilibrium at no speed.
    """
    frequency = values_of(dataset["frequency"].isel(engine=0), "crank_speed", "multiplier")[:, ::2]
    if not np.isfinite(frequency).any():
        raise InputError(NOTHING)
    height = NARROW_HEIGHT if style.is_narrow() else HEIGHT
    speed, curves = speeds_of(dataset), list[Curve]()
    for branch, along in enumerate(frequency.T):
        name = "" if branch else "Floquet frequency, in its branch's colour"
        curves.append(Curve(speed, along, _points(branch), name))
    curves += _moving(dataset)
    # Colours are those of branches.
    spans = [
        one
        if one.name == NO_EQUILIBRIUM
        else replace(one, look=one.look | UNSTABLE, name="unstable")
        for one in speed_spans(dataset)
    ]
    pane = Pane(
        "Frequency (Hz)",
        curves,
        spans=spans,
        limits=_limits(dataset, frequency),
        scale="plain log",
    )
    label = f"Crank speed ({speed_unit(dataset)})"
    layout, title = grid(1, 1, height + style.AXES_HEIGHT), "Floquet frequencies"
    return Picture([pane], label, dataset, title, over="speed", places=speed, layout=layout)


def _limits(dataset: xr.Dataset, frequency: FloatArray) -> tuple[float, float]:
    """Limits of the frequency axis: around the means of the moving frequencies, and their highest.

    Those of a linkage that is statically unstable are zero, and have no place on the axis.
    """
    mean = dataset["mean_frequency"].values
    if not (mean > 0).any():
        oscillating = frequency[frequency > 0] if (frequency > 0).any() else np.ones(1)
        return float(oscillating.min()) / ROOM, float(oscillating.max()) * ROOM
    highest = float(dataset["highest_frequency"].max())
    return LOWEST_PART * float(mean[mean > 0].min()), ROOM * highest


def _moving(dataset: xr.Dataset) -> list[Curve]:
    """Bands of the moving frequencies, and their means."""
    speed, curves = speeds_of(dataset, "moving_speed"), list[Curve]()
    lowest, mean, highest = (
        values_of(dataset[f"{name}_frequency"], "branch", "moving_speed")
        for name in ("lowest", "mean", "highest")
    )
    for branch in range(len(mean)):
        color, dashes = series_style(branch).color, series_style(branch).linestyle
        band = {"color": color, "zorder": 1} | FILL
        curves.append(
            Curve(speed, lowest[branch], band, "moving frequencies", upto=highest[branch])
        )
        name = str(dataset["branch"].values[branch])
        curves.append(
            Curve(speed, mean[branch], {"color": color, "lw": 0.6, "ls": dashes}, label=name)
        )
    return curves


def _points(branch: int) -> Look:
    each = series_style(branch)
    return {
        "color": each.color,
        "ls": "",
        "marker": each.marker,
        "ms": POINT_SIZE,
        "mew": 0.3,
        "zorder": 3,
    }
