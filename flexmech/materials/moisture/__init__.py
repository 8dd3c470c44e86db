"""Diffusion of water: diffusivity, series solutions, and a numerical solution for layers."""

from flexmech.materials.moisture.approximations import (
    shen_springer_uptake,
    short_time_uptake,
    time_to_saturation_shen_springer,
)
from flexmech.materials.moisture.diffusivity import (
    Diffusivity,
    MoistureEquilibrium,
    composite_diffusivity_ratio,
)
from flexmech.materials.moisture.history import Surroundings
from flexmech.materials.moisture.mesh import DiffusionLayer
from flexmech.materials.moisture.numerical import MoistureHistory, diffuse, diffuse_bar
from flexmech.materials.moisture.series import (
    bar_profile,
    bar_uptake,
    slab_profile,
    slab_uptake,
    time_to_saturation,
)
from flexmech.materials.moisture.unit_slab import Faces

__all__ = [
    "DiffusionLayer",
    "Diffusivity",
    "Faces",
    "MoistureEquilibrium",
    "MoistureHistory",
    "Surroundings",
    "bar_profile",
    "bar_uptake",
    "composite_diffusivity_ratio",
    "diffuse",
    "diffuse_bar",
    "shen_springer_uptake",
    "short_time_uptake",
    "slab_profile",
    "slab_uptake",
    "time_to_saturation",
    "time_to_saturation_shen_springer",
]
