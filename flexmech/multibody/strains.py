"""Strains of Exudyn's beam elements in their strain energy, for whole runs at once.

By displacements from the straight link, not by places: strains of 1e-9 keep their digits, which the
difference of two lengths would lose to round-off.

Shear of Exudyn's geometrically exact beam, such that its element is that of a bent beam.

The element is linear, with its strains taken in the middle. Where the nodes of an element turn
alike, its one strain is the shear, but a beam between these nodes bends besides, one way and
back. Its flexibility is that of shear plus that of this bending (the residual bending
flexibility of MacNeal, A simple quadrilateral shell element, Computers & Structures 8 (1978)
175-183; Hughes, The Finite Element Method, 1987, sec. 5.4). With it the stiffness of a
straight element is the exact one of Timoshenko's theory, for loads at nodes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.sections import BeamSection


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
    """Shear flexibilities: angle by unit shear force, from shear and bending, in rad/N."""
    bending = np.asarray(length**2 / (12 * section.bending_stiffness))
    return 1 / section.shear_stiffness, bending


# Exudyn integrates a cable's axial strain to order 9 and its curvature to order 5.
# So many of Gauss's points do the same: 2 n - 1.
AXIAL_POINTS = 5
BENDING_POINTS = 3
# Slope vector of the straight link, for each of many points.
ALONG = np.array([1.0, 0.0])[:, None, None, None]


@dataclass(frozen=True)
class Strain:
    """One strain of a chain of elements at their integration points.

    Parameters
    ----------
    value, rate : ndarray, shape (m, e, g)
        Axial strain, shear angle or curvature (1/m) and its time derivative.
    weight : ndarray, shape (e, g)
        Stiffness times the integration weight of the point in m: half of it times the strain
        squared is the strain energy in J.
    damping_time : float or ndarray, shape (e,)
        Kelvin-Voigt time of this strain in s.
    """

    value: FloatArray
    rate: FloatArray
    weight: FloatArray
    damping_time: float | FloatArray

    @property
    def energy(self) -> FloatArray:
        """Strain energy in J, shape (m,)."""
        return np.asarray(np.einsum("meg,meg,eg->m", self.value, self.value, self.weight) / 2)

    @property
    def power(self) -> FloatArray:
        """Power of the elastic stress in W, the rate of :attr:`energy`; (m,)."""
        return np.asarray(np.einsum("meg,meg,eg->m", self.value, self.rate, self.weight))

    @property
    def dissipation(self) -> FloatArray:
        """Dissipated power of Kelvin-Voigt damping in W, shape (m,)."""
        power = np.einsum("meg,meg,eg->me", self.rate, self.rate, self.weight)
        return np.asarray((self.damping_time * power).sum(axis=1))


def cable_strains(
    displacement: FloatArray, rate: FloatArray, length: FloatArray, section: BeamSection
) -> list[Strain]:
    """Stretch ``|r'| - 1`` and curvature ``r' x r'' / |r'|**2`` of ``ObjectANCFCable2D``.

    Parameters
    ----------
    displacement, rate : ndarray, shape (m, 4 (e + 1))
        Of the nodes' positions and slope vectors from the straight link along x, and their time
        derivatives.
    length : ndarray, shape (e,)
        Of the undeformed elements in m.
    section : BeamSection

    Returns
    -------
    list of Strain
    """
    points, weights = np.polynomial.legendre.leggauss(AXIAL_POINTS)
    first = _cubic_derivatives(points, length)[0]
    turned, slope_rate = _interpolated(displacement, first), _interpolated(rate, first)
    slope = turned + ALONG
    norm = np.sqrt(_dot(slope, slope))
    stretch = Strain(
        # |r'| - 1 = (|r'|^2 - 1) / (|r'| + 1)
        value=(2 * turned[0] + _dot(turned, turned)) / (norm + 1) - section.free_strain,
        rate=_dot(slope, slope_rate) / norm,
        weight=section.axial_stiffness * length[:, None] / 2 * weights,
        damping_time=section.damping.axial,
    )
    points, weights = np.polynomial.legendre.leggauss(BENDING_POINTS)
    first, second = _cubic_derivatives(points, length)
    slope, slope_rate = _interpolated(displacement, first) + ALONG, _interpolated(rate, first)
    bend, bend_rate = _interpolated(displacement, second), _interpolated(rate, second)
    square = _dot(slope, slope)
    curvature = _cross(slope, bend) / square
    change = _cross(slope_rate, bend) + _cross(slope, bend_rate)
    bending = Strain(
        value=curvature - section.free_curvature,
        rate=(change - 2 * curvature * _dot(slope, slope_rate)) / square,
        weight=section.bending_stiffness * length[:, None] / 2 * weights,
        damping_time=section.damping.bending,
    )
    return [stretch, bending]


def exact_beam_strains(
    displacement: FloatArray, rate: FloatArray, length: FloatArray, section: BeamSection
) -> list[Strain]:
    """Stretch, shear and curvature of the linear ``ObjectBeamGeometricallyExact2D``.

    All three in the middle of the element, its one integration point. The shear contains what
    the element bends one way and back; see :mod:`flexmech.multibody.strains`.

    Parameters
    ----------
    displacement, rate : ndarray, shape (m, 3 (e + 1))
        Of the nodes from the straight link along x, with their rotations, and their time
        derivatives.
    length : ndarray, shape (e,)
        Of the undeformed elements in m.
    section : BeamSection

    Returns
    -------
    list of Strain
    """
    nodes, node_rates = (v.reshape(len(v), -1, 3) for v in (displacement, rate))
    turn = (nodes[:, 1:, 2] + nodes[:, :-1, 2]) / 2
    spin = (node_rates[:, 1:, 2] + node_rates[:, :-1, 2]) / 2
    slope = np.moveaxis(np.diff(nodes, axis=1) / length[:, None], -1, 0)
    slope_rate = np.moveaxis(np.diff(node_rates, axis=1) / length[:, None], -1, 0)
    along = np.stack([np.cos(turn), np.sin(turn)])
    across = np.stack([-np.sin(turn), np.cos(turn)])
    # (e_x + u') . along = 1 + stretch, with cos(turn) - 1 = -2 sin(turn / 2)^2.
    stretch = _dot(slope, along) - 2 * np.sin(turn / 2) ** 2
    shear = _dot(slope, across) - np.sin(turn)
    damping, bend = section.damping, slope[2] - section.free_curvature
    stretching = _dot(slope_rate, along) + spin * shear
    shearing = _dot(slope_rate, across) - spin * (1 + stretch)
    return [
        Strain(value[..., None], change[..., None], (stiffness * length)[:, None], time)
        for value, change, stiffness, time in (
            (stretch, stretching, section.axial_stiffness, damping.axial),
            (
                shear,
                shearing,
                element_shear_stiffness(section, length),
                element_shear_damping_time(section, length),
            ),
            (bend, slope_rate[2], section.bending_stiffness, damping.bending),
        )
    ]


def _cubic_derivatives(points: FloatArray, length: FloatArray) -> tuple[FloatArray, FloatArray]:
    """First and second derivatives of the cubics at points (g,) from -1 to 1, (e, g, 4)."""
    s = (points + 1) / 2
    first = np.stack([6 * s**2 - 6 * s, 1 - 4 * s + 3 * s**2, 6 * s - 6 * s**2, 3 * s**2 - 2 * s])
    second = np.stack([12 * s - 6, 6 * s - 4, 6 - 12 * s, 6 * s - 2])
    h = length[:, None, None]
    unit = np.ones_like(h)
    # A displacement's derivative is divided by the length once more than a slope's.
    scale = np.concatenate([1 / h, unit, 1 / h, unit], axis=-1)
    return first.T * scale, second.T * scale / h


def _interpolated(chain: FloatArray, shapes: FloatArray) -> FloatArray:
    """Vectors (2, m, e, g) from nodal positions and slopes (m, 4 (e + 1)).

    Of both components by one product with all shapes, which are few.
    """
    elements, points = shapes.shape[:2]
    matrix = np.zeros((elements + 1, 2, elements, points))
    for number, shape in enumerate(shapes):
        matrix[number : number + 2, :, number] = shape.T.reshape(2, 2, points)
    flat = matrix.reshape(2 * (elements + 1), -1)
    parts = [np.ascontiguousarray(chain[:, axis::2]) @ flat for axis in range(2)]
    return np.stack(parts).reshape(2, len(chain), elements, points)


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[0] * b[0] + a[1] * b[1])


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[0] * b[1] - a[1] * b[0])
