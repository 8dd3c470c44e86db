"""Beam elements by theory: shape functions, element matrices, and links of elements."""

from flexmech.beams.comparison import compare_theories
from flexmech.beams.elements import BEAM_SHAPES
from flexmech.beams.link_matrices import build_chain
from flexmech.beams.theories import BeamShapes

__all__ = [
    "BEAM_SHAPES",
    "BeamShapes",
    "build_chain",
    "compare_theories",
]
