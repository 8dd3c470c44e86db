"""Driving torque and joint forces of the running linkage, next to those of rigid links."""

from __future__ import annotations

from typing import Any

import xarray as xr
from matplotlib.figure import Figure

from flexmech.plots.reading import Units, names_of, run_title
from flexmech.plots.response import draw_engines, engine_lines
from flexmech.plots.sheet import AxesLike, sheet
from flexmech.plots.style import line_handle
from flexmech.plots.time_axis import label_times, time_layout

__all__ = ["plot_forces"]

TORQUE_UNITS: Units = ((1.0, "N m"), (1e3, "mN m"), (1e6, "µN m"))
FORCE_UNITS: Units = ((1.0, "N"), (1e3, "mN"), (1e6, "µN"))

# Thinner than the engines' lines, which it covers where the links are as good as rigid.
RIGID: dict[str, Any] = {"color": "0.25", "lw": 0.6}


def plot_forces(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the driving torque and the pin forces against time, with those of rigid links.

    Forces are those of the pins between links, or of the clamped joint where there is no
    pin. Nothing is cut off or smoothed: axial vibrations, which are too fast to be told
    apart, show as a band around the rigid links' forces (dark grey).

    Parameters
    ----------
    dataset : Dataset
        Of a ``Response`` result; N m, N, s and rad.
    ax : Axes or sequence of Axes, optional
        The user's, one a panel. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    torque = dataset["driving_torque"], dataset["rigid_driving_torque"]
    shown = [(*torque, TORQUE_UNITS, "Driving\ntorque")]
    pins = dataset["joint"].values[dataset["joint_kind"].values == "pin"]
    for joint in pins if pins.size else dataset["joint"].values:
        for component in names_of(dataset, "component"):
            place = {"joint": joint, "component": component}
            force, rigid = (
                dataset[name].sel(place) for name in ("joint_force", "rigid_joint_force")
            )
            shown.append((force, rigid, FORCE_UNITS, f"Force at {joint},\n{component}"))
    with sheet(time_layout(len(shown)), ax=ax) as drawn:
        drawn.header(
            [*engine_lines(dataset), line_handle("rigid links", **RIGID)], run_title(dataset)
        )
        label_times(drawn, dataset)
        for axes, (elastic, rigid, units, what) in zip(drawn.panels, shown, strict=True):
            factor = draw_engines(axes, elastic, units, what)
            axes.plot(rigid["time"].values, factor * rigid.values, **RIGID, zorder=3)
    return drawn.figure
