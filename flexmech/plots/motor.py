"""What a motor gives, and how the crank runs up and turns under it."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexmech.plots import reading, scales
from flexmech.plots.law import PRESCRIBED
from flexmech.plots.layout import AxesLike, sheet
from flexmech.plots.response import draw_engines, engine_lines
from flexmech.plots.style import MID_GREY, Look, line_handle

SETTLED: Look = {"color": MID_GREY, "lw": 0.9, "ls": "--"}
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
    runs = "engine" in dataset["motor_torque"].dims
    panels = [panel for panel in _PANELS if panel[0] in dataset]
    with sheet(scales.time_layout(1 + len(panels)), ax=ax) as drawn:
        settled = "elastic_settled_speed" in dataset.attrs
        nominal = line_handle("settled, found directly" if settled else "rigid links", **PRESCRIBED)
        handles = [*engine_lines(dataset), nominal] if runs else []
        if "settled_crank_speed" in dataset:
            handles.append(line_handle("range once settled (rigid links)", **SETTLED))
        drawn.header(handles, f"Crank and motor\n{reading.conditions(dataset)}", of=dataset)
        scales.label_times(drawn, dataset)
        _draw_speed(drawn.panels[0], dataset, runs=runs)
        if settled:
            _fit_range(drawn.panels[0])
        for axes, (name, units, what) in zip(drawn.panels[1:], panels, strict=False):
            if runs:
                draw_engines(axes, dataset[name], units, what)
            else:
                _draw(axes, dataset[name], units, what)
    return drawn.figure


def _fit_range(axes: Axes) -> None:
    """Show how the speed fluctuates and not how far it is from zero."""
    values = np.concatenate(
        [np.asarray(line.get_ydata(), dtype=float) for line in axes.get_lines()]
    )
    values = values[np.abs(values) > 0]
    room = _ROOM * float(np.ptp(values))
    axes.set_ylim(float(values.min()) - room, float(values.max()) + room)


def _draw_speed(axes: Axes, dataset: xr.Dataset, *, runs: bool) -> None:
    """Speed of the crank: of all engines, and of the rigid or the settled motion."""
    speed = dataset["crank_speed_over_time"]
    if runs:
        factor = draw_engines(
            axes,
            speed + dataset["crank_speed_fluctuation"],
            reading.crank_speed_units(dataset),
            "Crank\nspeed",
        )
        axes.plot(dataset["time"].values, factor * speed.values, **PRESCRIBED, zorder=1.5)
    else:
        factor = _draw(axes, speed, reading.crank_speed_units(dataset), "Crank\nspeed")
    if "settled_crank_speed" in dataset:
        settled = dataset["settled_crank_speed"].values
        for value in (settled.min(), settled.max()):
            axes.axhline(factor * value, **SETTLED, zorder=1.2)


def _draw(axes: Axes, values: xr.DataArray, units: reading.Units, what: str) -> float:
    """Draw values, and return the factor to their unit."""
    factor, unit = reading.fitting_unit(values.values, units)
    scales.zero_line(axes)
    axes.plot(values["time"].values, factor * values.values, **PRESCRIBED)
    scales.plain_numbers(axes)
    axes.set_ylabel(f"{what}\n({unit})")
    return factor
