"""Which crank-rocker has the transmission angle that is wanted."""

from flexmech.analyses.synthesis.compute import crank_rocker_synthesis
from flexmech.analyses.synthesis.result import CrankRockerSynthesis

__all__ = ["CrankRockerSynthesis", "crank_rocker_synthesis"]
