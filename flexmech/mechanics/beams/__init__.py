"""Beam elements by theory: shape functions, element matrices, and links of elements."""

from flexmech.mechanics.beams.comparison import compare_theories
from flexmech.mechanics.beams.elements import BEAM_SHAPES, build_chain
from flexmech.mechanics.beams.theories import BeamShapes

__all__ = ["BEAM_SHAPES", "BeamShapes", "build_chain", "compare_theories"]
