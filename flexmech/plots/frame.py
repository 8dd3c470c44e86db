"""How a frame on springs moves under a running linkage, and what its springs put on the floor."""

from __future__ import annotations

import xarray as xr
from matplotlib.figure import Figure

from flexmech.plots import reading, scales
from flexmech.plots.drawing import draw
from flexmech.plots.layout import AxesLike
from flexmech.plots.picture import Picture
from flexmech.plots.response import ROTATION_UNITS, engine_panes, over_time


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
    picture = frame_picture(dataset)
    return draw(picture, scales.time_layout(len(picture.panes)), ax=ax)


def frame_picture(dataset: xr.Dataset) -> Picture:
    """Motion of a frame on springs and force on the floor, as of plot_frame_motion."""
    along = [(one, dataset.sel(component=one)) for one in reading.names_of(dataset, "component")]
    shown = [
        (f"Frame\nalong {one}", own["frame_displacement"], reading.LENGTH_UNITS)
        for one, own in along
    ]
    shown.append(("Frame\nrotation", dataset["frame_rotation"], ROTATION_UNITS))
    shown += [
        (f"Force on the\nfloor along {one}", own["floor_force"], reading.FORCE_UNITS)
        for one, own in along
    ]
    title = f"Frame on springs\n{reading.run_title(dataset)}"
    return over_time(dataset, engine_panes(dataset, shown), title)
