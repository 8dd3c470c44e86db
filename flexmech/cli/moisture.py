"""``flexmech moisture``: how water gets into the links of a mechanism."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from flexmech.cli import options
from flexmech.cli.deliver import deliver
from flexmech.cli.environment import parse_percent, parse_temperature, parse_time
from flexmech.cli.failures import reports_failures

__all__ = ["HELP", "moisture"]

HELP = "Moisture profiles and uptake of the links in air of constant humidity, by diffusion."

Humidity = Annotated[str, typer.Option(help="Humidity of the air in percent.", metavar="PERCENT")]
Temperature = Annotated[
    str | None,
    typer.Option(
        help="Temperature of air and links: degrees Celsius unless a unit is given. Left out: the "
        "model's reference temperature.",
        metavar="C",
    ),
]


@reports_failures
def moisture(
    model: options.Model,
    relative_humidity: Humidity,
    time: options.RequiredExposureTime,
    temperature: Temperature = None,
    link: options.Link = None,
    out: options.Out = Path("results"),
    no_plots: options.NoPlots = False,
) -> None:
    """Compute, save, draw and report the moisture of the links over a time of exposure."""
    humidity = parse_percent("--relative-humidity", relative_humidity)
    seconds = parse_time(time)
    kelvin = None if temperature is None else parse_temperature(temperature)

    from flexmech.analyses.moisture import MoistureUptake, moisture_uptake
    from flexmech.modelfile import load_mechanism

    request = load_mechanism(model), humidity, seconds, kelvin, link
    deliver(MoistureUptake, lambda _: moisture_uptake(*request), out, draw=not no_plots)
