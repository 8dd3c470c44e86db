"""``flexmech frequencies``: the moving natural frequencies of a model file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from flexmech.cli.arguments import (
    Element,
    Engine,
    Prestress,
    element_of_engines,
    parse_angles,
    parse_speeds,
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

Model = Annotated[Path, typer.Argument(help="Model file.", metavar="MODEL")]
Speeds = Annotated[
    str, typer.Option(help='Crank speeds: rad/s unless a unit is given, as in "0,10,300 rpm".')
]
Angles = Annotated[
    str, typer.Option(help="Crank angles in degrees: START:STOP:STEP, or a comma list.")
]
Modes = Annotated[int, typer.Option(min=1, help="Number of natural frequencies.")]
EngineOption = Annotated[Engine, typer.Option(help="Which engine computes.")]
ElementOption = Annotated[
    Element | None,
    typer.Option(
        help="Beam element, for the engine that has it. Left out: euler in the reference, "
        "ancf in Exudyn."
    ),
]
PrestressOption = Annotated[
    Prestress,
    typer.Option(
        help="none: elastic stiffness alone; axial: with the axial forces of the rigid motion; "
        "equilibrium: at the nonlinear quasi-static equilibrium."
    ),
]
RotationTerms = Annotated[
    bool,
    typer.Option(
        "--rotation-terms/--no-rotation-terms",
        help="Coriolis, centripetal and tangential terms of the link frames, or none of them.",
    ),
]
Elements = Annotated[int, typer.Option(min=1, help="Elements on each link.")]
Out = Annotated[Path, typer.Option(help="Folder for the files.", metavar="DIR")]
NoPlots = Annotated[bool, typer.Option("--no-plots", help="Write no pictures.")]


@reports_failures
def frequencies(
    model: Model,
    speeds: Speeds = "0,10,20",
    angles: Angles = "0:360:5",
    modes: Modes = 4,
    engine: EngineOption = Engine.both,
    element: ElementOption = None,
    prestress: PrestressOption = Prestress.equilibrium,
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
    check_writable(out, (*TABLES, *PICTURES))

    from flexmech.analyses import moving_frequencies

    with progress_bar() as progress:
        result = moving_frequencies(
            _engines(mechanism, chosen, elements),
            np.radians(crank_angles),
            np.array(crank_speeds),
            modes=modes,
            prestress=prestress.value,
            rotation_terms=rotation_terms,
            speed_effect=not no_plots and prestress is not Prestress.none and any(crank_speeds),
            progress=progress,
        )
    files = result.save(out)
    if not no_plots:
        files = [*files, *write_pictures(result.dataset, out)]
    _report(result, mechanism, out, files)


def _engines(mechanism: Mechanism, chosen: dict[Engine, Element], elements: int) -> list[Any]:
    """Make the engines chosen, each with its element."""
    engines: list[Any] = []
    if Engine.reference in chosen:
        from flexmech.reference import ReferenceEngine

        element = chosen[Engine.reference]
        engines.append(ReferenceEngine(mechanism, elements=elements, element=element.value))
    if Engine.exudyn in chosen:
        from flexmech.multibody import ExudynEngine

        element = chosen[Engine.exudyn]
        engines.append(ExudynEngine(mechanism, elements=elements, element=element.value))
    return engines


def _report(result: MovingFrequencies, mechanism: Mechanism, out: Path, files: list[Path]) -> None:
    """Print the table and the lines below it; the last one compares the engines."""
    from flexmech.cli.pictures import PICTURES
    from flexmech.cli.report import (
        agreement_line,
        error_lines,
        frequency_table,
        print_table,
        tracking_lines,
    )

    print_table(
        frequency_table(result.extremes(), f"natural frequencies, {mechanism.provenance.name}")
    )
    for line in (*error_lines(result.dataset), *tracking_lines(result.dataset)):
        typer.echo(line)
    typer.echo("files: " + ", ".join(str(file) for file in files))
    written = {file.name for file in files}
    stale = [name for name in PICTURES if name not in written and (out / name).exists()]
    if stale:
        typer.echo(f"from an earlier run, not of this one: {', '.join(stale)}")
    typer.echo(agreement_line(result))
