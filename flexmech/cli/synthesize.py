"""``flexmech synthesize``: link proportions for a wanted transmission angle."""

from __future__ import annotations

import math

from flexmech.cli import options
from flexmech.cli.arguments import parse_option
from flexmech.cli.deliver import deliver
from flexmech.cli.failures import naming
from flexmech.cli.pictures import asked_pictures
from flexmech.errors import InputError
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
    if not 0 < deviation < 90:
        raise InputError(
            f"--deviation: must lie between 0 and 90 deg (both excluded), got {deviation:g} deg"
        )
    metres = None if ground is None else parse_option("--ground", ground, LENGTH)
    if metres is not None and metres <= 0:
        raise InputError(f"--ground: must be positive, got {ground!r}")

    from flexmech.analyses.synthesis import CrankRockerSynthesis, crank_rocker_synthesis

    def compute(_: object) -> CrankRockerSynthesis:
        with naming("--rocker-angle"):
            return crank_rocker_synthesis(
                math.radians(deviation), math.radians(rocker_angle), metres
            )

    deliver(
        CrankRockerSynthesis,
        compute,
        out,
        pictures=asked_pictures(no_plots, formats, width),
    )
