"""Motion in time: the linkage driven by its shaft, its runs, and its periodic motion.

The doors below, from the ground up: ``recorded_runs``, ``equations_of_motion``, ``integrators`` and
``periodic_motion``. What a script needs first stands here too.
"""

from flexmech.time_domain.equations_of_motion import DrivenLinkage
from flexmech.time_domain.integrators import linear_run
from flexmech.time_domain.periodic_motion import (
    MovingModes,
    SampledTurn,
    counts_of_modes,
    moving_modes,
    nonlinear_orbit,
    periodic_state,
    simulated_orbit,
)
from flexmech.time_domain.recorded_runs import LinkState, Trajectory

__all__ = [
    "DrivenLinkage",
    "LinkState",
    "MovingModes",
    "SampledTurn",
    "Trajectory",
    "counts_of_modes",
    "linear_run",
    "moving_modes",
    "nonlinear_orbit",
    "periodic_state",
    "simulated_orbit",
]
