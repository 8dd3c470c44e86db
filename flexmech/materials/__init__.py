"""Materials, from fibres to laminates. No mechanisms here."""

from flexmech.materials.composition import RULES, PlyComposition, Rule
from flexmech.materials.constituents import Fibre, Matrix, published_constituents
from flexmech.materials.failure_criteria import (
    PLY_CRITERIA,
    FailureCriterion,
    failure_criterion,
)
from flexmech.materials.fatigue import FatigueStrength
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
from flexmech.materials.strength import PlyStrength

__all__ = [
    "PACKING_LIMIT",
    "PLY_CRITERIA",
    "REFERENCE_TEMPERATURE",
    "RULES",
    "FailureCriterion",
    "FatigueStrength",
    "Fibre",
    "Hygrothermal",
    "Laminate",
    "Layer",
    "Material",
    "Matrix",
    "Ply",
    "PlyComposition",
    "PlyDamping",
    "PlyStrength",
    "ResinContent",
    "Rule",
    "UnknownStiffnessError",
    "failure_criterion",
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
