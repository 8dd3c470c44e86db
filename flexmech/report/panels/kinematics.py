"""The rigid linkage: its motion, joint forces and drive, coupler curve and transmission angle."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from flexmech.analyses import CouplerPaths, Kinematics, ModelCheck
from flexmech.arrays import FloatArray
from flexmech.plots.reading import degrees, names_of
from flexmech.report.panel import (
    GREY,
    Choice,
    Panel,
    Plot,
    Trace,
    YAxis,
    over_angle,
    panel_of,
    shows,
)
from flexmech.report.results import Results
from flexmech.report.words import speed_name, speed_unit_of


def kinematics_panel(results: Results) -> Panel | None:
    """Angular velocities and accelerations, sizes of joint forces, torque and power.

    Of several speeds those at the one that the reader has chosen.
    """
    found = results.of_kind(Kinematics)
    if not found:
        return None
    motion, forces, lines = list[Trace](), list[Trace](), list[str]()
    links, joints = (names_of(found[0].dataset, what) for what in ("link", "joint"))
    for result in found:
        data = result.dataset
        speed = speed_name(float(data.attrs["crank_speed"]), speed_unit_of(results))
        when = {"speed": speed} if len(found) > 1 else {}
        angle = degrees(data["crank_angle"])
        motion += _motion(data, angle, links, when)
        forces += _forces(data, angle, when)
        at = f"{speed}: " if len(found) > 1 else ""
        lines += [f"{at}{line}" for line in result.summary().lines]
    plots = (
        over_angle(
            "link-motion",
            (YAxis("velocity (rad/s)"), YAxis("acceleration (rad/s²)")),
            motion,
            text=f"Angular velocity and acceleration of {', '.join(links)} over the crank angle",
            height=380,
            title="Angular velocity and acceleration",
        ),
        forces_plot("rigid-forces", joints, forces, "over the crank angle, rigid links"),
    )
    tables = tuple(table for result in found for table in result.summary().tables)
    return panel_of("kinematics", plots=plots, tables=tables, lines=tuple(lines))


def forces_plot(name: str, joints: list[str], traces: list[Trace], over: str) -> Plot:
    """Sizes of joint forces above each other, and the driving torque below them.

    Parameters
    ----------
    name : str
        Of the plot.
    joints : list of str
    traces : list of Trace
        On the axis of their joint; those of the torque on the last one.
    over : str
        Against what they are drawn, in words.

    Returns
    -------
    Plot
    """
    return over_angle(
        name,
        (*(YAxis(f"{joint} (N)") for joint in joints), YAxis("torque (N m)")),
        traces,
        text=f"Size of the force of each joint and driving torque {over}",
        height=110 + 100 * (len(joints) + 1),
        title="Joint forces (N) and driving torque (N m)",
    )


def _motion(data: xr.Dataset, angle: FloatArray, links: list[str], when: Choice) -> list[Trace]:
    """Angular velocities above angular accelerations."""
    traces = []
    for axis, name in enumerate(("angular_velocity", "angular_acceleration")):
        shown: dict[str, Any] = {"when": when, "followed": {}, "axis": axis, "legend": axis == 0}
        for number, link in enumerate(links):
            traces.append(Trace(link, angle, data[name].sel(link=link).values, number, **shown))
    return traces


def _forces(data: xr.Dataset, angle: FloatArray, when: Choice) -> list[Trace]:
    """Sizes of joint forces and the torque, distributed and lumped."""
    traces = []
    for number, (of, name) in enumerate((("", "distributed masses"), ("lumped_", "lumped masses"))):
        if f"{of}joint_force" not in data:
            continue
        force = data[f"{of}joint_force"].transpose("joint", "crank_angle", "component").values
        lines = [*np.linalg.norm(force, axis=-1), data[f"{of}driving_torque"].values]
        look: dict[str, Any] = {"look": "dot" if number else "solid", "when": when}
        look["followed"] = None if number else {}
        for axis, line in enumerate(lines):
            traces.append(Trace(name, angle, line, number, axis=axis, legend=axis == 0, **look))
    return traces


@shows(CouplerPaths)
def coupler_panel(result: CouplerPaths, results: Results) -> Panel:
    """Coupler curves of each state, with their crunodes and cusps."""
    data, traces = result.dataset, list[Trace]()
    angle = degrees(data["crank_angle"])
    for number, name in enumerate(names_of(data, "name")):
        x, y = (1e3 * data["position"].isel(state=number).sel(component=c).values for c in "xy")
        dashes: Any = "dash" if number else "solid"
        traces.append(Trace(name, x, y, number, dashes, followed={}, angle=angle))
        points = np.flatnonzero(data["double_point_state"].values == number)
        if points.size:
            x, y = 1e3 * data["double_point_position"].values[points].T
            traces.append(Trace(f"crunode or cusp, {name}", x, y, number, "points", 8.0))
    plot = Plot(
        "coupler",
        "x (mm)",
        (YAxis("y (mm)"),),
        tuple(traces),
        "Path of the coupler point in the plane, dry and in the environment asked for",
        "point",
        equal=True,
        height=420,
    )
    return panel_of("coupler-curve", result.summary(), plots=(plot,), tables=())


@shows(ModelCheck)
def mechanism_panel(result: ModelCheck, results: Results) -> Panel:
    """Links, masses and operation in words and a table, and the transmission angle."""
    said, data, plots = result.summary(), result.dataset, list[Plot]()
    if "transmission_angle" in data:
        angle = degrees(data["crank_angle"])
        values = np.degrees(data["transmission_angle"].values.astype(float))
        traces = [Trace("transmission angle", angle, values, followed={}, legend=False)]
        for limit in np.degrees(data["usual_transmission_angle"].values).tolist():
            line = f"{limit:g} deg", angle[[0, -1]], np.full(2, limit), GREY
            traces.append(Trace(*line, look="dot", width=1.0, legend=False))
        text = "Transmission angle between coupler and rocker against crank angle"
        axes = (YAxis("Transmission angle (deg)"),)
        plots.append(over_angle("transmission-angle", axes, traces, text=text, height=260))
    return panel_of("mechanism", said, plots=tuple(plots), lines=said.lines)
