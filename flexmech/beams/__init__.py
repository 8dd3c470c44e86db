"""Beam elements by theory: shape functions, element matrices, and links put together of them."""

from flexmech.beams.beam_shapes import BEAM_SHAPES, BeamShapes
from flexmech.beams.elements import BeamElements
from flexmech.beams.link_matrices import Chain, build_chain

__all__ = ["BEAM_SHAPES", "BeamElements", "BeamShapes", "Chain", "build_chain"]
