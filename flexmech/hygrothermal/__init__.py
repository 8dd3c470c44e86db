"""Mechanisms in heat and water: from an environment to the mechanism as it is there."""

from flexmech.hygrothermal.environment import (
    Environment,
    Exposure,
    HygrothermalState,
    environment_of,
)
from flexmech.hygrothermal.in_state import (
    coupler_point_in_state,
    elongation_of,
    linkage_in_state,
    links_of_unknown_stiffness,
    mechanism_in_state,
    rigid_linkage_in_state,
    swollen_links,
    without_softening,
)
from flexmech.hygrothermal.link_moisture import (
    LinkDiffusion,
    absorbing_links,
    inert_links,
    link_diffusion,
    link_profile,
    resin_retention,
)

__all__ = [
    "Environment",
    "Exposure",
    "HygrothermalState",
    "LinkDiffusion",
    "absorbing_links",
    "coupler_point_in_state",
    "elongation_of",
    "environment_of",
    "inert_links",
    "link_diffusion",
    "link_profile",
    "linkage_in_state",
    "links_of_unknown_stiffness",
    "mechanism_in_state",
    "resin_retention",
    "rigid_linkage_in_state",
    "swollen_links",
    "without_softening",
]
