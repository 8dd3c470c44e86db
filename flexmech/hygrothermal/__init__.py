"""Mechanisms in heat and water: from surroundings to a mechanism as it is in them."""

from flexmech.hygrothermal.in_state import (
    SwollenLink,
    coupler_point_in_state,
    linkage_in_state,
    mechanism_in_state,
    swollen_links,
)
from flexmech.hygrothermal.link_diffusion import LinkDiffusion, link_diffusion
from flexmech.hygrothermal.link_moisture import (
    absorbing_links,
    link_condition,
    resin_retention,
    silent_links,
)
from flexmech.hygrothermal.state import Environment, Exposure, HygrothermalState, State

__all__ = [
    "Environment",
    "Exposure",
    "HygrothermalState",
    "LinkDiffusion",
    "State",
    "SwollenLink",
    "absorbing_links",
    "coupler_point_in_state",
    "link_condition",
    "link_diffusion",
    "linkage_in_state",
    "mechanism_in_state",
    "resin_retention",
    "silent_links",
    "swollen_links",
]
