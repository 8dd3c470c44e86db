"""``flexmech moisture``: how water gets into the links of a mechanism."""

from __future__ import annotations

from pathlib import Path

from flexmech.cli import options
from flexmech.cli.arguments import parse_percent, parse_temperature, parse_time
from flexmech.cli.deliver import deliver
from flexmech.cli.pictures import asked_pictures


def moisture(
    model: options.Model,
    relative_humidity: options.RequiredHumidity,
    time: options.RequiredExposureTime,
    temperature: options.Temperature = None,
    link: options.Link = None,
    out: options.Out = Path("results"),
    no_plots: options.NoPlots = False,
    formats: options.Formats = "png",
    width: options.Width = "two-column",
) -> None:
    """Moisture profiles and uptake of the links in air of constant humidity, by diffusion."""
    humidity = parse_percent("--relative-humidity", relative_humidity)
    seconds = parse_time(time)
    kelvin = None if temperature is None else parse_temperature(temperature)

    from flexmech.analyses.moisture import MoistureUptake, moisture_uptake
    from flexmech.modelfile import load_mechanism

    request = load_mechanism(model), humidity, seconds, kelvin, link
    deliver(
        MoistureUptake,
        lambda _: moisture_uptake(*request),
        out,
        model=model,
        pictures=asked_pictures(no_plots, formats, width),
    )
