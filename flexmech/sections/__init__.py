"""Beam sections: what a link's cross-section is to a beam."""

from flexmech.sections.beam_reduction import (
    REDUCTIONS,
    SHEAR_THEORIES,
    WARPINGS,
    LayerDirection,
    Reduction,
    ThirdOrder,
    Zigzag,
)
from flexmech.sections.beam_section import (
    BeamSection,
    Layers,
    sections_between_joints,
    stiffened_section,
)
from flexmech.sections.damping import DampingTimes, SpecificDamping
from flexmech.sections.free_edges import TWISTS
from flexmech.sections.hygrothermal import (
    HygrothermalProfile,
    residual_ply_stresses,
    swollen_section,
)
from flexmech.sections.laminate_section import SURFACES, LaminateSection, unit_ply_stresses
from flexmech.sections.sheet_section import SheetSection
from flexmech.sections.solid_section import SolidSection, solid_section

__all__ = [
    "REDUCTIONS",
    "SHEAR_THEORIES",
    "SURFACES",
    "TWISTS",
    "WARPINGS",
    "BeamSection",
    "DampingTimes",
    "HygrothermalProfile",
    "LaminateSection",
    "LayerDirection",
    "Layers",
    "Reduction",
    "SheetSection",
    "SolidSection",
    "SpecificDamping",
    "ThirdOrder",
    "Zigzag",
    "residual_ply_stresses",
    "sections_between_joints",
    "solid_section",
    "stiffened_section",
    "swollen_section",
    "unit_ply_stresses",
]
