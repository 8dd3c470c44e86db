"""Stresses of pins and of the eyes around them, and what wears a bush.

Shigley's *Mechanical Engineering Design*, 9th ed.: sec. 8-12 on joints loaded in shear (bearing,
tension of the net section, shear-out of the edge), sec. 12-15 on boundary-lubricated bushes.
Stresses are mean ones of their areas: the concentration at the hole's edge and Hertz's pressure are
not in them. All functions take scalars or arrays of one shape.
"""

from __future__ import annotations

import math
from typing import TypeVar

from flexmech.arrays import FloatArray

Number = TypeVar("Number", float, FloatArray)

SHEAR_YIELD = 1 / math.sqrt(3)
"""Yield strength in shear over that in tension, by von Mises."""


def bearing_pressure(force: Number, diameter: float, thickness: float) -> Number:
    """Force over the projected area of a pin in its hole, F / (d t), in Pa.

    Parameters
    ----------
    force : float or ndarray
        In N.
    diameter : float
        Of the pin in m.
    thickness : float
        Length of the hole along the pin in m.

    Returns
    -------
    float or ndarray
    """
    return force / (diameter * thickness)


def net_tension(force: Number, width: float, diameter: float, thickness: float) -> Number:
    """Force over the two sides of an eye beside its hole, F / ((w - d) t), in Pa.

    Parameters
    ----------
    force : float or ndarray
        That pulls the pin away from the link in N.
    width : float
        Of the eye in m.
    diameter : float
    thickness : float

    Returns
    -------
    float or ndarray
    """
    return force / ((width - diameter) * thickness)


def shear_out(force: Number, edge_distance: float, diameter: float, thickness: float) -> Number:
    """Force over the two planes along which a pin tears out, F / (2 (e - d / 2) t), in Pa.

    The planes touch the hole's sides; they are counted from its edge on, and not from its centre,
    which is on the safe side.

    Parameters
    ----------
    force : float or ndarray
        That pulls the pin away from the link in N.
    edge_distance : float
        From the centre of the hole to the end of the link in m.
    diameter : float
    thickness : float

    Returns
    -------
    float or ndarray
    """
    return force / (2 * (edge_distance - diameter / 2) * thickness)


def pressure_velocity(force: Number, rate: Number, diameter: float, length: float) -> Number:
    """Bearing pressure times sliding velocity of a bush, F / (d L) times rate d / 2, in Pa m/s.

    Parameters
    ----------
    force : float or ndarray
        In N.
    rate : float or ndarray
        Size of the angular velocity of the pin in the bush in rad/s.
    diameter : float
        Of the pin in m.
    length : float
        Of the bush in m.

    Returns
    -------
    float or ndarray
    """
    return bearing_pressure(force, diameter, length) * (rate * (diameter / 2))
