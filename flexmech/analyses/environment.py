"""What heat and moisture make of each link, in words that every result can carry."""

from __future__ import annotations

from flexmech.hygrothermal import (
    Environment,
    SwollenLink,
    resin_retention,
    silent_links,
    swollen_links,
)
from flexmech.mechanism import Mechanism

__all__ = ["environment_lines"]


def environment_lines(mechanism: Mechanism, environment: Environment | None) -> list[str]:
    """What heat and moisture make of each link.

    Parameters
    ----------
    mechanism : Mechanism
        Dry, at its reference temperature.
    environment : HygrothermalState or Exposure, optional
        None where none was asked for: then there is nothing to say.

    Returns
    -------
    list of str
        A result keeps them in its dataset as the attribute ``environment_lines``, one text
        with a line for each.

    Raises
    ------
    InputError
        As :func:`flexmech.hygrothermal.swollen_links`.
    """
    if environment is None:
        return []
    lines = [f"state: {environment.label}"]
    for name, link in swollen_links(mechanism, environment).items():
        lines.append(_link_line(mechanism, name, link) + _kept(mechanism, name, environment))
        if link.section.free_curvature:
            sagitta = abs(link.section.free_curvature) * link.length**2 / 8
            lines[-1] += f", bent by itself {1e3 * sagitta:.4g} mm at its middle"
    unchanged = silent_links(mechanism)
    if unchanged:
        lines.append(f"heat and moisture do nothing to: {', '.join(unchanged)} (no such keys)")
    return lines


def _link_line(mechanism: Mechanism, name: str, link: SwollenLink) -> str:
    dry = mechanism.sections[name]
    stiffness = link.section.bending_stiffness / dry.bending_stiffness
    mass = link.section.mass_per_length / dry.mass_per_length
    return (
        f"{name}: {100 * link.elongation:+.4f} % longer, {100 * link.water:.3g} % water, "
        f"bending stiffness times {stiffness:.4f}, mass per length times {mass:.4f}"
    )


def _kept(mechanism: Mechanism, name: str, environment: Environment) -> str:
    """What the resin keeps of its dry stiffness and strength; nothing where that is not known."""
    kept = resin_retention(mechanism, name, environment)
    if kept is None:
        return ""
    least, most = (f"{100 * part:.4g}" for part in kept)
    share = least if least == most else f"{least} to {most}"
    return f", resin keeps {share} % of its stiffness and strength"
