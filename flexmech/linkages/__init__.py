"""Rigid linkages: topology, kinematics and inverse dynamics. No elasticity here."""

from flexmech.linkages.applied_forces import ForceOnLink
from flexmech.linkages.attachments import GROUND, JointSpring, LinkPoint, Load, Spring
from flexmech.linkages.coupler_curve import CouplerCurve, CouplerPoint
from flexmech.linkages.coupler_sextic import coupler_sextic
from flexmech.linkages.cusp_transitions import CuspTransition, cusp_transitions
from flexmech.linkages.double_points import DoublePoint, double_points
from flexmech.linkages.drawing import drawn_joints
from flexmech.linkages.drive import CrankDrive, LockedCrank
from flexmech.linkages.fourbar import Branch, FourBar, GrashofClass
from flexmech.linkages.inverse_dynamics import InverseDynamics, inverse_dynamics
from flexmech.linkages.link_mass import LEAST_DISTANCE, LinkBody, LinkMass, lumped_elements
from flexmech.linkages.linkage import Linkage
from flexmech.linkages.motion import RigidMotion
from flexmech.linkages.planar import PlanarJoint, PlanarLink, PlanarLinkage
from flexmech.linkages.positions import linkage_positions, shown_crank_angle, standing
from flexmech.linkages.rotating_arm import RotatingArm
from flexmech.linkages.synthesis import (
    CrankRockerProportions,
    TransmissionDesign,
    rocker_swing,
    synthesize_crank_rocker,
    time_ratio,
    transmission_design,
)
from flexmech.linkages.topology import Clamp, Link, LinkEnd, Pin, Pivot, Slider, Topology, Weld
from flexmech.linkages.winding import continuous_angles

__all__ = [
    "GROUND",
    "LEAST_DISTANCE",
    "Branch",
    "Clamp",
    "CouplerCurve",
    "CouplerPoint",
    "CrankDrive",
    "CrankRockerProportions",
    "CuspTransition",
    "DoublePoint",
    "ForceOnLink",
    "FourBar",
    "GrashofClass",
    "InverseDynamics",
    "JointSpring",
    "Link",
    "LinkBody",
    "LinkEnd",
    "LinkMass",
    "LinkPoint",
    "Linkage",
    "Load",
    "LockedCrank",
    "Pin",
    "Pivot",
    "PlanarJoint",
    "PlanarLink",
    "PlanarLinkage",
    "RigidMotion",
    "RotatingArm",
    "Slider",
    "Spring",
    "Topology",
    "TransmissionDesign",
    "Weld",
    "continuous_angles",
    "coupler_sextic",
    "cusp_transitions",
    "double_points",
    "drawn_joints",
    "inverse_dynamics",
    "linkage_positions",
    "lumped_elements",
    "rocker_swing",
    "shown_crank_angle",
    "standing",
    "synthesize_crank_rocker",
    "time_ratio",
    "transmission_design",
]
