"""Springs and dampers of a linkage in one posture: symbols where they are."""

from __future__ import annotations

import numpy as np

from flexmech.plots import linkage_symbols as symbols
from flexmech.plots.damper_symbols import dashpot, rotary_dashpot
from flexmech.plots.linkage_parts import LinkageParts, Posture
from flexmech.plots.linkage_symbols import OUTLINE, Symbol
from flexmech.plots.series import Look

BEARING: Look = {"ms": 7.0, "marker": "o", "mfc": "none", "mec": OUTLINE, "mew": 0.6, "zorder": 3.9}
# Of the ring around a bearing with a damper over that without.
DAMPED = 1.4
# Over the linkage's extent: half the width of a spring between points and of the wall that holds
# it; radius of a spring and of a damper in a joint.
SPRING, WALL, SPIRAL, BENT = 0.018, 0.03, 0.04, 0.065


def spring_symbols(parts: LinkageParts, posture: Posture, size: float) -> list[Symbol]:
    """Springs and dampers between points; a damper is beside its spring.

    Parameters
    ----------
    parts : LinkageParts
    posture : Posture
    size : float
        Extent of the linkage in m.

    Returns
    -------
    list of Symbol
    """
    found, half = [], SPRING * size
    for spring in parts.springs:
        first, second = map(posture.spring_end, spring["ends"])
        if stiff := spring.get("stiff", True):
            found.append(symbols.zigzag(first, second, half))
        if spring.get("damped"):
            found.append(dashpot(first, second, half, beside=stiff))
    return found


def wall_symbols(parts: LinkageParts, posture: Posture, size: float) -> list[Symbol]:
    """What holds springs and dampers on the ground.

    Parameters
    ----------
    parts : LinkageParts
    posture : Posture
    size : float
        Extent of the linkage in m.

    Returns
    -------
    list of Symbol
    """
    found = []
    for spring in parts.springs:
        places = [posture.spring_end(end) for end in spring["ends"]]
        for end, place, other in zip(spring["ends"], places, places[::-1], strict=True):
            if "ground" in end and (length := np.hypot(*(place - other))):
                half = WALL * size
                found += symbols.wall(place, (place - other) / length, half, 0.6 * half)
    return found


def joint_spring_symbols(
    parts: LinkageParts, posture: Posture, size: float, mark_size: float
) -> list[Symbol]:
    """Springs and dampers in joints.

    Parameters
    ----------
    parts : LinkageParts
    posture : Posture
    size : float
        Extent of the linkage in m.
    mark_size : float
        Of the rings of bearings over the usual one.

    Returns
    -------
    list of Symbol
    """
    at = {joint["name"]: joint["at"] for joint in parts.joints}
    found = []
    for one in parts.joint_springs:
        place, ring = posture.place(at[one["joint"]]), mark_size * BEARING["ms"]
        if one["torsional"]:
            found.append(symbols.spiral(place, SPIRAL * size))
        if one["radial"]:
            found += symbols.marks("bearing", [place], BEARING | {"ms": ring})
        if one.get("torsion_damped"):
            found.append(rotary_dashpot(place, BENT * size))
        if one.get("radially_damped"):
            found += symbols.marks("damped bearing", [place], BEARING | {"ms": DAMPED * ring})
    return found
