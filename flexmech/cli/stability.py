"""``flexmech stability``: at which crank speeds the linkage shakes itself up."""

from __future__ import annotations

from pathlib import Path

import typer

from flexmech.choices import ELEMENTS_A_LINK, KEPT_MODES
from flexmech.cli import options
from flexmech.cli.against import parse_against, parse_damping_ratio, parse_steps
from flexmech.cli.arguments import parse_speeds, speed_remark
from flexmech.cli.deliver import deliver
from flexmech.cli.engines import make_engines
from flexmech.cli.pictures import asked_pictures
from flexmech.cli.stopping import Stopped, answered_signals


def stability(
    model: options.Model,
    speeds: options.TurningSpeeds,
    engine: options.StabilityEngine = "reference",
    prestress: options.StabilityPrestress = "equilibrium",
    frame: options.Frame = "link",
    element: options.Element = None,
    elements: options.Elements = ELEMENTS_A_LINK,
    shaft: options.Shaft = "prescribed",
    modes: options.KeptModes = KEPT_MODES,
    steps: options.StepsATurn = "auto",
    damping_ratio: options.DampingRatio = None,
    against: options.Against = None,
    out: options.Out = Path("results"),
    no_plots: options.NoPlots = False,
    formats: options.Formats = "png",
    width: options.Width = "two-column",
) -> None:
    """At which crank speeds the running linkage shakes itself up: a stability map.

    Growth rates and Floquet multipliers over crank speed, and the unstable bands with the errors
    of their edges and the damping that closes them: a table, CSV and NetCDF files, and pictures.
    Ctrl-C ends the map early and keeps what is done.
    """
    given, ratio, count = (
        parse_speeds(speeds),
        parse_damping_ratio(damping_ratio),
        parse_steps(steps),
    )

    from flexmech.analyses.stability import StabilityMap
    from flexmech.analyses.stability import stability as analysis
    from flexmech.modelfile import load_mechanism

    mechanism = load_mechanism(model)
    second = parse_against(mechanism, against)
    earlier = len(answered_signals())
    found = deliver(
        StabilityMap,
        lambda progress: analysis(
            make_engines(mechanism, engine, element, elements),
            given.values,
            prestress=prestress,
            frame=frame,
            modes=modes,
            steps=count,
            damping_ratio=ratio,
            against=second,
            speed_unit=given.unit,
            shaft=shaft,
            progress=progress,
        ),
        out,
        model=model,
        pictures=asked_pictures(no_plots, formats, width),
        speed_unit=given.unit,
        remark=speed_remark("--speeds", speeds, given.values),
    )
    if found.is_interrupted:
        signals = answered_signals()[earlier:]
        raise typer.Exit((Stopped(signals[-1]) if signals else Stopped()).exit_code)
