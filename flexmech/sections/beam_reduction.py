"""From a laminate to a beam: what is free across the link, and the stiffness along it.

``narrow``: the stress resultants across the link and in shear of its plies vanish (plane
stress), and free edges let plies at different angles go
(:mod:`flexmech.sections.free_edges`); ``wide``: the strains across do (plane strain,
cylindrical bending). For Reddy's theory the higher-order resultants and strains are treated
alike.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np

from flexmech.arrays import FloatArray, IntArray
from flexmech.materials import Laminate


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
        Of the points in an integral over the layer, in m.
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
        Of each layer by the material's axes.

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
        Of a narrow link's free edges: what part of mid-plane strain and gradient finds each ply
        free of all others; none by default.
    restraint : float
        Of a narrow link's twist, the gradient in y of the shear strain: 0 leaves it free, 1
        prevents it.
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

        By mid-plane strain and gradient along the link: (2, N, 2, 3). Of what happens side by side
        along the width, the mean.
        """
        mean = sum(np.einsum("qp,qnij->pnij", share, fields) for fields, share in self._parts)
        return np.asarray(mean)

    @cached_property
    def _parts(self) -> list[tuple[FloatArray, FloatArray]]:
        """What happens side by side: strains (2, N, 2, 3), and of what part of theirs (2, 2)."""
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
            # Of like size, whatever the units of the warping.
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
