"""Remarks of a result on its conditions: heat and moisture, and loads that it leaves out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, SupportsFloat

import xarray as xr

from flexmech.analyses.beam_theory import theory_warnings
from flexmech.analyses.requests import environment_of
from flexmech.hygrothermal import Environment, inert_links, resin_retention, swollen_links
from flexmech.mechanism import Mechanism
from flexmech.plots.reading import speed_unit
from flexmech.units import from_si


def state_name(environment: Environment) -> str:
    """What a result calls the state in an environment beside ``"dry"``."""
    # An environment without heat and moisture is labelled dry too.
    return "wet" if environment.label == "dry" else environment.label


def environment_lines(
    mechanism: Mechanism, environment: Environment | None, *, lengths_alone: bool = False
) -> list[str]:
    """What heat and moisture make of each link.

    Parameters
    ----------
    mechanism : Mechanism
        Dry, at its reference temperature.
    environment : HygrothermalState or Exposure, optional
        None where none was asked for: then there is nothing to say.
    lengths_alone : bool
        Whether to leave out how stiff and heavy the links are then.

    Returns
    -------
    list of str
        A result keeps them in its dataset as the attribute ``environment_lines``, one text
        with a line for each.

    Raises
    ------
    InputError
        If it is no environment, or as :func:`flexmech.hygrothermal.swollen_links`.
    """
    if environment is None:
        return []
    lines = [f"state: {environment_of(environment).label}"]
    for name, link in swollen_links(mechanism, environment).items():
        if lengths_alone:
            lines.append(
                f"{name}: {100 * link.elongation:+.4f} % longer, {100 * link.water:.3g} % water"
            )
            continue
        dry, kept = mechanism.sections[name], resin_retention(mechanism, name, environment)
        stiffness = link.section.bending_stiffness / dry.bending_stiffness
        mass = link.section.mass_per_length / dry.mass_per_length
        line = (
            f"{name}: {100 * link.elongation:+.4f} % longer, {100 * link.water:.3g} % water, "
            f"bending stiffness times {stiffness:.4f}, mass per length times {mass:.4f}"
        )
        if kept is not None:
            # Least and most of it, where the link is not equally moist.
            share = " to ".join(dict.fromkeys(f"{100 * part:.4g}" for part in kept))
            line += f", resin keeps {share} % of its stiffness"
        if link.section.free_curvature:
            sagitta = abs(link.section.free_curvature) * link.length**2 / 8
            line += f", bent by itself {1e3 * sagitta:.4g} mm at its middle"
        lines.append(line)
    inert = inert_links(mechanism)
    if inert:
        lines.append(f"heat and moisture do nothing to: {', '.join(inert)} (no such keys)")
    return lines


LEFT_OUT = "loads_left_out"


def left_out_attributes(mechanism: Mechanism) -> dict[str, str]:
    """Attribute that names the loads over time; nothing where there are none.

    Parameters
    ----------
    mechanism : Mechanism

    Returns
    -------
    dict of str to str
    """
    names = [load.name for load in mechanism.loads if load.over == "time"]
    return {LEFT_OUT: ", ".join(names)} if names else {}


def left_out_warnings(attributes: Mapping[Any, Any]) -> tuple[str, ...]:
    """Warning that loads are left out, one line or none."""
    if LEFT_OUT not in attributes:
        return ()
    return (
        f"loads over time are left out here: {attributes[LEFT_OUT]}; they have no value at a crank "
        "angle, and flexmech response counts them",
    )


CHOSEN_DAMPING = "chosen_damping"


def warnings_of(attributes: Mapping[Any, Any]) -> tuple[str, ...]:
    """Warnings of a result on what it leaves out and on what was chosen for it.

    Loads over time, the frequency at which specific damping counts, and what beam theories do.
    """
    chosen = str(attributes.get(CHOSEN_DAMPING, "")).splitlines()
    return (*left_out_warnings(attributes), *chosen, *theory_warnings(attributes))


def speed_text(speed: SupportsFloat, unit: str) -> str:
    """A crank speed in rad/s, in a unit to six digits."""
    return f"{from_si(float(speed), unit):.6g}"


def speed_with_unit(dataset: xr.Dataset, speed: SupportsFloat) -> str:
    """A crank speed in rad/s, to five digits in the unit in which a result speaks of speeds."""
    unit = speed_unit(dataset)
    return f"{from_si(float(speed), unit):.5g} {unit}"


def crank_speed_text(attributes: Mapping[Any, Any]) -> str:
    """Crank speed of a result, in the unit in which it speaks of speeds."""
    unit = str(attributes["speed_unit"])
    return f"{speed_text(attributes['crank_speed'], unit)} {unit}"


def drive_words(attributes: Mapping[Any, Any]) -> str:
    """At which crank speed a result is, or under which law of motion."""
    law = attributes.get("drive")
    return f"at {crank_speed_text(attributes)}" if law is None else f"under {law}"
