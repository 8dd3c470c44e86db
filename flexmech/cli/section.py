"""``flexmech section``: the cross-sections of a model file's links."""

from __future__ import annotations

from flexmech.cli import options
from flexmech.cli.deliver import deliver
from flexmech.cli.environment import parse_environment
from flexmech.cli.pictures import asked_pictures


def section(
    model: options.Model,
    out: options.OptionalOut = None,
    no_plots: options.NoPlots = False,
    formats: options.Formats = "png",
    width: options.Width = "two-column",
    link: options.Link = None,
    temperature_rise: options.TemperatureRise = None,
    moisture: options.Moisture = None,
    relative_humidity: options.RelativeHumidity = None,
    time: options.ExposureTime = None,
) -> None:
    """Cross-sections of the links.

    Stiffness, coupling, mass and damping; strain and stress through the thickness under unit
    loads; dry, or in heat and moisture.
    """
    environment = parse_environment(temperature_rise, moisture, relative_humidity, time)

    from flexmech.analyses.section_profile import SectionProfiles, section_profiles
    from flexmech.modelfile import load_mechanism

    mechanism = load_mechanism(model)
    deliver(
        SectionProfiles,
        lambda _: section_profiles(mechanism, link, environment=environment),
        out,
        model=model,
        pictures=asked_pictures(no_plots, formats, width),
    )
