"""Commands on the rigid linkage: its motion, its balance, the path of a point, proportions."""

from __future__ import annotations

import math
from functools import partial
from typing import Annotated

from typer import Option

from flexmech import analyses
from flexmech.analyses import typed
from flexmech.analyses.options import KinematicsOptions
from flexmech.cli import options
from flexmech.cli.asking import question, speeds_or_own
from flexmech.cli.deliver import deliver, mechanism_of
from flexmech.errors import InputError, naming

kinematics = question("kinematics", "Kinematics", KinematicsOptions)


def balance(
    model: options.Model,
    speed: Annotated[typed.Speeds | None, typed.SPEED] = None,
    weights: Annotated[tuple[float, ...] | None, typed.WEIGHTS] = None,
    radius: Annotated[tuple[float, ...] | None, typed.RADIUS] = None,
    share: Annotated[float, typed.SHARE] = options.HALF,
    angles: options.Angles = options.EVERY_DEGREE,
    moment_point: options.MomentPoint = None,
    rigid: Annotated[bool, Option("--rigid")] = False,
    *,
    output: options.AskedOutput,
) -> None:
    """Counterweights that keep a linkage from shaking its frame, and what they cost.

    On crank and follower of a four-bar, for a full balance of the shaking force or a compromise;
    on the crank of a slider-crank. Writes the balanced model file too, as balanced.toml.

    Options
    -------
    speed : W
        Crank speed: rad/s unless a unit is given, as in "300 rpm". Left out: the model's greatest.
    weights : F,M,T
        Of shaking force, shaking moment and driving torque in a compromise, as in 1,0.5,0.5.
        Left out: full force balance of a four-bar, --share of a slider-crank.
    radius : LIST
        Distance of the counterweights from the joints about which crank and follower rotate, as in
        "40 mm,80 mm", or one for both. Left out: half of each link's length.
    share : PERCENT
        Of the reciprocating mass of a slider-crank that is balanced as if it rotated.
    rigid
        Leave out what elastic links add, which takes some seconds.
    """
    from flexmech.analyses.balance.compute import balance as analysis
    from flexmech.crank_values import GREATEST

    mechanism = mechanism_of(model)
    speed = speeds_or_own(speed, mechanism, "--speed", GREATEST)
    asked = speed.single, weights, radius, share, angles, speed.unit, moment_point
    with naming("--weights, --radius, --share"):
        run = partial(analysis, mechanism, analyses.BalanceRequest(*asked, elastic=not rigid))
    deliver(analyses.Balance, lambda bar: run(progress=bar), output, model=model, speeds=speed)


def coupler_curve(
    model: options.Model,
    environment: options.AskedEnvironment,
    point: Annotated[typed.CouplerPoint | None, typed.POINT] = None,
    link: str = "coupler",
    angles: options.Angles = options.EVERY_DEGREE,
    *,
    output: options.AskedOutput,
) -> None:
    """Path of a point of the coupler or another link, dry, and in heat and moisture.

    Of a four-bar's coupler with all crossings and cusps.

    Options
    -------
    point : e,gamma
        Distance e from A and angle gamma from A-B, as in "33 mm,320 deg"; from the first joint of
        another link. Left out: the coupler point of the model file.
    link : NAME
        Link that the point is on: the coupler, or any link of any linkage.
    """
    asked = mechanism_of(model), angles, point, environment
    deliver(
        analyses.CouplerPaths,
        lambda _: analyses.coupler_paths(*asked, link=link),
        output,
        model=model,
    )


def synthesize(
    deviation: float,
    rocker_angle: float,
    ground: Annotated[float | None, typed.GROUND] = None,
    *,
    output: options.AskedOptionalOutput,
) -> None:
    """Proportions of a crank-rocker for a wanted transmission angle, by Elamy et al. 2023.

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
