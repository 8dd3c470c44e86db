"""Whole campaigns: a paper's cases, computed and set beside what it prints."""

from flexmech.analyses.studies.claim import REPRODUCED_WITHIN, Claim, all_models
from flexmech.analyses.studies.claims import composite_claims
from flexmech.analyses.studies.composite_crank_rockers import (
    BEAMS,
    PLY_MODELS,
    composite_crank_rocker,
    composite_model_file,
    model_file_name,
    position_angles,
    study_composites,
)
from flexmech.analyses.studies.published import published_case, published_tables
from flexmech.analyses.studies.structure import (
    deviation_at_best_scale,
    laminate_factors,
    separable_error,
)

__all__ = [
    "BEAMS",
    "PLY_MODELS",
    "REPRODUCED_WITHIN",
    "Claim",
    "all_models",
    "composite_claims",
    "composite_crank_rocker",
    "composite_model_file",
    "deviation_at_best_scale",
    "laminate_factors",
    "model_file_name",
    "position_angles",
    "published_case",
    "published_tables",
    "separable_error",
    "study_composites",
]
