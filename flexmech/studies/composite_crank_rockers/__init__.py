"""Composite crank-rockers of Elamy et al. 2023: six laminates, four linkages, three positions."""

from flexmech.studies.composite_crank_rockers.compute import study_composites
from flexmech.studies.composite_crank_rockers.result import CompositeStudy

__all__ = ["CompositeStudy", "study_composites"]
