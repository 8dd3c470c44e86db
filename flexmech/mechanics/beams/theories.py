"""Plane beam theories as shape functions: Euler-Bernoulli, Timoshenko, Reddy, zigzag.

Every element moves by four fields along it: the displacement of its neutral axis along the
link, the deflection v, the rotation phi of its sections and the slope s = v' of its axis.
What they strain is the axial strain, the curvature phi', the shear angle s - phi and, in
the third-order theory, the change of the shear angle along the beam. All coordinates are those of
the pins' axis. Where the neutral axis is off it, its nodes are moved by rigid arms that turn with
the sections.

The faces of a sandwich bend about their own axes where its shear angle changes: next to joints
that keep the cross-section plane, and at jumps of the shear force. Such a layer falls off over
the length ``sqrt(E G^2 / kGA)``, mostly shorter than an element, so that elements of polynomials
converge slowly. Zigzag beams have the exponentials of these layers among the shapes of the shear
angle: static solutions of beams loaded at nodes are exact, as those of Timoshenko's are.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Self

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.sections import WARPINGS, BeamSection


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


def diagonal_matrix(*entries: FloatArray | float) -> FloatArray:
    """Matrices (..., k, k) with k entries (...) on their diagonals."""
    every = np.stack(np.broadcast_arrays(*entries), axis=-1)
    return every[..., None] * np.eye(len(entries))


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
        ndarray, shape (..., 2 + 2 w, 2 + 2 w)
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
        ndarray, shape (..., 2 + w, 2 + w)
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
            Length of the elements in m.

        Returns
        -------
        ndarray, shape (e, 2 (p - 2))
            Rotations of the first node in rad, then of the second.
        """
        inner = np.arange(2, self.per_node)
        is_angle = np.isin(inner, self.angles)
        turned = section.free_curvature * length[:, None] / 2 * is_angle
        # What neither turns nor warps the section is its curvature at the node.
        bends = ~is_angle & ~np.isin(inner, self.warping)
        bent = section.free_curvature * bends
        return np.concatenate([bent - turned, bent + turned], axis=1)

    def quadrature(self, length: FloatArray, section: BeamSection) -> tuple[FloatArray, FloatArray]:
        """Places and weights that integrate every product of two fields.

        Parameters
        ----------
        length : ndarray, shape (..., e)
            Length of the elements in m.
        section : BeamSection

        Returns
        -------
        fraction : ndarray, shape (..., e, g)
            Place in the element from 0 to 1.
        weight : ndarray, shape (..., e, g)
            In m.
        """
        places = np.broadcast_to((_POINTS + 1) / 2, (*length.shape, len(_POINTS)))
        return places, length[..., None] / 2 * _WEIGHTS

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


# Below this exponent over half an element, exponentials are taken by their series, which is within
# 1e-13 with so many terms; their differences have lost three digits there already.
SMALL = 0.5
TERMS = 6
# Points of each part of an element, and over how many lengths of fall-off the outer parts reach.
_LAYER_POINTS, _LAYER_WEIGHTS = np.polynomial.legendre.leggauss(8)
# Squares of what has fallen off by exp(-10) are 2e-9 of those at the joint, and so many points
# integrate the squares of what has not within 3e-5.
REACH = 10.0


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
        return diagonal_matrix(section.axial_stiffness, section.bending_stiffness, 0.0, 0.0)

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
        return diagonal_matrix(
            section.axial_stiffness, section.bending_stiffness, 0.0, section.shear_stiffness
        )

    def inertia(self, section: BeamSection) -> FloatArray:
        """See :class:`BeamShapes`: with rotary inertia."""
        inertia = _inertia_of_the_mass_axis(section)
        inertia[..., 1, 1] += section.rotary_inertia
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
    return np.multiply.outer(section.mass_per_length, np.outer(arm, arm))


@dataclass(frozen=True)
class BoundaryLayers:
    """Functions of t in [-1, 1] of the boundary layers of an element.

    Parameters
    ----------
    rise : ndarray, shape (s,)
        Mean of ``1 - cosh(k t) / cosh(k)``.
    bubble : ndarray, shape (3, s)
        ``1 - cosh(k t) / cosh(k)`` over its mean, its integral from -1 and its derivative.
    odd : ndarray, shape (3, s)
        ``sinh(k t) / sinh(k)``, likewise.
    gap : ndarray, shape (3, s)
        ``t - odd``, likewise.
    """

    rise: FloatArray
    bubble: FloatArray
    odd: FloatArray
    gap: FloatArray

    @classmethod
    def of(cls, t: FloatArray, k: FloatArray) -> Self:
        """At places t with the exponents k, of half an element over the fall-off length."""
        small = k < SMALL
        direct, series = cls._direct(t, np.where(small, 1.0, k)), cls._series(t, k)
        pairs = zip(vars(direct).values(), vars(series).values(), strict=True)
        return cls(*(np.where(small, by_series, exact) for exact, by_series in pairs))

    @classmethod
    def _direct(cls, t: FloatArray, k: FloatArray) -> Self:
        # 1 - cosh(kt)/cosh(k) and sinh(kt)/sinh(k) by exponentials that do not overflow.
        shortfall = np.expm1(-k * (1 + t)) * np.expm1(-k * (1 - t)) / (1 + np.exp(-2 * k))
        size = np.abs(t)
        odd = np.exp(-k * (1 - size)) * np.expm1(-2 * k * size) / np.expm1(-2 * k) * np.sign(t)
        tanh = np.tanh(k)
        mean = 1 - tanh / k
        integral = 1 + t - tanh / k * (1 + odd)
        bubble = np.stack([shortfall, integral, -k * tanh * odd]) / mean
        odds = np.stack([odd, -shortfall / (k * tanh), k * (1 - shortfall) / tanh])
        return cls(mean, bubble, odds, cls._straight(t) - odds)

    @classmethod
    def _series(cls, t: FloatArray, k: FloatArray) -> Self:
        k = np.minimum(k, SMALL)
        even = np.zeros((4, *t.shape))
        gap = np.zeros((4, *t.shape))
        for n in range(1, TERMS + 1):
            # Powers of k less those that bubble and gap have in common: only ratios count.
            a = k ** (2 * n - 2) / math.factorial(2 * n)
            even[0] += a * (1 - t ** (2 * n))
            even[1] += a * (1 + t - (1 + t ** (2 * n + 1)) / (2 * n + 1))
            even[2] -= a * 2 * n * t ** (2 * n - 1)
            even[3] += a * (1 - 1 / (2 * n + 1))
            b = k ** (2 * n) / math.factorial(2 * n + 1)
            gap[0] += b * (t - t ** (2 * n + 1))
            gap[1] += b * ((t**2 - 1) / 2 - (t ** (2 * n + 2) - 1) / (2 * n + 2))
            gap[2] += b * (1 - (2 * n + 1) * t ** (2 * n))
            gap[3] += b
        bubble, gaps = even[:3] / even[3], gap[:3] / (1 + gap[3])
        rise = k**2 * even[3] / np.cosh(k)
        return cls(rise, bubble, cls._straight(t) - gaps, gaps)

    @staticmethod
    def _straight(t: FloatArray) -> FloatArray:
        """Value, integral from -1 and derivative of the function t."""
        return np.stack([t, (t**2 - 1) / 2, np.ones_like(t)])


class ZigzagBeam(Timoshenko):
    """Coordinates (u, v, phi, phi', gamma_1, gamma_2): cross-sections that warp.

    Rotation and shear force are those of :class:`Timoshenko`. The shear angle has a part for each
    warping of the section (:mod:`flexmech.sections.beam_reduction`), which is continuous and whose
    change along the link meets a stiffness of its own. At joints the pin's fitting keeps the
    cross-section plane: there the parts are zero. Tension acts along the slope of the axis, as
    the faces that carry it do (Engesser's column; Bazant & Cedolin, *Stability of Structures*,
    sec. 1.7).
    """

    per_node = 4 + WARPINGS
    angles = (2,)
    clamped = (2,)
    warping = tuple(range(4, 4 + WARPINGS))

    def fields(self, fraction: FloatArray, length: FloatArray, section: BeamSection) -> BeamFields:
        """See :class:`BeamShapes`."""
        s, h, p = fraction, length[:, None], self.per_node
        turning = (2, 3, p + 2, p + 3)
        axial, stretch = linear(s, length, 2 * p)
        rotation, curvature, _, third = (placed(f, turning, 2 * p) for f in hermite(s, length))
        turned = placed(hermite_integral(s, length), turning, 2 * p)
        mean = placed(hermite_integral(np.ones_like(s), length) / h, turning, 2 * p)
        chord = placed(np.stack([-1 / length, 1 / length], axis=-1), (1, p + 1), 2 * p)
        bending = section.bending_stiffness / section.shear_stiffness
        zigzag = section.zigzag
        layers = [BoundaryLayers.of(2 * s - 1, length / (2 * reach)) for reach in zigzag.fall_off]
        sums = [self._node_angles(number, 0.5) for number in range(WARPINGS)]
        # The shear force is what the mean of the shear angle leaves: springs in series.
        softness = np.stack([f * x.rise for f, x in zip(zigzag.flexibility, layers, strict=True)])
        free = chord - mean
        for layer, both in zip(layers, sums, strict=True):
            free = free - (1 - layer.rise)[:, None] * both
        share = softness / softness.sum(axis=0)
        # Value, integral from the start, and derivative of one function.
        one, parts = np.stack([np.ones_like(s), 2 * s, np.zeros_like(s)]), []
        for number, layer in enumerate(layers):
            both, across = sums[number], self._node_angles(number, -0.5)
            given = -zigzag.flexibility[number] * bending * h / 2 * third
            amounts = np.stack(
                [share[number][:, None] * free]
                + [np.broadcast_to(x, free.shape) for x in (both, across)]
                + [given]
            )
            rest = one - layer.rise * layer.bubble
            factors = np.stack([layer.bubble, rest, layer.odd, layer.gap])
            parts.append(np.einsum("aks,asi->ksi", factors, amounts))
        shears, integrals, slopes = np.stack(parts, axis=1)
        deflection = turned + h / 2 * integrals.sum(axis=0)
        deflection[:, 1] += 1.0
        return BeamFields(
            axial,
            deflection,
            rotation,
            rotation + shears.sum(axis=0),
            stretch,
            curvature,
            shears,
            2 / h * slopes,
        )

    def strain_stiffness(self, section: BeamSection) -> FloatArray:
        """See :class:`BeamShapes`."""
        zigzag = section.zigzag
        shear = section.shear_stiffness / zigzag.flexibility
        axes = [section.axial_stiffness, section.bending_stiffness]
        return np.diag(np.concatenate([axes, shear * zigzag.fall_off**2, shear]))

    def inertia(self, section: BeamSection) -> FloatArray:
        """See :class:`BeamShapes`: with the inertia of the warping."""
        zigzag, mass = section.zigzag, section.mass_per_length
        inertia = np.zeros((2 + WARPINGS, 2 + WARPINGS))
        inertia[:2, :2] = super().inertia(section)[:2, :2]
        inertia[0, 2:] = inertia[2:, 0] = mass * zigzag.along
        inertia[1, 2:] = inertia[2:, 1] = -mass * zigzag.turning
        inertia[2:, 2:] = mass * zigzag.square
        return inertia

    def softening(self, section: BeamSection) -> float:
        """See :class:`BeamShapes`: none, the faces carry the tension along the axis."""
        return 0.0

    def quadrature(self, length: FloatArray, section: BeamSection) -> tuple[FloatArray, FloatArray]:
        """See :class:`BeamShapes`: denser where the boundary layers are."""
        short, long = np.sort(section.zigzag.fall_off)[[0, -1]]
        outer = np.minimum(0.5, REACH * long / length)
        inner = np.minimum(outer / 2, REACH * short / length)
        edges = np.stack([0 * outer, inner, outer, 1 - outer, 1 - inner, 1 + 0 * outer], axis=1)
        middle, half = (edges[:, 1:] + edges[:, :-1]) / 2, np.diff(edges, axis=1) / 2
        places = middle[..., None] + half[..., None] * _LAYER_POINTS
        weights = half[..., None] * _LAYER_WEIGHTS * length[:, None, None]
        return places.reshape(len(length), -1), weights.reshape(len(length), -1)

    def _node_angles(self, number: int, first: float) -> FloatArray:
        """Half the sum of one shear angle at both nodes, or of second less first; (2 p,)."""
        row = np.zeros(2 * self.per_node)
        row[4 + number], row[self.per_node + 4 + number] = first, 0.5
        return row
