"""Rigid linkages: topology, kinematics and inverse dynamics. No elasticity here."""

from flexmech.linkages.applied_forces import GROUND, AttachmentPoint, JointSpring, Load, Spring
from flexmech.linkages.coupler_curves import (
    CouplerCurve,
    CouplerPoint,
    DoublePoint,
    circuit_of,
    coupler_sextic,
    double_points,
    finite_double_points,
    focal_cubic,
    full_turn,
)
from flexmech.linkages.drives.drive import ConstantSpeed, Drive, LockedCrank
from flexmech.linkages.drives.laws import LAWS, LawDrive, LawName, TableDrive
from flexmech.linkages.drives.shaped import (
    FrequenciesOnPath,
    InputShaper,
    PathShapedDrive,
    ShapedDrive,
    Shaping,
    input_shaper,
)
from flexmech.linkages.fourbar import FourBar, GrashofClass
from flexmech.linkages.inverse_dynamics import InverseDynamics, inverse_dynamics
from flexmech.linkages.link_mass import LinkBody, LinkMass, lumped_elements
from flexmech.linkages.linkage import (
    Linkage,
    assemblable,
    continuous_angles,
    refuse_passing,
)
from flexmech.linkages.motion import RigidMotion, carried_motion, turned
from flexmech.linkages.motors.motor import (
    DcMotor,
    DriveTrain,
    Motor,
    MotorDrive,
    SpeedControl,
    TorqueMotor,
)
from flexmech.linkages.motors.motor_run import MotorRun, SettledRun
from flexmech.linkages.planar import PlanarJoint, PlanarLink, PlanarLinkage
from flexmech.linkages.positions import linkage_positions, moving_points, picture_crank_angle
from flexmech.linkages.rotating_arm import RotatingArm
from flexmech.linkages.synthesis import (
    TransmissionDesign,
    rocker_swing,
    synthesize_crank_rocker,
    time_ratio,
    transmission_design,
)
from flexmech.linkages.topology import Clamp, Link, LinkEnd, Pin, Pivot, Slider, Topology, Weld

__all__ = [
    "GROUND",
    "LAWS",
    "AttachmentPoint",
    "Clamp",
    "ConstantSpeed",
    "CouplerCurve",
    "CouplerPoint",
    "DcMotor",
    "DoublePoint",
    "Drive",
    "DriveTrain",
    "FourBar",
    "FrequenciesOnPath",
    "GrashofClass",
    "InputShaper",
    "InverseDynamics",
    "JointSpring",
    "LawDrive",
    "LawName",
    "Link",
    "LinkBody",
    "LinkEnd",
    "LinkMass",
    "Linkage",
    "Load",
    "LockedCrank",
    "Motor",
    "MotorDrive",
    "MotorRun",
    "PathShapedDrive",
    "Pin",
    "Pivot",
    "PlanarJoint",
    "PlanarLink",
    "PlanarLinkage",
    "RigidMotion",
    "RotatingArm",
    "SettledRun",
    "ShapedDrive",
    "Shaping",
    "Slider",
    "SpeedControl",
    "Spring",
    "TableDrive",
    "Topology",
    "TorqueMotor",
    "TransmissionDesign",
    "Weld",
    "assemblable",
    "carried_motion",
    "circuit_of",
    "continuous_angles",
    "coupler_sextic",
    "double_points",
    "finite_double_points",
    "focal_cubic",
    "full_turn",
    "input_shaper",
    "inverse_dynamics",
    "linkage_positions",
    "lumped_elements",
    "moving_points",
    "picture_crank_angle",
    "refuse_passing",
    "rocker_swing",
    "synthesize_crank_rocker",
    "time_ratio",
    "transmission_design",
    "turned",
]
