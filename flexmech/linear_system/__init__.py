"""Linear systems in link frames: the contract between engines and analyses."""

from flexmech.linear_system.component_modes import ComponentModes, component_modes
from flexmech.linear_system.engine import (
    PRESTRESS_LEVELS,
    ConvergenceOrders,
    Engine,
    Prestress,
)
from flexmech.linear_system.link_frames import LinkDamping, LinkFrames, RotationTerms
from flexmech.linear_system.link_model import LinkModel, RigidFields, inertia_loads
from flexmech.linear_system.posture import refuse_other_postures
from flexmech.linear_system.stressed_links import StressedLinks
from flexmech.linear_system.system import LinearSystem, condense
from flexmech.linear_system.tension import element_tensions

__all__ = [
    "PRESTRESS_LEVELS",
    "ComponentModes",
    "ConvergenceOrders",
    "Engine",
    "LinearSystem",
    "LinkDamping",
    "LinkFrames",
    "LinkModel",
    "Prestress",
    "RigidFields",
    "RotationTerms",
    "StressedLinks",
    "component_modes",
    "condense",
    "element_tensions",
    "inertia_loads",
    "refuse_other_postures",
]
