"""Whole campaigns: a paper's cases, computed and set beside what it prints."""

from flexmech.studies.claim import Claim, Verdict
from flexmech.studies.composite_crank_rockers import CompositeStudy, study_composites
from flexmech.studies.composite_crank_rockers.linkages import (
    composite_crank_rocker,
    composite_model_file,
    position_angles,
)
from flexmech.studies.composite_crank_rockers.published import published_case, published_tables
from flexmech.studies.composite_crank_rockers.structure import (
    deviation_at_best_scale,
    laminate_factors,
)

__all__ = [
    "Claim",
    "CompositeStudy",
    "Verdict",
    "composite_crank_rocker",
    "composite_model_file",
    "deviation_at_best_scale",
    "laminate_factors",
    "position_angles",
    "published_case",
    "published_tables",
    "study_composites",
]
