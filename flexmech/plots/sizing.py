"""Torque over speed, as a motor must give it."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.plots import reading, style
from flexmech.plots.drawing import figure
from flexmech.plots.layout import grid
from flexmech.plots.picture import ZERO, Curve, Pane, Picture
from flexmech.plots.style import Look

# Room beside the range of speeds, over it.
_ROOM = 0.04
_HEIGHT = 3.2
_RMS: Look = {"ls": "", "marker": "D", "ms": 6, "mfc": "white", "mew": 1.4, "zorder": 4}


@figure
def plot_motor_plane(dataset: xr.Dataset) -> Picture:
    """Draw torque over speed, a point for each position: of the motor, or else of the shaft.

    A diamond is the root mean square of both, which the motor must bear all the time.

    Parameters
    ----------
    dataset : Dataset
        Dataset of a ``Kinematics`` or ``Response`` result: ``driving_torque`` and
        ``crank_speed_over_time``, the attribute ``crank_speed`` in its place, or ``motor_torque``
        and ``motor_speed``; N m and rad/s.
    ax : Axes, optional
        The user's. Left out: a new figure is made.

    Returns
    -------
    Figure
    """
    who = "motor" if "motor_torque" in dataset else "shaft"
    torque, speed = _of_motor(dataset) if who == "motor" else _of_shaft(dataset)
    factor, unit = reading.crank_speed_units(dataset)[0]
    rms = reading.sizing(dataset, "rms_torque", who)
    names = [""]
    if "engine" in torque.dims:
        names = [reading.engine_label(dataset, n) for n in range(dataset.sizes["engine"])]
    over = str(speed.dims[-1])
    torques = np.reshape(torque.transpose(..., over).values, (len(names), -1))
    speeds = factor * np.broadcast_to(speed.transpose(..., over).values, torques.shape)
    points, means = list[Curve](), list[Curve]()
    for number, (x, y, mean) in enumerate(zip(speeds, torques, np.ravel(rms), strict=True)):
        colour = style.series_style(number).color
        look: Look = {"ls": "", "marker": "ox"[number % 2], "ms": 2, "color": colour}
        points.append(Curve(x, y, look, names[number]))
        at = np.array([np.sqrt((x**2).mean())]), np.array([mean])
        means.append(Curve(*at, _RMS | {"color": colour}, "root mean square"))
    low, high = min(float(speeds.min()), 0.0), max(float(speeds.max()), 0.0)
    room = _ROOM * (high - low)
    limits = (low - room, high + room) if room else None
    pane = Pane(
        f"Torque of the {who}",
        [*points, *means],
        reading.TORQUE_UNITS,
        spans=(ZERO,),
        x_limits=limits,
    )
    title = f"Torque over speed of the {who}, {reading.conditions(dataset)}"
    speed_label = f"Speed of the {who} ({unit})"
    return Picture([pane], speed_label, dataset, title, layout=grid(1, 1, _HEIGHT))


def _of_motor(dataset: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray]:
    """Torque and speed of a motor on its own shaft."""
    return dataset["motor_torque"], dataset["motor_speed"]


def _of_shaft(dataset: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray]:
    """Torque of the shaft, with what its own inertia takes, and its speed."""
    torque = dataset["driving_torque"]
    constant = xr.full_like(torque, float(dataset.attrs["crank_speed"]))
    speed = dataset.get("crank_speed_over_time", constant) + dataset.get(
        "crank_speed_fluctuation", 0.0
    )
    return torque + dataset.get("shaft_inertia_torque", 0.0), speed
