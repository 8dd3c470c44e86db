"""Campbell diagram: natural frequencies over crank speed, and critical speeds."""

from flexmech.analyses.campbell.compute import campbell
from flexmech.analyses.campbell.request import ORDERS, CampbellRequest
from flexmech.analyses.campbell.result import CampbellDiagram

__all__ = ["ORDERS", "CampbellDiagram", "CampbellRequest", "campbell"]
