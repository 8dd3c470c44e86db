"""A mechanism: linkage, sections, masses, loads, springs and surroundings."""

from flexmech.mechanism.drawing import drawing, drawn_parts
from flexmech.mechanism.joint_pins import JointPin, PinEye
from flexmech.mechanism.mechanism import Mechanism
from flexmech.mechanism.motor_runs import motor_run, with_motor_run
from flexmech.mechanism.parts import AttachedBody, PointMass, Provenance, Wetting

__all__ = [
    "AttachedBody",
    "JointPin",
    "Mechanism",
    "PinEye",
    "PointMass",
    "Provenance",
    "Wetting",
    "drawing",
    "drawn_parts",
    "motor_run",
    "with_motor_run",
]
