"""``flexmech frequencies``: the moving natural frequencies of a model file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flexmech.cli.arguments import MapPrestress, Model, NoPlots, Out, parse_angles, parse_speeds
from flexmech.cli.engines import (
    ElementOption,
    Elements,
    Engine,
    EngineOption,
    element_of_engines,
    make_engines,
)
from flexmech.cli.failures import reports_failures
from flexmech.files import check_writable

if TYPE_CHECKING:
    from flexmech.analyses import MovingFrequencies
    from flexmech.mechanism import Mechanism

__all__ = ["HELP", "frequencies"]

HELP = (
    "Moving natural frequencies of a mechanism. Over crank angle and crank speed: a table, CSV "
    "and NetCDF files, and pictures."
)
TABLES = ("frequencies.csv", "frequencies.nc")
FURTHER_TABLES = ("vibration_effect.csv", "damping.csv")

Speeds = Annotated[
    str, typer.Option(help='Crank speeds: rad/s unless a unit is given, as in "0,10,300 rpm".')
]
Angles = Annotated[
    str, typer.Option(help="Crank angles in degrees: START:STOP:STEP, or a comma list.")
]
Modes = Annotated[int, typer.Option(min=1, help="Number of natural frequencies.")]
PrestressOption = Annotated[
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
    model: Model,
    speeds: Speeds = "0,10,20",
    angles: Angles = "0:360:5",
    modes: Modes = 4,
    engine: EngineOption = Engine.both,
    element: ElementOption = None,
    prestress: PrestressOption = MapPrestress.equilibrium,
    rotation_terms: RotationTerms = True,
    elements: Elements = 8,
    out: Out = Path("results"),
    no_plots: NoPlots = False,
) -> None:
    """Compute, save, draw and report the moving natural frequencies of a model file."""
    crank_speeds = parse_speeds(speeds)
    crank_angles = parse_angles(angles)
    chosen = element_of_engines(engine, element)

    import numpy as np

    from flexmech.cli.pictures import PICTURES, write_pictures
    from flexmech.cli.progress import progress_bar
    from flexmech.modelfile import load_mechanism

    mechanism = load_mechanism(model)
    check_writable(out, (*TABLES, *FURTHER_TABLES, *PICTURES))

    from flexmech.analyses import moving_frequencies

    with progress_bar() as progress:
        result = moving_frequencies(
            make_engines(mechanism, chosen, elements),
            np.radians(crank_angles),
            np.array(crank_speeds),
            modes=modes,
            prestress=prestress.value,
            rotation_terms=rotation_terms,
            speed_effect=not no_plots and prestress is not MapPrestress.none and any(crank_speeds),
            progress=progress,
        )
    files = result.save(out)
    if not no_plots:
        files = [*files, *write_pictures(result.dataset, out)]
    _report(result, mechanism, out, files)


def _report(result: MovingFrequencies, mechanism: Mechanism, out: Path, files: list[Path]) -> None:
    """Print the table and the lines below it; the last one compares the engines."""
    from flexmech.cli.pictures import PICTURES, file_lines
    from flexmech.cli.report import (
        agreement_line,
        damping_lines,
        error_lines,
        frequency_table,
        print_table,
        tracking_lines,
        vibration_lines,
    )

    print_table(
        frequency_table(result.extremes(), f"natural frequencies, {mechanism.provenance.name}")
    )
    for line in (
        *error_lines(result.dataset),
        *tracking_lines(result.dataset),
        *vibration_lines(result),
        *damping_lines(result.dataset),
        *file_lines(out, files, (*FURTHER_TABLES, *PICTURES)),
        agreement_line(result),
    ):
        typer.echo(line)
