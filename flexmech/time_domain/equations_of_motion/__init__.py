"""Equations of motion of a linkage driven by its shaft: matrices, loads and forces over time."""

from flexmech.time_domain.equations_of_motion.driven_connectors import ConnectorWork
from flexmech.time_domain.equations_of_motion.driven_linkage import DrivenLinkage
from flexmech.time_domain.equations_of_motion.dynamics import LinkageDynamics
from flexmech.time_domain.equations_of_motion.equations import Equations, Following
from flexmech.time_domain.equations_of_motion.linkage_stretch import (
    LinkageStretch,
    PinTurns,
    StretchForces,
)
from flexmech.time_domain.equations_of_motion.reduced_links import (
    DETAIL,
    ReducedLinks,
    is_reduced,
    prestressed_links,
    stretches_in_runs,
)

__all__ = [
    "DETAIL",
    "ConnectorWork",
    "DrivenLinkage",
    "Equations",
    "Following",
    "LinkageDynamics",
    "LinkageStretch",
    "PinTurns",
    "ReducedLinks",
    "StretchForces",
    "is_reduced",
    "prestressed_links",
    "stretches_in_runs",
]
