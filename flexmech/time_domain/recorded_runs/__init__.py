"""Records of runs in time: samples, energies, forces in a band, and what runs are told by."""

from flexmech.time_domain.recorded_runs.recording import Recorder, StepBlock, Trajectory
from flexmech.time_domain.recorded_runs.states import Impact, LinkState, ShaftMotion, rigid_torque

__all__ = [
    "Impact",
    "LinkState",
    "Recorder",
    "ShaftMotion",
    "StepBlock",
    "Trajectory",
    "rigid_torque",
]
