"""How far points of a running linkage leave the paths that they have on rigid links."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.plots import reading, style
from flexmech.plots.drawing import figure
from flexmech.plots.layout import grid
from flexmech.plots.picture import ZERO, Curve, Pane, Picture, series
from flexmech.plots.response import RIGID
from flexmech.plots.style import TIMES, Look

# Part of the path's extent that the greatest deviation is drawn as, at most, and factors of it.
_DRAWN, _FACTORS = 0.15, np.outer(10.0 ** np.arange(7), (1, 2, 5)).ravel()
_HEIGHT = 3.4
# Between numbers along the crank angle, in degrees.
_TICK = 60.0
_MM = 1e3


@figure
def plot_paths(dataset: xr.Dataset) -> Picture:
    """Draw the path of the point that leaves its path most, and the deviations of points.

    The path is that of the last turn by the first engine, beside the one on rigid links (dark
    grey), with the deviation enlarged. Where there are more points than styles, those that deviate
    most are drawn.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``Response`` result: ``point_position`` (engine, time, point, component) and
        ``path_deviation`` (engine, time, point), and ``rigid_point_position`` of rigid links; m.
    ax : sequence of Axes, optional
        Two of the user's. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    own, angle = dataset.isel(engine=0), dataset["crank_angle"].values
    most = np.argsort(-own["peak_path_deviation"].values)[: len(style.SERIES_STYLES)]
    own = own.isel(point=np.sort(most))
    turn = own.isel(time=np.abs(angle[-1] - angle) <= reading.A_TURN)
    point = str(own["peak_path_deviation"].idxmax("point").item())
    rigid, elastic = (
        _MM * reading.values_of(turn[name].sel(point=point), "component", "time")
        for name in ("rigid_point_position", "point_position")
    )
    (x, y), (u, v) = rigid, elastic - rigid
    extent, greatest = float(np.ptp(rigid, axis=1).max()), float(np.hypot(u, v).max())
    fitting = _FACTORS[_FACTORS * greatest <= _DRAWN * extent] if greatest else _FACTORS[:0]
    factor = float(fitting[-1]) if fitting.size else 1.0
    enlarged = f", deviation {TIMES} {factor:g}" if factor > 1 else ""
    colour = style.series_style(reading.names_of(own, "point").index(point)).color
    path = Pane(
        "y (mm)",
        (
            Curve(x + factor * u, y + factor * v, {"color": colour, "lw": 1.2}),
            Curve(x, y, RIGID | {"lw": 1.0}, "rigid links", followed=None),
        ),
        title=f"{point}{enlarged}",
        along="x (mm)",
        apart="plane",
    )
    along, places, ticks = "Time (s)", turn["time"].values, np.zeros(0)
    if "drive" not in dataset.attrs:
        places = reading.degrees(turn["crank_angle"])
        places = places - 360.0 * np.floor(places.min() / 360.0)
        first, last = np.ceil(places.min() / _TICK), np.floor(places.max() / _TICK)
        along, ticks = "Crank angle (deg)", _TICK * np.arange(first, last + 1)
    sizes = reading.values_of(turn["path_deviation"], "point", "time")
    curves = series(places, sizes, reading.names_of(own, "point"))
    options: Look = {"along": along, "x_ticks": ticks}
    size = Pane("Deviation", curves, reading.LENGTH_UNITS, spans=(ZERO,), **options)
    title = f"Deviation from the path on rigid links\n{reading.run_title(dataset)}"
    return Picture([path, size], "", dataset, title, layout=grid(1, 2, _HEIGHT))
