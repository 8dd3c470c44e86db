"""Stability maps over crank speed, alone and with a second parameter; unstable bands named."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from flexmech.errors import InputError
from flexmech.plots import scales, style
from flexmech.plots.layout import AxesLike, grid, sheet
from flexmech.plots.reading import cell_edges, engine_label, speed_unit
from flexmech.plots.style import Look, line_handle, series_line, series_style
from flexmech.runs import unbroken_runs
from flexmech.types import FloatArray
from flexmech.units import from_si

KINDS = ("principal", "sum", "difference", "unnamed")
WORDS = {
    "principal": "twice a frequency",
    "sum": "sum of two frequencies",
    "difference": "difference of two",
    "unnamed": "unnamed band",
}
# So that kinds differ without colour too.
HATCHES = {"principal": "", "sum": "", "difference": "....", "unnamed": "xxxx"}
GAP: Look = {"facecolor": "0.94", "edgecolor": "0.7", "hatch": "////", "lw": 0}
SUBSCRIPTS = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
LABEL_POINTS = 6.5
# Part of the axes' width that the name of a band takes, upright; less on a wide page.
NAME_WIDTH, NARROW_NAME_WIDTH = 0.024, 0.045
MOST_NAMES, MOST_NARROW_NAMES = 14, 7
# Of the axes' width: narrower bands are marks at the lower edge, of this height.
LEAST_WIDTH, MARK_HEIGHT = 0.004, 0.05
# Of the greatest growth rate: bands that grow more slowly have no names.
LEAST_NAMED = 0.02
RPM = 30 / np.pi

GROWTH_HEIGHT, MODULUS_HEIGHT = 2.6, 1.7
# The two axes of speed, in inches.
AXES_HEIGHT = 0.9
ZERO: Look = {"color": "0.55", "lw": 0.6, "zorder": 1}
# Room for the names of bands over the curve.
ROOM = 1.55
LEAST_GROWTH = 1e-3
BOTH = "give two Axes: one for the growth rate and one for the modulus"

AGAINST_HEIGHT = 2.9
# Grows darker throughout, and begins where it is told from white.
COLOURS = LinearSegmentedColormap.from_list(
    "growth", mpl.colormaps["YlOrBr"](np.linspace(0.15, 1.0, 256))
)
CONTOUR: Look = {"color": "0.1", "lw": 1.0}
GAP: Look = {"facecolor": "0.94", "edgecolor": "0.7", "hatch": "////", "lw": 0}
# Numbers of parameters in the unit that they are read in.
READ: dict[str, tuple[float, str]] = {"m": (1e3, "mm"), "Pa": (1e-9, "GPa"), "s": (1e3, "ms")}
PERCENT = ("damping-ratio", "moisture")
# Decay next to the zero line, as a part of the greatest growth: round-off makes no line.
DECAY = 1e-3


def limit_speeds(axes: Axes, dataset: xr.Dataset) -> None:
    """Let the x axis reach over the crank speeds asked for, in the user's unit."""
    speeds = from_si(1.0, speed_unit(dataset)) * dataset["crank_speed"].values
    low, high = float(speeds.min()), float(speeds.max())
    axes.set_xlim((low - 1.0, high + 1.0) if low == high else (low, high))


def speed_axes(panels: list[Axes], dataset: xr.Dataset) -> None:
    """Crank speed in turns a minute above the first panel, or in rad/s where those are below."""
    unit = speed_unit(dataset)
    factor = from_si(1.0, unit)
    other, ratio = ("rad/s", 1.0 / factor) if unit == "rpm" else ("rpm", RPM / factor)
    functions = (lambda speed: ratio * speed, lambda speed: speed / ratio)
    upper = panels[0].secondary_xaxis("top", functions=functions)
    upper.set_xlabel(f"Crank speed ({other})")


def shade_bands(axes: Axes, dataset: xr.Dataset) -> None:
    """Shade the unstable bands of the first engine; narrow ones are marks at the lower edge."""
    low, high = axes.get_xlim()
    for band in _bands(dataset):
        start, end = _ends(band, dataset)
        wide = end - start >= LEAST_WIDTH * (high - low)
        look = _look(str(band["band_kind"].item()))
        axes.axvspan(start, end, ymax=1.0 if wide else MARK_HEIGHT, **look, zorder=0.5)


def draw_gaps(axes: Axes, dataset: xr.Dataset) -> None:
    """Hatch the speeds at which the first engine has no equilibrium, half way to the next ones."""
    speed = from_si(1.0, speed_unit(dataset)) * dataset["crank_speed"].values
    missing = dataset["unstable"].values[0] == "no equilibrium"
    for run in unbroken_runs(missing):
        low, high = run[0], run[-1]
        before = speed[low] if low == 0 else (speed[low - 1] + speed[low]) / 2
        after = speed[high] if high == len(speed) - 1 else (speed[high] + speed[high + 1]) / 2
        axes.axvspan(before, after, **GAP, zorder=0)


def name_bands(axes: Axes, dataset: xr.Dataset) -> None:
    """Write the names of the fastest growing bands upright over them, at the top of axes.

    A band that has no room beside those that grow faster has no name: a name that stood beside its
    band would be read as its neighbour's.
    """
    narrow = style.is_narrow()
    most = MOST_NARROW_NAMES if narrow else MOST_NAMES
    bands = sorted(_bands(dataset), key=lambda band: -float(band["band_largest_growth_rate"]))
    greatest = max((float(band["band_largest_growth_rate"]) for band in bands), default=0.0)
    low, high = axes.get_xlim()
    width = (NARROW_NAME_WIDTH if narrow else NAME_WIDTH) * (high - low)
    taken: list[float] = []
    for band in bands:
        middle = sum(_ends(band, dataset)) / 2
        place = float(np.clip(middle, low + width / 2, high - width / 2))
        slow = float(band["band_largest_growth_rate"]) < LEAST_NAMED * greatest
        if slow or any(abs(place - other) < width for other in taken) or len(taken) == most:
            continue
        taken.append(place)
        axes.text(
            place,
            0.98,
            _name(band),
            transform=axes.get_xaxis_transform(),
            rotation=90,
            ha="center",
            va="top",
            fontsize=LABEL_POINTS,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.4, "alpha": 0.75},
            zorder=5,
        )


def unstable_handles(dataset: xr.Dataset) -> list[Artist]:
    """Legend entries of the kinds of bands that there are, and of gaps."""
    kinds = {str(band["band_kind"].item()) for band in _bands(dataset)}
    handles: list[Artist] = [
        Patch(**_look(kind), label=WORDS[kind]) for kind in KINDS if kind in kinds
    ]
    if (dataset["unstable"].values[0] == "no equilibrium").any():
        handles.append(Patch(**GAP, label="no equilibrium"))
    return handles


def _bands(dataset: xr.Dataset) -> list[xr.Dataset]:
    first = str(dataset["engine"].values[0])
    places = np.flatnonzero(dataset["band_engine"].values == first)
    return [dataset.isel(band=place) for place in places.tolist()]


def _ends(band: xr.Dataset, dataset: xr.Dataset) -> tuple[float, float]:
    """Edges of a band in the user's unit, the lesser first."""
    factor = from_si(1.0, speed_unit(dataset))
    low, high = sorted(factor * float(band[f"band_{end}"]) for end in ("lower", "upper"))
    return low, high


def _look(kind: str) -> Look:
    color = series_style(KINDS.index(kind)).color if kind != "unnamed" else style.MID_GREY
    return {
        "facecolor": f"{color}40" if color.startswith("#") else "0.85",
        "edgecolor": color,
        "lw": 0.5,
        "hatch": HATCHES[kind],
    }


def _name(band: xr.Dataset) -> str:
    """What meets, such as "f₁+f₃ = 11f" with f of the crank."""
    kind, branches = str(band["band_kind"].item()), str(band["band_branches"].item()).split()
    if kind == "unnamed" or not branches:
        return "?"
    one, other = (f"f{branch}".translate(SUBSCRIPTS) for branch in (branches[0], branches[-1]))
    order = int(band["band_order"])
    if kind == "principal":
        return f"2{one} = {order}f"
    sign = "+" if kind == "sum" else "\N{MINUS SIGN}"
    return f"{one}{sign}{other} = {order}f"


def plot_stability(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw growth rate and largest multiplier against crank speed, and name the unstable bands.

    Shaded are the unstable bands of the first engine, each with what meets there: f₁ and f₃ are
    Floquet frequencies, f is the crank's. Hatched are speeds without equilibrium. The curve runs
    through the speeds asked for and through edges and fastest speed of each band. Of further
    engines the curves alone are drawn.

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
        raise InputError(
            "this map has no Floquet multipliers: there is no equilibrium at any speed"
        )
    heights = [GROWTH_HEIGHT, MODULUS_HEIGHT]
    layout = grid(2, 1, sum(heights) + AXES_HEIGHT, sharex=True, height_ratios=heights)
    with sheet(layout, ax=ax, fewer=BOTH) as drawn:
        drawn.header(_map_handles(dataset), "Stability of the running linkage", of=dataset)
        growth, modulus = drawn.panels
        for axes in drawn.panels:
            limit_speeds(axes, dataset)
            shade_bands(axes, dataset)
            draw_gaps(axes, dataset)
        for number in range(dataset.sizes["engine"]):
            speed, rate, size = _curve(dataset, number)
            look = series_line(number, dataset["crank_speed"].values)
            growth.plot(speed, rate, **look, zorder=3)
            modulus.plot(speed, size, **look, zorder=3)
        growth.axhline(0.0, **ZERO)
        modulus.axhline(1.0, **ZERO)
        for axes, part, middle in ((growth, 1, 0.0), (modulus, 2, 1.0)):
            _scale(axes, _with_equilibrium(dataset, part) - middle, middle)
        growth.set_ylabel("Growth rate (1/s)")
        modulus.set_ylabel("Largest modulus\nof a multiplier")
        name_bands(growth, dataset)
        drawn.label_x(f"Crank speed ({speed_unit(dataset)})")
        speed_axes(drawn.panels, dataset)
    return drawn.figure


def _curve(dataset: xr.Dataset, engine: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Speed in the user's unit, growth rate and modulus, with what bands add between speeds."""
    own = dataset.isel(engine=engine)
    bands = dataset.isel(
        band=np.flatnonzero(dataset["band_engine"].values == str(own["engine"].item()))
    )
    speed, rate = [own["crank_speed"].values], [own["growth_rate"].values]
    closed = {end: ~bands[f"band_{end}_open"].values for end in ("lower", "upper")}
    for end, place in closed.items():
        speed.append(bands[f"band_{end}"].values[place])
        rate.append(np.zeros(int(place.sum())))
    speed.append(bands["band_fastest_speed"].values)
    rate.append(bands["band_largest_growth_rate"].values)
    every, growth = np.concatenate(speed), np.concatenate(rate)
    # Stable: where a speed asked for is an edge, its own value comes first.
    order = np.argsort(every, kind="stable")
    every, growth = every[order], growth[order]
    modulus = np.exp(growth * 2 * np.pi / np.abs(every))
    return from_si(1.0, speed_unit(dataset)) * every, growth, modulus


def _with_equilibrium(dataset: xr.Dataset, part: int) -> FloatArray:
    """Growth rates or moduli that are drawn, of all engines, at speeds with an equilibrium."""
    found = [np.zeros(0)]
    for number in range(dataset.sizes["engine"]):
        curve = _curve(dataset, number)
        states = dataset["unstable"].values[number] != "no equilibrium"
        speed = from_si(1.0, speed_unit(dataset)) * dataset["crank_speed"].values
        nearest = np.abs(curve[0][:, None] - speed).argmin(axis=1)
        found.append(curve[part][states[nearest] & np.isfinite(curve[part])])
    return np.concatenate(found)


def _scale(axes: Axes, values: FloatArray, middle: float) -> None:
    """Fit the y axis to what there is with an equilibrium, with room for the names of bands.

    Beyond, where straight links buckle, the curve may leave the axes; so may strong decay.
    """
    high = max(LEAST_GROWTH, float(values.max(initial=0.0)))
    low = (
        max(float(values.min(initial=0.0)), -high)
        if high > LEAST_GROWTH
        else float(values.min(initial=-high))
    )
    axes.set_ylim(middle + low - 0.06 * (high - low), middle + high + (ROOM - 1) * (high - low))
    scales.plain_numbers(axes)


def _map_handles(dataset: xr.Dataset) -> list[Artist]:
    speeds = dataset["crank_speed"].values
    names = [engine_label(dataset, n) for n in range(dataset.sizes["engine"])]
    lines = [line_handle(name, **series_line(n, speeds)) for n, name in enumerate(names)]
    return [*lines, *unstable_handles(dataset)]


def plot_stability_against(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw where vibrations grow over crank speed and a second parameter, a panel an engine.

    The darker, the faster; white is stable, and the line between the two is that of growth rate
    zero. Hatched is where there is no equilibrium.

    Parameters
    ----------
    dataset : Dataset
        Of a ``StabilityMap`` result that was asked for a second parameter.
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
    data = dataset.sortby("crank_speed").transpose(..., "parameter", "crank_speed")
    rate, state = data["against_growth_rate"].values, data["against_unstable"].values
    engines = dataset.sizes["engine"]
    speed = from_si(1.0, speed_unit(dataset)) * data["crank_speed"].values
    factor, label = _parameter(dataset)
    parameter = factor * data["parameter"].values
    top = float(np.nanmax(np.where(state == "yes", rate, np.nan), initial=0.0))
    norm = Normalize(0.0, top or 1.0)
    layout = grid(engines, 1, engines * AGAINST_HEIGHT + 0.5, sharex=True)
    with sheet(layout, ax=ax) as drawn:
        drawn.header(
            _against_handles(state), f"Growth over crank speed and {_words(dataset)}", of=dataset
        )
        for number, axes in enumerate(drawn.panels):
            _draw(axes, speed, parameter, rate[number], state[number], norm)
            if engines > 1:
                axes.set_title(engine_label(dataset, number), loc="left")
        drawn.label_x(f"Crank speed ({speed_unit(dataset)})")
        drawn.label_y(label)
        bar = drawn.figure.colorbar(
            ScalarMappable(norm, COLOURS), ax=drawn.panels, pad=0.02, aspect=30
        )
        bar.set_label("Growth rate (1/s)")
        bar.outline.set_linewidth(0.6)
    return drawn.figure


def _draw(
    axes: Axes,
    speed: FloatArray,
    parameter: FloatArray,
    rate: FloatArray,
    state: np.ndarray[tuple[int, ...], np.dtype[np.str_]],
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
            speed, parameter, known, [0.0], colors=[CONTOUR["color"]], linewidths=CONTOUR["lw"]
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


def _against_handles(state: np.ndarray[tuple[int, ...], np.dtype[np.str_]]) -> list[Artist]:
    handles: list[Artist] = [line_handle("growth rate zero", **CONTOUR)]
    if (state == "no equilibrium").any():
        handles.append(Patch(**GAP, label="no equilibrium"))
    return handles
