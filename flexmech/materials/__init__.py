"""Materials, from fibres to laminates. No mechanisms here."""

from flexmech.materials.composition import RULES, PlyComposition, Rule
from flexmech.materials.constituents import Fibre, Matrix, published_constituents
from flexmech.materials.hygrothermal import (
    REFERENCE_TEMPERATURE,
    Hygrothermal,
    ResinContent,
    UnknownStiffnessError,
)
from flexmech.materials.laminate import Laminate, Layer, solid_stiffness
from flexmech.materials.material import Material
from flexmech.materials.micromechanics import (
    PACKING_LIMIT,
    ply_from_constituents,
    propagated_uncertainty,
    uncertainty_parts,
    woven_ply,
)
from flexmech.materials.plies_in_state import (
    moisture_of,
    ply_diluted,
    ply_in_state,
    through_thickness_strain,
)
from flexmech.materials.ply import Ply, PlyDamping

__all__ = [
    "PACKING_LIMIT",
    "REFERENCE_TEMPERATURE",
    "RULES",
    "Fibre",
    "Hygrothermal",
    "Laminate",
    "Layer",
    "Material",
    "Matrix",
    "Ply",
    "PlyComposition",
    "PlyDamping",
    "ResinContent",
    "Rule",
    "UnknownStiffnessError",
    "moisture_of",
    "ply_diluted",
    "ply_from_constituents",
    "ply_in_state",
    "propagated_uncertainty",
    "published_constituents",
    "solid_stiffness",
    "through_thickness_strain",
    "uncertainty_parts",
    "woven_ply",
]
