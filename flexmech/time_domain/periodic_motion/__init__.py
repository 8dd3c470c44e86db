"""Periodic motion at constant crank speed, and the linear periodic system about it.

Periodic motion is found by shooting or, with nonlinear internal forces, by collocation; moving
modes make the small system whose stability and response are wanted.
"""

from flexmech.time_domain.periodic_motion.forced_linkage import forced_linkage
from flexmech.time_domain.periodic_motion.forced_modes import (
    ForcedModes,
    FreeAndForced,
    forced_modes,
)
from flexmech.time_domain.periodic_motion.moving_modes import (
    MovingModes,
    counts_of_modes,
    moving_modes,
)
from flexmech.time_domain.periodic_motion.nonlinear_orbit import NonlinearOrbit, nonlinear_orbit
from flexmech.time_domain.periodic_motion.sampled_turn import SampledTurn
from flexmech.time_domain.periodic_motion.shooting import (
    periodic_state,
    periodic_turn,
    simulated_orbit,
)

__all__ = [
    "ForcedModes",
    "FreeAndForced",
    "MovingModes",
    "NonlinearOrbit",
    "SampledTurn",
    "counts_of_modes",
    "forced_linkage",
    "forced_modes",
    "moving_modes",
    "nonlinear_orbit",
    "periodic_state",
    "periodic_turn",
    "simulated_orbit",
]
