"""What drives a crank: a law of motion and what rings after its stop, or a motor."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from flexmech.plots import reading, scales
from flexmech.plots.drawing import draw
from flexmech.plots.kinematics import POWER
from flexmech.plots.layout import AxesLike
from flexmech.plots.picture import ZERO, Curve, Pane, Picture, Span, by_engine
from flexmech.plots.response import ROTATION_UNITS, engine_panes, over_time
from flexmech.plots.style import MID_GREY, Look

# Of the drive, which is the same for all engines.
PRESCRIBED: Look = {"color": "0.15", "lw": 1.2}
ENVELOPE: Look = {"color": MID_GREY, "lw": 0.9, "zorder": 1.5}
STOP: Look = {"color": MID_GREY, "lw": 0.9, "ls": ":", "zorder": 0.5}
SETTLED: Look = {"color": MID_GREY, "lw": 0.9, "ls": "--", "zorder": 1.2}
# Room beside the range of a speed that fluctuates, over that range.
_ROOM = 0.15
_PANELS: tuple[tuple[str, reading.Units, str], ...] = (
    ("motor_torque", ((1.0, "N m"), (1e3, "N mm")), "Motor\ntorque"),
    ("motor_power", ((1.0, "W"), (1e3, "mW")), "Motor\npower"),
    ("motor_current", ((1.0, "A"), (1e3, "mA")), "Motor\ncurrent"),
)
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
    time, end = dataset["time"].values, float(dataset.attrs.get("run_up_time", np.inf))
    stop = (Span(end, end, STOP, "end of the law", upright=True),) if end < time[-1] else ()
    runs = "engine" in dataset.dims
    panes = [
        Pane(
            f"{what}\n",
            (Curve(time, dataset[name].values, PRESCRIBED, "crank" if runs else ""),),
            units,
            spans=(ZERO, *stop),
        )
        for name, units, what in (
            ("crank_angle", ROTATION_UNITS, "Angle"),
            ("crank_speed_over_time", reading.crank_speed_units(dataset), "Speed"),
            ("crank_acceleration", _ACCELERATION, "Acceleration"),
        )
    ]
    if runs:
        power = engine_panes(dataset, [("Driving\npower", dataset["driving_power"], POWER)])
        panes += [replace(pane, spans=[*pane.spans, *stop]) for pane in power]
    title = f"Motion of the crank\n{reading.conditions(dataset)}"
    return draw(over_time(dataset, panes, title), scales.time_layout(len(panes)), ax=ax)


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
    time, panes = after["time"].values, []
    for link in reading.bending_links(dataset):
        own = after.sel(link=link)
        first = own.isel(engine=0)
        middle = first["residual_middle"].values
        edges = [
            Curve(time, middle + side * first["residual_envelope"].values, ENVELOPE, "envelope")
            for side in (-1.0, 1.0)
        ]
        what = f"{reading.link_label(dataset, link)}\ndeflection"
        curves = (*by_engine(own["deflection"], dataset), *edges)
        panes.append(Pane(what, curves, reading.LENGTH_UNITS, spans=(ZERO,)))
    title = f"Vibration after the stop\n{reading.run_title(dataset)}"
    picture = Picture(panes, "Time (s)", dataset, title, places=time)
    return draw(picture, scales.time_layout(len(panes)), ax=ax)


def plot_motor(dataset: xr.Dataset, *, ax: AxesLike | None = None) -> Figure:
    """Draw the crank's speed, and torque, power and current of the motor on its own shaft.

    Dashed lines are the least and the greatest speed of the rigid linkage's settled motion.

    Parameters
    ----------
    dataset : Dataset
        Of a ``Kinematics`` or ``Response`` result under a motor: ``motor_speed``,
        ``motor_torque`` and ``motor_power`` over time, or (engine, time); ``motor_current`` of a
        DC motor.
    ax : sequence of Axes, optional
        The user's: three, or four of a DC motor. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    picture = motor_picture(dataset)
    return draw(picture, scales.time_layout(len(picture.panes)), ax=ax)


def motor_picture(dataset: xr.Dataset) -> Picture:
    """Speed of the crank, and torque, power and current of the motor, as of plot_motor."""
    time, speed = dataset["time"].values, dataset["crank_speed_over_time"]
    runs = "engine" in dataset["motor_torque"].dims
    settled = "elastic_settled_speed" in dataset.attrs
    name = "settled, found directly" if settled else "rigid links"
    curves = [Curve(time, speed.values, PRESCRIBED | {"zorder": 1.5}, name if runs else "")]
    if runs:
        curves = by_engine(speed + dataset["crank_speed_fluctuation"], dataset) + curves
    spans, limits = [ZERO], None
    if "settled_crank_speed" in dataset:
        found = dataset["settled_crank_speed"].values
        words = "range once settled (rigid links)"
        spans += [Span(end, end, SETTLED, words) for end in (found.min(), found.max())]
    if settled:
        # How the speed fluctuates is to be seen, and not how far it is from zero.
        values = np.concatenate([curve.y for curve in curves])
        values = np.append(values, [span.low for span in spans])
        values = values[np.abs(values) > 0]
        room = _ROOM * float(np.ptp(values))
        limits = float(values.min()) - room, float(values.max()) + room
    units = reading.crank_speed_units(dataset)
    first = Pane("Crank\nspeed", curves, units, spans=spans, limits=limits)
    shown = [(what, dataset[name], units) for name, units, what in _PANELS if name in dataset]
    panes = [first]
    if runs:
        panes += engine_panes(dataset, shown)
    else:
        panes += [
            Pane(what, (Curve(time, values.values, PRESCRIBED),), units, spans=(ZERO,))
            for what, values, units in shown
        ]
    return over_time(dataset, panes, f"Crank and motor\n{reading.conditions(dataset)}")
