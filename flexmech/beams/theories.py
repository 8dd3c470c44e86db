"""Beam theories by name."""

from __future__ import annotations

from flexmech.beams.beam_shapes import BeamShapes, EulerBernoulli, Reddy, Timoshenko
from flexmech.beams.zigzag_shapes import ZigzagBeam

BEAM_SHAPES: dict[str, BeamShapes] = {
    "euler": EulerBernoulli(),
    "timoshenko": Timoshenko(),
    "reddy": Reddy(),
    "zigzag": ZigzagBeam(),
}
"""Beam theories by the names of the reference engine's elements."""
