"""Nyquist circles: the mobility about each identified mode in the complex plane."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from flexmech.errors import InputError
from flexmech.plots.frf import CURVES, complex_values, curve_handles, first_angle, hammer_title
from flexmech.plots.layout import AxesLike, grid, sheet
from flexmech.plots.series import Look

PANEL_HEIGHT, COLUMNS = 2.3, 3
MOST_MODES = 6
DOTS: Look = {"marker": ".", "ms": 3.5, "ls": ""}


def plot_nyquist(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the mobility about each mode: a viscously damped mode gives a circle.

    The dots are the measured lines near the mode. The natural frequency is the circle's far end.

    Parameters
    ----------
    dataset : Dataset
        Of a ``HammerTest`` result; up to six modes identified at its first crank angle are drawn.
    ax : Axes or sequence of Axes, optional
        The user's, one a mode. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If no mode was identified there.
    """
    data = first_angle(dataset)
    modes = np.flatnonzero(np.isfinite(data["identified_frequency"].values))[:MOST_MODES]
    if not len(modes):
        raise InputError("no mode was identified at the first crank angle: there is no circle")
    columns = min(COLUMNS, len(modes))
    rows = -(-len(modes) // columns)
    layout = grid(rows, columns, PANEL_HEIGHT * rows, count=len(modes), narrow=2)
    with sheet(layout, ax=ax, fewer="give one Axes a mode") as drawn:
        drawn.header(curve_handles(**DOTS), hammer_title(dataset), of=dataset)
        for axes, mode in zip(drawn.panels, modes, strict=True):
            _draw_circle(axes, data, int(mode))
        drawn.label_x("Re mobility (m/(N s))")
        drawn.label_y("Im mobility (m/(N s))")
    return drawn.figure


def _draw_circle(axes: Axes, data: xr.Dataset, mode: int) -> None:
    circle = data.isel(mode=mode)
    around = circle["circle_frequency"].values
    for curve in ("exact_receptance", "identified_receptance"):
        values = complex_values(circle, f"circle_{curve}") * 2j * np.pi * around
        axes.plot(values.real, values.imag, **CURVES[curve][1])
    frequency = data["frequency"].values
    near = (frequency >= around[0]) & (frequency <= around[-1])
    measured = complex_values(data, "receptance")[near] * 2j * np.pi * frequency[near]
    axes.plot(measured.real, measured.imag, **(CURVES["receptance"][1] | DOTS))
    axes.axhline(0.0, color="0.7", lw=0.5, zorder=0)
    axes.axvline(0.0, color="0.7", lw=0.5, zorder=0)
    axes.set_aspect("equal", adjustable="datalim")
    axes.locator_params(nbins=4)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(FuncFormatter(_number))
    natural = float(circle["identified_frequency"])
    axes.set_title(f"Mode {int(circle['mode'])}: {natural:.5g} Hz", loc="left")


def _number(value: float, place: int | None = None) -> str:
    """Tick in full, with a true minus sign."""
    return f"{value:.3g}".replace("-", "\N{MINUS SIGN}")
