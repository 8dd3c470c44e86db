"""How the rigid linkage moves, and which joint forces and torque that takes."""

from flexmech.analyses.kinematics.compute import KinematicsRequest, kinematics
from flexmech.analyses.kinematics.result import Kinematics

__all__ = ["Kinematics", "KinematicsRequest", "kinematics"]
