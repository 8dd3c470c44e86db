"""``flexmech frequencies``: the moving natural frequencies of a model file."""

from __future__ import annotations

from pathlib import Path

from flexmech.choices import ELEMENTS_A_LINK, TOLERANCE
from flexmech.cli import options
from flexmech.cli.arguments import parse_angles, parse_speeds, speed_remark
from flexmech.cli.deliver import deliver
from flexmech.cli.engines import make_engines
from flexmech.cli.environment import parse_environment
from flexmech.cli.pictures import asked_pictures


def frequencies(
    model: options.Model,
    speeds: options.Speeds = None,
    angles: options.Angles = "0:360:5",
    modes: options.Modes = None,
    shapes_at: options.ShapesAt = None,
    engine: options.Engine = "both",
    element: options.Element = None,
    prestress: options.MapPrestress = "equilibrium",
    rotation_terms: options.RotationTerms = True,
    elements: options.PinnedElements = None,
    shaft: options.Shaft = "prescribed",
    mass: options.Mass = "distributed",
    tolerance: options.Tolerance = TOLERANCE,
    temperature_rise: options.TemperatureRise = None,
    moisture: options.Moisture = None,
    relative_humidity: options.RelativeHumidity = None,
    time: options.ExposureTime = None,
    out: options.Out = Path("results"),
    no_plots: options.NoPlots = False,
    formats: options.Formats = "png",
    width: options.Width = "two-column",
) -> None:
    """Moving natural frequencies of a mechanism.

    Over crank angle and crank speed: a table, CSV and NetCDF files, and pictures; in heat and
    moisture, beside those of the dry linkage.
    """
    given = None if speeds is None else parse_speeds(speeds)
    crank_angles = parse_angles(angles)
    shape_angles = None if shapes_at is None else parse_angles(shapes_at, "--shapes-at")
    environment = parse_environment(temperature_rise, moisture, relative_humidity, time)

    import numpy as np

    from flexmech.analyses import MovingFrequencies, moving_frequencies
    from flexmech.modelfile import load_mechanism

    mechanism = load_mechanism(model)
    unit = "rad/s" if given is None else given.unit
    deliver(
        MovingFrequencies,
        lambda progress: moving_frequencies(
            make_engines(mechanism, engine, element, elements or ELEMENTS_A_LINK, mass=mass),
            np.radians(crank_angles),
            None if given is None else given.values,
            modes=modes,
            prestress=prestress,
            rotation_terms=rotation_terms,
            speed_effect="fastest" if not no_plots and prestress != "none" else False,
            environment=environment,
            speed_unit=unit,
            tolerance=tolerance if elements is None else None,
            shapes_at=None if shape_angles is None else np.radians(shape_angles),
            smooth=not no_plots,
            shaft=shaft,
            progress=progress,
        ),
        out,
        model=model,
        pictures=asked_pictures(no_plots, formats, width),
        speed_unit=unit,
        remark="" if given is None else speed_remark("--speeds", str(speeds), given.values),
    )
