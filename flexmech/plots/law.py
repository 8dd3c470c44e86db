"""The law of motion of a crank, the power that it takes, and what rings after its stop."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from flexmech.plots import reading, scales
from flexmech.plots.kinematics import POWER
from flexmech.plots.layout import AxesLike, sheet
from flexmech.plots.response import ROTATION_UNITS, draw_engines, engine_lines
from flexmech.plots.style import MID_GREY, Look, line_handle

# Of the drive, which is the same for all engines.
PRESCRIBED: Look = {"color": "0.15", "lw": 1.2}
ENVELOPE: Look = {"color": MID_GREY, "lw": 0.9}
STOP: Look = {"color": MID_GREY, "lw": 0.9, "ls": ":"}
_ACCELERATION: reading.Units = ((1.0, "rad/s²"),)


def plot_law(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw angle, speed and acceleration of the crank over time, and of a run the driving power.

    A dotted line is where the law ends.

    Parameters
    ----------
    dataset : Dataset
        Of a ``Kinematics`` or ``Response`` result under a law of motion: ``crank_angle``,
        ``crank_speed_over_time`` and ``crank_acceleration`` over time, and ``driving_power``
        (engine, time) of a run.
    ax : sequence of Axes, optional
        The user's, three, or four of a run. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    runs = "engine" in dataset.dims
    of_crank = (
        ("crank_angle", ROTATION_UNITS, "Angle"),
        ("crank_speed_over_time", reading.crank_speed_units(dataset), "Speed"),
        ("crank_acceleration", _ACCELERATION, "Acceleration"),
    )
    time = dataset["time"].values
    end = float(dataset.attrs.get("run_up_time", np.inf))
    with sheet(scales.time_layout(3 + runs), ax=ax) as drawn:
        handles = [line_handle("crank", **PRESCRIBED), *engine_lines(dataset)] if runs else []
        if end < time[-1]:
            handles.append(line_handle("end of the law", **STOP))
        drawn.header(handles, f"Motion of the crank\n{reading.conditions(dataset)}", of=dataset)
        scales.label_times(drawn, dataset)
        for axes, (name, units, what) in zip(drawn.panels, of_crank, strict=False):
            factor, unit = reading.fitting_unit(dataset[name].values, units)
            scales.zero_line(axes)
            axes.plot(time, factor * dataset[name].values, **PRESCRIBED)
            scales.plain_numbers(axes)
            axes.set_ylabel(f"{what}\n({unit})")
        if runs:
            draw_engines(drawn.panels[-1], dataset["driving_power"], POWER, "Driving\npower")
        for axes in drawn.panels if end < time[-1] else ():
            axes.axvline(end, **STOP, zorder=0.5)
    return drawn.figure


def plot_residual(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the deflection of each link after the crank has stopped, and its envelope.

    Parameters
    ----------
    dataset : Dataset
        Of a ``Response`` result under a law that stops: ``deflection``, and ``residual_envelope``
        about ``residual_middle`` (engine, time, link) in m; the first engine's envelope is drawn in
        grey.
    ax : sequence of Axes, optional
        The user's, one for each link that bends. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    after = dataset.sel(time=dataset["time"] >= float(dataset.attrs["run_up_time"]))
    links = reading.bending_links(dataset)
    with sheet(scales.time_layout(len(links)), ax=ax) as drawn:
        handles = [*engine_lines(dataset), line_handle("envelope", **ENVELOPE)]
        title = f"Vibration after the stop\n{reading.run_title(dataset)}"
        drawn.header(handles, title, of=dataset)
        time = after["time"].values
        for axes, link in zip(drawn.panels, links, strict=True):
            axes.set_xlim(float(time[0]), float(time[-1]))
            own = after.sel(link=link)
            what = f"{reading.link_label(dataset, link)}\ndeflection"
            factor = draw_engines(axes, own["deflection"], reading.LENGTH_UNITS, what)
            first = own.isel(engine=0)
            middle = first["residual_middle"].values
            for side in (-1.0, 1.0):
                edge = factor * (middle + side * first["residual_envelope"].values)
                axes.plot(time, edge, **ENVELOPE, zorder=1.5)
        drawn.label_x("Time (s)")
    return drawn.figure
