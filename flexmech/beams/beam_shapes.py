"""Displacement inside two-node plane beam elements: Euler-Bernoulli, Timoshenko, Reddy.

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

from flexmech.beams.interpolation import hermite, hermite_integral, linear, placed
from flexmech.sections import BeamSection
from flexmech.types import FloatArray

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
        Coordinates of a node that a clamp holds besides its displacement.
    warping : tuple of int
        Coordinates of a node that a joint holds because its pin's fitting keeps the
        cross-section plane.
    stiff_in_shear : bool
        Whether the section's rotation is the slope of the axis.
    curvature : int, optional
        Which of a node's coordinates is the curvature; None where elements share none.
    """

    per_node: int
    angles: tuple[int, ...]
    clamped: tuple[int, ...]
    warping: tuple[int, ...] = ()
    stiff_in_shear: bool = False
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
        """Distance of the neutral axis that turns with each of :attr:`angles`, in m."""
        return (section.neutral_axis,)

    def arc(self, section: BeamSection, length: FloatArray) -> FloatArray:
        """Node coordinates other than displacements of elements bent without load.

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
        """How much of the squared shear angle tension takes off the squared slope.

        Parameters
        ----------
        section : BeamSection

        Returns
        -------
        float
            Without unit.
        """
        return 0.0


class EulerBernoulli(BeamShapes):
    """Coordinates (u, v, phi): sections stay normal to the axis, cubic deflection."""

    per_node = 3
    angles = (2,)
    clamped = (2,)
    stiff_in_shear = True

    def fields(self, fraction: FloatArray, length: FloatArray, section: BeamSection) -> BeamFields:
        """See :class:`BeamShapes`."""
        axial, stretch = linear(fraction, length, 6)
        cubic = hermite(fraction, length, 2)
        deflection, slope, bend = (placed(h, (1, 2, 4, 5), 6) for h in cubic)
        none = np.zeros((1, *bend.shape))
        return BeamFields(axial, deflection, slope, slope, stretch, bend, none, none)

    def strain_stiffness(self, section: BeamSection) -> FloatArray:
        """See :class:`BeamShapes`."""
        return np.diag([section.axial_stiffness, section.bending_stiffness, 0.0, 0.0])

    def inertia(self, section: BeamSection) -> FloatArray:
        """See :class:`BeamShapes`: all mass is on the line through the centres of mass."""
        return _inertia_of_the_mass_axis(section)


class Timoshenko(BeamShapes):
    """Coordinates (u, v, phi, phi'): shear deformation and rotary inertia.

    The rotation is cubic, with the curvature at the nodes; the shear angle varies as the
    equilibrium of the element wants it, ``kGA (v' - phi) = -EI phi''``, up to a constant that
    the deflections of the nodes settle. No locking, static solutions of beams loaded at
    nodes are exact, and the slope of the axis may jump where a point mass makes the shear
    force jump. The common element with three coordinates a node (Przemieniecki, *Theory of
    Matrix Structural Analysis*, 1968, sec. 5.6) converges in second order only, because its
    shear angle is constant.

    Tension acts along the section's normal, as in geometrically exact beams (Reissner 1972;
    Haringx' column), not along the axis (Engesser's).
    """

    per_node = 4
    angles = (2,)
    clamped = (2,)
    curvature = 3

    def fields(self, fraction: FloatArray, length: FloatArray, section: BeamSection) -> BeamFields:
        """See :class:`BeamShapes`."""
        s, h = fraction, length[:, None]
        turning, ends = (2, 3, 6, 7), (1, 5)
        axial, stretch = linear(s, length, 8)
        rotation, curvature, second, third = (placed(f, turning, 8) for f in hermite(s, length))
        integral = placed(hermite_integral(s, length), turning, 8)
        mean = placed(hermite_integral(np.ones_like(s), length) / h, turning, 8)
        start = placed(np.ones((len(s), 1)), (3,), 8)
        mean_second = placed(np.stack([-1 / length, 1 / length], axis=-1), (3, 7), 8)
        chord = placed(np.stack([-1 / length, 1 / length], axis=-1), ends, 8)
        soft = section.bending_stiffness / section.shear_stiffness
        constant = chord - mean + soft * mean_second
        x = (s * length)[:, None]
        deflection = integral - soft * (curvature - start) + x * constant
        deflection[:, 1] += 1.0
        shear, change = constant - soft * second, -soft * third
        return BeamFields(
            axial,
            deflection,
            rotation,
            rotation + shear,
            stretch,
            curvature,
            shear[None],
            change[None],
        )

    def strain_stiffness(self, section: BeamSection) -> FloatArray:
        """See :class:`BeamShapes`."""
        return np.diag(
            [section.axial_stiffness, section.bending_stiffness, 0.0, section.shear_stiffness]
        )

    def inertia(self, section: BeamSection) -> FloatArray:
        """See :class:`BeamShapes`: with rotary inertia."""
        inertia = _inertia_of_the_mass_axis(section)
        inertia[1, 1] += section.rotary_inertia
        return inertia

    def softening(self, section: BeamSection) -> float:
        """See :class:`BeamShapes`.

        A stretch lambda under a shear angle gamma strains the section's normal by
        ``lambda cos(gamma) - 1`` and shears it by ``lambda sin(gamma)``: to first order in
        the tension N, its energy changes by ``N gamma^2 (kGA / EA - 1 / 2)``.
        """
        return 1.0 - 2.0 * section.shear_stiffness / section.axial_stiffness


class Reddy(BeamShapes):
    """Coordinates (u, v, phi, s, phi'): third-order shear deformation, Bickford's beam.

    Axial displacements vary with the cube of the distance from the axis, so that the shear
    stress vanishes at the surfaces (Bickford 1982; Reddy 1984). Deflection and rotation are
    both cubic in each element, with slope and curvature at the nodes: no locking.
    """

    per_node = 5
    angles = (2, 3)
    clamped = (2, 3)
    curvature = 4

    def fields(self, fraction: FloatArray, length: FloatArray, section: BeamSection) -> BeamFields:
        """See :class:`BeamShapes`."""
        axial, stretch = linear(fraction, length, 10)
        cubic = hermite(fraction, length, 2)
        deflection, slope, slope_change = (placed(h, (1, 3, 6, 8), 10) for h in cubic)
        rotation, curvature, _ = (placed(h, (2, 4, 7, 9), 10) for h in cubic)
        shear, change = slope - rotation, slope_change - curvature
        return BeamFields(
            axial, deflection, rotation, slope, stretch, curvature, shear[None], change[None]
        )

    def strain_stiffness(self, section: BeamSection) -> FloatArray:
        """See :class:`BeamShapes`."""
        third = section.third_order
        cubic = third.cubic_factor
        axial, along = third.stiffness[0, 0], third.stiffness[0, 1:]
        # The strains are e0 - y phi' - y^3 c (s' - phi'), with e0 as no axial force has it.
        bending = third.stiffness[1:, 1:] - np.outer(along, along) / axial
        scale = np.array([1.0, cubic])
        stiffness = np.zeros((4, 4))
        stiffness[0, 0], stiffness[3, 3] = axial, third.shear_force_stiffness
        stiffness[1:3, 1:3] = bending * np.outer(scale, scale)
        return stiffness

    def inertia(self, section: BeamSection) -> FloatArray:
        """See :class:`BeamShapes`; Elamy et al. 2023, eq. 44, with c = -4 / (3 h^2) corrected."""
        moment, cubic = section.third_order.inertia, section.third_order.cubic_factor
        upper = np.array(
            [
                [moment[0], -moment[1], -cubic * moment[3]],
                [0.0, moment[2], cubic * moment[4]],
                [0.0, 0.0, cubic**2 * moment[6]],
            ]
        )
        return np.asarray(upper + np.triu(upper, 1).T)

    def arms(self, section: BeamSection) -> tuple[float, ...]:
        """See :class:`BeamShapes`: part of the arm turns with the slope of the axis."""
        stiffness = section.third_order.stiffness
        # N = A e0 - B phi' - c E (s' - phi') vanishes for e0 = n phi' + m (s' - phi').
        sheared = section.third_order.cubic_factor * stiffness[0, 2] / stiffness[0, 0]
        return (float(stiffness[0, 1] / stiffness[0, 0] - sheared), float(sheared))


def _inertia_of_the_mass_axis(section: BeamSection) -> FloatArray:
    arm = np.array([1.0, -section.mass_axis, 0.0])
    return np.asarray(section.mass_per_length * np.outer(arm, arm))
