"""``flexmech synthesize``: link proportions for a wanted transmission angle."""

from __future__ import annotations

import math
from typing import Annotated

import typer

from flexmech.cli import options
from flexmech.cli.arguments import parse_option
from flexmech.cli.deliver import deliver
from flexmech.cli.failures import reports_failures
from flexmech.units import LENGTH

__all__ = ["HELP", "synthesize"]

HELP = "Proportions of a crank-rocker for a wanted transmission angle, by Elamy et al. 2023."

Deviation = Annotated[
    float, typer.Option(help="Greatest deviation of the transmission angle from 90 deg, in deg.")
]
RockerAngle = Annotated[
    float, typer.Option(help="Angle of the rocker at crank angle zero, in deg.")
]
Ground = Annotated[
    str | None,
    typer.Option(
        help='Distance of the ground pivots, such as "400 mm": prints a table for a model file.',
        metavar="LENGTH",
    ),
]


@reports_failures
def synthesize(
    deviation: Deviation,
    rocker_angle: RockerAngle,
    ground: Ground = None,
    out: options.OptionalOut = None,
    no_plots: options.NoPlots = False,
) -> None:
    """Print the proportions of one crank-rocker, and what comes out when they are checked."""
    metres = None if ground is None else parse_option("--ground", ground, LENGTH)

    from flexmech.analyses.synthesis import CrankRockerSynthesis, crank_rocker_synthesis

    request = math.radians(deviation), math.radians(rocker_angle), metres
    deliver(
        CrankRockerSynthesis, lambda _: crank_rocker_synthesis(*request), out, draw=not no_plots
    )
