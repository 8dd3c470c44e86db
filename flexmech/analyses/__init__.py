"""Analyses of linear systems, whatever the engine."""

from flexmech.analyses.eigenproblem import Modes, solve_frequencies, solve_modes
from flexmech.analyses.frequencies import frequency_map, moving_frequencies, natural_frequencies
from flexmech.analyses.hygrothermal_effect import HygrothermalEffect, hygrothermal_effect
from flexmech.analyses.mapping import FrequencyRequest
from flexmech.analyses.result import EngineAgreement, MovingFrequencies

__all__ = [
    "EngineAgreement",
    "FrequencyRequest",
    "HygrothermalEffect",
    "Modes",
    "MovingFrequencies",
    "frequency_map",
    "hygrothermal_effect",
    "moving_frequencies",
    "natural_frequencies",
    "solve_frequencies",
    "solve_modes",
]
