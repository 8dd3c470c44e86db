"""Mechanisms in heat and water: from surroundings to a mechanism as it is in them."""

from flexmech.hygrothermal.coupler_path import CouplerPath, coupler_path
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
from flexmech.hygrothermal.state import Exposure, HygrothermalState, State
from flexmech.hygrothermal.uptake import LinkUptake, link_uptake

__all__ = [
    "CouplerPath",
    "Exposure",
    "HygrothermalState",
    "LinkDiffusion",
    "LinkUptake",
    "State",
    "SwollenLink",
    "absorbing_links",
    "coupler_path",
    "coupler_point_in_state",
    "link_condition",
    "link_diffusion",
    "link_uptake",
    "linkage_in_state",
    "mechanism_in_state",
    "resin_retention",
    "silent_links",
    "swollen_links",
]
