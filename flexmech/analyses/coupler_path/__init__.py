"""The path of a point of the coupler, dry and in heat and moisture."""

from flexmech.analyses.coupler_path.compute import coupler_paths
from flexmech.analyses.coupler_path.result import CouplerPaths

__all__ = ["CouplerPaths", "coupler_paths"]
