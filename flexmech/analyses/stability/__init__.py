"""Stability of the running linkage: Floquet multipliers over the crank speed."""

from flexmech.analyses.stability.against import parameters_of
from flexmech.analyses.stability.compute import stability
from flexmech.analyses.stability.engine_stability import (
    Band,
    BandEdge,
    CheckedErrors,
    EngineStability,
    NoEquilibrium,
    TrackedSpeed,
)
from flexmech.analyses.stability.request import StabilityRequest
from flexmech.analyses.stability.result import StabilityMap
from flexmech.analyses.stability.solver import LinkageSolver

__all__ = [
    "Band",
    "BandEdge",
    "CheckedErrors",
    "EngineStability",
    "LinkageSolver",
    "NoEquilibrium",
    "StabilityMap",
    "StabilityRequest",
    "TrackedSpeed",
    "parameters_of",
    "stability",
]
