"""Linear systems in link frames: the contract between engines and analyses."""

from flexmech.choices import Prestress
from flexmech.linear_system.assembly.engine import (
    Engine,
    all_constant,
    has_constant_tangents,
    has_relative_motion,
    is_constant_turn,
    stressed_along_turn,
)
from flexmech.linear_system.assembly.engine_parameters import (
    COMPRESSED,
    NEGLIGIBLE,
    RESTRAINED_ENDS,
    TheoryComparison,
    TheoryDifference,
    check_elastic,
    checked_mechanism,
)
from flexmech.linear_system.assembly.prestress import (
    LAST_STEP,
    LOAD_STEPS,
    MAX_ITERATIONS,
    BalancedLoads,
    refuse_large_displacements,
    straight_forces,
    with_rigid_links,
)
from flexmech.linear_system.assembly.section_forces import DisplacedLinks
from flexmech.linear_system.assembly.system import LinearSystem, condense, point_rows
from flexmech.linear_system.joints.carried_linkage import COORDINATES, CarriedLinkage
from flexmech.linear_system.joints.link_frames import LinkFrames
from flexmech.linear_system.joints.link_ties import DependentRows, DisplacedTies
from flexmech.linear_system.joints.position_errors import (
    LESS_LOADED,
    BucklingError,
    EquilibriumError,
    OverdampedError,
    RefusedPositionsError,
    TooManyModesError,
    refuse_positions,
)
from flexmech.linear_system.links.body_forces import (
    DeadMoments,
    DisplacedInertia,
    body_turns,
)
from flexmech.linear_system.links.chains import (
    chain_matrix,
    in_positions,
)
from flexmech.linear_system.links.link_inertia import LinkInertia, MovingLink, inertia_loads
from flexmech.linear_system.links.link_model import (
    LinkModel,
    RigidFields,
    StressedLinks,
    rigid_link,
)
from flexmech.linear_system.links.link_readings import LinkReadings, LinkStretch
from flexmech.linear_system.links.rigid_body import RigidBody, body_nodes
from flexmech.linear_system.links.rotation_terms import RotationTerms, SystemMatrices
from flexmech.linear_system.loads.attached_points import (
    AttachedPoint,
    LinkPoint,
    PointJacobian,
    displacement_row,
)
from flexmech.linear_system.loads.connectors import (
    ConnectedMatrices,
    Connectors,
    PointForce,
    acts_at_rest,
    connected_matrices,
    deformations,
    has_dampers,
    kinks_of,
)
from flexmech.linear_system.reduction.component_modes import (
    GREAT_DETAIL,
    ComponentModes,
    component_modes,
)
from flexmech.linear_system.reduction.unreduced_links import LinkPencil, StaticResponse

__all__ = [
    "COMPRESSED",
    "COORDINATES",
    "GREAT_DETAIL",
    "LAST_STEP",
    "LESS_LOADED",
    "LOAD_STEPS",
    "MAX_ITERATIONS",
    "NEGLIGIBLE",
    "RESTRAINED_ENDS",
    "AttachedPoint",
    "BalancedLoads",
    "BucklingError",
    "CarriedLinkage",
    "ComponentModes",
    "ConnectedMatrices",
    "Connectors",
    "DeadMoments",
    "DependentRows",
    "DisplacedInertia",
    "DisplacedLinks",
    "DisplacedTies",
    "Engine",
    "EquilibriumError",
    "LinearSystem",
    "LinkFrames",
    "LinkInertia",
    "LinkModel",
    "LinkPencil",
    "LinkPoint",
    "LinkReadings",
    "LinkStretch",
    "MovingLink",
    "OverdampedError",
    "PointForce",
    "PointJacobian",
    "Prestress",
    "RefusedPositionsError",
    "RigidBody",
    "RigidFields",
    "RotationTerms",
    "StaticResponse",
    "StressedLinks",
    "SystemMatrices",
    "TheoryComparison",
    "TheoryDifference",
    "TooManyModesError",
    "acts_at_rest",
    "all_constant",
    "body_nodes",
    "body_turns",
    "chain_matrix",
    "check_elastic",
    "checked_mechanism",
    "component_modes",
    "condense",
    "connected_matrices",
    "deformations",
    "displacement_row",
    "has_constant_tangents",
    "has_dampers",
    "has_relative_motion",
    "in_positions",
    "inertia_loads",
    "is_constant_turn",
    "kinks_of",
    "point_rows",
    "refuse_large_displacements",
    "refuse_positions",
    "rigid_link",
    "straight_forces",
    "stressed_along_turn",
    "with_rigid_links",
]
