"""Beam sections: what a link's cross-section is to a beam."""

from flexmech.sections.beam_section import BeamSection
from flexmech.sections.damping import DampingTimes, SpecificDamping
from flexmech.sections.laminate_section import (
    REDUCTIONS,
    LaminateSection,
    Reduction,
    ThroughThickness,
)
from flexmech.sections.third_order import ThirdOrder

__all__ = [
    "REDUCTIONS",
    "BeamSection",
    "DampingTimes",
    "LaminateSection",
    "Reduction",
    "SpecificDamping",
    "ThirdOrder",
    "ThroughThickness",
]
