"""``flexmech synthesize``: link proportions for a wanted transmission angle."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flexmech.cli.arguments import NoPlots
from flexmech.cli.failures import reports_failures
from flexmech.errors import InputError
from flexmech.files import check_writable, moved_into, write_table
from flexmech.units import LENGTH, parse_quantity

if TYPE_CHECKING:
    from flexmech.linkages import CrankRockerProportions, FourBar

__all__ = ["HELP", "synthesize"]

HELP = (
    "Find the proportions of a crank-rocker for a wanted transmission angle. Within 90 deg plus "
    "or minus a deviation, by the equations of Elamy et al. 2023."
)
TABLE, PICTURE = "transmission_angle.csv", "transmission_angle.png"


@reports_failures
def synthesize(
    deviation: Annotated[
        float,
        typer.Option(help="Greatest deviation of the transmission angle from 90 deg, in deg."),
    ],
    rocker_angle: Annotated[
        float, typer.Option(help="Angle of the rocker at crank angle zero, in deg.")
    ],
    ground: Annotated[
        str | None,
        typer.Option(
            help='Distance of the ground pivots, such as "400 mm": prints the lengths as a table '
            "for a model file.",
            metavar="LENGTH",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(help="Folder for the transmission angle over a turn.", metavar="DIR"),
    ] = None,
    no_plots: NoPlots = False,
) -> None:
    """Print the proportions of one crank-rocker, and what comes out when they are checked."""
    length = None if ground is None else _ground_length(ground)

    import numpy as np

    from flexmech.cli.pictures import file_lines
    from flexmech.linkages import synthesize_crank_rocker

    found = synthesize_crank_rocker(np.radians(deviation), np.radians(rocker_angle))
    linkage = found.linkage(1.0 if length is None else length)
    lines = _lines(found, linkage)
    if length is not None:
        lines += _model_file_table(linkage)
    if out is not None:
        check_writable(out, (TABLE, PICTURE))
        files = _write(linkage, np.radians(deviation), out, draw=not no_plots)
        lines += file_lines(out, files, (TABLE, PICTURE))
    for line in lines:
        typer.echo(line)


def _ground_length(text: str) -> float:
    try:
        length = parse_quantity(text, LENGTH)
    except InputError as error:
        raise InputError(f"--ground: {error}") from error
    if length <= 0:
        raise InputError(f"--ground: must be positive, got {text!r}")
    return length


def _lines(found: CrankRockerProportions, linkage: FourBar) -> list[str]:
    """Proportions, and what the linkage made of them has, computed back from its lengths."""
    import numpy as np

    from flexmech.linkages import rocker_swing, time_ratio, transmission_design

    design = transmission_design(linkage)
    least, greatest = np.degrees(linkage.transmission_angle_limits())
    return [
        f"crank {float(found.crank):.4f}, coupler {float(found.coupler):.4f}, rocker "
        f"{float(found.rocker):.4f} of the ground",
        f"check: transmission angle {least:.6g} to {greatest:.6g} deg, rocker at "
        f"{np.degrees(design.rocker_angle):.6g} deg at crank angle 0",
        f"Grashof class: {linkage.grashof_class}; the rocker swings through "
        f"{np.degrees(rocker_swing(linkage)):.5g} deg, time ratio {time_ratio(linkage):.4g}",
    ]


def _model_file_table(linkage: FourBar) -> list[str]:
    lengths = [f'{name} = "{size * 1e3:.6g} mm"' for name, size in linkage.lengths.items()]
    return ["", "[linkage]", 'kind = "four-bar"', *lengths, ""]


def _write(linkage: FourBar, deviation: float, out: Path, *, draw: bool) -> list[Path]:
    """Write the transmission angle at each degree of the crank, and its picture; all or none."""
    import numpy as np

    degrees = np.arange(361.0)
    angle = linkage.transmission_angle(np.radians(degrees))
    with moved_into(out) as folder:
        write_table(
            folder / TABLE,
            ("crank_angle_deg", "transmission_angle_deg"),
            ([f"{a:g}", f"{b:.10g}"] for a, b in zip(degrees, np.degrees(angle), strict=True)),
        )
        if draw:
            from flexmech.cli.pictures import DOTS_PER_INCH, without_windows

            without_windows()
            from flexmech.plots import plot_transmission_angle

            figure = plot_transmission_angle(
                np.radians(degrees),
                {"this linkage": angle},
                band=(np.pi / 2 - deviation, np.pi / 2 + deviation),
                band_label="wanted range",
            )
            figure.savefig(folder / PICTURE, dpi=DOTS_PER_INCH)
    return [out / name for name in ((TABLE, PICTURE) if draw else (TABLE,))]
