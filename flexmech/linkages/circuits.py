"""Circuits of a four-bar linkage: the positions it reaches without being taken apart."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Literal

from flexmech.errors import InputError
from flexmech.linkages.fourbar import FourBar

Circuit = Literal["open", "crossed", "upper", "lower", "whole"]
CrankMotion = Literal["turns", "swings in two ranges", "swings in one range"]


@lru_cache(maxsize=16)
def crank_motion(linkage: FourBar) -> CrankMotion:
    """How the crank moves, which tells the circuits apart.

    Parameters
    ----------
    linkage : FourBar

    Returns
    -------
    {"turns", "swings in two ranges", "swings in one range"}
        A full turn on either branch (crank-rocker and double-crank); between limits on either
        side of the ground's line, over both branches (double-rocker and rocker-crank); or over
        both branches between limits on one circuit (triple-rocker).

    Raises
    ------
    InputError
        If the linkage has a change point, where circuits meet.
    """
    grashof_class = linkage.grashof_class
    if grashof_class == "change-point":
        raise InputError(
            "the linkage has a change point (shortest and longest link together are as long as "
            "the other two): its circuits meet there and are not told apart; change a link "
            "length slightly"
        )
    if grashof_class in ("crank-rocker", "double-crank"):
        return "turns"
    return "swings in one range" if grashof_class == "triple-rocker" else "swings in two ranges"


def circuit_of(linkage: FourBar, crank_angle: float | None = None) -> Circuit:
    """Name of the circuit in which a linkage moves.

    Parameters
    ----------
    linkage : FourBar
    crank_angle : float, optional
        A crank angle of the circuit in rad, where the crank swings within two ranges; without
        it the one above the ground's line is meant. Otherwise without effect.

    Returns
    -------
    {"open", "crossed", "upper", "lower", "whole"}
        The branch of a crank that turns fully, the side of the ground's line of one that swings
        in two ranges, or the only circuit.

    Raises
    ------
    InputError
        If the linkage has a change point or cannot be assembled at the crank angle.
    """
    motion = crank_motion(linkage)
    if motion == "turns":
        return linkage.branch
    if motion == "swings in one range":
        return "whole"
    if crank_angle is None:
        return "upper"
    linkage.transmission_angle(crank_angle)
    return "upper" if math.sin(crank_angle) > 0 else "lower"


def circuit_of_position(
    linkage: FourBar, motion: CrankMotion, pin: tuple[float, float], coupler_angle: float
) -> Circuit:
    """Name of the circuit to which a position of the linkage belongs.

    Parameters
    ----------
    linkage : FourBar
        Its branch is without effect.
    motion : {"turns", "swings in two ranges", "swings in one range"}
        As :func:`crank_motion` gives it.
    pin : tuple of two floats
        Place of pin A in m.
    coupler_angle : float
        Angle theta3 in rad.

    Returns
    -------
    {"open", "crossed", "upper", "lower", "whole"}
    """
    if motion == "turns":
        to_o4 = linkage.ground - pin[0]
        left = to_o4 * math.sin(coupler_angle) + pin[1] * math.cos(coupler_angle)
        return "open" if left > 0 else "crossed"
    if motion == "swings in two ranges":
        return "upper" if pin[1] > 0 else "lower"
    return "whole"
