"""``flexmech check``: what a model file says, as it was understood."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flexmech.cli.failures import reports_failures
from flexmech.errors import InputError

if TYPE_CHECKING:
    from rich.table import Table

    from flexmech.mechanism import Mechanism
    from flexmech.sections import BeamSection

__all__ = ["HELP", "check"]

HELP = "Print what was understood of a model file. With the first natural frequencies at rest."
ELEMENTS = 8
MODES = 4


@reports_failures
def check(model: Annotated[Path, typer.Argument(help="Model file.", metavar="MODEL")]) -> None:
    """Print geometry, masses and sections of a model file and its frequencies at rest."""
    from flexmech.cli.report import print_table
    from flexmech.modelfile import load_mechanism

    mechanism = load_mechanism(model)
    # First the computation: what fails, fails before anything is printed.
    frequencies = _frequencies_at_rest(mechanism)
    provenance = mechanism.provenance
    typer.echo(f"{provenance.name}\nsource: {provenance.source}")
    typer.echo(f"file: {provenance.file}, SHA-256 {provenance.sha256}")
    for line in _linkage_lines(mechanism):
        typer.echo(line)
    print_table(_link_table(mechanism))
    for line in (
        *_mass_lines(mechanism),
        *_operation_lines(mechanism),
        *_hygrothermal_lines(mechanism),
        frequencies,
    ):
        typer.echo(line)


def _linkage_lines(mechanism: Mechanism) -> list[str]:
    import numpy as np

    from flexmech.linkages import FourBar, RotatingArm

    linkage = mechanism.linkage
    if isinstance(linkage, FourBar):
        lengths = ", ".join(f"{name} {_milli(size)} mm" for name, size in linkage.lengths.items())
        least, greatest = np.degrees(linkage.transmission_angle_limits())
        turns = "turns fully" if linkage.crank_turns_fully else "does not turn fully"
        return [
            f"kind: four-bar, {linkage.branch} branch",
            f"lengths: {lengths}",
            f"Grashof class: {linkage.grashof_class}; the crank {turns}",
            f"transmission angle: {least:.4g} to {greatest:.4g} deg",
        ]
    lines = [f"lengths: {name} {_milli(size)} mm" for name, size in _link_lengths(mechanism)]
    if isinstance(linkage, RotatingArm):
        lines = ["kind: rotating arm", *lines, f"hub radius: {_milli(linkage.hub_radius)} mm"]
    return lines


def _link_lengths(mechanism: Mechanism) -> list[tuple[str, float]]:
    return [(link.name, link.length) for link in mechanism.linkage.topology.links]


def _link_table(mechanism: Mechanism) -> Table:
    """Section properties, one column for each link."""
    from rich.table import Table

    links = mechanism.linkage.topology.links
    sections = [mechanism.sections[link.name] for link in links]
    table = Table(title="links")
    table.add_column("property")
    for link in links:
        table.add_column(link.name, justify="right")
    table.add_row("length (mm)", *(_milli(link.length) for link in links))
    table.add_row(
        "mass without point masses (g)",
        *(
            _milli(section.mass_per_length * link.length)
            for section, link in zip(sections, links, strict=True)
        ),
    )
    table.add_row("in-plane thickness (mm)", *(_milli(s.in_plane_thickness) for s in sections))
    for heading, values in _section_rows(sections):
        table.add_row(heading, *values)
    return table


def _section_rows(sections: Sequence[BeamSection]) -> Iterator[tuple[str, list[str]]]:
    """Headings and texts of the sections' properties; what no section has is left out."""
    for heading, name in (
        ("EA (N)", "axial_stiffness"),
        ("EI (N m^2)", "bending_stiffness"),
        ("kGA (N)", "shear_stiffness"),
        ("rho A (kg/m)", "mass_per_length"),
        ("rho I (kg m)", "rotary_inertia"),
    ):
        yield heading, [f"{getattr(section, name):.6g}" for section in sections]
    if any(section.neutral_axis for section in sections):
        yield "neutral axis y (mm)", [_milli(section.neutral_axis) for section in sections]
    if any(section.mass_axis for section in sections):
        yield "mass axis y (mm)", [_milli(section.mass_axis) for section in sections]
    names = ("axial", "bending", "shear")
    times = {name: [getattr(section.damping, name) for section in sections] for name in names}
    if times["axial"] == times["bending"] == times["shear"]:
        times = {"": times["bending"]}
    for name, values in times.items():
        yield f"damping time (s){name and f', {name}'}", [f"{value:.6g}" for value in values]
    known = [section.specific_damping for section in sections]
    for name in names if any(known) else ():
        yield (
            f"specific damping (%), {name}",
            ["not known" if loss is None else f"{100 * getattr(loss, name):.4g}" for loss in known],
        )


def _mass_lines(mechanism: Mechanism) -> list[str]:
    links = mechanism.linkage.topology.links
    total = sum(mechanism.sections[link.name].mass_per_length * link.length for link in links)
    total += sum(mechanism.joint_masses.values())
    total += sum(point.mass for point in mechanism.link_masses)
    joints = [f"{name} {_milli(mass)} g" for name, mass in mechanism.joint_masses.items()]
    points = [
        f"{point.link} {_milli(point.mass)} g at {_milli(point.position)} mm"
        for point in mechanism.link_masses
    ]
    return [
        f"joint masses: {', '.join(joints) or 'none'}",
        f"link point masses: {', '.join(points) or 'none'}",
        f"total mass: {_milli(total)} g",
    ]


def _operation_lines(mechanism: Mechanism) -> list[str]:
    import numpy as np

    x, y = mechanism.gravity
    speeds = [
        f"{speed:.6g} rad/s ({speed * 30 / np.pi:.4g} rpm)" for speed in mechanism.operating_speeds
    ]
    return [
        f"gravity: ({x:g}, {y:g}) m/s^2",
        f"operating speeds: {', '.join(speeds) or 'none stated'}",
    ]


def _hygrothermal_lines(mechanism: Mechanism) -> list[str]:
    """Coupler point, and what heat and water do to which links; none where nothing is known."""
    import numpy as np

    from flexmech.hygrothermal import absorbing_links, silent_links

    lines = []
    point = mechanism.coupler_point
    if point is not None:
        lines.append(
            f"coupler point: {_milli(point.distance)} mm from A, {np.degrees(point.angle):.6g} deg"
        )
    names = mechanism.linkage.topology.link_names
    silent = silent_links(mechanism)
    if len(silent) < len(names):
        lines.append(
            f"heat and moisture change: {', '.join(n for n in names if n not in silent)}; water "
            f"enters: {', '.join(absorbing_links(mechanism)) or 'none'}; reference temperature "
            f"{mechanism.reference_temperature - 273.15:.4g} degC"
        )
    return lines


def _frequencies_at_rest(mechanism: Mechanism) -> str:
    from flexmech.analyses import natural_frequencies
    from flexmech.reference import ReferenceEngine

    title = "natural frequencies at rest, crank angle 0 deg"
    engine = ReferenceEngine(mechanism, elements=ELEMENTS)
    try:
        found = natural_frequencies(engine, 0.0, modes=MODES)
    except InputError as error:
        # Not every linkage can stand at crank angle zero; the model file is right even so.
        return f"{title}: none ({error})"
    listed = ", ".join(f"{frequency:.4f}" for frequency in found)
    return f"{title}: {listed} Hz (reference engine, {ELEMENTS} elements a link)"


def _milli(value: float) -> str:
    """Write a length in mm or a mass in g."""
    return f"{value * 1e3:.6g}"
