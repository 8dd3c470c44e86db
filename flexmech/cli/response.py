"""``flexmech response``: the linkage of a model file running."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flexmech.cli.arguments import Model, NoPlots, Out, Prestress
from flexmech.cli.engines import (
    ElementOption,
    Elements,
    Engine,
    EngineOption,
    element_of_engines,
    make_engines,
)
from flexmech.cli.failures import reports_failures
from flexmech.cli.run_arguments import (
    AUTO,
    Integrator,
    Start,
    parse_revolutions,
    parse_run_up,
    parse_speed,
    parse_step,
)
from flexmech.cli.surroundings import (
    ExposureTime,
    Moisture,
    RelativeHumidity,
    TemperatureRise,
    in_state,
    parse_state,
)
from flexmech.errors import InputError
from flexmech.files import check_writable

if TYPE_CHECKING:
    from flexmech.analyses.response import Response, ResponseRequest
    from flexmech.linkages import CrankDrive
    from flexmech.mechanism import Mechanism

__all__ = ["HELP", "response"]

HELP = (
    "The running mechanism in time. Deflections, strains, driving torque and joint forces at "
    "constant crank speed: a table, CSV and NetCDF files, pictures and an animation; dry, or in "
    "heat and moisture."
)
TABLES = ("response.csv", "response.nc")

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
    model: Model,
    speed: Speed,
    revolutions: Revolutions = "4",
    engine: EngineOption = Engine.both,
    element: ElementOption = None,
    elements: Elements = 8,
    start: StartOption = Start.rigid,
    step: Step = AUTO,
    samples: Samples = 720,
    prestress: PrestressOption = Prestress.equilibrium,
    integrator: IntegratorOption = Integrator.trapezoidal,
    run_up: RunUp = "0",
    check_mesh: CheckMesh = False,
    modes: Modes = 4,
    temperature_rise: TemperatureRise = None,
    moisture: Moisture = None,
    relative_humidity: RelativeHumidity = None,
    time: ExposureTime = None,
    out: Out = Path("results"),
    no_plots: NoPlots = False,
    animate: Animate = False,
) -> None:
    """Run the mechanism of a model file; save, draw and report its response."""
    crank_speed, turns = parse_speed(speed), parse_revolutions(revolutions)
    time_step, run_up_time = parse_step(step), parse_run_up(run_up)
    chosen = element_of_engines(engine, element)
    state = parse_state(temperature_rise, moisture, relative_humidity, time)

    from flexmech.cli.progress import progress_bar
    from flexmech.cli.response_pictures import (
        ANIMATIONS,
        PICTURES,
        write_animations,
        write_pictures,
    )
    from flexmech.cli.state_report import link_lines
    from flexmech.linkages import CrankDrive
    from flexmech.modelfile import load_mechanism

    dry = load_mechanism(model)
    mechanism = in_state(dry, state)
    request = _request(
        CrankDrive(crank_speed, run_up_time), turns, samples, modes, start, time_step
    )
    request = replace(request, integrator=integrator.value, prestress=prestress.value)
    optional = (*(() if no_plots else PICTURES), *(ANIMATIONS if animate else ()))
    check_writable(out, (*TABLES, *optional))

    from flexmech.analyses.response import response as compute

    with progress_bar() as progress:
        result = compute(
            make_engines(mechanism, chosen, elements),
            request,
            check_mesh=check_mesh,
            progress=progress,
        )
    files = result.save(out)
    if not no_plots:
        files = [*files, *write_pictures(result.dataset, out)]
    if animate:
        with progress_bar() as progress:
            files = [*files, *write_animations(result.dataset, out, progress)]
    _report(result, mechanism, out, files, link_lines(dry, state), animate=animate)


def _request(
    drive: CrankDrive,
    revolutions: float,
    samples: int,
    modes: int,
    start: Start,
    step: float | None,
) -> ResponseRequest:
    """What is asked for; where that is refused, the message names the options."""
    from flexmech.analyses.response import ResponseRequest

    if start is Start.periodic and not drive.is_constant:
        raise InputError(
            "--start periodic needs a constant crank speed; leave --run-up out, or choose "
            "--start rigid or equilibrium"
        )
    try:
        request = ResponseRequest(
            drive, revolutions=revolutions, samples=samples, start=start.value, modes=modes
        )
    except InputError as error:
        raise InputError(f"--revolutions, --samples, --run-up: {error}") from error
    try:
        return replace(request, step=step)
    except InputError as error:
        raise InputError(f"--step: {error}") from error


def _report(
    result: Response,
    mechanism: Mechanism,
    out: Path,
    files: list[Path],
    state_lines: list[str],
    *,
    animate: bool,
) -> None:
    """Print the table and the lines below it; the last one compares the engines."""
    from flexmech.cli.pictures import file_lines
    from flexmech.cli.report import print_table
    from flexmech.cli.response_pictures import ANIMATIONS, PICTURES
    from flexmech.cli.response_report import (
        agreement_line,
        check_lines,
        load_lines,
        peak_table,
        spectrogram_lines,
    )

    speed = result.dataset.attrs["crank_speed"]
    print_table(peak_table(result, f"peaks at {speed:.6g} rad/s, {mechanism.provenance.name}"))
    lines = [
        *check_lines(result.dataset),
        *load_lines(result),
        *spectrogram_lines(result.dataset),
        *state_lines,
    ]
    if animate and ANIMATIONS[-1] not in {file.name for file in files}:
        lines.append("animation: a GIF alone, for MP4 needs ffmpeg; install it and run again")
    lines += [*file_lines(out, files, (*PICTURES, *ANIMATIONS)), agreement_line(result)]
    for line in lines:
        typer.echo(line)
