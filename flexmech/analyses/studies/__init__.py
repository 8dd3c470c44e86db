"""Whole campaigns: a paper's cases, computed and set beside what it prints."""

from flexmech.analyses.studies.claims import Claim, composite_claims, laminate_factors
from flexmech.analyses.studies.composite_crank_rockers import (
    composite_crank_rocker,
    composite_model_file,
    position_angles,
    study_composites,
)
from flexmech.analyses.studies.published import published_case, published_tables

__all__ = [
    "Claim",
    "composite_claims",
    "composite_crank_rocker",
    "composite_model_file",
    "laminate_factors",
    "position_angles",
    "published_case",
    "published_tables",
    "study_composites",
]
