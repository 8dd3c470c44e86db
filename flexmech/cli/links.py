"""Commands on a model file and its links: what it says, their sections, and the water in them."""

from __future__ import annotations

import math
from typing import Annotated

from flexmech.cli import options, typed
from flexmech.cli.deliver import deliver


def check(
    model: options.Model,
    angle: Annotated[float | None, typed.POSTURE_ANGLE] = None,
    *,
    output: options.AskedOptionalOutput,
) -> None:
    """Print what was understood of a model file, and remark on what is unusual in it.

    With the first natural frequencies at rest, and a picture: posture, paths, sections to scale
    and transmission angle.

    Options
    -------
    angle : DEG
        Crank angle of the picture and the natural frequencies in degrees. Left out: frequencies
        at 0, and a picture in which the links stand apart.
    """
    from flexmech.analyses import ModelCheck, check_mechanism
    from flexmech.modelfile import load_mechanism
    from flexmech.reference import ReferenceEngine

    engine = ReferenceEngine(load_mechanism(model))
    radians = None if angle is None else math.radians(angle)
    deliver(ModelCheck, lambda _: check_mechanism(engine, radians), output, model=model)


def section(
    model: options.Model,
    link: options.Link = None,
    *,
    environment: options.AskedEnvironment,
    output: options.AskedOptionalOutput,
) -> None:
    """Cross-sections of the links.

    Stiffness, coupling, mass and damping; strain and stress through the thickness under unit
    loads; dry, or in heat and moisture.
    """
    from flexmech.analyses import SectionProfiles, section_profiles
    from flexmech.modelfile import load_mechanism

    mechanism = load_mechanism(model)
    deliver(
        SectionProfiles,
        lambda _: section_profiles(mechanism, link, environment=environment),
        output,
        model=model,
    )


def moisture(
    model: options.Model,
    relative_humidity: Annotated[float, typed.RELATIVE_HUMIDITY],
    time: options.ExposureTime,
    temperature: Annotated[float | None, typed.TEMPERATURE] = None,
    link: options.Link = None,
    *,
    output: options.AskedOutput,
) -> None:
    """Moisture profiles and uptake of the links in air of constant humidity, by diffusion.

    Options
    -------
    relative_humidity : PERCENT
        Humidity of the air in percent.
    time : T
        Time of exposure since the links were dry, such as "30 day".
    temperature : C
        Temperature of air and links: degrees Celsius unless a unit is given. Left out: the model's
        reference temperature.
    """
    from flexmech.analyses import MoistureUptake, moisture_uptake
    from flexmech.modelfile import load_mechanism

    request = load_mechanism(model), relative_humidity, time, temperature, link
    deliver(MoistureUptake, lambda _: moisture_uptake(*request), output, model=model)
