"""Axes of crank speed for stability maps: unstable bands shaded and named, gaps hatched."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from flexmech.plots import style
from flexmech.plots.labels import speed_unit
from flexmech.plots.series import Look, series_style
from flexmech.runs import unbroken_runs
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
