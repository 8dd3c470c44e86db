"""Motion in time: the linkage driven by its shaft, its runs, and its periodic motion.

From the ground up: ``recorded_runs``, ``equations_of_motion``, ``integrators`` and
``periodic_motion``.
"""

from flexmech.time_domain.equations_of_motion.driven_connectors import ConnectorWork
from flexmech.time_domain.equations_of_motion.driven_linkage import (
    DETAIL,
    DrivenLinkage,
    is_reduced,
    static_balance,
    stretches_in_runs,
)
from flexmech.time_domain.equations_of_motion.driven_shaft import (
    RotorCoupling,
    ShaftTorque,
    with_rotor,
)
from flexmech.time_domain.integrators.runs import (
    end_state,
    linear_run,
    simulator,
    step_lag,
)
from flexmech.time_domain.integrators.stretch_march import UnbalancedStepError
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
from flexmech.time_domain.periodic_motion.orbit_equations import require_periodic_motion
from flexmech.time_domain.periodic_motion.sampled_turn import SampledTurn
from flexmech.time_domain.periodic_motion.shooting import (
    periodic_state,
    periodic_turn,
    quasi_static_turn,
    state_under_motor,
)
from flexmech.time_domain.recorded_runs.recording import Recorder, StepBlock
from flexmech.time_domain.recorded_runs.states import (
    FrameMotion,
    Impact,
    LinkState,
    ShaftMotion,
    Trajectory,
    rigid_torque,
)

__all__ = [
    "DETAIL",
    "ConnectorWork",
    "DrivenLinkage",
    "ForcedModes",
    "FrameMotion",
    "FreeAndForced",
    "Impact",
    "LinkState",
    "MovingModes",
    "NonlinearOrbit",
    "Recorder",
    "RotorCoupling",
    "SampledTurn",
    "ShaftMotion",
    "ShaftTorque",
    "StepBlock",
    "Trajectory",
    "UnbalancedStepError",
    "counts_of_modes",
    "end_state",
    "forced_linkage",
    "forced_modes",
    "is_reduced",
    "linear_run",
    "moving_modes",
    "nonlinear_orbit",
    "periodic_state",
    "periodic_turn",
    "quasi_static_turn",
    "require_periodic_motion",
    "rigid_torque",
    "simulator",
    "state_under_motor",
    "static_balance",
    "step_lag",
    "stretches_in_runs",
    "with_rotor",
]
