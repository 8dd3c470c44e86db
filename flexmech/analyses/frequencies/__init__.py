"""Natural frequencies of the moving linkage: over crank angle and crank speed, and at positions."""

from flexmech.analyses.frequencies.agreement import EngineAgreement
from flexmech.analyses.frequencies.compute import moving_frequencies
from flexmech.analyses.frequencies.eigenproblem import Modes, solve_frequencies, solve_modes
from flexmech.analyses.frequencies.formulation import Formulation
from flexmech.analyses.frequencies.frequency_map import frequency_map
from flexmech.analyses.frequencies.positions import (
    frequencies_at,
    natural_frequencies,
    strain_energy_damping,
)
from flexmech.analyses.frequencies.request import FrequencyRequest
from flexmech.analyses.frequencies.result import MovingFrequencies

__all__ = [
    "EngineAgreement",
    "Formulation",
    "FrequencyRequest",
    "Modes",
    "MovingFrequencies",
    "frequencies_at",
    "frequency_map",
    "moving_frequencies",
    "natural_frequencies",
    "solve_frequencies",
    "solve_modes",
    "strain_energy_damping",
]
