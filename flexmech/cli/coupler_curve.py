"""``flexmech coupler-curve``: the path of a coupler point, dry and in heat and moisture."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from flexmech.cli import options
from flexmech.cli.arguments import parse_angles, parse_point
from flexmech.cli.deliver import deliver
from flexmech.cli.environment import parse_environment
from flexmech.cli.failures import reports_failures

__all__ = ["HELP", "coupler_curve"]

HELP = "Path of a point of the coupler, its crossings and cusps: dry, and in heat and moisture."

Point = Annotated[
    str | None,
    typer.Option(
        help='Distance e from A and angle gamma from A-B, as in "33 mm,320 deg". Left out: the '
        "coupler point of the model file.",
        metavar="e,gamma",
    ),
]


@reports_failures
def coupler_curve(
    model: options.Model,
    temperature_rise: options.TemperatureRise = None,
    moisture: options.Moisture = None,
    relative_humidity: options.RelativeHumidity = None,
    time: options.ExposureTime = None,
    point: Point = None,
    angles: options.Angles = "0:360:1",
    out: options.Out = Path("results"),
    no_plots: options.NoPlots = False,
) -> None:
    """Compute, save, draw and report the path of a coupler point."""
    degrees = parse_angles(angles)
    environment = parse_environment(temperature_rise, moisture, relative_humidity, time)
    given = None if point is None else parse_point(point)

    import numpy as np

    from flexmech.analyses.coupler_path import CouplerPaths, coupler_paths
    from flexmech.modelfile import load_mechanism

    request = load_mechanism(model), np.radians(degrees), given, environment
    deliver(CouplerPaths, lambda _: coupler_paths(*request), out, draw=not no_plots)
