"""What a section is to the zigzag beam, whose cross-sections warp as equilibrium asks.

Bending that changes along the link needs a shear stress through the thickness (Jourawski); in
every layer the shear strain is that stress over the layer's modulus. Its integral is the shape
into which the cross-section warps: kinked at each interface, steep in a soft layer, flat in a
stiff one. Reddy's fixed cubic shears all layers alike and is far too stiff where they differ.
The stress along the link that this first warping brings, where it changes, needs a shear stress
in its turn, and so a second warping: with two, each core of a stack with two soft cores shears
by an amount of its own.

The scale of the warpings is such that Timoshenko's beam remains where shear does not change along
the link: the same rotation, the same kGA, which the warpings share as springs in series. What is
added is the stiffness against a change of their shear angles, which holds the bending of each
face about its own axis (Allen, *Analysis and Design of Structural Sandwich Panels*, 1969, ch. 2;
Krajcinovic, *J. Appl. Mech.* 39 (1972) 773; refined zigzag theory: Tessler, Di Sciuva & Gherlone,
*J. Compos. Mater.* 43 (2009) 1051).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import scipy.linalg

from flexmech.materials import Laminate, Layer, Material, Ply
from flexmech.sections.beam_reduction import Reduction, Strained, Strip
from flexmech.sections.plane_state import PlaneState, energy_by_direction, gauss_points
from flexmech.short_repr import shapes, short_repr
from flexmech.types import FloatArray

WARPINGS = 2
"""How many warpings a cross-section has."""

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
    scale = np.abs(stress[..., 0]).max()
    fields, shears, strains, residuals, held = [], [], [], [], []
    for _ in range(WARPINGS):
        # Balanced from face to face: each stress has no resultant along the link.
        shear = _from_lowest_face(laminate, stress[..., [2, 0]] / scale)
        angle = _shear_strain(laminate, reduction, shear)
        moved = _from_lowest_face(laminate, angle)
        strain = np.zeros((*place.shape, 3))
        strain[..., 0], strain[..., 2] = moved[..., 1], moved[..., 0]
        parts = strip.warping_parts(Strained(place, weight, strain))
        held.append(parts.held[1])
        stress = np.einsum("nij,nmj->nmi", laminate.transformed_stiffness, parts.residual)
        scale = np.abs(stress[..., 0]).max()
        shears.append(shear)
        strains.append(angle)
        fields.append(parts.residual)
        residuals.append(stress)
    sheared = np.einsum("nm,anmi,bnmi->ab", weight, np.stack(shears), np.stack(strains))
    changed = np.einsum("nm,anmi,bnmi->ab", weight, np.stack(fields), np.stack(residuals))
    squared_length, vectors = scipy.linalg.eigh(changed, sheared)
    # Each with the shear angle that it gives to the axis.
    angles = np.array(held) @ vectors
    warping = np.tensordot((vectors / angles).T, np.stack(fields)[..., 0], axes=1)
    density = np.array([layer.ply.density for layer in laminate.layers])[:, None]
    mass = weight * density / np.sum(weight * density)
    energy = energy_by_direction(laminate, fields[0], weight)
    capacity = np.array([layer.ply.specific_damping.by_direction for layer in laminate.layers])
    return Zigzag(
        flexibility=angles**2 / np.sum(angles**2),
        fall_off=np.sqrt(np.abs(squared_length)),
        along=np.einsum("nm,anm->a", mass, warping),
        turning=np.einsum("nm,nm,anm->a", mass, place, warping),
        square=np.einsum("nm,anm,bnm->ab", mass, warping, warping),
        loss=max(0.0, float(np.sum(capacity * energy) / energy.sum())),
    )


@cache
def _unit_rectangle() -> Zigzag:
    """Of a rectangle 1 m thick with ``EI / kGA`` of 0.2 m^2."""
    laminate = Laminate((Layer(Ply.isotropic(Material(1.0, 1.0, poisson_ratio=0.0)), 1.0),))
    strip = Strip(laminate, "wide")
    return zigzag_of(strip, PlaneState(laminate, strip.strains[1]))


def rectangular_zigzag(thickness: float, bending_over_shear: float) -> Zigzag:
    """Of a solid rectangle of one material.

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


def _shear_strain(laminate: Laminate, reduction: Reduction, stress: FloatArray) -> FloatArray:
    """Shear strains zy and xy (N, m, 2) of shear stresses; none across a wide link."""
    stiffness = laminate.transformed_shear_stiffness
    if reduction == "wide":
        return np.asarray(stress * np.array([0.0, 1.0]) / stiffness[:, 1, 1, None, None])
    return np.asarray(np.einsum("nij,nmj->nmi", np.linalg.inv(stiffness), stress))
