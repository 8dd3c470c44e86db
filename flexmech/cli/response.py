"""``flexmech response``: the linkage of a model file running."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from flexmech.choices import MODES, Integrator, Prestress, Start
from flexmech.cli import options
from flexmech.cli.arguments import (
    AUTO,
    parse_revolutions,
    parse_run_up,
    parse_speed,
    parse_step,
)
from flexmech.cli.deliver import deliver
from flexmech.cli.engines import element_by_engine, make_engines
from flexmech.cli.environment import parse_environment
from flexmech.cli.failures import reports_failures
from flexmech.errors import InputError

if TYPE_CHECKING:
    from flexmech.analyses import Response, ResponseRequest
    from flexmech.types import LabelledProgress

__all__ = ["HELP", "response"]

HELP = (
    "The running mechanism in time. Deflections, strains, driving torque and joint forces at "
    "constant crank speed: a table, CSV and NetCDF files, pictures and an animation; dry, or in "
    "heat and moisture."
)
Speed = Annotated[
    str,
    typer.Option(
        help='Crank speed: rad/s unless a unit is given, as in "300 rpm". Negative turns backwards.'
    ),
]
Revolutions = Annotated[
    str, typer.Option(help="Turns at that speed; may be a fraction.", metavar="NUMBER")
]
StartOption = Annotated[
    Start,
    typer.Option(
        help="rigid: undeformed links at the rigid motion's velocities; equilibrium: links bent "
        "quasi-statically by the loads; periodic: on the periodic motion of the linear equations."
    ),
]
Step = Annotated[
    str,
    typer.Option(
        help='Time step: s unless a unit is given, as in "0.1 ms"; auto: halved until '
        "deflections hold still.",
        metavar="auto|SECONDS",
    ),
]
Samples = Annotated[int, typer.Option(min=8, help="Samples saved of each turn.")]
PrestressOption = Annotated[
    Prestress,
    typer.Option(
        help="Of the reference engine's linear equations and of the frequencies drawn into the "
        "spectrogram: as in frequencies."
    ),
]
IntegratorOption = Annotated[
    Integrator,
    typer.Option(help="Time integration in Exudyn; the reference engine's is trapezoidal."),
]
RunUp = Annotated[
    str,
    typer.Option(
        help="Duration of a smooth (cycloidal) run-up to the speed, before the turns: s unless a "
        "unit is given.",
        metavar="SECONDS",
    ),
]
CheckMesh = Annotated[
    bool, typer.Option("--check-mesh", help="Repeat with twice the elements and compare.")
]
Modes = Annotated[
    int,
    typer.Option(
        min=1, help="Natural frequencies of interest: set the time step and the spectra's range."
    ),
]
Animate = Annotated[
    bool, typer.Option("--animate", help="Write an animation: GIF, and MP4 where ffmpeg exists.")
]


@reports_failures
def response(
    model: options.Model,
    speed: Speed,
    revolutions: Revolutions = "4",
    engine: options.Engine = "both",
    element: options.Element = None,
    elements: options.Elements = 8,
    start: StartOption = "rigid",
    step: Step = AUTO,
    samples: Samples = 720,
    prestress: PrestressOption = "equilibrium",
    integrator: IntegratorOption = "trapezoidal",
    run_up: RunUp = "0",
    check_mesh: CheckMesh = False,
    modes: Modes = MODES,
    temperature_rise: options.TemperatureRise = None,
    moisture: options.Moisture = None,
    relative_humidity: options.RelativeHumidity = None,
    time: options.ExposureTime = None,
    out: options.Out = Path("results"),
    no_plots: options.NoPlots = False,
    animate: Animate = False,
) -> None:
    """Run the mechanism of a model file; save, draw and report its response."""
    crank_speed, unit = parse_speed(speed)
    asked = {"revolutions": parse_revolutions(revolutions), "samples": samples, "start": start}
    run_up_time, time_step = parse_run_up(run_up), parse_step(step)
    chosen = element_by_engine(engine, element)
    environment = parse_environment(temperature_rise, moisture, relative_humidity, time)
    if start == "periodic" and run_up_time:
        raise InputError(
            "--start periodic needs a constant crank speed; leave --run-up out, or choose "
            "--start rigid or equilibrium"
        )

    from flexmech.analyses import Response
    from flexmech.analyses import response as compute
    from flexmech.linkages import CrankDrive
    from flexmech.modelfile import load_mechanism

    mechanism = load_mechanism(model)
    request = _request(
        CrankDrive(crank_speed, run_up_time),
        time_step,
        **asked,
        modes=modes,
        integrator=integrator,
        prestress=prestress,
        speed_unit=unit,
    )

    def animations(result: Response, progress: LabelledProgress | None) -> list[Path]:
        files = result.save_animations(out, progress) if animate else []
        if len(files) == 1:
            typer.echo("animation: a GIF alone, for MP4 needs ffmpeg; install it and run again")
        return files

    deliver(
        Response,
        lambda progress: compute(
            make_engines(mechanism, chosen, elements),
            request,
            check_mesh=check_mesh,
            environment=environment,
            progress=progress,
        ),
        out,
        draw=not no_plots,
        speed_unit=unit,
        further=animations,
    )


def _request(drive: Any, step: float | None, **asked: Any) -> ResponseRequest:
    """What is asked for; where that is refused, the message names the options."""
    from flexmech.analyses import ResponseRequest

    try:
        request = ResponseRequest(drive, **asked)
    except InputError as error:
        raise error.within("--revolutions, --samples, --run-up") from error
    try:
        return replace(request, step=step)
    except InputError as error:
        raise error.within("--step") from error
