"""Beam elements by theory: shape functions, element matrices, and links of elements."""

from flexmech.beams.beam_shapes import BeamShapes
from flexmech.beams.comparison import compare_theories
from flexmech.beams.elements import BEAM_SHAPES, BeamElements
from flexmech.beams.link_matrices import Chain, build_chain

__all__ = [
    "BEAM_SHAPES",
    "BeamElements",
    "BeamShapes",
    "Chain",
    "build_chain",
    "compare_theories",
]
