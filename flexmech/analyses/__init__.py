"""Questions put to a mechanism or to engines; each answer is a result.

A folder a question: what can be asked (request), how it is computed, and the result with its
tables, pictures and summary.
"""

from flexmech.analyses.check import ModelCheck, check_mechanism
from flexmech.analyses.coupler_path import CouplerPaths, coupler_paths
from flexmech.analyses.frequencies import (
    EngineAgreement,
    Formulation,
    FrequencyRequest,
    Modes,
    MovingFrequencies,
    frequency_map,
    moving_frequencies,
    natural_frequencies,
    solve_frequencies,
    solve_modes,
    strain_energy_damping,
)
from flexmech.analyses.moisture import MoistureUptake, moisture_uptake
from flexmech.analyses.response import Response, ResponseRequest, deflections, response
from flexmech.analyses.result import Result
from flexmech.analyses.section_profile import SectionProfiles, section_profiles
from flexmech.analyses.speed_sweep import SpeedSweep, speed_sweep
from flexmech.analyses.summary import Summary, Table
from flexmech.analyses.synthesis import CrankRockerSynthesis, crank_rocker_synthesis

__all__ = [
    "CouplerPaths",
    "CrankRockerSynthesis",
    "EngineAgreement",
    "Formulation",
    "FrequencyRequest",
    "ModelCheck",
    "Modes",
    "MoistureUptake",
    "MovingFrequencies",
    "Response",
    "ResponseRequest",
    "Result",
    "SectionProfiles",
    "SpeedSweep",
    "Summary",
    "Table",
    "check_mechanism",
    "coupler_paths",
    "crank_rocker_synthesis",
    "deflections",
    "frequency_map",
    "moisture_uptake",
    "moving_frequencies",
    "natural_frequencies",
    "response",
    "section_profiles",
    "solve_frequencies",
    "solve_modes",
    "speed_sweep",
    "strain_energy_damping",
]
