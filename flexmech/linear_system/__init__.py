"""Linear systems in link frames: the contract between engines and analyses."""

from flexmech.choices import PRESTRESS_LEVELS, Prestress
from flexmech.linear_system.attached_points import AttachedPoint
from flexmech.linear_system.balanced_loads import BalancedLoads
from flexmech.linear_system.body_couples import BodyCouples
from flexmech.linear_system.carried_inertia import CarriedInertia
from flexmech.linear_system.chains import (
    ChainMatrix,
    LinkMatrix,
    chain_matrices,
    chain_matrix,
    diagonal,
    in_positions,
    link_matrices,
    summed,
    whole,
)
from flexmech.linear_system.checks import check_elastic, checked_mechanism
from flexmech.linear_system.component_modes import (
    GREAT_DETAIL,
    ComponentModes,
    component_modes,
)
from flexmech.linear_system.connected_matrices import ConnectedMatrices
from flexmech.linear_system.connector_forces import Push, acts_still
from flexmech.linear_system.connectors import Connectors
from flexmech.linear_system.constant_turn import (
    is_constant_turn,
    same_answers,
    stressed_along_turn,
    turns_or_slides,
    unchanged,
)
from flexmech.linear_system.engine import Engine
from flexmech.linear_system.joint_couples import has_dampers
from flexmech.linear_system.link_bodies import (
    BodyMatrices,
    body_couple,
    body_nodes,
    with_bodies,
)
from flexmech.linear_system.link_frames import LinkFrames
from flexmech.linear_system.link_model import LinkModel, RigidFields, inertia_loads
from flexmech.linear_system.link_place import DependentRows
from flexmech.linear_system.link_points import LinkPoint, displacement_row, point_rows
from flexmech.linear_system.link_readings import LinkReadings
from flexmech.linear_system.link_stretch import LinkStretch
from flexmech.linear_system.mass_root import inverse_mass_root
from flexmech.linear_system.mode_errors import OverdampedError, TooManyModesError
from flexmech.linear_system.position_errors import (
    LESS_LOADED,
    RefusedPositionsError,
    refuse_positions,
)
from flexmech.linear_system.quasi_static import (
    LAST_STEP,
    LOAD_STEPS,
    MAX_ITERATIONS,
    RELATIVE_RESIDUAL,
    ROUND_OFF,
    free_load,
    refuse_large_displacements,
)
from flexmech.linear_system.rigid_coordinates import PoseStiffness
from flexmech.linear_system.rigid_link import (
    dead_virial,
    off_axis_inertia,
    rigid_link,
    rigid_tangent,
)
from flexmech.linear_system.rigid_pose import DisplacedTies
from flexmech.linear_system.rotation_terms import LinkDamping, RotationTerms, SystemMatrices
from flexmech.linear_system.sparse_positions import SparseMatrices, SparsePositions
from flexmech.linear_system.straight_links import (
    StraightForces,
    straight_forces,
    ties_beyond_pins,
    with_rigid_links,
)
from flexmech.linear_system.stressed_links import StressedLinks
from flexmech.linear_system.system import LinearSystem, condense
from flexmech.linear_system.tension import (
    element_tensions,
    forces_of_links,
    static_displacement,
)
from flexmech.linear_system.theory_comparison import (
    ELASTICITY,
    HELD_ENDS,
    NEGLIGIBLE,
    TheoryComparison,
    TheoryDifference,
)

__all__ = [
    "ELASTICITY",
    "GREAT_DETAIL",
    "HELD_ENDS",
    "LAST_STEP",
    "LESS_LOADED",
    "LOAD_STEPS",
    "MAX_ITERATIONS",
    "NEGLIGIBLE",
    "PRESTRESS_LEVELS",
    "RELATIVE_RESIDUAL",
    "ROUND_OFF",
    "AttachedPoint",
    "BalancedLoads",
    "BodyCouples",
    "BodyMatrices",
    "CarriedInertia",
    "ChainMatrix",
    "ComponentModes",
    "ConnectedMatrices",
    "Connectors",
    "DependentRows",
    "DisplacedTies",
    "Engine",
    "LinearSystem",
    "LinkDamping",
    "LinkFrames",
    "LinkMatrix",
    "LinkModel",
    "LinkPoint",
    "LinkReadings",
    "LinkStretch",
    "OverdampedError",
    "PoseStiffness",
    "Prestress",
    "Push",
    "RefusedPositionsError",
    "RigidFields",
    "RotationTerms",
    "SparseMatrices",
    "SparsePositions",
    "StraightForces",
    "StressedLinks",
    "SystemMatrices",
    "TheoryComparison",
    "TheoryDifference",
    "TooManyModesError",
    "acts_still",
    "body_couple",
    "body_nodes",
    "chain_matrices",
    "chain_matrix",
    "check_elastic",
    "checked_mechanism",
    "component_modes",
    "condense",
    "dead_virial",
    "diagonal",
    "displacement_row",
    "element_tensions",
    "forces_of_links",
    "free_load",
    "has_dampers",
    "in_positions",
    "inertia_loads",
    "inverse_mass_root",
    "is_constant_turn",
    "link_matrices",
    "off_axis_inertia",
    "point_rows",
    "refuse_large_displacements",
    "refuse_positions",
    "rigid_link",
    "rigid_tangent",
    "same_answers",
    "static_displacement",
    "straight_forces",
    "stressed_along_turn",
    "summed",
    "ties_beyond_pins",
    "turns_or_slides",
    "unchanged",
    "whole",
    "with_bodies",
    "with_rigid_links",
]
