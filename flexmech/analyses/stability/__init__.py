"""Stability of the running linkage: Floquet multipliers over the crank speed."""

from flexmech.analyses.stability.against import parameters_of
from flexmech.analyses.stability.compute import stability
from flexmech.analyses.stability.engine_stability import (
    Band,
    BandEdge,
    EngineStability,
    ExponentErrors,
    NoEquilibrium,
    TrackedSpeed,
)
from flexmech.analyses.stability.request import StabilityRequest
from flexmech.analyses.stability.result import StabilityMap
from flexmech.analyses.stability.solver import LinkageSolver

__all__ = [
    "Band",
    "BandEdge",
    "EngineStability",
    "ExponentErrors",
    "LinkageSolver",
    "NoEquilibrium",
    "StabilityMap",
    "StabilityRequest",
    "TrackedSpeed",
    "parameters_of",
    "stability",
]
