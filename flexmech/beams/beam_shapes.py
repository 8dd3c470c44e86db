"""Shape functions of two-node plane beam elements: the interface of all theories.

Every element moves by four fields along it: the displacement of its neutral axis along the
link, the deflection v, the rotation phi of its sections and the slope s = v' of its axis.
What they strain is the axial strain, the curvature phi', the shear angle s - phi and, in
the third-order theory, the change of the shear angle along the beam.

All coordinates are those of the pins' axis. Where the neutral axis is off it, its nodes are
moved by rigid arms that turn with the sections.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.sections import BeamSection


def hermite(s: FloatArray, length: FloatArray, derivatives: int = 3) -> tuple[FloatArray, ...]:
    """Cubic with end values and slopes, and its first derivatives.

    Parameters
    ----------
    s, length : ndarray, shape (m,)
        Places from 0 to 1, and lengths of the elements in m.
    derivatives : int
        How many of them.

    Returns
    -------
    tuple of ndarray, shape (m, 4)
    """
    powers = np.stack([np.ones_like(s), s, s**2, s**3], axis=-1)
    scale = np.ones((len(s), 4))
    scale[:, 1] = scale[:, 3] = length
    shapes = []
    for order in range(derivatives + 1):
        shapes.append(powers @ _HERMITE[order] * scale)
        scale = scale / length[:, None]
    return tuple(shapes)


# Coefficients of 1, s, s^2 and s^3 (rows) of the four cubics (columns), and of their
# derivatives.
_CUBICS = np.array([[1.0, 0, 0, 0], [0, 1, 0, 0], [-3, -2, 3, -1], [2, 1, -2, 1]])
_DERIVATIVE = np.array([[0.0, 1, 0, 0], [0, 0, 2, 0], [0, 0, 0, 3], [0, 0, 0, 0]])
_HERMITE = [np.linalg.matrix_power(_DERIVATIVE, order) @ _CUBICS for order in range(4)]


def hermite_integral(s: FloatArray, length: FloatArray) -> FloatArray:
    """Integral of the cubic from the element's start; (s, 4)."""
    rows = [
        s - s**3 + s**4 / 2,
        s**2 / 2 - 2 * s**3 / 3 + s**4 / 4,
        s**3 - s**4 / 2,
        s**4 / 4 - s**3 / 3,
    ]
    one = np.ones_like(s)
    scale = np.stack([one, length, one, length], axis=-1)
    return np.stack(rows, axis=-1) * scale * length[:, None]


def placed(rows: FloatArray, columns: tuple[int, ...], size: int) -> FloatArray:
    """Rows at some of an element's coordinates, zero at the others.

    Parameters
    ----------
    rows : ndarray, shape (m, k)
    columns : tuple of int
        Where they belong, k of them.
    size : int
        Number of coordinates.

    Returns
    -------
    ndarray, shape (m, size)
    """
    full = np.zeros((len(rows), size))
    full[:, columns] = rows
    return full


def linear(fraction: FloatArray, length: FloatArray, size: int) -> tuple[FloatArray, FloatArray]:
    """Linear interpolation of the axial displacement, and its derivative.

    Parameters
    ----------
    fraction, length : ndarray, shape (m,)
        Places from 0 to 1, and lengths of the elements in m.
    size : int
        Number of an element's coordinates.

    Returns
    -------
    tuple of ndarray, shape (m, size)
    """
    value, slope = np.zeros((2, len(fraction), size))
    first, second = 0, size // 2
    value[:, first], value[:, second] = 1 - fraction, fraction
    slope[:, second] = 1 / length
    slope[:, first] = -slope[:, second]
    return value, slope


# Exact to degree 9; products of quartics, and of squared cubics with a quadratic tension, have 8.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(5)


@dataclass(frozen=True)
class BeamFields:
    """Fields inside elements at places, each of shape (..., 2 p): a row a place.

    Parameters
    ----------
    axial, deflection, rotation, slope : ndarray
        Displacement along at the neutral axis and across in m, rotation of the section and
        slope of the axis in rad.
    axial_strain, curvature : ndarray
        First derivatives of ``axial`` and ``rotation``.
    shears, shear_changes : ndarray, shape (w, ..., 2 p)
        Shear angles that together turn the axis against the section, one in most theories, and
        their derivatives along the beam in 1/m.
    """

    axial: FloatArray
    deflection: FloatArray
    rotation: FloatArray
    slope: FloatArray
    axial_strain: FloatArray
    curvature: FloatArray
    shears: FloatArray
    shear_changes: FloatArray

    @property
    def shear(self) -> FloatArray:
        """Shear angle of the axis."""
        return self.slope - self.rotation


class BeamShapes(ABC):
    """One kind of element: its coordinates a node and its shape functions.

    Attributes
    ----------
    per_node : int
        Coordinates a node; the first two are u and v, the third the section's rotation.
    angles : tuple of int
        Coordinates of a node that are angles.
    clamped : tuple of int
        Coordinates of a node that a clamp fixes besides its displacement.
    warping : tuple of int
        Coordinates of a node that a joint fixes because its pin's fitting keeps the
        cross-section plane.
    stiff_in_shear : bool
        Whether the section's rotation is the slope of the axis.
    has_rotary_inertia : bool
        Whether vibration has the rotary inertia of the sections; the rigid motion always has it.
    curvature : int, optional
        Which of a node's coordinates is the curvature; None where elements share none.
    """

    per_node: int
    angles: tuple[int, ...]
    clamped: tuple[int, ...]
    warping: tuple[int, ...] = ()
    stiff_in_shear: bool = False
    has_rotary_inertia: bool = True
    curvature: int | None = None

    @abstractmethod
    def fields(self, fraction: FloatArray, length: FloatArray, section: BeamSection) -> BeamFields:
        """Fields by the displacements of the neutral axis's nodes.

        Parameters
        ----------
        fraction, length : ndarray, shape (s,)
            Place in the element from 0 to 1, and the element's length in m.
        section : BeamSection

        Returns
        -------
        BeamFields
        """

    @abstractmethod
    def strain_stiffness(self, section: BeamSection) -> FloatArray:
        """Stiffness of the strains, about the neutral axis.

        Parameters
        ----------
        section : BeamSection

        Returns
        -------
        ndarray, shape (2 + 2 w, 2 + 2 w)
            By axial strain, curvature, changes of the w shear angles, and shear angles.
        """

    @abstractmethod
    def inertia(self, section: BeamSection) -> FloatArray:
        """Mass of the motion along the link, about the pins' axis.

        Parameters
        ----------
        section : BeamSection

        Returns
        -------
        ndarray, shape (2 + w, 2 + w)
            By displacement along, rotation and shear angles; its first entry is the mass per
            length, which the deflection moves too.
        """

    def arms(self, section: BeamSection) -> tuple[float, ...]:
        """Arm of the neutral axis that rotates with each of :attr:`angles`, in m."""
        return (section.neutral_axis,)

    def arc(self, section: BeamSection, length: FloatArray) -> FloatArray:
        """Node rotations of elements bent by free curvature, without load.

        Against their chords: the free curvature makes an arc of each element.

        Parameters
        ----------
        section : BeamSection
        length : ndarray, shape (e,)
            Of the elements in m.

        Returns
        -------
        ndarray, shape (e, 2 (p - 2))
            Of the first node, then of the second.
        """
        own = np.arange(2, self.per_node)
        is_angle = np.isin(own, self.angles)
        turned = section.free_curvature * length[:, None] / 2 * is_angle
        # What neither turns nor warps the section is its curvature at the node.
        bends = ~is_angle & ~np.isin(own, self.warping)
        bent = section.free_curvature * bends
        return np.concatenate([bent - turned, bent + turned], axis=1)

    def quadrature(self, length: FloatArray, section: BeamSection) -> tuple[FloatArray, FloatArray]:
        """Places and weights that integrate every product of two fields.

        Parameters
        ----------
        length : ndarray, shape (e,)
            Of the elements in m.
        section : BeamSection

        Returns
        -------
        fraction : ndarray, shape (e, g)
            Place in the element from 0 to 1.
        weight : ndarray, shape (e, g)
            In m.
        """
        places = np.broadcast_to((_POINTS + 1) / 2, (len(length), len(_POINTS)))
        return places, length[:, None] / 2 * _WEIGHTS

    def softening(self, section: BeamSection) -> float:
        """Coefficient of the squared shear angle in the work of the tension.

        Parameters
        ----------
        section : BeamSection

        Returns
        -------
        float
            Without unit.
        """
        return 0.0
