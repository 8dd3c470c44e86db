"""The rigid linkage: its motion, joint forces and drive, coupler curve and transmission angle."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from flexmech.analyses import CouplerPaths, Kinematics, ModelCheck, Table
from flexmech.arrays import FloatArray
from flexmech.plots.motion import KINDS, MOST_POINTS, drawn_points, motion_lines
from flexmech.plots.reading import degrees, names_of
from flexmech.report import panel
from flexmech.report import results as words
from flexmech.report.results import Results


def kinematics_panel(results: Results) -> panel.Panel | None:
    """Motion of links and points, sizes of joint forces, torque and power.

    Of several speeds those at the one that the reader has chosen.
    """
    found = results.of_kind(Kinematics)
    # Those under a motor have a panel of their own, and stand here where there are no others.
    found = [own for own in found if "motor_torque" not in own.dataset] or found
    if not found:
        return None
    motion, moved, forces = (list[panel.Trace]() for _ in range(3))
    answer, lines, warnings = list[str](), list[str](), list[str]()
    tables, folded = list[Table](), list[Table]()
    links, joints = (names_of(found[0].dataset, what) for what in ("link", "joint"))
    points = drawn_points(found[-1].dataset)[:MOST_POINTS]
    for result in found:
        data = result.dataset
        speed = words.speed_name(float(data.attrs["crank_speed"]), words.speed_unit_of(results))
        when = {"speed": speed} if len(found) > 1 else {}
        # Under a law of motion all is over time, which has no picture of the page: words tell it.
        if "time" not in data.dims:
            angle = degrees(data["crank_angle"])
            motion += _motion(data, angle, links, when)
            moved += _moved(data, angle, points, when)
            forces += _forces(data, angle, when)
        at = f"{speed}: " if len(found) > 1 else ""
        said = result.summary()
        answer += [f"{at}{line}" for line in said.answer]
        lines += [f"{at}{line}" for line in panel.further_lines(said)]
        tables += said.tables[:1]
        folded += said.tables[1:]
        warnings += [f"{at}{warning}" for warning in said.warnings]
    pictures = [
        panel.over_angle(
            "link-motion",
            (panel.YAxis("velocity (rad/s)"), panel.YAxis("acceleration (rad/s²)")),
            motion,
            text=f"Angular velocity and acceleration of {', '.join(links)} over the crank angle",
            height=380,
            title="Angular velocity and acceleration",
        ),
        forces_plot("rigid-forces", joints, forces, "over the crank angle, rigid links"),
    ]
    if points:
        pictures.insert(1, _points_plot(points, moved))
    shown = pictures if motion else []
    return panel.panel_of(
        "kinematics",
        answer=tuple(answer),
        plots=tuple(shown),
        tables=tuple(tables),
        folded=tuple(folded),
        lines=tuple(lines),
        warnings=tuple(warnings),
    )


def _points_plot(points: list[str], traces: list[panel.Trace]) -> panel.Plot:
    """Position, velocity and acceleration of sliders along their lines, of points along x and y."""
    units = ("mm", "m/s", "m/s²")
    return panel.over_angle(
        "point-motion",
        tuple(
            panel.YAxis(f"{name} ({unit})") for (name, *_), unit in zip(KINDS, units, strict=True)
        ),
        traces,
        text=f"Position, velocity and acceleration of {', '.join(points)} over the crank angle",
        height=480,
        title="Position, velocity and acceleration of points",
    )


def _moved(
    data: xr.Dataset, angle: FloatArray, points: list[str], when: panel.Choice
) -> list[panel.Trace]:
    """Each direction of a point in a style of its own, above each other."""
    traces = []
    for number, line in enumerate(motion_lines(data, points)):
        for axis, (values, factor) in enumerate(zip(line.values, (1e3, 1.0, 1.0), strict=True)):
            shown: dict[str, Any] = {"when": when, "followed": {}, "axis": axis}
            shown["legend"] = axis == 0
            name = f"{line.point} along {line.along}"
            traces.append(panel.Trace(name, angle, factor * values, number, **shown))
    return traces


def forces_plot(name: str, joints: list[str], traces: list[panel.Trace], over: str) -> panel.Plot:
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
    return panel.over_angle(
        name,
        (*(panel.YAxis(f"{joint} (N)") for joint in joints), panel.YAxis("torque (N m)")),
        traces,
        text=f"Size of the force of each joint and driving torque {over}",
        height=panel.FRAME_HEIGHT + 100 * (len(joints) + 1),
        title="Joint forces (N) and driving torque (N m)",
    )


def _motion(
    data: xr.Dataset, angle: FloatArray, links: list[str], when: panel.Choice
) -> list[panel.Trace]:
    """Angular velocities above angular accelerations."""
    traces = []
    for axis, name in enumerate(("angular_velocity", "angular_acceleration")):
        shown: dict[str, Any] = {"when": when, "followed": {}, "axis": axis, "legend": axis == 0}
        for number, link in enumerate(links):
            traces.append(
                panel.Trace(link, angle, data[name].sel(link=link).values, number, **shown)
            )
    return traces


def _forces(data: xr.Dataset, angle: FloatArray, when: panel.Choice) -> list[panel.Trace]:
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
            traces.append(
                panel.Trace(name, angle, line, number, axis=axis, legend=axis == 0, **look)
            )
    return traces


@panel.shows(CouplerPaths)
def coupler_panel(result: CouplerPaths, results: Results) -> panel.Panel:
    """Coupler curves of each state, with their crunodes and cusps."""
    data, traces = result.dataset, list[panel.Trace]()
    angle = degrees(data["crank_angle"])
    for number, name in enumerate(names_of(data, "name")):
        x, y = (1e3 * data["position"].isel(state=number).sel(component=c).values for c in "xy")
        dashes: Any = "dash" if number else "solid"
        traces.append(panel.Trace(name, x, y, number, dashes, followed={}, angle=angle))
        points = np.flatnonzero(data["double_point_state"].values == number)
        if points.size:
            x, y = 1e3 * data["double_point_position"].values[points].T
            traces.append(panel.Trace(f"crunode or cusp, {name}", x, y, number, "points", 8.0))
    plot = panel.Plot(
        "coupler",
        "x (mm)",
        (panel.YAxis("y (mm)"),),
        tuple(traces),
        "Path of the coupler point in the plane, dry and in the environment asked for",
        "point",
        equal=True,
        height=420,
    )
    return panel.panel_of("coupler-curve", result.summary(), plots=(plot,))


@panel.shows(ModelCheck)
def mechanism_panel(result: ModelCheck, results: Results) -> panel.Panel:
    """Links, masses and operation in words and a table, and the transmission angle."""
    said, data, plots = result.summary(), result.dataset, list[panel.Plot]()
    variant = "transmission_angle" if "transmission_angle" in data else "drawn"
    if variant in data:
        angle = degrees(data["crank_angle"])
        values = np.degrees(data["transmission_angle"].values.astype(float))
        traces = [panel.Trace("transmission angle", angle, values, followed={}, legend=False)]
        for limit in np.degrees(data["usual_transmission_angle"].values).tolist():
            line = f"{limit:g} deg", angle[[0, -1]], np.full(2, limit), panel.GREY
            traces.append(panel.Trace(*line, look="dot", width=1.0, legend=False))
        text = "Transmission angle between coupler and rocker against crank angle"
        axes = (panel.YAxis("Transmission angle (deg)"),)
        plots.append(panel.over_angle("transmission-angle", axes, traces, text=text, height=260))
    return panel.panel_of("mechanism", said, variant, plots=tuple(plots))
