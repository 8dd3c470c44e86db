"""Stability map: growth rate and largest Floquet multiplier over crank speed."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexmech.errors import InputError
from flexmech.plots import scales
from flexmech.plots.labels import engine_label, speed_unit
from flexmech.plots.layout import AxesLike, grid, sheet
from flexmech.plots.series import Look, line_handle, series_line
from flexmech.plots.unstable_bands import (
    draw_gaps,
    limit_speeds,
    name_bands,
    shade_bands,
    speed_axes,
    unstable_handles,
)
from flexmech.types import FloatArray
from flexmech.units import from_si

GROWTH_HEIGHT, MODULUS_HEIGHT = 2.6, 1.7
# The two axes of speed, in inches.
AXES_HEIGHT = 0.9
ZERO: Look = {"color": "0.55", "lw": 0.6, "zorder": 1}
# Room for the names of bands over the curve.
ROOM = 1.55
LEAST_GROWTH = 1e-3
BOTH = "give two Axes: one for the growth rate and one for the modulus"


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
        drawn.header(_handles(dataset), "Stability of the running linkage", of=dataset)
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


def _handles(dataset: xr.Dataset) -> list[Artist]:
    speeds = dataset["crank_speed"].values
    names = [engine_label(dataset, n) for n in range(dataset.sizes["engine"])]
    lines = [line_handle(name, **series_line(n, speeds)) for n, name in enumerate(names)]
    return [*lines, *unstable_handles(dataset)]
