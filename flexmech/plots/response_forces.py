"""Driving torque and joint forces of the running linkage, next to those of rigid links."""

from __future__ import annotations

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from flexmech.plots.response import (
    draw_engines,
    engine_handles,
    fitting_unit,
    run_title,
)
from flexmech.plots.style import header_height, header_legend, new_figure, publication_style
from flexmech.plots.time_axis import time_panels, time_panels_height

__all__ = ["plot_forces"]

TORQUE_UNITS = ((1.0, "N m"), (1e3, "mN m"), (1e6, "µN m"))
FORCE_UNITS = ((1.0, "N"), (1e3, "mN"), (1e6, "µN"))

RIGID_GREY = "0.25"
# Thinner than the engines' lines, which it covers where the links are as good as rigid.
RIGID_WIDTH = 0.6


def plot_forces(dataset: xr.Dataset) -> Figure:
    """Draw the driving torque and the pin forces against time, with those of rigid links.

    Forces are those of the pins between links, or of the clamped joint where there is no
    pin. Nothing is cut off or smoothed: axial vibrations, which are too fast to be told
    apart, show as a band around the rigid links' forces (dark grey).

    Parameters
    ----------
    dataset : Dataset
        Of a ``Response`` result; N m, N, s and rad.

    Returns
    -------
    Figure
    """
    with publication_style():
        places = [
            {"joint": joint, "component": str(component)}
            for joint in _pins(dataset)
            for component in dataset["component"].values
        ]
        rigid = Line2D([], [], color=RIGID_GREY, lw=RIGID_WIDTH, label="rigid links")
        handles, title = [*engine_handles(dataset), rigid], run_title(dataset)
        count = 1 + len(places)
        figure = new_figure(time_panels_height(count) + header_height(handles, title))
        panels = time_panels(figure, count, dataset)
        torque = dataset["driving_torque"]
        factor, unit = fitting_unit(torque.values, TORQUE_UNITS)
        draw_engines(panels[0], dataset, factor * torque)
        _draw_rigid(panels[0], factor * dataset["rigid_driving_torque"])
        panels[0].set_ylabel(f"Driving\ntorque ({unit})")
        for axes, place in zip(panels[1:], places, strict=True):
            force = dataset["joint_force"].sel(place)
            factor, unit = fitting_unit(force.values, FORCE_UNITS)
            draw_engines(axes, dataset, factor * force)
            _draw_rigid(axes, factor * dataset["rigid_joint_force"].sel(place))
            axes.set_ylabel(f"Force at {place['joint']},\n{place['component']} ({unit})")
        figure.align_ylabels()
        header_legend(figure, handles, title)
    return figure


def _pins(dataset: xr.Dataset) -> list[str]:
    """Joints between links; of a lone link, its joint with the ground."""
    names = [str(name) for name in dataset["joint"].values]
    if "joint_kind" in dataset.coords:
        kinds = dataset["joint_kind"].values
        pins = [name for name, kind in zip(names, kinds, strict=True) if kind == "pin"]
    else:
        # Without kinds only the custom is left of naming joints with the ground O2, O4, ...
        pins = [name for name in names if not name.startswith("O")]
    return pins or names


def _draw_rigid(axes: Axes, values: xr.DataArray) -> None:
    axes.plot(values["time"].values, values.values, color=RIGID_GREY, lw=RIGID_WIDTH, zorder=3)
