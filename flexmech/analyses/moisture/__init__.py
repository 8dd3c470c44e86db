"""How water gets into the links of a mechanism, and how fast."""

from flexmech.analyses.moisture.compute import moisture_uptake
from flexmech.analyses.moisture.result import MoistureUptake

__all__ = ["MoistureUptake", "moisture_uptake"]
