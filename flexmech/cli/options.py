"""Options that several commands share, with the library's own words as choices."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from flexmech.choices import ElementName, EngineChoice

__all__ = [
    "Angles",
    "Element",
    "Elements",
    "Engine",
    "ExposureTime",
    "Link",
    "Model",
    "Modes",
    "Moisture",
    "NoPlots",
    "OptionalOut",
    "Out",
    "RelativeHumidity",
    "RequiredExposureTime",
    "TemperatureRise",
]

Model = Annotated[Path, typer.Argument(help="Model file.", metavar="MODEL")]
Out = Annotated[Path, typer.Option(help="Folder for the files.", metavar="DIR")]
OptionalOut = Annotated[
    Path | None,
    typer.Option(help="Folder for CSV files and pictures; none if left out.", metavar="DIR"),
]
NoPlots = Annotated[bool, typer.Option("--no-plots", help="Write no pictures.")]
Angles = Annotated[
    str, typer.Option(help="Crank angles in degrees: START:STOP:STEP, or a comma list.")
]
Modes = Annotated[int, typer.Option(min=1, help="Number of natural frequencies.")]
Link = Annotated[str | None, typer.Option(help="This link alone, such as coupler.", metavar="NAME")]

Engine = Annotated[EngineChoice, typer.Option(help="Which engine computes.")]
Element = Annotated[
    ElementName | None,
    typer.Option(
        help="Beam element: euler, timoshenko or reddy in the reference, ancf or "
        "geometrically-exact in Exudyn; the other engine takes its element of the same theory. "
        "Left out: euler and ancf, or timoshenko and geometrically-exact where a link's neutral "
        "axis is off its pins."
    ),
]
Elements = Annotated[int, typer.Option(min=1, help="Elements on each link.")]

TemperatureRise = Annotated[
    str | None,
    typer.Option(
        help="Temperature over the model's reference temperature: degrees Celsius unless a unit "
        "is given.",
        metavar="C",
    ),
]
Moisture = Annotated[
    str | None,
    typer.Option(
        help="Moisture of every resin: mass of water over its dry mass, in percent.",
        metavar="PERCENT",
    ),
]
RelativeHumidity = Annotated[
    str | None,
    typer.Option(
        help="Instead of --moisture: humidity of the surrounding air in percent, with --time.",
        metavar="PERCENT",
    ),
]
_TIME = typer.Option(
    *("--time", "--exposure-time"),
    help='Time of exposure since the links were dry, such as "30 day".',
    metavar="T",
)
ExposureTime = Annotated[str | None, _TIME]
RequiredExposureTime = Annotated[str, _TIME]
