"""Shear of Exudyn's geometrically exact beam, such that its element is that of a bent beam.

The element is linear, with its strains taken in the middle. Where the nodes of an element turn
alike, its one strain is the shear, but a beam between these nodes bends besides, one way and
back. Its flexibility is that of shear plus that of this bending (the residual bending
flexibility of MacNeal, A simple quadrilateral shell element, Computers & Structures 8 (1978)
175-183; Hughes, The Finite Element Method, 1987, sec. 5.4). With it the stiffness of a
straight element is the exact one of Timoshenko's theory, for loads at nodes.
"""

from __future__ import annotations

import numpy as np

from flexmech.sections import BeamSection
from flexmech.types import FloatArray


def element_shear_stiffness(section: BeamSection, length: FloatArray) -> FloatArray:
    """Shear stiffness of elements, ``1 / (1 / kGA + h^2 / (12 EI))``.

    Parameters
    ----------
    section : BeamSection
    length : ndarray, shape (e,)
        Of the elements in m.

    Returns
    -------
    ndarray, shape (e,)
        In N. What it strains is the shear angle of the section and the bending of the element
        together; their common shear force is right.
    """
    shearing, bending = _flexibilities(section, length)
    return np.asarray(1 / (shearing + bending))


def element_shear_damping_time(section: BeamSection, length: FloatArray) -> FloatArray:
    """Kelvin-Voigt time of that stiffness.

    Of both flexibilities, each with its own time: under one shear force their rates add up,
    and so do the losses.

    Parameters
    ----------
    section : BeamSection
    length : ndarray, shape (e,)
        Of the elements in m.

    Returns
    -------
    ndarray, shape (e,)
        In s.
    """
    shearing, bending = _flexibilities(section, length)
    times = section.damping
    return np.asarray((times.shear * shearing + times.bending * bending) / (shearing + bending))


def _flexibilities(section: BeamSection, length: FloatArray) -> tuple[float, FloatArray]:
    """Angle by unit shear force, from shear and from bending, in rad/N."""
    bending = np.asarray(length**2 / (12 * section.bending_stiffness))
    return 1 / section.shear_stiffness, bending
