"""What the legend of a picture says of masses, springs, dampers, loads and gravity."""

from __future__ import annotations

import numpy as np
from matplotlib.artist import Artist
from matplotlib.path import Path
from matplotlib.transforms import Affine2D

from flexmech.plots import linkage_symbols as symbols
from flexmech.plots.damper_symbols import dashpot, rotary_dashpot
from flexmech.plots.linkage_parts import LinkageParts
from flexmech.plots.series import Look, line_handle
from flexmech.types import FloatArray

MASS: Look = {"marker": "o", "mew": 0.0, "alpha": 0.75, "zorder": 3.0}
ZIGZAG = Path(symbols.zigzag(np.array([-1.0, 0.0]), np.array([1.0, 0.0]), 0.22).places)
"""Marks of springs, dampers and bodies in a legend."""
DASHPOT = dashpot(np.array([-1.0, 0.0]), np.array([1.0, 0.0]), 0.3, beside=False).places
BENT_DASHPOT = rotary_dashpot(np.array([0.0, -0.5]), 1.0).places
COIL = Path(symbols.spiral(np.zeros(2), 1.0).places)
CROSSED = Path.make_compound_path(
    Path.unit_circle(), Path([[-1, 0], [1, 0]]), Path([[0, -1], [0, 1]])
)
RINGS = Path.make_compound_path(
    Path.unit_circle(), Path.unit_circle().transformed(Affine2D().scale(0.7))
)
# Along x, to be turned where gravity pulls.
ARROW = Path(
    np.array([[-1, 0], [0.3, 0], [0.3, 0.24], [1, 0], [0.3, -0.24], [0.3, 0]]),
    np.array([Path.MOVETO, *5 * [Path.LINETO]]),
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
    if parts.springs_with("stiff"):
        zigzag: Look = {"ls": "", "marker": ZIGZAG, "ms": 16, "mew": 0.9, "mfc": "none"}
        found.append(line_handle("spring", color="0.25", **zigzag))
    if parts.springs_with("damped"):
        cup: Look = {"ls": "", "marker": _broken(DASHPOT), "ms": 16, "mew": 0.9, "mfc": "none"}
        found.append(line_handle("damper", color="0.25", **cup))
    if parts.springs_with("torsional"):
        coil: Look = {"ls": "", "marker": COIL, "ms": 9, "mew": 0.7, "mfc": "none"}
        found.append(line_handle("torsional spring", color="0.25", **coil))
    if parts.springs_with("torsion_damped"):
        bent: Look = {"ls": "", "marker": _broken(BENT_DASHPOT), "ms": 12, "mew": 0.7}
        found.append(line_handle("torsional damper", color="0.25", **bent, mfc="none"))
    if parts.springs_with("radially_damped"):
        rings: Look = {"ls": "", "marker": RINGS, "ms": 8, "mew": 0.6, "mfc": "none"}
        found.append(line_handle("bearing with a damper", color=symbols.OUTLINE, **rings))
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
    if strength := float(np.hypot(*parts.gravity)):
        turn = np.degrees(np.arctan2(parts.gravity[1], parts.gravity[0]))
        down: Look = {"ls": "", "marker": ARROW.transformed(Affine2D().rotate_deg(turn)), "ms": 10}
        down |= {"mew": 0.8, "color": symbols.GRAVITY_COLOR}
        found.append(line_handle(f"gravity ({strength:.4g} m/s\N{SUPERSCRIPT TWO})", **down))
    return found


def _broken(places: FloatArray) -> Path:
    """A path of lines that is broken where places are not numbers."""
    kept = np.isfinite(places[:, 0])
    starts = np.r_[True, ~kept[:-1]]
    return Path(places[kept], np.where(starts, Path.MOVETO, Path.LINETO)[kept])
