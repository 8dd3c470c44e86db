"""Records of runs in time: samples, energies, forces in a band, and engines that simulate."""

from flexmech.time_domain.recorded_runs.recording import (
    BlockTaker,
    PointRecorder,
    Recorder,
    StepBlock,
    Trajectory,
)
from flexmech.time_domain.recorded_runs.shaft_motion import ShaftMotion, rigid_torque
from flexmech.time_domain.recorded_runs.simulator import Impact, LinkState, simulator

__all__ = [
    "BlockTaker",
    "Impact",
    "LinkState",
    "PointRecorder",
    "Recorder",
    "ShaftMotion",
    "StepBlock",
    "Trajectory",
    "rigid_torque",
    "simulator",
]
