"""``flexmech coupler-curve``: the path of a coupler point, dry and in heat and moisture."""

from __future__ import annotations

from pathlib import Path

from flexmech.cli import options
from flexmech.cli.arguments import parse_angles, parse_point
from flexmech.cli.deliver import deliver
from flexmech.cli.environment import parse_environment
from flexmech.cli.pictures import asked_pictures


def coupler_curve(
    model: options.Model,
    temperature_rise: options.TemperatureRise = None,
    moisture: options.Moisture = None,
    relative_humidity: options.RelativeHumidity = None,
    time: options.ExposureTime = None,
    point: options.Point = None,
    link: options.OnLink = "coupler",
    angles: options.Angles = "0:360:1",
    out: options.Out = Path("results"),
    no_plots: options.NoPlots = False,
    formats: options.Formats = "png",
    width: options.Width = "two-column",
) -> None:
    """Path of a point of the coupler or another link, dry, and in heat and moisture.

    Of a four-bar's coupler with all crossings and cusps.
    """
    degrees = parse_angles(angles)
    environment = parse_environment(temperature_rise, moisture, relative_humidity, time)
    given = None if point is None else parse_point(point)

    import numpy as np

    from flexmech.analyses.coupler_path import CouplerPaths, coupler_paths
    from flexmech.modelfile import load_mechanism

    request = load_mechanism(model), np.radians(degrees), given, environment
    deliver(
        CouplerPaths,
        lambda _: coupler_paths(*request, link=link),
        out,
        model=model,
        pictures=asked_pictures(no_plots, formats, width),
    )
