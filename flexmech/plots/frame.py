"""How a frame on springs moves under a running linkage, and what its springs put on the floor."""

from __future__ import annotations

import xarray as xr
from matplotlib.figure import Figure

from flexmech.plots import reading, scales
from flexmech.plots.layout import AxesLike, sheet
from flexmech.plots.response import ROTATION_UNITS, draw_engines, engine_lines


def plot_frame_motion(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw displacement and rotation of a frame on springs, and force on the floor, against time.

    Parameters
    ----------
    dataset : Dataset
        Of a ``Response`` result of a mechanism with a frame on springs: ``frame_displacement``
        (engine, time, component) in m, ``frame_rotation`` in rad and ``floor_force`` in N.
    ax : Axes or sequence of Axes, optional
        The user's, five of them. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    components = reading.names_of(dataset, "component")
    moved, force = dataset["frame_displacement"], dataset["floor_force"]
    shown = [
        (moved.sel(component=one), reading.LENGTH_UNITS, f"Frame\nalong {one}")
        for one in components
    ]
    shown.append((dataset["frame_rotation"], ROTATION_UNITS, "Frame\nrotation"))
    shown += [
        (force.sel(component=one), reading.FORCE_UNITS, f"Force on the\nfloor along {one}")
        for one in components
    ]
    with sheet(scales.time_layout(len(shown)), ax=ax) as drawn:
        title = f"Frame on springs\n{reading.run_title(dataset)}"
        drawn.header(engine_lines(dataset), title, of=dataset)
        scales.label_times(drawn, dataset)
        for axes, (quantity, units, what) in zip(drawn.panels, shown, strict=True):
            draw_engines(axes, quantity, units, what)
    return drawn.figure
