"""What is known of a mechanism, and its natural frequencies at rest."""

from flexmech.analyses.check.compute import check_mechanism
from flexmech.analyses.check.result import ModelCheck

__all__ = ["ModelCheck", "check_mechanism"]
