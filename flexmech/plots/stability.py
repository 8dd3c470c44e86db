"""Stability maps: growth rate, multipliers and unstable bands over crank speed."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, unbroken_runs
from flexmech.errors import InputError
from flexmech.plots import scales, style
from flexmech.plots.drawing import draw
from flexmech.plots.layout import AxesLike, grid
from flexmech.plots.picture import Choice, Curve, Pane, Picture, Span
from flexmech.plots.reading import cell_edges, engine_label, speed_unit, speeds_of, subscripts
from flexmech.plots.style import Look, series_line, series_style
from flexmech.units import from_si

# Kinds of bands: what meets in words, and a hatch, so that kinds differ without colour too.
KINDS = {
    "principal": ("twice a frequency", ""),
    "sum": ("sum of two frequencies", ""),
    "difference": ("difference of two", "...."),
    "divergence": ("divergence", "||||"),
    "unnamed": ("unnamed band", "xx"),
}
GAP: Look = {"facecolor": "0.94", "edgecolor": "0.7", "hatch": "////", "lw": 0}
NOTHING = "this map has no Floquet multipliers: there is no equilibrium at any speed"
# Of names of bands, in points: smaller than other words, as they stand upright side by side.
LABEL_POINTS = 6.5
# Names at most, as more would hide the curve under them, and the part of the axes' width that one
# takes upright: a letter's height with some room, on a wide and on a narrow page.
NAMES, NARROW_NAMES = (14, 0.024), (7, 0.045)
# Of the axes' width, two points: narrower bands are marks at the lower edge, of this part of the
# height, which hide no curve.
LEAST_WIDTH, MARK_HEIGHT = 0.004, 0.05
# Of the greatest growth rate: bands that grow more slowly lie on the line of zero, without names.
LEAST_NAMED = 0.02

# Of both panels in inches: the upper one holds the names of bands too.
GROWTH_HEIGHT, MODULUS_HEIGHT = 2.6, 1.7
ZERO: Look = {"color": "0.55", "lw": 0.6, "zorder": 1}
# Height of the axis over that of the curve: names of bands, of eleven letters, stand above it.
ROOM = 1.55
# Of the axis in 1/s: growth below it is round-off of multipliers that do not grow.
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
        Of a ``StabilityMap`` result.

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
        Of a ``StabilityMap`` result.
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
        Of a ``StabilityMap`` result.

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
        spans.append(Span(*ends, GAP | {"zorder": 0}, "no equilibrium", upright=True))
    return tuple(spans)


def name_bands(axes: Axes, dataset: xr.Dataset) -> None:
    """Write the names of the fastest growing bands upright over them, at the top of axes.

    A band that has no room beside those that grow faster has no name: a name that stood beside its
    band would be read as its neighbour's.
    """
    most, part = NARROW_NAMES if style.is_narrow() else NAMES
    bands = sorted(unstable_bands(dataset), key=lambda band: -band.growth)
    low, high = axes.get_xlim()
    width, taken = part * (high - low), list[float]()
    look: Look = {"rotation": 90, "ha": "center", "va": "top", "fontsize": LABEL_POINTS}
    look["bbox"] = {"facecolor": "white", "edgecolor": "none", "pad": 0.4, "alpha": 0.75}
    for band in bands:
        place = float(np.clip((band.low + band.high) / 2, low + width / 2, high - width / 2))
        slow = band.growth < LEAST_NAMED * bands[0].growth
        if slow or any(abs(place - other) < width for other in taken) or len(taken) == most:
            continue
        taken.append(place)
        across = axes.get_xaxis_transform()
        axes.text(place, 0.98, band.name, transform=across, zorder=5, **look)


def gap_handles(state: NDArray[np.str_]) -> list[Artist]:
    """Legend entry of gaps, where some state is that there is no equilibrium."""
    there = (state == "no equilibrium").any()
    return [Patch(**GAP, label="no equilibrium")] if there else []


def _look(kind: str) -> Look:
    color = series_style(list(KINDS).index(kind)).color if kind != "unnamed" else style.MID_GREY
    fill = f"{color}40" if color.startswith("#") else "0.85"
    return {"facecolor": fill, "edgecolor": color, "lw": 0.5, "hatch": KINDS[kind][1]}


def _name(band: xr.Dataset) -> str:
    """What meets, such as "f₁+f₃ = 11f" with f of the crank."""
    kind, branches = str(band["band_kind"].item()), str(band["band_branches"].item()).split()
    if not branches:
        return kind if kind == "divergence" else "?"
    one, other = (f"f{subscripts(branch)}" for branch in (branches[0], branches[-1]))
    order = int(band["band_order"])
    if kind == "principal":
        return f"2{one} = {order}f"
    sign = "+" if kind == "sum" else "\N{MINUS SIGN}"
    return f"{one}{sign}{other} = {order}f"


def plot_stability(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw growth rate and largest multiplier against crank speed, and name the unstable bands.

    Shaded are the unstable bands of the first engine, each with what meets there: f₁ and f₃ are
    Floquet frequencies, f is the crank's. Hatched are speeds without equilibrium. The curve runs
    through the speeds asked for, which are marked where they are few, through those between
    that were solved for, and through edges and fastest speed of each band. Of further engines the
    curves alone are drawn.

    Parameters
    ----------
    dataset : Dataset
        Of a ``StabilityMap`` result.
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
    heights = [GROWTH_HEIGHT, MODULUS_HEIGHT]
    layout = grid(2, 1, sum(heights) + style.AXES_HEIGHT, sharex=True, height_ratios=heights)
    return draw(
        stability_picture(dataset),
        layout,
        ax=ax,
        fewer=BOTH,
        finish=lambda drawn: name_bands(drawn.panels[0], dataset),
    )


def stability_picture(dataset: xr.Dataset) -> Picture:
    """Growth rate and modulus over crank speed, as of plot_stability."""
    speeds, spans, panes = speeds_of(dataset), speed_spans(dataset), []
    for part, middle, label in (
        (1, 0.0, "Growth rate (1/s)"),
        (2, 1.0, "Largest modulus\nof a multiplier"),
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
        panes.append(Pane(label, curves, spans=across, limits=limits, scale=scale, height=1.5))
    along, title = f"Crank speed ({speed_unit(dataset)})", "Stability of the running linkage"
    return Picture(panes, along, dataset, title, over="speed", places=speeds)


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
        return (high**-0.06, high**ROOM), "log"
    low = float(values.min(initial=-high))
    if high > LEAST_GROWTH:
        low = max(float(values.min(initial=0.0)), -high)
    ends = middle + low - 0.06 * (high - low), middle + high + (ROOM - 1) * (high - low)
    return ends, "linear"
