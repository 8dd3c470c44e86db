"""What the legend of a picture says of masses, springs and loads."""

from __future__ import annotations

import numpy as np
from matplotlib.artist import Artist
from matplotlib.path import Path

from flexmech.plots import linkage_symbols as symbols
from flexmech.plots.linkage_parts import LinkageParts
from flexmech.plots.series import Look, line_handle

__all__ = ["MASS", "part_handles"]

MASS: Look = {"marker": "o", "mew": 0.0, "alpha": 0.75, "zorder": 3.0}
ZIGZAG = Path(symbols.zigzag(np.array([-1.0, 0.0]), np.array([1.0, 0.0]), 0.22).places)
"""Marks of springs and bodies in a legend."""
COIL = Path(symbols.spiral(np.zeros(2), 1.0).places)
CROSSED = Path.make_compound_path(
    Path.unit_circle(), Path([[-1, 0], [1, 0]]), Path([[0, -1], [0, 1]])
)
OVER = {"constant": "load", "crank_angle": "load over the crank angle", "time": "load over time"}


def part_handles(parts: LinkageParts, mass_color: str) -> list[Artist]:
    """Legend entries of the parts that are not told by their symbols alone.

    Parameters
    ----------
    parts : LinkageParts
    mass_color : str
        Of point masses and bodies.

    Returns
    -------
    list of Artist
    """
    found: list[Artist] = []
    if masses := [mass["kg"] for mass in parts.masses]:
        disc: Look = MASS | {"ls": "", "ms": 6, "color": mass_color}
        found.append(line_handle(f"point mass (largest {1e3 * max(masses):.4g} g)", **disc))
    if parts.springs:
        zigzag: Look = {"ls": "", "marker": ZIGZAG, "ms": 16, "mew": 0.9, "mfc": "none"}
        found.append(line_handle("spring", color="0.25", **zigzag))
    if any(one["torsional"] for one in parts.joint_springs):
        coil: Look = {"ls": "", "marker": COIL, "ms": 9, "mew": 0.7, "mfc": "none"}
        found.append(line_handle("torsional spring", color="0.25", **coil))
    if parts.bodies:
        look: Look = {"ls": "", "marker": CROSSED, "ms": 7, "mew": 0.9, "mfc": "none"}
        found.append(line_handle("centre of a body", color=mass_color, **look))
    for over, words in OVER.items():
        names = [load["name"] for load in parts.loads if load["over"] == over]
        if names:
            varies = over != "constant"
            arrow: Look = {"color": "black", "lw": 1.2, "marker": ">", "ms": 5, "mew": 0.8}
            if varies:
                arrow |= {"ls": (0.0, (3.0, 1.5)), "mfc": "white"}
            label = f"{words}: {', '.join(names)}".replace("$", r"\$")
            found.append(line_handle(label, **arrow))
    return found
