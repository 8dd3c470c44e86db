"""Curves that points of a four-bar's coupler trace: their equation, double points, circuits."""

from flexmech.linkages.coupler_curves.curve import CouplerCurve, CouplerPoint, coupler_sextic
from flexmech.linkages.coupler_curves.double_points import (
    DoublePoint,
    FiniteDoublePoint,
    circuit_of,
    double_points,
    finite_double_points,
    focal_cubic,
    full_turn,
)

__all__ = [
    "CouplerCurve",
    "CouplerPoint",
    "DoublePoint",
    "FiniteDoublePoint",
    "circuit_of",
    "coupler_sextic",
    "double_points",
    "finite_double_points",
    "focal_cubic",
    "full_turn",
]
