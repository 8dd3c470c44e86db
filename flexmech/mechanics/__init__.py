"""Mechanics of a linkage of elastic links: from one link to the equations of motion.

Read first ``system.py``, the linear system that an engine returns and every analysis asks, then
``engine.py``, what both engines share. ``links/`` holds one link in its frame: mass, stiffness,
rotation terms, bodies and component modes. ``joints/`` ties links together and turns their frames.
``loads/`` holds springs, dampers, loads and the points to which they are attached. ``prestress.py``
and ``section_forces.py`` give the stress of the rigid motion and of displaced links. ``beams/``
holds beam elements and theories, ``running/`` the equations of motion in time.
"""

from flexmech.choices import Prestress
from flexmech.mechanics.engine import (
    Engine,
    all_constant,
    has_constant_tangents,
    has_relative_motion,
    is_constant_turn,
    stressed_along_turn,
)
from flexmech.mechanics.engine_parameters import (
    COMPRESSED,
    NEGLIGIBLE,
    RESTRAINED_ENDS,
    TheoryComparison,
    TheoryDifference,
    check_elastic,
    checked_mechanism,
)
from flexmech.mechanics.joints.carried_linkage import COORDINATES, CarriedLinkage
from flexmech.mechanics.joints.link_frames import LinkFrames
from flexmech.mechanics.joints.link_ties import DependentRows, DisplacedTies
from flexmech.mechanics.joints.position_errors import (
    LESS_LOADED,
    BucklingError,
    EquilibriumError,
    OverdampedError,
    RefusedPositionsError,
    TooManyModesError,
    refuse_positions,
)
from flexmech.mechanics.links.body_forces import DeadMoments, DisplacedInertia, body_turns
from flexmech.mechanics.links.component_modes import GREAT_DETAIL, ComponentModes, component_modes
from flexmech.mechanics.links.link_inertia import LinkInertia, MovingLink, inertia_loads
from flexmech.mechanics.links.link_model import (
    LinkModel,
    RigidFields,
    StressedLinks,
    chain_matrix,
    in_positions,
    rigid_link,
)
from flexmech.mechanics.links.link_readings import LinkReadings, LinkStretch
from flexmech.mechanics.links.rigid_body import RigidBody, body_nodes
from flexmech.mechanics.links.rotation_terms import RotationTerms, SystemMatrices
from flexmech.mechanics.loads.attached_points import (
    AttachedPoint,
    LinkPoint,
    PointJacobian,
    displacement_row,
)
from flexmech.mechanics.loads.connectors import (
    ConnectedMatrices,
    Connectors,
    PointForce,
    acts_at_rest,
    connected_matrices,
    deformations,
    has_dampers,
    kinks_of,
)
from flexmech.mechanics.prestress import (
    LAST_STEP,
    LOAD_STEPS,
    MAX_ITERATIONS,
    BalancedLoads,
    refuse_large_displacements,
    straight_forces,
    with_rigid_links,
)
from flexmech.mechanics.section_forces import DisplacedLinks
from flexmech.mechanics.system import LinearSystem, condense, point_rows

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
