"""Planar linkages of any kind from a drawing: topology, and motion by dyads and Newton's method."""

from flexmech.linkages.planar.drawing import PlanarJoint, PlanarLink
from flexmech.linkages.planar.linkage import PlanarLinkage

__all__ = ["PlanarJoint", "PlanarLink", "PlanarLinkage"]
