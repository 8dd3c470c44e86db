"""Stability of the running linkage: Floquet multipliers over the crank speed."""

from flexmech.analyses.stability.band import Band, BandEdge
from flexmech.analyses.stability.engine_stability import (
    CheckedErrors,
    EngineStability,
    FollowedSpeed,
    NoEquilibrium,
)
from flexmech.analyses.stability.frames import frozen_eigenvalues
from flexmech.analyses.stability.request import KEPT_MODES, StabilityRequest
from flexmech.analyses.stability.solver import LinkageSolver

__all__ = [
    "KEPT_MODES",
    "Band",
    "BandEdge",
    "CheckedErrors",
    "EngineStability",
    "FollowedSpeed",
    "LinkageSolver",
    "NoEquilibrium",
    "StabilityRequest",
    "frozen_eigenvalues",
]
