"""``flexmech synthesize``: link proportions for a wanted transmission angle."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flexmech.cli.failures import reports_failures
from flexmech.files import check_writable, moved_into
from flexmech.units import LENGTH, parse_quantity

if TYPE_CHECKING:
    from flexmech.linkages import CrankRockerProportions, FourBar

__all__ = ["HELP", "synthesize"]

HELP = "Find the proportions of a crank-rocker for a wanted transmission angle."
TABLE, PICTURE = "transmission_angle.csv", "transmission_angle.png"


@reports_failures
def synthesize(
    deviation: Annotated[
        float, typer.Option(help="Greatest deviation of the transmission angle from 90 deg.")
    ],
    rocker_angle: Annotated[
        float, typer.Option(help="Angle of the rocker at crank angle zero, in deg.")
    ],
    ground: Annotated[
        str, typer.Option(help="Distance of the ground pivots, for lengths.", metavar="LENGTH")
    ] = "",
    out: Annotated[
        Path | None, typer.Option(help="Folder for the transmission angle over a turn.")
    ] = None,
    no_plots: Annotated[bool, typer.Option("--no-plots", help="Draw no picture.")] = False,
) -> None:
    """Print the proportions of one crank-rocker, and what comes out when they are checked."""
    import numpy as np

    from flexmech.linkages import synthesize_crank_rocker

    length = parse_quantity(ground, LENGTH) if ground else None
    found = synthesize_crank_rocker(np.radians(deviation), np.radians(rocker_angle))
    linkage = found.linkage(length or 1.0)
    files = () if out is None else ((TABLE,) if no_plots else (TABLE, PICTURE))
    if out is not None:
        check_writable(out, files)
    for line in _lines(found, linkage, length):
        typer.echo(line)
    if out is not None:
        _write(linkage, out, draw=not no_plots)
        typer.echo(f"files: {', '.join(str(out / name) for name in files)}")


def _lines(found: CrankRockerProportions, linkage: FourBar, length: float | None) -> list[str]:
    import numpy as np

    from flexmech.linkages import rocker_swing

    ratios = (float(found.crank), float(found.coupler), float(found.rocker))
    least, greatest = np.degrees(linkage.transmission_angle_limits())
    rocker = float(np.degrees(linkage.motion(np.array([0.0])).angle[0, 2]))
    lines = [
        "crank {:.4f}, coupler {:.4f}, rocker {:.4f} of the ground".format(*ratios),
        f"check: transmission angle {least:.6g} to {greatest:.6g} deg, rocker at {rocker:.6g} deg "
        "at crank angle 0",
        f"Grashof class: {linkage.grashof_class}; the rocker swings through "
        f"{np.degrees(rocker_swing(linkage)):.5g} deg",
    ]
    if length is not None:
        lines += ["", "[linkage]", 'kind = "four-bar"']
        lines += [f'{name} = "{size * 1e3:.6g} mm"' for name, size in linkage.lengths.items()]
    return lines


def _write(linkage: FourBar, out: Path, *, draw: bool) -> None:
    import numpy as np

    degrees = np.arange(361.0)
    angle = linkage.transmission_angle(np.radians(degrees))
    with moved_into(out) as folder:
        with (folder / TABLE).open("w", encoding="utf-8", newline="") as stream:
            table = csv.writer(stream, lineterminator="\n")
            table.writerow(["crank_angle_deg", "transmission_angle_deg"])
            table.writerows(np.stack([degrees, np.degrees(angle)], axis=1).tolist())
        if draw:
            from flexmech.plots import plot_transmission_angle

            limits = linkage.transmission_angle_limits()
            named = "this linkage, with the range asked for in grey"
            figure = plot_transmission_angle(np.radians(degrees), {named: angle}, limits)
            figure.savefig(folder / PICTURE)
