"""Questions put to a mechanism or to engines; each answer is a result.

A folder a question: what can be asked (request), how it is computed, and the result with its
tables, pictures and summary.
"""

from flexmech.analyses.frequencies import (
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
from flexmech.analyses.response import Response, ResponseRequest, response
from flexmech.analyses.result import Result
from flexmech.analyses.speed_sweep import SpeedSweep, speed_sweep
from flexmech.analyses.summary import Summary, Table

__all__ = [
    "Formulation",
    "FrequencyRequest",
    "Modes",
    "MovingFrequencies",
    "Response",
    "ResponseRequest",
    "Result",
    "SpeedSweep",
    "Summary",
    "Table",
    "frequency_map",
    "moving_frequencies",
    "natural_frequencies",
    "response",
    "solve_frequencies",
    "solve_modes",
    "speed_sweep",
    "strain_energy_damping",
]
