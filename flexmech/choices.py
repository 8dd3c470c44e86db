"""What can be chosen by name: the words of requests, of engines and of command-line options.

They stand on the ground floor and import nothing, so that the command line can list them without
waiting for a library.
"""

from __future__ import annotations

from typing import Literal, get_args

__all__ = [
    "INTEGRATORS",
    "PRESTRESS_LEVELS",
    "STARTS",
    "ElementName",
    "EngineName",
    "ExudynElement",
    "Integrator",
    "MapPrestress",
    "Prestress",
    "ReferenceElement",
    "Start",
]

EngineName = Literal["reference", "exudyn"]
ReferenceElement = Literal["euler", "timoshenko", "reddy"]
ExudynElement = Literal["ancf", "geometrically-exact"]
ElementName = ReferenceElement | ExudynElement
"""Beam elements of the two engines."""

Prestress = Literal["none", "axial", "equilibrium"]
"""Quasi-static stress at which links are linearized."""
PRESTRESS_LEVELS: tuple[Prestress, ...] = get_args(Prestress)
MapPrestress = Literal["none", "axial", "equilibrium", "trajectory"]
"""With the states of the simulated, settled motion besides."""

Integrator = Literal["trapezoidal", "generalized-alpha"]
"""Time integration of a simulation."""
INTEGRATORS: tuple[Integrator, ...] = get_args(Integrator)
Start = Literal["rigid", "equilibrium", "periodic"]
"""State in which a run begins."""
STARTS: tuple[Start, ...] = get_args(Start)
