"""Plane beam theories as shape functions: Euler-Bernoulli, Timoshenko, Reddy."""

from __future__ import annotations

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.beams.beam_shapes import (
    BeamFields,
    BeamShapes,
    hermite,
    hermite_integral,
    linear,
    placed,
)
from flexmech.sections import BeamSection


class EulerBernoulli(BeamShapes):
    """Coordinates (u, v, phi): sections stay normal to the axis, cubic deflection."""

    per_node = 3
    angles = (2,)
    clamped = (2,)
    stiff_in_shear = True
    has_rotary_inertia = False

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
    the deflections of the nodes determine. No locking, static solutions of beams loaded at
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
    return section.mass_per_length * np.outer(arm, arm)
