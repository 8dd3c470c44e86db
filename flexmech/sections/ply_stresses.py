"""Stresses of the plies of a section in their own axes: by its loads, and those that stay.

Five stresses of each ply: along its fibres, across them and in shear, which is all that criteria
of plane stress ask for, then the shear stresses 13 and 23 between the plies.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.materials import Laminate
from flexmech.sections.beam_reduction import PlaneState
from flexmech.sections.beam_section import Layers
from flexmech.sections.hygrothermal import free_strains, keeping_stress, without_twist
from flexmech.sections.laminate_section import LaminateSection

SURFACES = ("lower", "upper")
"""Of each layer, at its lower and its higher y; of plies across the width their two edges."""
STRESSES = ("1", "2", "12", "13", "23")
"""In the order of the last axis."""


# A search for the weakest place judges the same few layers hundreds of times: a fifth of its time.
@lru_cache(maxsize=64)
def unit_ply_stresses(layers: Layers) -> FloatArray:
    """Stresses under a unit axial force, bending moment and shear force at the pins' axis.

    Parameters
    ----------
    layers : LaminateSection or SheetSection

    Returns
    -------
    ndarray, shape (3, N, 2, 5)
        In Pa for 1 N along the pins' axis (with coupling it bends the link), 1 N m that stretches
        the side of lower y, and 1 N along y on the face towards higher x; of each layer at both
        surfaces. The mean over the width of what free edges let go. Read-only.
    """
    laminate, place = layers.laminate, layers.places(2)
    # Along the pins' axis the force has this lever about the neutral axis.
    loads = [(1.0, layers.neutral_axis, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
    every = np.arange(len(laminate.layers))[:, None]
    found = np.zeros((3, *place.shape, 5))
    for stress, (force, moment, shear) in zip(found, loads, strict=True):
        if isinstance(layers, LaminateSection):
            state = layers.plane_state(force, moment)
            stress[..., :3] = _in_ply_axes(laminate, state.stress(place, every))
            growing = layers.plane_state(0.0, 1.0).balancing_shear(place, every)
            stress[..., 3:] = _between_plies(laminate, shear * growing)
        else:
            in_plane = layers.plane_stress(place, force, moment, shear)
            stress[..., :3] = _in_ply_axes(laminate, in_plane)
    found.setflags(write=False)
    return found


def residual_ply_stresses(
    layers: Layers, temperature_rise: float, moisture: FloatArray
) -> FloatArray:
    """Stresses that the layers put on each other without loads.

    Parameters
    ----------
    layers : LaminateSection or SheetSection
        As they are in heat and water.
    temperature_rise : float
        Over the temperature at which they are free of stress, in K.
    moisture : ndarray, shape (N,)
        Of each layer's resin, as :func:`flexmech.materials.moisture_of` gives it.

    Returns
    -------
    ndarray, shape (N, 2, 5)
        In Pa, at both surfaces of each layer; of plies across the width in their middle. Classical
        lamination theory, linear in the temperature; no ply flows.
    """
    laminate = layers.laminate
    strains = [
        [
            heat * temperature_rise + water * own
            for heat, water in zip(
                layer.ply.thermal_expansion, layer.ply.moisture_expansion, strict=True
            )
        ]
        for layer, own in zip(laminate.layers, moisture, strict=True)
    ]
    kept = np.stack([keeping_stress(*one) for one in zip(laminate.layers, strains, strict=True)])
    free = free_strains(laminate, kept, layers.reduction)
    through = isinstance(layers, LaminateSection)
    if isinstance(layers, LaminateSection) and layers.twist == "held" and layers.twists:
        free = without_twist(free, layers)
    faces = laminate.boundaries
    place = np.stack([faces[:-1], faces[1:]], axis=1)
    if not through:
        place = np.repeat(place.mean(axis=1, keepdims=True), 2, axis=1)
    count = len(laminate.layers)
    state = PlaneState(laminate, np.broadcast_to(free, (count, 2, 3)))
    stress = state.stress(place, np.arange(count)[:, None]) - kept[:, None]
    found = np.zeros((count, 2, 5))
    found[..., :3] = _in_ply_axes(laminate, stress)
    return found


def _in_ply_axes(laminate: Laminate, stress: FloatArray) -> FloatArray:
    """Stresses x, z, xz of layers (N, m, 3) along the fibres, across them and in shear."""
    turns = np.stack([np.linalg.inv(layer.strain_turn).T for layer in laminate.layers])
    return np.asarray(np.einsum("nij,nmj->nmi", turns, stress))


def _between_plies(laminate: Laminate, shear: FloatArray) -> FloatArray:
    """Shear stresses zy and xy (N, m, 2) as those along the fibres, 13, and across them, 23."""
    angle = np.array([layer.angle for layer in laminate.layers])[:, None]
    across, along = shear[..., 0], shear[..., 1]
    return np.stack(
        [
            np.cos(angle) * along + np.sin(angle) * across,
            np.cos(angle) * across - np.sin(angle) * along,
        ],
        axis=-1,
    )
