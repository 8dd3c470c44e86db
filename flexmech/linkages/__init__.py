"""Rigid linkages: topology, kinematics and inverse dynamics. No elasticity here."""

from flexmech.linkages.attachments import GROUND, AttachmentPoint, JointSpring, Load, Spring
from flexmech.linkages.coupler_curves.curve import CouplerCurve, CouplerPoint, coupler_sextic
from flexmech.linkages.coupler_curves.double_points import (
    DoublePoint,
    circuit_of,
    double_points,
    finite_double_points,
    focal_cubic,
    full_turn,
)
from flexmech.linkages.drives.drive import ConstantSpeed, Drive, LockedCrank
from flexmech.linkages.drives.shaped import (
    FrequenciesOnPath,
    PathShapedDrive,
    ShapedDrive,
    check_shapeable,
)
from flexmech.linkages.drives.shapers import InputShaper, input_shaper
from flexmech.linkages.drives.standard_laws import LAWS, LawDrive, LawName
from flexmech.linkages.drives.tabulated import TABLE_ENDS, TableDrive, TableEnds
from flexmech.linkages.fourbar import FourBar, GrashofClass
from flexmech.linkages.inverse_dynamics import (
    InverseDynamics,
    forces_by_joints,
    inverse_dynamics,
)
from flexmech.linkages.link_mass import LEAST_DISTANCE, LinkBody, LinkMass, lumped_elements
from flexmech.linkages.linkage import (
    Linkage,
    LinkageStack,
    assemblable,
    connections,
    continuous_angles,
    refuse_passing,
)
from flexmech.linkages.motion import RigidMotion, carried_motion, turned
from flexmech.linkages.motors.along_motion import states_along, yielded_along
from flexmech.linkages.motors.drive_train import DriveTrain, MotorOutput
from flexmech.linkages.motors.integrated_run import known_until, solved_run
from flexmech.linkages.motors.motor import DcMotor, Motor, TorqueMotor
from flexmech.linkages.motors.motor_drive import MotorDrive, SpeedControl
from flexmech.linkages.motors.motor_run import MotorRun, SettledRun, Stall, repeated
from flexmech.linkages.motors.settled import SettledMotion, settled_motion, speed_range
from flexmech.linkages.motors.shaft_equation import (
    ShaftEquation,
    ShaftLoad,
    TurnSeries,
    TwistedShaft,
)
from flexmech.linkages.planar import PlanarJoint, PlanarLink, PlanarLinkage
from flexmech.linkages.positions import (
    drawn_joints,
    linkage_positions,
    moving_points,
    picture_crank_angle,
)
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

__all__ = [
    "GROUND",
    "LAWS",
    "LEAST_DISTANCE",
    "TABLE_ENDS",
    "AttachmentPoint",
    "Clamp",
    "ConstantSpeed",
    "CouplerCurve",
    "CouplerPoint",
    "CrankRockerProportions",
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
    "LinkageStack",
    "Load",
    "LockedCrank",
    "Motor",
    "MotorDrive",
    "MotorOutput",
    "MotorRun",
    "PathShapedDrive",
    "Pin",
    "Pivot",
    "PlanarJoint",
    "PlanarLink",
    "PlanarLinkage",
    "RigidMotion",
    "RotatingArm",
    "SettledMotion",
    "SettledRun",
    "ShaftEquation",
    "ShaftLoad",
    "ShapedDrive",
    "Slider",
    "SpeedControl",
    "Spring",
    "Stall",
    "TableDrive",
    "TableEnds",
    "Topology",
    "TorqueMotor",
    "TransmissionDesign",
    "TurnSeries",
    "TwistedShaft",
    "Weld",
    "assemblable",
    "carried_motion",
    "check_shapeable",
    "circuit_of",
    "connections",
    "continuous_angles",
    "coupler_sextic",
    "double_points",
    "drawn_joints",
    "finite_double_points",
    "focal_cubic",
    "forces_by_joints",
    "full_turn",
    "input_shaper",
    "inverse_dynamics",
    "known_until",
    "linkage_positions",
    "lumped_elements",
    "moving_points",
    "picture_crank_angle",
    "refuse_passing",
    "repeated",
    "rocker_swing",
    "settled_motion",
    "solved_run",
    "speed_range",
    "states_along",
    "synthesize_crank_rocker",
    "time_ratio",
    "transmission_design",
    "turned",
    "yielded_along",
]
