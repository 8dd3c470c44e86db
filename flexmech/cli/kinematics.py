"""``flexmech kinematics``: how the rigid linkage moves, and the forces that it takes."""

from __future__ import annotations

from pathlib import Path

from flexmech.cli import options
from flexmech.cli.arguments import parse_angles, parse_crank_speed, parse_lumped, speed_remark
from flexmech.cli.deliver import deliver
from flexmech.cli.pictures import asked_pictures


def kinematics(
    model: options.Model,
    speed: options.OptionalSpeed = None,
    angles: options.Angles = "0:360:1",
    lumped: options.Lumped = None,
    out: options.Out = Path("results"),
    no_plots: options.NoPlots = False,
    formats: options.Formats = "png",
    width: options.Width = "two-column",
) -> None:
    """Motion of the rigid linkage, its joint forces and driving torque.

    Angles, velocities and accelerations of the links, forces and moments at the joints, torque,
    power and transmission angle over the crank angle: a table, CSV and NetCDF files, and pictures.
    """
    degrees = parse_angles(angles)
    crank_speed, unit = (None, "rad/s") if speed is None else parse_crank_speed(speed)
    elements = None if lumped is None else parse_lumped(lumped)

    import numpy as np

    from flexmech.analyses.kinematics import Kinematics, KinematicsRequest
    from flexmech.analyses.kinematics import kinematics as analysis
    from flexmech.modelfile import load_mechanism

    request = KinematicsRequest(np.radians(degrees), crank_speed, elements, unit)
    mechanism = load_mechanism(model)
    deliver(
        Kinematics,
        lambda _: analysis(mechanism, request),
        out,
        model=model,
        pictures=asked_pictures(no_plots, formats, width),
        speed_unit=unit,
        remark="" if speed is None else speed_remark("--speed", speed, [crank_speed or 0.0]),
    )
