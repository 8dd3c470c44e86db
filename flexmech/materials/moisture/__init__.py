"""Diffusion of water: diffusivity, series solutions, and a numerical solution for layers."""

from flexmech.materials.moisture.diffusivity import (
    Diffusivity,
    MoistureEquilibrium,
    composite_diffusivity_ratio,
)
from flexmech.materials.moisture.history import Ambient
from flexmech.materials.moisture.numerical import (
    DiffusionLayer,
    MoistureHistory,
    diffuse,
    diffuse_bar,
)
from flexmech.materials.moisture.slab import (
    Faces,
    shen_springer_uptake,
    short_time_uptake,
    time_to_saturation,
)

__all__ = [
    "Ambient",
    "DiffusionLayer",
    "Diffusivity",
    "Faces",
    "MoistureEquilibrium",
    "MoistureHistory",
    "composite_diffusivity_ratio",
    "diffuse",
    "diffuse_bar",
    "shen_springer_uptake",
    "short_time_uptake",
    "time_to_saturation",
]
