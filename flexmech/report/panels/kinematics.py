"""Motion of the rigid links, joint forces, and what drives the linkage."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.analyses import Kinematics
from flexmech.report.panel import Choice, Panel, Plot, Trace, YAxis
from flexmech.report.results import Results
from flexmech.report.words import crank_degrees
from flexmech.types import FloatArray

__all__ = ["kinematics_panel"]


def kinematics_panel(results: Results) -> Panel | None:
    """Angular velocities and accelerations, sizes of joint forces, torque and power."""
    result = results.first(Kinematics)
    if result is None:
        return None
    data, said = result.dataset, result.summary()
    angle = crank_degrees(data["crank_angle"].values)
    links, joints = ([str(name) for name in data[what].values] for what in ("link", "joint"))
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
                tuple(
                    Trace(
                        link,
                        angle,
                        data[name].sel(link=link).values,
                        number,
                        followed={},
                        axis=axis,
                        legend=axis == 0,
                    )
                    for axis, name in enumerate(("angular_velocity", "angular_acceleration"))
                    for number, link in enumerate(links)
                ),
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
                tuple(_forces(data, angle, joints)),
                "Size of the force of each joint and driving torque over the crank angle, rigid "
                "links",
                "angle",
                tick=60.0,
                height=110 + 100 * (len(joints) + 1),
                title="Joint forces (N) and driving torque (N m)",
            ),
        ),
        tables=said.tables,
        lines=said.lines,
    )


def _forces(data: xr.Dataset, angle: FloatArray, joints: list[str]) -> list[Trace]:
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
                followed=followed,
                axis=axis,
                legend=axis == 0,
            )
            for axis, line in enumerate(lines)
        ]
    return traces
