"""``flexmech frequencies``: the moving natural frequencies of a model file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flexmech.cli.arguments import (
    Angles,
    MapPrestress,
    Model,
    NoPlots,
    Out,
    parse_angles,
    parse_speeds,
)
from flexmech.cli.engines import (
    ElementOption,
    Elements,
    Engine,
    EngineOption,
    element_of_engines,
    make_engines,
)
from flexmech.cli.failures import reports_failures
from flexmech.cli.surroundings import (
    ExposureTime,
    Moisture,
    RelativeHumidity,
    TemperatureRise,
    in_state,
    parse_state,
)
from flexmech.files import check_writable

if TYPE_CHECKING:
    from flexmech.analyses import MovingFrequencies
    from flexmech.hygrothermal import State
    from flexmech.linear_system import Engine as AnyEngine
    from flexmech.mechanism import Mechanism

__all__ = ["HELP", "frequencies"]

HELP = (
    "Moving natural frequencies of a mechanism. Over crank angle and crank speed: a table, CSV "
    "and NetCDF files, and pictures; in heat and moisture, beside those of the dry linkage."
)
TABLES = ("frequencies.csv", "frequencies.nc")
FURTHER_TABLES = ("vibration_effect.csv", "damping.csv")
STATE_FILES = ("hygrothermal_effect.csv", "hygrothermal_effect.nc", "hygrothermal_effect.png")
# Folder of the dry linkage's files, inside that of the state's.
DRY = "dry"

# Of models that do not say at which speeds they operate.
SPEEDS = "0,10,20"

Speeds = Annotated[
    str | None,
    typer.Option(
        help='Crank speeds: rad/s unless a unit is given, as in "0,10,300 rpm". Left out: '
        f"standstill and the speeds at which the model operates; {SPEEDS} if it names none.",
        metavar="LIST",
    ),
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
    speeds: Speeds = None,
    angles: Angles = "0:360:5",
    modes: Modes = 4,
    engine: EngineOption = Engine.both,
    element: ElementOption = None,
    prestress: PrestressOption = MapPrestress.equilibrium,
    rotation_terms: RotationTerms = True,
    elements: Elements = 8,
    temperature_rise: TemperatureRise = None,
    moisture: Moisture = None,
    relative_humidity: RelativeHumidity = None,
    time: ExposureTime = None,
    out: Out = Path("results"),
    no_plots: NoPlots = False,
) -> None:
    """Compute, save, draw and report the moving natural frequencies of a model file."""
    given = None if speeds is None else parse_speeds(speeds)
    crank_angles = parse_angles(angles)
    chosen = element_of_engines(engine, element)
    state = parse_state(temperature_rise, moisture, relative_humidity, time)

    import numpy as np

    from flexmech.cli.pictures import PICTURES
    from flexmech.cli.progress import progress_bar
    from flexmech.modelfile import load_mechanism

    dry = load_mechanism(model)
    crank_speeds = _operating_speeds(dry) if given is None else given
    mechanism = in_state(dry, state)
    check_writable(out, (*TABLES, *FURTHER_TABLES, *STATE_FILES, *PICTURES))
    if state is not None:
        check_writable(out / DRY, (*TABLES, *FURTHER_TABLES, *PICTURES))
    engines = make_engines(mechanism, chosen, elements)

    from flexmech.analyses import moving_frequencies

    splits_speed = not no_plots and prestress is not MapPrestress.none and any(crank_speeds)

    def computed(of: list[AnyEngine], *, bent: bool) -> MovingFrequencies:
        with progress_bar() as progress:
            return moving_frequencies(
                of,
                np.radians(crank_angles),
                np.array(crank_speeds),
                modes=modes,
                prestress=prestress.value,
                rotation_terms=rotation_terms,
                speed_effect=splits_speed and not bent,
                progress=progress,
            )

    result = computed(engines, bent=mechanism.is_free_strained)
    dry_result = None
    if state is not None:
        # The same elements in both states: only heat and moisture shall make a difference.
        same = [type(one)(dry, elements=elements, element=one.element) for one in engines]
        dry_result = computed(same, bent=False)
    files = _written(result, out, draw=not no_plots)
    lines: list[str] = []
    if state is not None and dry_result is not None:
        files += _written(dry_result, out / DRY, draw=not no_plots)
        more, lines = _compare(dry_result, result, dry, state, out, draw=not no_plots)
        files += more
        if splits_speed and mechanism.is_free_strained:
            lines.append("effect of speed: not split by term, since links bend without load")
    _report(result, mechanism, out, files, lines)


def _operating_speeds(mechanism: Mechanism) -> list[float]:
    """Standstill and the speeds at which the model operates, in rad/s, ascending."""
    named = mechanism.operating_speeds
    return sorted({0.0, *named}) if named else parse_speeds(SPEEDS)


def _written(result: MovingFrequencies, out: Path, *, draw: bool) -> list[Path]:
    from flexmech.cli.pictures import write_pictures

    files = result.save(out)
    return [*files, *write_pictures(result.dataset, out)] if draw else files


def _compare(
    dry: MovingFrequencies,
    wet: MovingFrequencies,
    mechanism: Mechanism,
    state: State,
    out: Path,
    *,
    draw: bool,
) -> tuple[list[Path], list[str]]:
    """Write and word what the state changes."""
    from flexmech.analyses import hygrothermal_effect
    from flexmech.cli.pictures import save_drawings
    from flexmech.cli.state_report import change_lines, link_lines

    effect = hygrothermal_effect(dry, wet, state.label)
    files = effect.save(out)
    if draw:
        from flexmech.plots import plot_hygrothermal_effect

        files += save_drawings({STATE_FILES[-1]: plot_hygrothermal_effect}, effect.dataset, out)
    return files, [*link_lines(mechanism, state), *change_lines(effect)]


def _report(
    result: MovingFrequencies,
    mechanism: Mechanism,
    out: Path,
    files: list[Path],
    state_lines: list[str],
) -> None:
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
        *state_lines,
        *file_lines(out, files, (*FURTHER_TABLES, *STATE_FILES, *PICTURES)),
        agreement_line(result),
    ):
        typer.echo(line)
