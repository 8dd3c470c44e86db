"""Commands on the rigid linkage: its motion, its balance, the path of a point, proportions."""

from __future__ import annotations

import math
from typing import Annotated

from flexmech import analyses
from flexmech.analyses import typed
from flexmech.analyses.options import BalanceOptions, CouplerPathOptions, KinematicsOptions
from flexmech.cli import options
from flexmech.cli.asking import question
from flexmech.cli.deliver import deliver
from flexmech.errors import InputError, naming

kinematics = question("kinematics", "kinematics.kinematics", KinematicsOptions)
balance = question("balance", "balance.balance", BalanceOptions)
coupler_curve = question("coupler_curve", "coupler_path.coupler_paths", CouplerPathOptions)


def synthesize(
    deviation: float,
    rocker_angle: float,
    ground: Annotated[float | None, typed.GROUND] = None,
    *,
    output: options.AskedOptionalOutput,
) -> None:
    """Crank-rocker for a wanted transmission angle.

    Proportions of its links by Elamy et al. 2023.

    Options
    -------
    deviation
        Greatest deviation of the transmission angle from 90 deg, in deg.
    rocker_angle
        Angle of the rocker at crank angle zero, in deg.
    ground : LENGTH
        Distance of the ground pivots, such as "400 mm": prints a table for a model file.
    """
    if not 0 < deviation < 90:
        raise InputError(
            f"--deviation: must lie between 0 and 90 deg (both excluded), got {deviation:g} deg"
        )
    asked = math.radians(deviation), math.radians(rocker_angle), ground

    def compute(_: object) -> analyses.CrankRockerSynthesis:
        with naming("--rocker-angle"):
            return analyses.crank_rocker_synthesis(*asked)

    deliver(analyses.CrankRockerSynthesis, compute, output)
