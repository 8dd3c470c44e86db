"""From a laminate to a beam: what is free across the link, and the stiffness along it.

``narrow``: the stress resultants across the link and in shear of its plies vanish (plane
stress), and free edges let plies at different angles go
(:mod:`flexmech.sections.free_edges`); ``wide``: the strains across do (plane strain,
cylindrical bending). For Reddy's theory the higher-order resultants and strains are treated
alike.

Shear is spread through a section by equilibrium, by Reddy's theory, or as in the zigzag beam, whose
cross-sections warp as equilibrium asks. Bending that changes along the link
needs a shear stress through the thickness (Jourawski); in every layer the shear strain is that
stress over the layer's modulus. Its integral is the shape into which the cross-section warps:
kinked at each interface, steep in a soft layer, flat in a stiff one. Reddy's fixed cubic shears
all layers alike and is far too stiff where they differ. The stress along the link that this first
warping brings, where it changes, needs a shear stress in its turn, and so a second warping: with
two, each core of a stack with two soft cores shears by an amount of its own.

The scale of the warpings is such that Timoshenko's beam remains where shear does not change along
the link: the same rotation, the same kGA, which the warpings share as springs in series. What is
added is the stiffness against a change of their shear angles, which holds the bending of each
face about its own axis (Allen, *Analysis and Design of Structural Sandwich Panels*, 1969, ch. 2;
Krajcinovic, *J. Appl. Mech.* 39 (1972) 773; refined zigzag theory: Tessler, Di Sciuva & Gherlone,
*J. Compos. Mater.* 43 (2009) 1051).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import Literal, get_args

import numpy as np
import scipy.linalg

from flexmech.arrays import FloatArray, IntArray
from flexmech.materials import Laminate, Layer, Material, Ply
from flexmech.model_text import shapes, short_repr


@dataclass(frozen=True)
class PlaneState:
    """A laminate under in-plane strains, each of its plies in plane stress.

    Places come with the indices of their layers, which broadcast against them: at an
    interface two layers meet, each with its own stress.

    Parameters
    ----------
    laminate : Laminate
    strains : ndarray, shape (N, 2, 3)
        Strains x, z and xz of each layer at the mid-plane, and their gradients in y. Plies at
        free edges strain each in its own way.
    """

    laminate: Laminate
    strains: FloatArray

    def strain(self, place: FloatArray, layer: IntArray) -> FloatArray:
        """Strains x, z and xz at places (...) of layers, (..., 3)."""
        strains = self.strains[layer]
        return np.asarray(strains[..., 0, :] + place[..., None] * strains[..., 1, :])

    def stress(self, place: FloatArray, layer: IntArray) -> FloatArray:
        """Stresses x, z and xz at places (...) of layers, (..., 3), in Pa."""
        stiffness = self.laminate.transformed_stiffness[layer]
        return np.asarray(np.einsum("...ij,...j->...i", stiffness, self.strain(place, layer)))

    def balancing_shear(self, place: FloatArray, layer: IntArray) -> FloatArray:
        """Shear stresses zy and xy that balance a loss of this state per metre of the link.

        They are the integrals of the stresses xz and x from the lowest face: if bending
        decreases along the link by this state in each metre, nothing else holds a slice of
        it (Jourawski; Whitney, *J. Appl. Mech.* 40 (1973) 302).

        Parameters
        ----------
        place : ndarray, shape (...)
            In m.
        layer : ndarray of int
            Layers of the places.

        Returns
        -------
        ndarray, shape (..., 2)
            In Pa for a state per metre.
        """
        faces = self.laminate.boundaries
        every = np.arange(len(faces) - 1)
        heights = np.diff(faces)[:, None]
        start = self.stress(faces[:-1], every)[:, [2, 0]]
        end = self.stress(faces[1:], every)[:, [2, 0]]
        slope = (end - start) / heights
        above = np.cumsum(heights * (start + end) / 2, axis=0)
        below = np.concatenate([np.zeros((1, 2)), above[:-1]])
        depth = (place - faces[layer])[..., None]
        return np.asarray(below[layer] + start[layer] * depth + slope[layer] * depth**2 / 2)


def energy_by_direction(
    laminate: Laminate, strain: FloatArray, weights: FloatArray, other: FloatArray | None = None
) -> FloatArray:
    """Twice the strain energy of each layer by the material's axes.

    Half the product of stress and strain along the fibres, across them and in shear, over the
    area of the laminate (Adams & Bacon 1973; Ni & Adams 1984).

    Parameters
    ----------
    laminate : Laminate
    strain : ndarray, shape (N, m, 3)
        Strains x, z and xz at points in each layer.
    weights : ndarray, shape (N, m)
        Weights of the points in an integral over the layer, in m.
    other : ndarray, shape (N, m, 3), optional
        Strains of the stress, where it is that of another state.

    Returns
    -------
    ndarray, shape (N, 3)
        In N/m.
    """
    layers = laminate.layers
    turns = np.stack([layer.strain_turn for layer in layers])
    stiffness = np.stack([layer.ply.reduced_stiffness for layer in layers])
    turned = np.einsum("nij,nmj->nmi", turns, strain)
    other = turned if other is None else np.einsum("nij,nmj->nmi", turns, other)
    stress = np.einsum("nij,nmj->nmi", stiffness, other)
    return np.asarray(np.einsum("nm,nmi,nmi->ni", weights, stress, turned))


def lost_share(laminate: Laminate, energy: FloatArray) -> float:
    """Specific damping capacity of a deformation: what its energies lose over all of them.

    Parameters
    ----------
    laminate : Laminate
    energy : ndarray, shape (N, 3)
        Energy of each layer by the material's axes.

    Returns
    -------
    float
        Not below zero, though Poisson's contraction can give a direction a share that is.
    """
    capacity = np.array([layer.ply.specific_damping.by_direction for layer in laminate.layers])
    return max(0.0, float(np.sum(capacity * energy) / energy.sum()))


def layer_powers(faces: FloatArray) -> FloatArray:
    """Integrals of 1, y and y^2 over each of n layers between faces (n + 1,), (3, n)."""
    return np.stack([np.diff(faces**order) / order for order in (1, 2, 3)])


def gauss_points(laminate: Laminate, count: int = 3) -> tuple[FloatArray, FloatArray]:
    """Points in each layer and their weights, (N, count) each, in m.

    Exact up to the power ``2 count - 1``; the squares of shear stresses have 4.
    """
    faces = laminate.boundaries
    points, weights = np.polynomial.legendre.leggauss(count)
    half = np.diff(faces)[:, None] / 2
    middle = (faces[:-1] + faces[1:])[:, None] / 2
    return middle + half * points, half * weights


Reduction = Literal["narrow", "wide"]
REDUCTIONS: tuple[Reduction, ...] = ("narrow", "wide")
# Among the strains x, z and xz at the mid-plane and their gradients: those along the link, all
# others, and these without the twist.
ALONG = np.array([0, 3])
OTHERS = np.array([1, 2, 4, 5])
UNTWISTED = np.array([1, 2, 4])


@dataclass(frozen=True, eq=False)
class Strip:
    """A laminate as a beam: its strains and its stiffness for each metre of width.

    Parameters
    ----------
    laminate : Laminate
    reduction : {"narrow", "wide"}
    relaxation : ndarray, shape (2, 2)
        Relaxation of a narrow link's free edges: what part of mid-plane strain and gradient finds
        each ply free of all others; none by default.
    restraint : float
        Restraint of a narrow link's twist, the gradient in y of the shear strain: 0 leaves it free,
        1 prevents it.
    """

    laminate: Laminate
    reduction: Reduction
    relaxation: FloatArray = field(default_factory=lambda: np.zeros((2, 2)))
    restraint: float = 0.0

    @property
    def joined(self) -> Strip:
        """The same without free edges."""
        return Strip(self.laminate, self.reduction, restraint=self.restraint)

    @cached_property
    def strains(self) -> FloatArray:
        """Strains x, z and xz of each layer at the mid-plane, and their gradients in y.

        By mid-plane strain and gradient along the link: (2, N, 2, 3); the mean over fields that
        stand side by side along the width.
        """
        mean = sum(np.einsum("qp,qnij->pnij", share, fields) for fields, share in self._parts)
        return np.asarray(mean)

    @cached_property
    def _parts(self) -> list[tuple[FloatArray, FloatArray]]:
        """Fields side by side: strains (2, N, 2, 3), and their shares (2, 2)."""
        every = np.zeros((2, 6))
        every[:, ALONG] = np.eye(2)
        count = len(self.laminate.layers)

        def of_all_layers(strains: FloatArray) -> FloatArray:
            return np.repeat(strains.reshape(2, 1, 2, 3), count, axis=1)

        if self.reduction == "wide":
            return [(of_all_layers(every), np.eye(2))]
        joined, untwisted = every.copy(), every.copy()
        plate = self.laminate.plate_stiffness
        for strains, others in ((joined, OTHERS), (untwisted, UNTWISTED)):
            moved = np.linalg.solve(plate[np.ix_(others, others)], plate[np.ix_(others, ALONG)])
            strains[:, others] -= moved.T
        twists = 1 - self.restraint
        parts = [(of_all_layers(joined), twists * (np.eye(2) - self.relaxation))]
        if self.relaxation.any():
            compliance = np.linalg.inv(self.laminate.transformed_stiffness)
            # Each ply strains as if it were alone, by its strain at each place.
            alone = np.einsum("pq,nj->pnqj", np.eye(2), compliance[:, 0] / compliance[:, :1, 0])
            parts.append((alone, twists * self.relaxation))
        if self.restraint:
            parts.append((of_all_layers(untwisted), self.restraint * np.eye(2)))
        return parts

    @cached_property
    def stiffness(self) -> FloatArray:
        """By mid-plane strain and its gradient in y, (2, 2), in N/m, N and N m."""
        stress = np.einsum("nj,pnij->pni", self.laminate.transformed_stiffness[:, 0], self.strains)
        powers = layer_powers(self.laminate.boundaries)[[[0, 1], [1, 2]]]
        reduced = np.einsum("qin,pni->qp", powers, stress)
        return np.asarray((reduced + reduced.T) / 2)

    def energy_by_direction(self, strains: FloatArray) -> FloatArray:
        """Twice the strain energy of each layer by the material's axes, (N, 3), in N/m.

        Parameters
        ----------
        strains : ndarray, shape (2,)
            Mid-plane strain and its gradient in y, along the link.
        """
        every = np.arange(len(self.laminate.layers))[:, None]
        places, weights = gauss_points(self.laminate)

        def at_points(fields: FloatArray, amounts: FloatArray) -> FloatArray:
            state = PlaneState(self.laminate, np.tensordot(amounts, fields, axes=1))
            return state.strain(places, every)

        return np.asarray(
            sum(
                energy_by_direction(
                    self.laminate,
                    at_points(fields, strains),
                    weights,
                    at_points(fields, share @ strains),
                )
                for fields, share in self._parts
            )
        )

    def warping_parts(
        self, place: FloatArray, weight: FloatArray, strain: FloatArray
    ) -> tuple[FloatArray, FloatArray, float]:
        """Split the strains of warping cross-sections from stretching and bending.

        Stretching and bending are those of slender beams. If a free edge let go strains of higher
        order with them, they would be too soft however slender the link; so what warping lets go
        of its own belongs to the warping alone. It warps as it does away from the edges.

        Parameters
        ----------
        place, weight : ndarray, shape (N, m)
            Points in the layers in m, and what each counts in an integral through the thickness.
        strain : ndarray, shape (N, m, 3)
            Strains x, z and xz there of a unit change of the warping along the link; those that a
            narrow link lets go are not among them.

        Returns
        -------
        slender : ndarray, shape (2,)
            Mid-plane strain and gradient that the warping brings along.
        residual : ndarray, shape (N, m, 3)
            What is left of its strains without its part in stretching and bending.
        stiffness : float
            Integral of the residual's stress times strain.
        """
        y, stiffness = place, self.laminate.transformed_stiffness
        joined = self.joined
        mean, gradient = joined.strains[:, :, None, 0], joined.strains[:, :, None, 1]
        slender = mean + gradient * y[..., None]

        def products(left: FloatArray, right: FloatArray) -> FloatArray:
            """Integrals of fields (a, N, m, 3) with the stress of fields (b, N, m, 3)."""
            stress = np.einsum("nij,bnmj->bnmi", stiffness, right)
            return np.asarray(np.einsum("nm,anmi,bnmi->ab", weight, left, stress))

        coupling = products(slender, strain[None])[:, 0]
        amounts = np.asarray(np.linalg.solve(joined.stiffness, coupling), dtype=float)
        residual = strain - np.tensordot(amounts, slender, axes=1)
        if self.reduction == "narrow":
            # All shapes have a like size, whatever the units of the warping.
            shapes = np.stack([np.ones_like(y), y, residual[..., 0]])
            shapes /= np.abs(shapes).max(axis=(1, 2))[:, None, None]
            free = np.zeros((2, *shapes.shape, 3))
            free[0, ..., 1] = free[1, ..., 2] = shapes
            free = free.reshape(6, *residual.shape)
            amount = np.linalg.solve(products(free, free), products(free, residual[None]))[:, 0]
            residual = residual - np.tensordot(amount, free, axes=1)
        return amounts, residual, float(products(residual[None], residual[None])[0, 0])


def shear_across(stiffness: FloatArray, reduction: Reduction) -> float:
    """Shear strain across the link over that along it, from a (2, 2) stiffness (zy, xy).

    In a narrow link no shear force acts across; in a wide one nothing shears across.
    """
    if reduction == "wide":
        return 0.0
    return float(-stiffness[0, 1] / stiffness[0, 0])


LayerDirection = Literal["through thickness", "across width"]
"""Direction of a stack: in the plane of the linkage, or across it with plies parallel to it."""

ShearTheory = Literal["equilibrium", "third-order"]
SHEAR_THEORIES: tuple[ShearTheory, ...] = get_args(ShearTheory)


@dataclass(frozen=True, repr=False)
class ThroughThickness:
    """Strain and stress at places through the thickness, all of one shape.

    Parameters
    ----------
    place : ndarray
        Distance y from the mid-plane in m.
    strain : ndarray
        Along the link.
    normal_stress, shear_stress : ndarray
        Along the link, and on its cross-section in the plane of the linkage, in Pa.
    """

    place: FloatArray
    strain: FloatArray
    normal_stress: FloatArray
    shear_stress: FloatArray

    def __repr__(self) -> str:
        return short_repr(self, *shapes(self))


@dataclass(frozen=True)
class ThirdOrder:
    """Integrals over a section whose points move along by a cubic of their place y.

    With the section's rotation phi and the slope s of the axis, points move along by
    ``u0 - y phi - c y^3 (s - phi)`` with ``c = 4 / (3 h^2)``, so that the shear strain
    ``(1 - 4 y^2 / h^2) (s - phi)`` vanishes at the surfaces (Reddy 1984; Elamy et al. 2023,
    eqs. 18-22, corrected: the cubic term is negative).

    Parameters
    ----------
    thickness : float
        h in m, in the plane of the linkage.
    stiffness : ndarray, shape (3, 3)
        By the strains of ``e0 + y k1 + y^3 k3``: integrals of E times powers of y.
    shear_stiffness : ndarray, shape (3,)
        Integrals of G times 1, y^2 and y^4.
    inertia : ndarray, shape (7,)
        Integrals of rho times y to the power 0 to 6.
    """

    thickness: float
    stiffness: FloatArray
    shear_stiffness: FloatArray
    inertia: FloatArray

    def __repr__(self) -> str:
        return short_repr(self, f"{self.thickness * 1e3:.6g} mm thick", *shapes(self))

    @property
    def cubic_factor(self) -> float:
        """Factor c of the cube in 1/m^2."""
        return 4 / (3 * self.thickness**2)

    @property
    def shear_force_stiffness(self) -> float:
        """Stiffness against the shear angle of the axis in N."""
        c = self.cubic_factor
        return float(self.shear_stiffness @ np.array([1.0, -6 * c, 9 * c**2]))


def third_order_of(strip: Strip, width: float) -> ThirdOrder:
    """Integrals of a laminate, reduced as for the classical theory.

    Stretching and bending are those of that theory: slender links of all theories are alike.
    In a narrow link the shear strain across it is a parabola too, of the height at which
    its higher-order shear force (Elamy et al. 2023, eq. 29) vanishes.

    Parameters
    ----------
    strip : Strip
    width : float
        Along the joint axes, in m.

    Returns
    -------
    ThirdOrder
    """
    laminate, reduction = strip.laminate, strip.reduction
    tilt = _tilt(laminate, reduction)
    moments = [laminate.shear_moment(power) for power in (0, 2, 4)]
    shear = [m[1, 1] + 2 * tilt * m[0, 1] + tilt**2 * m[0, 0] for m in moments]
    # By the strains of e0 + y k1 + y^3 k3.
    places, weights = gauss_points(laminate, 4)
    strain = np.zeros((*places.shape, 3))
    strain[..., 0] = places**3
    slender, _, warping = strip.warping_parts(places, weights, strain)
    column = (strip.stiffness @ slender)[:, None]
    last = slender @ column + warping
    return ThirdOrder(
        thickness=laminate.thickness,
        stiffness=width * np.block([[strip.stiffness, column], [column.T, last]]),
        shear_stiffness=width * np.array(shear),
        inertia=width * np.array([laminate.mass_moment(power) for power in range(7)]),
    )


def parabolic_shear(
    laminate: Laminate, reduction: Reduction, place: FloatArray, layer: IntArray
) -> FloatArray:
    """Shear stress of a unit shear force on each metre of width, from the shear strain.

    It vanishes at the surfaces and jumps at interfaces of layers with different stiffness.

    Parameters
    ----------
    laminate : Laminate
    reduction : {"narrow", "wide"}
    place : ndarray, shape (...)
        In m.
    layer : ndarray of int
        Layers of the places.

    Returns
    -------
    ndarray, shape (...)
        In 1/m: times the shear force over the width it is Pa.
    """
    square = 4 / laminate.thickness**2
    row = np.array([_tilt(laminate, reduction), 1.0])
    resultant = (laminate.shear_moment(0) - square * laminate.shear_moment(2))[1] @ row
    along = laminate.transformed_shear_stiffness[:, 1] @ row
    return np.asarray(along[layer] * (1 - square * place**2) / resultant)


def _tilt(laminate: Laminate, reduction: Reduction) -> float:
    """Shear strain across the link over that along it, both parabolas with y."""
    square = 4 / laminate.thickness**2
    factors = ((0, 1.0), (2, -2 * square), (4, square**2))
    stiffness = sum(factor * laminate.shear_moment(power) for power, factor in factors)
    return shear_across(np.asarray(stiffness), reduction)


WARPINGS = 2
"""How many warpings a cross-section has: two let each core of two shear by its own amount."""

# In a layer the second warping is of degree 5 and its square of degree 10.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(6)


def _integrals(ends: FloatArray) -> FloatArray:
    """Integrals from -1 to ends of the polynomials that are 1 at one of the points, (6, n)."""
    powers = np.arange(len(_POINTS))
    coefficients = np.linalg.inv(_POINTS[:, None] ** powers)
    grown = (ends[:, None] ** (powers + 1) - (-1.0) ** (powers + 1)) / (powers + 1)
    return np.asarray((grown @ coefficients).T)


_TO_POINTS = _integrals(_POINTS)


@dataclass(frozen=True)
class Zigzag:
    """Integrals over a section whose warpings each have a shear angle of their own.

    Points move along by ``u - y phi + sum(W_i(y) gamma_i)``; the slope of the axis is
    ``phi + sum(gamma_i)``. Every W is orthogonal to 1 and y, weighted by the stiffness along the
    link, and to the others.

    Parameters
    ----------
    flexibility : ndarray, shape (w,)
        Share of each warping in 1 / kGA; 1 together.
    fall_off : ndarray, shape (w,)
        Length over which a boundary layer of each shear angle falls off to 1 / e, in m: the
        square root of the integral of ``E W^2`` over the stiffness against the shear angle.
    along, turning : ndarray, shape (w,)
        Integrals of rho times W and ``y W``, over the mass per length, in m and m^2.
    square : ndarray, shape (w, w)
        Those of the products of two warpings, in m^2.
    loss : float
        Specific damping capacity of a change of the first warping along the link.
    """

    flexibility: FloatArray
    fall_off: FloatArray
    along: FloatArray
    turning: FloatArray
    square: FloatArray
    loss: float

    def __repr__(self) -> str:
        return short_repr(self, *shapes(self))


def zigzag_of(strip: Strip, bent: PlaneState) -> Zigzag:
    """Integrals of a laminate, reduced as for the classical theory.

    Parameters
    ----------
    strip : Strip
    bent : PlaneState
        Under a bending moment, at whose loss along the link the section warps.

    Returns
    -------
    Zigzag
    """
    laminate, reduction = strip.laminate, strip.reduction
    place, weight = gauss_points(laminate, len(_POINTS))
    every = np.arange(len(place))[:, None]
    stress = bent.stress(place, every)
    warpings = []
    for _ in range(WARPINGS):
        # Balanced from face to face: each stress has no resultant along the link.
        shear = _from_lowest_face(laminate, stress[..., [2, 0]] / np.abs(stress[..., 0]).max())
        angle = shear_strain(laminate, reduction, shear)
        moved = _from_lowest_face(laminate, angle)
        strain = np.zeros((*place.shape, 3))
        strain[..., 0], strain[..., 2] = moved[..., 1], moved[..., 0]
        slender, residual, _ = strip.warping_parts(place, weight, strain)
        stress = np.einsum("nij,nmj->nmi", laminate.transformed_stiffness, residual)
        warpings.append((slender[1], shear, angle, residual, stress))
    bending, shears, strains, fields, residuals = map(np.stack, zip(*warpings, strict=True))
    sheared = np.einsum("nm,anmi,bnmi->ab", weight, shears, strains)
    changed = np.einsum("nm,anmi,bnmi->ab", weight, fields, residuals)
    squared_length, vectors = scipy.linalg.eigh(changed, sheared)
    # Each with the shear angle that it gives to the axis.
    angles = bending @ vectors
    warping = np.tensordot((vectors / angles).T, fields[..., 0], axes=1)
    density = np.array([layer.ply.density for layer in laminate.layers])[:, None]
    mass = weight * density / np.sum(weight * density)
    energy = energy_by_direction(laminate, fields[0], weight)
    return Zigzag(
        flexibility=angles**2 / np.sum(angles**2),
        fall_off=np.sqrt(np.abs(squared_length)),
        along=np.einsum("nm,anm->a", mass, warping),
        turning=np.einsum("nm,nm,anm->a", mass, place, warping),
        square=np.einsum("nm,anm,bnm->ab", mass, warping, warping),
        loss=lost_share(laminate, energy),
    )


@cache
def _unit_rectangle() -> Zigzag:
    """Zigzag beam of a rectangle 1 m thick with ``EI / kGA`` of 0.2 m^2."""
    laminate = Laminate((Layer(Ply.isotropic(Material(1.0, 1.0, poisson_ratio=0.0)), 1.0),))
    strip = Strip(laminate, "wide")
    return zigzag_of(strip, PlaneState(laminate, strip.strains[1]))


def rectangular_zigzag(thickness: float, bending_over_shear: float) -> Zigzag:
    """Zigzag beam of a solid rectangle of one material.

    Parameters
    ----------
    thickness : float
        In m.
    bending_over_shear : float
        EI over kGA in m^2.

    Returns
    -------
    Zigzag
    """
    unit = _unit_rectangle()
    return replace(
        unit,
        fall_off=unit.fall_off * np.sqrt(bending_over_shear / 0.2),
        square=unit.square * thickness**2,
    )


def _from_lowest_face(laminate: Laminate, values: FloatArray) -> FloatArray:
    """Integrals through the thickness up to each point, of values there, (N, 6, c)."""
    half = np.diff(laminate.boundaries)[:, None, None] / 2
    layers = np.sum(half * _WEIGHTS[:, None] * values, axis=1)
    below = np.cumsum(layers, axis=0) - layers
    return np.asarray(below[:, None] + half * np.einsum("nmc,mp->npc", values, _TO_POINTS))


def shear_strain(laminate: Laminate, reduction: Reduction, stress: FloatArray) -> FloatArray:
    """Shear strains of layers under shear stresses; none across a wide link.

    Parameters
    ----------
    laminate : Laminate
    reduction : {"narrow", "wide"}
    stress : ndarray, shape (N, m, 2)
        zy and xy in Pa.

    Returns
    -------
    ndarray, shape (N, m, 2)
        zy and xy.
    """
    stiffness = laminate.transformed_shear_stiffness
    if reduction == "wide":
        return np.asarray(stress * np.array([0.0, 1.0]) / stiffness[:, 1, 1, None, None])
    return np.asarray(np.einsum("nij,nmj->nmi", np.linalg.inv(stiffness), stress))
