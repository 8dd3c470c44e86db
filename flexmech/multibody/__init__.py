"""The only place that imports exudyn."""

from flexmech.multibody.engine import ExudynEngine
from flexmech.multibody.exudyn_system import SCRIPT, ExudynSystem

__all__ = ["SCRIPT", "ExudynEngine", "ExudynSystem"]
