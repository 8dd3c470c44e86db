"""A mechanism: linkage, sections, masses, loads, springs and surroundings."""

from flexmech.mechanism.mechanism import Mechanism
from flexmech.mechanism.parts import AttachedBody, PointMass, Provenance, Wetting

__all__ = ["AttachedBody", "Mechanism", "PointMass", "Provenance", "Wetting"]
