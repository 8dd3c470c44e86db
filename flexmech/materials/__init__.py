"""Materials, from fibres to laminates. No mechanisms here."""

from flexmech.materials.constituents import (
    Fibre,
    Matrix,
    propagated_uncertainty,
    published_constituents,
)
from flexmech.materials.laminate import Laminate, Layer
from flexmech.materials.material import Material
from flexmech.materials.micromechanics import (
    PACKING_LIMIT,
    RULES,
    Rule,
    ply_from_constituents,
    woven_ply,
)
from flexmech.materials.ply import Ply, PlyDamping

__all__ = [
    "PACKING_LIMIT",
    "RULES",
    "Fibre",
    "Laminate",
    "Layer",
    "Material",
    "Matrix",
    "Ply",
    "PlyDamping",
    "Rule",
    "ply_from_constituents",
    "propagated_uncertainty",
    "published_constituents",
    "woven_ply",
]
