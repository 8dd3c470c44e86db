"""Stress and energy inside a laminate whose strains are linear through the thickness."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flexmech.errors import InputError
from flexmech.materials import Laminate
from flexmech.types import FloatArray, IntArray


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


def gauss_points(laminate: Laminate, count: int = 3) -> tuple[FloatArray, FloatArray]:
    """Points in each layer and their weights, (N, count) each, in m.

    Exact up to the power ``2 count - 1``; the squares of shear stresses have 4.
    """
    faces = laminate.boundaries
    points, weights = np.polynomial.legendre.leggauss(count)
    half = np.diff(faces)[:, None] / 2
    middle = (faces[:-1] + faces[1:])[:, None] / 2
    return middle + half * points, half * weights


def layer_of(laminate: Laminate, place: FloatArray) -> IntArray:
    """Layers of places through the thickness.

    Parameters
    ----------
    laminate : Laminate
    place : ndarray, shape (m,) or (N, m)
        In m. A list of places: at an interface the upper layer is meant. A row a layer:
        each row belongs to its layer, interfaces included.

    Returns
    -------
    ndarray of int
        Broadcasts against the places.

    Raises
    ------
    InputError
        If a place is not a number or not in the laminate or its row's layer, or the rows
        are not as many as the layers.
    """
    faces = laminate.boundaries
    count = len(faces) - 1
    if place.ndim == 2 and len(place) == count:
        layer = np.arange(count)[:, None]
    elif place.ndim < 2:
        layer = np.clip(np.searchsorted(faces, place, side="right") - 1, 0, count - 1)
    else:
        raise InputError(
            f"places must be a list, or have one row for each of the {count} layers; got "
            f"shape {place.shape}"
        )
    slack = 1e-9 * laminate.thickness
    inside = (place >= faces[layer] - slack) & (place <= faces[layer + 1] + slack)
    if not np.all(inside):
        wrong = place[~inside].flat[0]
        raise InputError(
            f"place {wrong:.6g} m is outside its layer; the laminate reaches from "
            f"{faces[0]:.6g} to {faces[-1]:.6g} m"
        )
    return np.asarray(layer)
