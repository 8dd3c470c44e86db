"""The only place that imports exudyn."""

from flexmech.multibody.engine import ExudynEngine

__all__ = ["ExudynEngine"]
