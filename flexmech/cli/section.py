"""``flexmech section``: the cross-sections of a model file's links."""

from __future__ import annotations

from flexmech.cli.deliver import deliver
from flexmech.cli.environment import parse_environment
from flexmech.cli.failures import reports_failures
from flexmech.cli.options import (
    ExposureTime,
    Link,
    Model,
    Moisture,
    NoPlots,
    OptionalOut,
    RelativeHumidity,
    TemperatureRise,
)

__all__ = ["HELP", "section"]

HELP = (
    "Cross-sections of the links. Stiffness, coupling, mass and damping; strain and stress "
    "through the thickness under unit loads; dry, or in heat and moisture."
)


@reports_failures
def section(
    model: Model,
    out: OptionalOut = None,
    no_plots: NoPlots = False,
    link: Link = None,
    temperature_rise: TemperatureRise = None,
    moisture: Moisture = None,
    relative_humidity: RelativeHumidity = None,
    time: ExposureTime = None,
) -> None:
    """Print each link's section, and write tables and pictures of what is inside it."""
    environment = parse_environment(temperature_rise, moisture, relative_humidity, time)

    from flexmech.analyses.section_profile import SectionProfiles, section_profiles
    from flexmech.modelfile import load_mechanism

    mechanism = load_mechanism(model)
    deliver(
        SectionProfiles,
        lambda _: section_profiles(mechanism, link, environment=environment),
        out,
        draw=not no_plots,
    )
