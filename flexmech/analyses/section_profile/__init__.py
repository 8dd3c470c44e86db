"""Cross-sections of links: stiffness and mass, and strain and stress inside under unit loads."""

from flexmech.analyses.section_profile.compute import section_profiles
from flexmech.analyses.section_profile.result import SectionProfiles

__all__ = ["SectionProfiles", "section_profiles"]
