"""``flexmech section``: the cross-sections of a model file's links."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flexmech.cli.arguments import Model, NoPlots
from flexmech.cli.failures import reports_failures
from flexmech.cli.surroundings import (
    ExposureTime,
    Moisture,
    RelativeHumidity,
    TemperatureRise,
    in_state,
    parse_state,
)
from flexmech.errors import InputError
from flexmech.files import check_writable, moved_into

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexmech.mechanism import Mechanism
    from flexmech.sections import BeamSection

__all__ = ["HELP", "section"]

HELP = (
    "Cross-sections of the links. Stiffness, coupling, mass and damping; strain and stress "
    "through the thickness under unit loads; dry, or in heat and moisture."
)
TABLES = ("sections.csv", "through_thickness.csv")

OutOption = Annotated[
    Path | None,
    typer.Option(
        "--out", help="Folder for CSV files and pictures; none if left out.", metavar="DIR"
    ),
]
LinkOption = Annotated[
    str | None, typer.Option("--link", help="This link alone, such as coupler.", metavar="NAME")
]


@reports_failures
def section(
    model: Model,
    out: OutOption = None,
    no_plots: NoPlots = False,
    link: LinkOption = None,
    temperature_rise: TemperatureRise = None,
    moisture: Moisture = None,
    relative_humidity: RelativeHumidity = None,
    time: ExposureTime = None,
) -> None:
    """Print each link's section, and write tables and pictures of what is inside it."""
    state = parse_state(temperature_rise, moisture, relative_humidity, time)

    from flexmech.cli.pictures import file_lines
    from flexmech.cli.state_report import link_lines
    from flexmech.modelfile import load_mechanism

    dry = load_mechanism(model)
    mechanism = in_state(dry, state)
    sections = _chosen(mechanism, link)
    pictures = {name: f"section_{name}.png" for name in mechanism.sections}
    files: list[Path] = []
    if out is not None:
        check_writable(out, (*TABLES, *pictures.values()))
        files = _write(sections, out, {} if no_plots else pictures)
    _report(sections)
    for line in link_lines(dry, state):
        typer.echo(line)
    if out is not None:
        for line in file_lines(out, files, (*TABLES, *pictures.values())):
            typer.echo(line)


def _chosen(mechanism: Mechanism, link: str | None) -> dict[str, BeamSection]:
    """Sections of all links in the order of the linkage, or of one."""
    from flexmech.modelfile.table import suggestion

    names = list(mechanism.linkage.topology.link_names)
    if link is not None and link not in names:
        raise InputError(f"--link: the linkage has no link {link!r}; {suggestion(link, names)}")
    return {name: mechanism.sections[name] for name in ([link] if link else names)}


def _write(sections: Mapping[str, BeamSection], out: Path, pictures: dict[str, str]) -> list[Path]:
    """Write tables and pictures, all or none."""
    from flexmech.cli.pictures import DOTS_PER_INCH, without_windows
    from flexmech.cli.section_data import profile_frame, section_frame, unit_load_profile

    profiles = {
        name: unit_load_profile(name, section, section.layers)
        for name, section in sections.items()
        if section.layers is not None
    }
    tables = {TABLES[0]: section_frame(sections)}
    if profiles:
        tables[TABLES[1]] = profile_frame(profiles.values())
    drawn = {pictures[name]: profile for name, profile in profiles.items() if name in pictures}
    with moved_into(out) as temporary:
        for name, table in tables.items():
            table.to_csv(temporary / name, index=False, float_format="%.10g")
        if drawn:
            without_windows()
            from flexmech import plots

            for name, profile in drawn.items():
                plots.plot_section(profile).savefig(temporary / name, dpi=DOTS_PER_INCH)
    return [out / name for name in (*tables, *drawn)]


def _report(sections: Mapping[str, BeamSection]) -> None:
    from flexmech.cli.report import print_table
    from flexmech.cli.section_report import (
        layer_tables,
        load_line,
        section_table,
        without_layers_lines,
    )

    for name, section in sections.items():
        print_table(section_table(name, section))
        for table in layer_tables(name, section, section.layers) if section.layers else ():
            print_table(table)
    lines = [line for name, s in sections.items() for line in without_layers_lines(name, s)]
    if any(section.layers for section in sections.values()):
        lines.insert(0, load_line())
    for line in lines:
        typer.echo(line)
