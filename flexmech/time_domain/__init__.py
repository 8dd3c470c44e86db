"""Motion in time: linear time-varying systems, their periodic motion, and recorded runs."""

from flexmech.choices import INTEGRATORS, Integrator
from flexmech.time_domain.axial_frequency import lowest_axial_frequency
from flexmech.time_domain.connector_work import ConnectorWork
from flexmech.time_domain.driven_linkage import DrivenLinkage
from flexmech.time_domain.equations import Equations
from flexmech.time_domain.forced_linkage import forced_linkage
from flexmech.time_domain.forced_modes import ForcedModes, FreeAndForced, forced_modes
from flexmech.time_domain.linear_run import linear_run
from flexmech.time_domain.marching import step_lag
from flexmech.time_domain.moving_modes import MovingModes, counts_of_modes, moving_modes
from flexmech.time_domain.nonlinear_orbit import NonlinearOrbit, nonlinear_orbit
from flexmech.time_domain.orbit import PeriodicOrbit, simulated_orbit
from flexmech.time_domain.periodic import TurnMap, periodic_state, periodic_turn, turn_map
from flexmech.time_domain.point_recording import BlockTaker, PointRecorder
from flexmech.time_domain.recording import EnergyHistory, Recorder, StepBlock, Trajectory
from flexmech.time_domain.reduced_links import (
    DETAIL,
    can_stretch,
    is_reduced,
    stretches_in_runs,
)
from flexmech.time_domain.sampled_turn import SampledTurn
from flexmech.time_domain.shaft_motion import ShaftMotion
from flexmech.time_domain.shaft_torque import rigid_torque
from flexmech.time_domain.simulator import Impact, Simulator, simulator
from flexmech.time_domain.state import LinkState, VibrationState
from flexmech.time_domain.stretch_march import UnbalancedStepError
from flexmech.time_domain.struck_run import StruckLinkage

__all__ = [
    "DETAIL",
    "INTEGRATORS",
    "BlockTaker",
    "ConnectorWork",
    "DrivenLinkage",
    "EnergyHistory",
    "Equations",
    "ForcedModes",
    "FreeAndForced",
    "Impact",
    "Integrator",
    "LinkState",
    "MovingModes",
    "NonlinearOrbit",
    "PeriodicOrbit",
    "PointRecorder",
    "Recorder",
    "SampledTurn",
    "ShaftMotion",
    "Simulator",
    "StepBlock",
    "StruckLinkage",
    "Trajectory",
    "TurnMap",
    "UnbalancedStepError",
    "VibrationState",
    "can_stretch",
    "counts_of_modes",
    "forced_linkage",
    "forced_modes",
    "is_reduced",
    "linear_run",
    "lowest_axial_frequency",
    "moving_modes",
    "nonlinear_orbit",
    "periodic_state",
    "periodic_turn",
    "rigid_torque",
    "simulated_orbit",
    "simulator",
    "step_lag",
    "stretches_in_runs",
    "turn_map",
]
