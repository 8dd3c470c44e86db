"""Beam sections: what a link's cross-section is to a beam."""

from flexmech.sections.beam_section import BeamSection
from flexmech.sections.damping import DampingTimes, SpecificDamping

__all__ = ["BeamSection", "DampingTimes", "SpecificDamping"]
