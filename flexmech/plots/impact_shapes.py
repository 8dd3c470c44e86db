"""Mode shapes that an impact roving over points of all links shows."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexmech.errors import InputError
from flexmech.plots.frf import first_angle
from flexmech.plots.layout import AxesLike, grid, sheet
from flexmech.plots.series import Look, line_handle, series_style

PANEL_HEIGHT = 1.5
COLUMNS, MOST_MODES = 2, 6
EIGEN: Look = {"color": "0.35", "lw": 1.0}
FOUND: Look = {
    "color": series_style(0).color,
    "marker": "o",
    "markersize": 4,
    "ls": "none",
}
IMAGINARY: Look = {
    "color": series_style(1).color,
    "marker": "x",
    "markersize": 3.5,
    "ls": "none",
}
JOINT: Look = {"color": "0.8", "lw": 0.6, "zorder": 0}
NO_GRID = "this hammer test has no grid of impacts; ask for it by grid=N (--grid N)"


def plot_impact_shapes(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw identified mode shapes over the links, on those of the eigen model.

    The links follow each other along the axis, a unit each. The greatest entry of an identified
    shape is 1, so that its imaginary part shows how complex it is.

    Parameters
    ----------
    dataset : Dataset
        Of a ``HammerTest`` result with a grid of impacts; up to six modes identified at its first
        crank angle are drawn.
    ax : Axes or sequence of Axes, optional
        The user's, one a mode. Left out: a new figure is made.

    Returns
    -------
    Figure

    Raises
    ------
    InputError
        If there is no grid, or no mode was identified there.
    """
    if "point" not in dataset.dims:
        raise InputError(NO_GRID)
    data = first_angle(dataset)
    modes = np.flatnonzero(np.isfinite(data["shape_real"].values).all(axis=0))[:MOST_MODES]
    if not len(modes):
        raise InputError("no mode was identified at the first crank angle: there is no shape")
    columns = min(COLUMNS, len(modes))
    rows = -(-len(modes) // columns)
    layout = grid(rows, columns, PANEL_HEIGHT * rows + 0.3, count=len(modes))
    with sheet(layout, ax=ax, fewer="give one Axes a mode") as drawn:
        drawn.header(_handles(), _title(dataset), of=dataset)
        for axes, mode in zip(drawn.panels, modes, strict=True):
            _draw(axes, data.isel(mode=int(mode)))
        drawn.label_x("Link")
        drawn.label_y("Displacement (-)")
    return drawn.figure


def _draw(axes: Axes, data: xr.Dataset) -> None:
    links = [str(name) for name in data["link"].values]
    own = np.array([links.index(str(name)) for name in data["point_link"].values])
    place = own + data["point_fraction"].values
    for number in range(len(links)):
        which = own == number
        axes.plot(place[which], data["eigen_shape_real"].values[which], **EIGEN)
        axes.axvline(number + 1, **JOINT)
    axes.plot(place, data["shape_imag"].values, **IMAGINARY)
    axes.plot(place, data["shape_real"].values, **FOUND)
    axes.set_xlim(0.0, len(links))
    axes.set_ylim(-1.15, 1.15)
    axes.set_xticks(np.arange(len(links)) + 0.5, links)
    axes.tick_params(axis="x", length=0)
    axes.set_title(
        f"Mode {int(data['mode'])}: MAC {float(data['mac']):.4f}, "
        f"MCF {float(data['complexity_factor']):.2g}",
        loc="left",
    )


def _handles() -> list[Artist]:
    return [
        line_handle("eigen model", **EIGEN),
        line_handle("identified, real part", **FOUND),
        line_handle("imaginary part", **IMAGINARY),
    ]


def _title(dataset: xr.Dataset) -> str:
    degrees = float(np.degrees(first_angle(dataset)["crank_angle"]))
    response = dataset.attrs["response_point"]
    return f"Mode shapes at crank angle {degrees:.6g} deg, response at {response}"
