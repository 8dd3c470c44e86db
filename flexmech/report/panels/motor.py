"""A motor and the crank that it turns: speed, torque, power and current over time."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.analyses import Kinematics, Response
from flexmech.plots.reading import crank_speed_units, names_of
from flexmech.report.panel import (
    FRAME_HEIGHT,
    GREY,
    Panel,
    Plot,
    Trace,
    YAxis,
    further_lines,
    panel_of,
)
from flexmech.report.results import Results

# Of the motor on its own shaft.
_GIVEN = {
    "motor_torque": "torque (N m)",
    "motor_power": "power (W)",
    "motor_current": "current (A)",
}


def motor_panel(results: Results) -> Panel | None:
    """Crank speed, and torque, power and current of the motor, of every result under a motor."""
    found = [
        result
        for result in (*results.of_kind(Kinematics), *results.of_kind(Response))
        if "motor_torque" in result.dataset
    ]
    if not found:
        return None
    said = [result.summary() for result in found]
    return panel_of(
        "motor",
        answer=tuple(dict.fromkeys(one.answer[0] for one in said)),
        plots=tuple(_plot(result.dataset, number) for number, result in enumerate(found)),
        lines=tuple(line for one in said for line in further_lines(one) if "motor" in line),
    )


def _plot(data: xr.Dataset, number: int) -> Plot:
    time, traces = data["time"].values, list[Trace]()
    [(factor, unit)] = crank_speed_units(data)
    axes = [YAxis(f"crank ({unit})")]
    speed = factor * data["crank_speed_over_time"]
    traces.append(Trace("rigid links", time, speed.values, GREY, axis=0))
    engines = names_of(data, "engine") if "engine" in data["motor_torque"].dims else []
    for colour, engine in enumerate(engines):
        own = (speed + factor * data["crank_speed_fluctuation"]).sel(engine=engine)
        traces.append(Trace(f"elastic links, {engine}", time, own.values, colour, axis=0))
    for name, label in _GIVEN.items():
        if name not in data:
            continue
        axes.append(YAxis(label))
        lines = [data[name].sel(engine=engine).values for engine in engines] or [data[name].values]
        for colour, line in enumerate(lines):
            shown = np.asarray(line, dtype=float)
            look = colour if engines else GREY
            traces.append(Trace("motor", time, shown, look, axis=len(axes) - 1, legend=False))
    return Plot(
        "motor" if not number else f"motor-{number + 1}",
        "Time (s)",
        tuple(axes),
        tuple(traces),
        "Crank speed, and torque, power and current of the motor on its own shaft, against time",
        height=FRAME_HEIGHT + 130 * len(axes),
        title=str(data.attrs.get("drive", "")),
    )
