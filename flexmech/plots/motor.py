"""What a motor gives, and how the crank runs up and turns under it."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from flexmech.plots import reading, scales
from flexmech.plots.drawing import draw
from flexmech.plots.law import PRESCRIBED
from flexmech.plots.layout import AxesLike
from flexmech.plots.picture import ZERO, Curve, Pane, Picture, Span, by_engine
from flexmech.plots.response import engine_panes, over_time
from flexmech.plots.style import MID_GREY, Look

SETTLED: Look = {"color": MID_GREY, "lw": 0.9, "ls": "--", "zorder": 1.2}
# Of the range of a speed that fluctuates, beside it.
_ROOM = 0.15
_PANELS: tuple[tuple[str, reading.Units, str], ...] = (
    ("motor_torque", ((1.0, "N m"), (1e3, "N mm")), "Motor\ntorque"),
    ("motor_power", ((1.0, "W"), (1e3, "mW")), "Motor\npower"),
    ("motor_current", ((1.0, "A"), (1e3, "mA")), "Motor\ncurrent"),
)


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
