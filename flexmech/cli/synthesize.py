"""``flexmech synthesize``: link proportions for a wanted transmission angle."""

from __future__ import annotations

import math

from flexmech.cli import options
from flexmech.cli.arguments import parse_option
from flexmech.cli.deliver import deliver
from flexmech.cli.pictures import asked_pictures
from flexmech.units import LENGTH


def synthesize(
    deviation: options.Deviation,
    rocker_angle: options.RockerAngle,
    ground: options.Ground = None,
    out: options.OptionalOut = None,
    no_plots: options.NoPlots = False,
    formats: options.Formats = "png",
    width: options.Width = "two-column",
) -> None:
    """Proportions of a crank-rocker for a wanted transmission angle, by Elamy et al. 2023."""
    metres = None if ground is None else parse_option("--ground", ground, LENGTH)

    from flexmech.analyses.synthesis import CrankRockerSynthesis, crank_rocker_synthesis

    request = math.radians(deviation), math.radians(rocker_angle), metres
    deliver(
        CrankRockerSynthesis,
        lambda _: crank_rocker_synthesis(*request),
        out,
        pictures=asked_pictures(no_plots, formats, width),
    )
