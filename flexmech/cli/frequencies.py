"""``flexmech frequencies``: the moving natural frequencies of a model file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from flexmech.choices import MODES, MapPrestress
from flexmech.cli import options
from flexmech.cli.arguments import parse_angles, parse_speeds
from flexmech.cli.deliver import deliver
from flexmech.cli.engines import element_by_engine, make_engines
from flexmech.cli.environment import parse_environment
from flexmech.cli.failures import reports_failures

__all__ = ["HELP", "frequencies"]

HELP = (
    "Moving natural frequencies of a mechanism. Over crank angle and crank speed: a table, CSV "
    "and NetCDF files, and pictures; in heat and moisture, beside those of the dry linkage."
)
Speeds = Annotated[
    str | None,
    typer.Option(
        help='Crank speeds: a comma list or START:STOP:STEP with one unit at the end, as in "0,50,'
        '100 rpm" or "0:300:10 rpm"; rad/s if there is none. Left out: standstill and the speeds '
        "at which the model operates; 0,10,20 rad/s if it names none.",
        metavar="LIST",
    ),
]
Prestress = Annotated[
    MapPrestress,
    typer.Option(
        help="none: elastic stiffness alone; axial: with the axial forces of the rigid motion; "
        "equilibrium: at the nonlinear quasi-static equilibrium; trajectory: in the states that "
        "Exudyn's settled simulation runs through, beside the quasi-static ones."
    ),
]
RotationTerms = Annotated[
    bool,
    typer.Option(
        "--rotation-terms/--no-rotation-terms",
        help="Coriolis, centripetal and tangential terms of the link frames, or none of them.",
    ),
]


@reports_failures
def frequencies(
    model: options.Model,
    speeds: Speeds = None,
    angles: options.Angles = "0:360:5",
    modes: options.Modes = MODES,
    engine: options.Engine = "both",
    element: options.Element = None,
    prestress: Prestress = "equilibrium",
    rotation_terms: RotationTerms = True,
    elements: options.Elements = 8,
    temperature_rise: options.TemperatureRise = None,
    moisture: options.Moisture = None,
    relative_humidity: options.RelativeHumidity = None,
    time: options.ExposureTime = None,
    out: options.Out = Path("results"),
    no_plots: options.NoPlots = False,
) -> None:
    """Compute, save, draw and report the moving natural frequencies of a model file."""
    given = None if speeds is None else parse_speeds(speeds)
    crank_angles = parse_angles(angles)
    chosen = element_by_engine(engine, element)
    environment = parse_environment(temperature_rise, moisture, relative_humidity, time)

    import numpy as np

    from flexmech.analyses import MovingFrequencies, moving_frequencies
    from flexmech.modelfile import load_mechanism

    mechanism = load_mechanism(model)
    unit = "rad/s" if given is None else given.unit
    deliver(
        MovingFrequencies,
        lambda progress: moving_frequencies(
            make_engines(mechanism, chosen, elements),
            np.radians(crank_angles),
            None if given is None else given.values,
            modes=modes,
            prestress=prestress,
            rotation_terms=rotation_terms,
            speed_effect=not no_plots and prestress != "none",
            environment=environment,
            speed_unit=unit,
            progress=progress,
        ),
        out,
        draw=not no_plots,
        speed_unit=unit,
    )
