"""Motion of the rigid links, joint forces, and what drives the linkage."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.analyses import Kinematics
from flexmech.report.panel import Choice, Panel, Plot, Trace, YAxis
from flexmech.report.results import Results
from flexmech.report.words import crank_degrees, speed_name, speed_unit_of
from flexmech.types import FloatArray


def kinematics_panel(results: Results) -> Panel | None:
    """Angular velocities and accelerations, sizes of joint forces, torque and power.

    Of several speeds those at the one that the reader has chosen.
    """
    found = results.of_kind(Kinematics)
    if not found:
        return None
    motion: list[Trace] = []
    forces: list[Trace] = []
    lines: list[str] = []
    links, joints = (
        [str(name) for name in found[0].dataset[what].values] for what in ("link", "joint")
    )
    for result in found:
        data = result.dataset
        speed = speed_name(float(data.attrs["crank_speed"]), speed_unit_of(results))
        when = {"speed": speed} if len(found) > 1 else {}
        angle = crank_degrees(data["crank_angle"].values)
        motion += _motion(data, angle, links, when)
        forces += _forces(data, angle, joints, when)
        at = f"{speed}: " if len(found) > 1 else ""
        lines += [f"{at}{line}" for line in result.summary().lines]
    return Panel(
        name="kinematics",
        title="Motion of the rigid linkage, joint forces and drive",
        caption=(
            "Angular velocity and acceleration of the links, size of the force at each joint, "
            "torque and power of the shaft against crank angle, if links were rigid. Dotted: by "
            "lumped masses, where these were asked for."
        ),
        equation="F = -m a_G,  M = -I_G α, and three equations of motion a link",
        source="Kumar & Chandrakar, eqs. 1.37 to 1.44, 1.64, 1.65",
        plots=(
            Plot(
                "link-motion",
                "Crank angle (deg)",
                (YAxis("velocity (rad/s)"), YAxis("acceleration (rad/s²)")),
                tuple(motion),
                f"Angular velocity and acceleration of {', '.join(links)} over the crank angle",
                "angle",
                tick=60.0,
                height=380,
                title="Angular velocity and acceleration",
            ),
            Plot(
                "rigid-forces",
                "Crank angle (deg)",
                (*(YAxis(f"{joint} (N)") for joint in joints), YAxis("torque (N m)")),
                tuple(forces),
                "Size of the force of each joint and driving torque over the crank angle, rigid "
                "links",
                "angle",
                tick=60.0,
                height=110 + 100 * (len(joints) + 1),
                title="Joint forces (N) and driving torque (N m)",
            ),
        ),
        tables=tuple(table for result in found for table in result.summary().tables),
        lines=tuple(lines),
    )


def _motion(data: xr.Dataset, angle: FloatArray, links: list[str], when: Choice) -> list[Trace]:
    """Angular velocities above angular accelerations."""
    return [
        Trace(
            link,
            angle,
            data[name].sel(link=link).values,
            number,
            when=when,
            followed={},
            axis=axis,
            legend=axis == 0,
        )
        for axis, name in enumerate(("angular_velocity", "angular_acceleration"))
        for number, link in enumerate(links)
    ]


def _forces(data: xr.Dataset, angle: FloatArray, joints: list[str], when: Choice) -> list[Trace]:
    """Sizes of joint forces and the torque, distributed and lumped."""
    traces = []
    for number, (of, name) in enumerate((("", "distributed masses"), ("lumped_", "lumped masses"))):
        if f"{of}joint_force" not in data:
            continue
        force = data[f"{of}joint_force"].transpose("joint", "crank_angle", "component").values
        lines = [*np.linalg.norm(force, axis=-1), data[f"{of}driving_torque"].values]
        followed: Choice | None = {} if number == 0 else None
        traces += [
            Trace(
                name,
                angle,
                line,
                number,
                "dot" if number else "solid",
                when=when,
                followed=followed,
                axis=axis,
                legend=axis == 0,
            )
            for axis, line in enumerate(lines)
        ]
    return traces
