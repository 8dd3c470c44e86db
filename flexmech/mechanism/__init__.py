"""A mechanism: linkage, sections, masses, loads, springs and surroundings."""

from flexmech.mechanism.drawing import drawing, drawn_parts
from flexmech.mechanism.mechanism import Mechanism
from flexmech.mechanism.motor_runs import motor_run, settled_run, with_motor_run
from flexmech.mechanism.parts import (
    AttachedBody,
    FrameSpring,
    JointPin,
    PinEye,
    PointMass,
    Provenance,
    SprungFrame,
    Wetting,
)

__all__ = [
    "AttachedBody",
    "FrameSpring",
    "JointPin",
    "Mechanism",
    "PinEye",
    "PointMass",
    "Provenance",
    "SprungFrame",
    "Wetting",
    "drawing",
    "drawn_parts",
    "motor_run",
    "settled_run",
    "with_motor_run",
]
