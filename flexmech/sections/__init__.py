"""Beam sections: what a link's cross-section is to a beam."""

from flexmech.sections.beam_reduction import REDUCTIONS, Reduction
from flexmech.sections.beam_section import BeamSection
from flexmech.sections.between_joints import sections_between_joints
from flexmech.sections.damping import DampingTimes, SpecificDamping
from flexmech.sections.free_edges import TWISTS
from flexmech.sections.hygrothermal import HygrothermalProfile, swollen_section
from flexmech.sections.laminate_section import (
    SHEAR_THEORIES,
    LaminateSection,
)
from flexmech.sections.shear_theories import WARPINGS, ThirdOrder, Zigzag
from flexmech.sections.solid_section import SolidSection, solid_section

__all__ = [
    "REDUCTIONS",
    "SHEAR_THEORIES",
    "TWISTS",
    "WARPINGS",
    "BeamSection",
    "DampingTimes",
    "HygrothermalProfile",
    "LaminateSection",
    "Reduction",
    "SolidSection",
    "SpecificDamping",
    "ThirdOrder",
    "Zigzag",
    "sections_between_joints",
    "solid_section",
    "swollen_section",
]
