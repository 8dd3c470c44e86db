"""Stability maps over crank speed and a second parameter."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, ListedColormap, Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.plots import scales
from flexmech.plots.layout import AxesLike, grid, sheet
from flexmech.plots.reading import cell_edges, engine_label, speed_unit, speeds_of
from flexmech.plots.stability import GAP, gap_handles
from flexmech.plots.style import Look, line_handle

# Of a panel of an engine in inches: two fill two thirds of a page.
PANEL_HEIGHT = 2.9
# Grows darker throughout, and begins where it is told from white.
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
