"""What is the cross-section of a link to a beam, and how is it strained and stressed inside?"""

from flexmech.analyses.section_profile.compute import section_profiles
from flexmech.analyses.section_profile.result import SectionProfiles

__all__ = ["SectionProfiles", "section_profiles"]
