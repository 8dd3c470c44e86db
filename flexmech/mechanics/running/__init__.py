"""Equations of motion of the running linkage, and what a run has recorded."""

from flexmech.mechanics.running.driven_connectors import ConnectorWork
from flexmech.mechanics.running.driven_linkage import (
    DETAIL,
    DrivenLinkage,
    is_reduced,
    static_balance,
    stretches_in_runs,
)
from flexmech.mechanics.running.driven_shaft import RotorCoupling, ShaftTorque, with_rotor
from flexmech.mechanics.running.recorded_run import (
    FrameMotion,
    Impact,
    LinkState,
    Recorder,
    ShaftMotion,
    StepBlock,
    Trajectory,
    rigid_torque,
)

__all__ = [
    "DETAIL",
    "ConnectorWork",
    "DrivenLinkage",
    "FrameMotion",
    "Impact",
    "LinkState",
    "Recorder",
    "RotorCoupling",
    "ShaftMotion",
    "ShaftTorque",
    "StepBlock",
    "Trajectory",
    "is_reduced",
    "rigid_torque",
    "static_balance",
    "stretches_in_runs",
    "with_rotor",
]
