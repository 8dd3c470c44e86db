"""A measured record beside what is computed, and what of the model is fitted to it."""

from flexmech.analyses.comparison.compute import compare_with_record
from flexmech.analyses.comparison.request import ComparisonRequest
from flexmech.analyses.comparison.result import Comparison, FittedValue

__all__ = ["Comparison", "ComparisonRequest", "FittedValue", "compare_with_record"]
